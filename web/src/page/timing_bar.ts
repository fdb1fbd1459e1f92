import type { DrapeDetail } from "../viewer/events";
import { make } from "./dom";

/** The stages of the service's work as one bar, with their times beneath. */
export function timingBar(detail: Pick<DrapeDetail, "stages" | "roundTrip" | "bytes">): HTMLElement {
  const stages = detail.stages.filter((stage) => stage.name !== "total");
  const total = serviceTime(detail.stages);
  const segments = stages.map((stage, index) => {
    const segment = make("span", { className: "timing__segment", title: `${stage.name} ${milliseconds(stage.milliseconds)}` });
    segment.style.setProperty("--share", String(stage.milliseconds / Math.max(total, 1e-6)));
    segment.style.setProperty("--tone", tone(index, stages.length));
    return segment;
  });
  const legend = stages.map((stage, index) => {
    const item = make("li", {}, make("span", { textContent: stage.name }), make("b", { textContent: milliseconds(stage.milliseconds) }));
    item.style.setProperty("--tone", tone(index, stages.length));
    return item;
  });
  const facts = `${milliseconds(detail.roundTrip)} round trip · ${kilobytes(detail.bytes)}`;
  return make(
    "div",
    { className: "timing" },
    make("p", { className: "timing__total" }, make("strong", { textContent: milliseconds(total) }), ` in the service · ${facts}`),
    make("div", { className: "timing__bar", role: "img", aria: { label: `The service took ${milliseconds(total)}` } }, ...segments),
    make("ul", { className: "timing__legend" }, ...legend),
  );
}

function tone(index: number, count: number): string {
  return `${Math.round((100 * index) / Math.max(count - 1, 1))}%`;
}

/** The service's own time: its `total` where it gives one, or the sum of the stages. */
export function serviceTime(stages: DrapeDetail["stages"]): number {
  const total = stages.find((stage) => stage.name === "total");
  return total?.milliseconds ?? stages.reduce((sum, stage) => sum + stage.milliseconds, 0);
}

export function milliseconds(value: number): string {
  if (value >= 1000) return `${(value / 1000).toFixed(1)} s`;
  return `${value.toFixed(value < 1 ? 2 : value < 100 ? 1 : 0)} ms`;
}

function kilobytes(bytes: number): string {
  return bytes < 1_000_000 ? `${Math.round(bytes / 1000)} kB` : `${(bytes / 1_000_000).toFixed(1)} MB`;
}
