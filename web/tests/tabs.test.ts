import { expect, it } from "vitest";
import { make } from "../src/page/dom";
import { Tabs } from "../src/page/tabs";

it("moves between tabs with the arrow keys and shows one panel", () => {
  const tabs = new Tabs("Choices", ["a", "b", "c"].map((id) => ({ id, label: id, content: make("p") })));
  document.body.replaceChildren(tabs.element);
  const selected = (): string | undefined => tabs.element.querySelector('[aria-selected="true"]')?.id;
  const press = (key: string): void => {
    document.activeElement?.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  };
  tabs.element.querySelector<HTMLElement>("#tab-a")?.focus();
  press("ArrowRight");
  expect(selected()).toBe("tab-b");
  press("ArrowLeft");
  press("ArrowLeft");
  expect(selected()).toBe("tab-c");
  expect(tabs.element.querySelectorAll("section:not([hidden])")).toHaveLength(1);
});
