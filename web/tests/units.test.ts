import { expect, it } from "vitest";
import { formatMeasure, formatResidual, fromShown, shownUnit, toShown } from "../src/page/units";
import { nameFromFile } from "../src/page/upload_zone";

it("goes from centimetres to inches and back", () => {
  expect(toShown(167.64, "cm", "imperial")).toBeCloseTo(66, 3);
  expect(fromShown(66, "cm", "imperial")).toBe(167.64);
  expect(fromShown(150, "lb", "metric")).toBe(150);
  expect(toShown(70, "kg", "imperial")).toBeCloseTo(154.3, 1);
  expect([shownUnit("kg", "imperial"), shownUnit("cm", "metric")]).toEqual(["lb", "cm"]);
});

it("shows a tenth, and a residual only where it is one", () => {
  expect([168, 92.45].map(formatMeasure)).toEqual(["168", "92.5"]);
  expect([0.02, -0.31, 1.4].map(formatResidual)).toEqual([undefined, "−0.3", "+1.4"]);
});

it("names an outfit after its file", () => {
  expect(["summer_dress-02.glb", "COAT.obj", ".glb"].map(nameFromFile)).toEqual(["Summer dress 02", "COAT", "Outfit"]);
});
