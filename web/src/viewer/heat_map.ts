import { BufferAttribute, type BufferGeometry, Color, DynamicDrawUsage, SRGBColorSpace } from "three";
import type { VertexAttribute } from "../api/types";

/** What a heat map shows, in the unit of its legend. */
export interface HeatScale {
  kind: VertexAttribute;
  title: string;
  /** Values, in the attribute's own unit, at the two ends of the ramp. */
  from: number;
  to: number;
  lowLabel: string;
  highLabel: string;
  stops: string[];
}

type Values = ArrayLike<number> & Iterable<number>;

export interface HeatSummary {
  kind: VertexAttribute;
  /** Largest value, in the attribute's own unit. */
  max: number;
  /** Share of garment vertices above the scale's threshold, 0 to 1. */
  share: number;
}

export const HEAT_SCALES: Record<VertexAttribute, HeatScale> = {
  penetration: {
    kind: "penetration",
    title: "Inside the body before the resolve",
    from: 0,
    to: 0.01,
    lowLabel: "0 mm",
    highLabel: "10 mm",
    stops: ["#e9e4da", "#f2c879", "#e07a3f", "#a81e32", "#4f0a2c"],
  },
  strain: {
    kind: "strain",
    title: "Stretch against the rest pose",
    from: -0.15,
    to: 0.15,
    lowLabel: "−15 %",
    highLabel: "+15 %",
    stops: ["#274b8f", "#7fa8d6", "#e9e4da", "#e79a6b", "#a3242f"],
  },
};

/** A vertex counts towards `HeatSummary.share` above this: half a millimetre inside, or 5 % longer. */
const THRESHOLD: Record<VertexAttribute, number> = { penetration: 0.0005, strain: 0.05 };

/** A colour between the stops, linear sRGB. `share` is 0 at the first stop and 1 at the last. */
export function rampColor(stops: readonly Color[], share: number, target: Color): Color {
  const last = stops.length - 1;
  const place = Math.min(Math.max(Number.isFinite(share) ? share : 0, 0), 1) * last;
  const index = Math.min(Math.floor(place), last - 1);
  const low = stops[index];
  const high = stops[index + 1];
  return low && high ? target.lerpColors(low, high, place - index) : target;
}

/** Writes the heat colours of `values` into the geometry's `color` attribute, reusing it where it fits. */
export function paintHeat(geometry: BufferGeometry, values: ArrayLike<number>, kind: VertexAttribute): void {
  const scale = HEAT_SCALES[kind];
  const stops = scale.stops.map((stop) => new Color().setStyle(stop, SRGBColorSpace));
  const colors = colorAttribute(geometry, values.length);
  const color = new Color();
  for (let vertex = 0; vertex < values.length; vertex++) {
    rampColor(stops, ((values[vertex] ?? 0) - scale.from) / (scale.to - scale.from), color);
    colors.setXYZ(vertex, color.r, color.g, color.b);
  }
  colors.needsUpdate = true;
}

export function summarizeHeat(kind: VertexAttribute, arrays: Values[]): HeatSummary {
  let max = 0;
  let above = 0;
  let count = 0;
  for (const values of arrays) {
    for (const value of values) {
      max = Math.max(max, value);
      if (value > THRESHOLD[kind]) above++;
    }
    count += values.length;
  }
  return { kind, max, share: count > 0 ? above / count : 0 };
}

function colorAttribute(geometry: BufferGeometry, count: number): BufferAttribute {
  const existing = geometry.getAttribute("color");
  if (existing instanceof BufferAttribute && existing.count === count) return existing;
  const created = new BufferAttribute(new Float32Array(count * 3), 3).setUsage(DynamicDrawUsage);
  geometry.setAttribute("color", created);
  return created;
}
