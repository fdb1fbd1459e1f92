import { describe, expect, it } from "vitest";
import { Color } from "three";
import { rampColor, summarizeHeat } from "../src/viewer/heat_map";

const stops = [new Color(0, 0, 0), new Color(1, 0, 0), new Color(1, 1, 1)];

describe("heat map", () => {
  it.each([[-1, 0], [0, 0], [0.25, 0.5], [0.5, 1], [2, 1], [Number.NaN, 0]])("ramps %d to red %d", (share, red) => {
    expect(rampColor(stops, share, new Color(9, 9, 9)).r).toBeCloseTo(red);
  });

  it("counts vertices more than half a millimetre inside the body", () => {
    const summary = summarizeHeat("penetration", [Float32Array.of(0, 0.0002, 0.004), Float32Array.of(0.001)]);
    expect(summary.share).toBe(0.5);
    expect(summary.max).toBeCloseTo(0.004);
  });
});
