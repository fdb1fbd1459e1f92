import { make } from "./dom";

export interface Tab {
  id: string;
  label: string;
  content: HTMLElement;
}

/** Tabs after the WAI-ARIA pattern: arrow keys move between them. */
export class Tabs {
  readonly element: HTMLElement;
  private readonly buttons: HTMLButtonElement[];

  constructor(label: string, private readonly tabs: Tab[]) {
    this.buttons = tabs.map((tab) =>
      make("button", {
        type: "button",
        id: `tab-${tab.id}`,
        className: "tabs__tab",
        role: "tab",
        textContent: tab.label,
        onclick: () => this.open(tab.id),
        aria: { controls: `panel-${tab.id}` },
      }),
    );
    const list = make("div", { className: "tabs__list", role: "tablist", aria: { label } }, ...this.buttons);
    list.addEventListener("keydown", (event) => this.move(event));
    const panels = tabs.map((tab) =>
      make(
        "section",
        { id: `panel-${tab.id}`, className: "tabs__panel", role: "tabpanel", aria: { labelledby: `tab-${tab.id}` } },
        tab.content,
      ),
    );
    this.element = make("div", { className: "tabs" }, list, ...panels);
    this.open(tabs[0]?.id ?? "");
  }

  open(id: string): void {
    for (const [index, tab] of this.tabs.entries()) {
      const selected = tab.id === id;
      const button = this.buttons[index];
      button?.setAttribute("aria-selected", String(selected));
      if (button) button.tabIndex = selected ? 0 : -1;
      const panel = this.element.querySelector<HTMLElement>(`#panel-${tab.id}`);
      if (panel) panel.hidden = !selected;
    }
  }

  private move(event: KeyboardEvent): void {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const current = this.buttons.findIndex((button) => button === document.activeElement);
    if (!step || current < 0) return;
    event.preventDefault();
    const next = (current + step + this.tabs.length) % this.tabs.length;
    this.buttons[next]?.focus();
    this.open(this.tabs[next]?.id ?? "");
  }
}
