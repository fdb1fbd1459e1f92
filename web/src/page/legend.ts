import { HEAT_SCALES, type HeatSummary } from "../viewer/heat_map";
import { make } from "./dom";

/** The scale of the heat map, and what it says of this drape. */
export function heatLegend(summary: HeatSummary): HTMLElement {
  const scale = HEAT_SCALES[summary.kind];
  const ramp = make("span", { className: "legend__ramp" });
  ramp.style.background = `linear-gradient(90deg, ${scale.stops.join(", ")})`;
  return make(
    "div",
    { className: "legend", role: "note", aria: { label: scale.title } },
    make("strong", { textContent: scale.title }),
    ramp,
    make("span", { className: "legend__ends" }, make("span", { textContent: scale.lowLabel }), make("span", { textContent: scale.highLabel })),
    make("span", { className: "legend__summary", textContent: describe(summary) }),
  );
}

function describe({ kind, max, share }: HeatSummary): string {
  const percent = `${(share * 100).toFixed(1)} % of vertices`;
  if (kind === "penetration") return `${percent} more than 0.5 mm inside; deepest ${(max * 1000).toFixed(1)} mm`;
  return `${percent} stretched more than 5 %; most ${(max * 100).toFixed(0)} %`;
}
