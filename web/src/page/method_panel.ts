import type { Garment, GarmentKind, Kinds, Method, Outfit } from "../api/types";
import { make } from "./dom";
import { canDrape, METHODS } from "./methods";

const KINDS: readonly { id: GarmentKind; name: string }[] = [
  { id: "tee", name: "T-shirt" },
  { id: "sweater", name: "Sweater" },
  { id: "dress", name: "Dress" },
  { id: "jeans", name: "Jeans" },
];

/** A way to drape, and what it needs to know of the outfit's garments. */
export interface MethodChoice {
  method: Method;
  kinds: Kinds;
}

/** The way to drape. GarNet++ can be chosen once the kind of every garment is known, pixel cloth where it was trained. */
export class MethodPanel {
  readonly element: HTMLElement;
  private readonly inputs = new Map<Method, HTMLInputElement>();
  private readonly kindRows = make("div", { className: "kinds" });
  private outfit: Outfit | undefined;
  private choice: MethodChoice = { method: "deepsd", kinds: {} };

  constructor(private readonly onChoose: (choice: MethodChoice) => void) {
    const options = METHODS.filter(({ id }) => id !== "simulation").map((method) => this.option(method));
    this.element = make("div", { className: "methods", role: "radiogroup", aria: { label: "Method" } }, ...options);
  }

  /** Offers what can drape the outfit, and returns what is chosen for it. */
  showOutfit(outfit: Outfit): MethodChoice {
    this.outfit = outfit;
    this.choice = { ...this.choice, kinds: { ...outfit.kinds } };
    this.kindRows.replaceChildren(...outfit.garments.map((garment) => this.kindRow(garment)));
    this.refresh();
    return this.choice;
  }

  private option({ id, name, text }: (typeof METHODS)[number]): HTMLElement {
    const input = make("input", { type: "radio", name: "method", value: id, checked: id === this.choice.method });
    input.addEventListener("change", () => this.choose({ method: id }));
    this.inputs.set(id, input);
    const words = make("span", {}, make("strong", { textContent: name }), make("span", { textContent: text }));
    const label = make("label", { className: "method" }, input, words);
    return id === "garnet" ? make("div", {}, label, this.kindRows) : label;
  }

  private kindRow(garment: Garment): HTMLElement {
    const select = make("select", { name: `kind of ${garment.name}` });
    select.append(make("option", { value: "", textContent: "another kind" }));
    for (const { id, name } of KINDS) {
      select.append(make("option", { value: id, textContent: name, selected: this.choice.kinds[garment.name] === id }));
    }
    select.addEventListener("change", () => this.setKind(garment.name, KINDS.find(({ id }) => id === select.value)?.id));
    return make("label", {}, make("span", { textContent: `${garment.name} is a` }), select);
  }

  private setKind(garment: string, kind: GarmentKind | undefined): void {
    const others = Object.entries(this.choice.kinds).filter(([name]) => name !== garment);
    const was = this.choice.method;
    this.choice = { ...this.choice, kinds: Object.fromEntries(kind ? [...others, [garment, kind]] : others) };
    this.refresh();
    if (was === "garnet") this.onChoose(this.choice);
  }

  private choose(change: Partial<MethodChoice>): void {
    this.choice = { ...this.choice, ...change };
    this.onChoose(this.choice);
  }

  /** What cannot drape the outfit is not offered; DeePSD takes its place. */
  private refresh(): void {
    const { outfit } = this;
    const able = (method: Method): boolean => outfit !== undefined && canDrape(method, outfit, this.choice.kinds);
    if (!able(this.choice.method)) this.choice = { ...this.choice, method: "deepsd" };
    for (const [method, input] of this.inputs) {
      input.disabled = !able(method);
      input.checked = method === this.choice.method;
    }
  }
}
