import { make } from "./dom";

/** Colours as a fabric book names them. */
const SWATCHES: readonly [name: string, color: string][] = [
  ["Chalk", "#efe9df"], ["Sand", "#cdb594"], ["Clay", "#b2694a"], ["Rust", "#8a3b24"],
  ["Rose", "#c98b8b"], ["Claret", "#6d1f2f"], ["Sage", "#8f9c80"], ["Forest", "#2f4a3a"],
  ["Sky", "#9db4c8"], ["Indigo", "#2f3b63"], ["Slate", "#5b6068"], ["Ink", "#1f2024"],
];

export type Tint = (garment: string, color: string | undefined) => void;

/** Colours for the whole outfit or one garment of it. */
export class FabricPanel {
  readonly element = make("div", { className: "stack" });
  private garments: { name: string; color: string }[] = [];
  private readonly chosen = new Map<string, string>();
  private garment = "*";

  constructor(private readonly onTint: Tint) {
    this.draw();
  }

  /** The garments on the stage; a new set starts with the colours of the file. */
  show(garments: { name: string; color: string }[], reset: boolean): void {
    const same = garments.map(({ name }) => name).join() === this.garments.map(({ name }) => name).join();
    if (same && !reset) return;
    this.garments = garments;
    this.chosen.clear();
    this.garment = "*";
    this.draw();
  }

  private draw(): void {
    const swatches = SWATCHES.map(([name, color]) => this.swatch(name, color));
    this.element.replaceChildren(
      ...(this.garments.length > 1 ? [this.garmentChoice()] : []),
      make(
        "section",
        {},
        make("h3", { className: "eyebrow", textContent: "Colour" }),
        make("div", { className: "swatches" }, this.original(), ...swatches, this.custom()),
      ),
      make("p", { className: "hint", textContent: "The weave and sheen of the fabric stay; only its dye changes." }),
    );
  }

  private garmentChoice(): HTMLElement {
    const chips = [{ name: "*", label: "Whole outfit" }, ...this.garments.map(({ name }) => ({ name, label: readable(name) }))].map(
      ({ name, label }) =>
        make("button", {
          type: "button",
          className: "chip",
          textContent: label,
          aria: { pressed: String(name === this.garment) },
          onclick: () => {
            this.garment = name;
            this.draw();
          },
        }),
    );
    return make("section", {}, make("h3", { className: "eyebrow", textContent: "Garment" }), make("div", { className: "chips" }, ...chips));
  }

  private swatch(name: string, color: string): HTMLElement {
    const button = make("button", {
      type: "button",
      className: "swatch",
      title: name,
      aria: { label: name, pressed: String(this.chosen.get(this.garment) === color) },
      data: { color },
      onclick: () => this.choose(color),
    });
    button.style.setProperty("--swatch", color);
    return button;
  }

  private original(): HTMLElement {
    return make("button", {
      type: "button",
      className: "swatch swatch--original",
      title: "As made",
      aria: { label: "As made", pressed: String(!this.chosen.has(this.garment)) },
      onclick: () => this.choose(undefined),
    });
  }

  private custom(): HTMLElement {
    const chosen = this.chosen.get(this.garment);
    const own = this.garments.find(({ name }) => name === this.garment)?.color;
    const input = make("input", { type: "color", value: chosen ?? own ?? "#888888", aria: { label: "Any colour" } });
    input.addEventListener("input", () => this.choose(input.value, false));
    return make("label", { className: "swatch swatch--custom", title: "Any colour" }, input);
  }

  private choose(color: string | undefined, redraw = true): void {
    // A colour for the whole outfit replaces those of single garments.
    if (this.garment === "*") {
      for (const { name } of this.garments) this.apply(name, undefined);
    }
    this.apply(this.garment, color);
    if (redraw) this.draw();
  }

  private apply(garment: string, color: string | undefined): void {
    if (color) this.chosen.set(garment, color);
    else this.chosen.delete(garment);
    this.onTint(garment, color);
  }
}

function readable(name: string): string {
  const words = name.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}
