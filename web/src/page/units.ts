export type UnitSystem = "metric" | "imperial";

const IMPERIAL: Record<string, { unit: string; factor: number }> = {
  cm: { unit: "in", factor: 1 / 2.54 },
  kg: { unit: "lb", factor: 2.204_622_6 },
};

/** The unit in which a measurement is shown. */
export function shownUnit(unit: string, system: UnitSystem): string {
  return system === "imperial" ? (IMPERIAL[unit]?.unit ?? unit) : unit;
}

/** From the API's unit (centimetres, kilograms) to the shown one. */
export function toShown(value: number, unit: string, system: UnitSystem): number {
  return system === "imperial" ? value * (IMPERIAL[unit]?.factor ?? 1) : value;
}

/** From the shown unit to the API's, to a thousandth, so that 66 in is sent as 167.64 cm. */
export function fromShown(value: number, unit: string, system: UnitSystem): number {
  const metric = system === "imperial" ? value / (IMPERIAL[unit]?.factor ?? 1) : value;
  return Math.round(metric * 1000) / 1000;
}

export function formatMeasure(value: number): string {
  return value.toFixed(1).replace(/\.0$/, "");
}

/** A residual with its sign, or undefined where it rounds to nothing. */
export function formatResidual(residual: number): string | undefined {
  const text = formatMeasure(Math.abs(residual));
  if (text === "0") return undefined;
  return `${residual > 0 ? "+" : "−"}${text}`;
}
