import type { Method, Outfit, VertexAttribute } from "../api/types";
import type { DrapeDetail } from "../viewer/events";
import { choiceButtons, make } from "./dom";
import { timingBar } from "./timing_bar";

const METHODS: readonly { id: Method; name: string; text: string }[] = [
  { id: "deepsd", name: "DeePSD", text: "Learned folds, in real time." },
  { id: "deepsd-concat", name: "DeePSD, as printed", text: "The paper's per-vertex network. Slower; for comparison." },
  { id: "skinning", name: "Skinning only", text: "Follows the bones; nothing learned." },
];

type HeatChoice = VertexAttribute | "none";

/** How the drape was made and how good it is: heat map, quality, timing, method. */
export class InsightPanel {
  readonly element: HTMLElement;
  private readonly quality = make("dl", { className: "facts" });
  private readonly timing = make("div");
  private readonly inputs = new Map<Method, HTMLInputElement>();

  constructor(
    private readonly onHeat: (heat: VertexAttribute | null) => void,
    private readonly onMethod: (method: Method) => void,
  ) {
    this.element = make(
      "div",
      { className: "stack" },
      section("Heat map", this.heatChoice()),
      section("This drape", this.quality),
      section("Time", this.timing),
      section("Method", this.methodChoice()),
    );
    this.timing.append(make("p", { className: "hint", textContent: "Wear an outfit to see how long it takes." }));
  }

  showDrape(detail: DrapeDetail): void {
    this.timing.replaceChildren(timingBar(detail));
    const { quality } = detail;
    const percent = (value: number): string => `${value.toFixed(value < 1 ? 2 : 1)} %`;
    const rows: [string, string][] = quality
      ? [
          ["Inside the body before the resolve", percent(quality.penetration_before_percent)],
          ["After it", percent(quality.penetration_after_percent)],
          ["Edge strain, 95th percentile", percent(quality.p95_edge_strain * 100)],
          ["Longest stretch", `${quality.max_edge_stretch.toFixed(2)} ×`],
        ]
      : [["Quality", "not measured"]];
    this.quality.replaceChildren(...rows.flatMap(([label, value]) => [make("dt", { textContent: label }), make("dd", { textContent: value })]));
  }

  /** Offers only the methods that can drape the outfit. */
  showOutfit(outfit: Outfit): void {
    for (const [method, input] of this.inputs) input.disabled = !outfit.methods.includes(method);
  }

  private heatChoice(): HTMLElement {
    const choices: { value: HeatChoice; label: string }[] = [
      { value: "none", label: "Off" },
      { value: "penetration", label: "Penetration" },
      { value: "strain", label: "Strain" },
    ];
    const chooser = choiceButtons<HeatChoice>("Heat map", choices, "none", (value) => this.onHeat(value === "none" ? null : value));
    chooser.element.classList.add("segmented--wide");
    return chooser.element;
  }

  private methodChoice(): HTMLElement {
    const options = METHODS.map(({ id, name, text }) => {
      const input = make("input", { type: "radio", name: "method", value: id, checked: id === "deepsd" });
      input.addEventListener("change", () => this.onMethod(id));
      this.inputs.set(id, input);
      const words = make("span", {}, make("strong", { textContent: name }), make("span", { textContent: text }));
      return make("label", { className: "method" }, input, words);
    });
    return make("div", { className: "methods", role: "radiogroup", aria: { label: "Method" } }, ...options);
  }
}

function section(title: string, content: HTMLElement): HTMLElement {
  return make("section", {}, make("h3", { className: "eyebrow", textContent: title }), content);
}
