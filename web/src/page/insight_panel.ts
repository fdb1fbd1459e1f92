import type { Outfit, VertexAttribute } from "../api/types";
import type { DrapeDetail } from "../viewer/events";
import { choiceButtons, make } from "./dom";
import { type MethodChoice, MethodPanel } from "./method_panel";
import { timingBar } from "./timing_bar";

type HeatChoice = VertexAttribute | "none";

/** How the drape was made and how good it is: heat map, quality, timing, method. */
export class InsightPanel {
  readonly element: HTMLElement;
  private readonly quality = make("dl", { className: "facts" });
  private readonly timing = make("div");
  private readonly methods: MethodPanel;

  constructor(
    private readonly onHeat: (heat: VertexAttribute | null) => void,
    onMethod: (choice: MethodChoice) => void,
  ) {
    this.methods = new MethodPanel(onMethod);
    this.element = make(
      "div",
      { className: "stack" },
      section("Heat map", this.heatChoice()),
      section("This drape", this.quality),
      section("Time", this.timing),
      section("Method", this.methods.element),
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

  /** Offers what can drape the outfit, and returns what is chosen for it. */
  showOutfit(outfit: Outfit): MethodChoice {
    return this.methods.showOutfit(outfit);
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
}

function section(title: string, content: HTMLElement): HTMLElement {
  return make("section", {}, make("h3", { className: "eyebrow", textContent: title }), content);
}
