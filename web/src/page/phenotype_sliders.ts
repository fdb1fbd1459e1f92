import type { Body, PhenotypeParameter } from "../api/types";
import { make } from "./dom";

/** The body by its phenotypes: one slider each, live. */
export class PhenotypeSliders {
  readonly element: HTMLElement;
  private readonly sliders = new Map<string, { input: HTMLInputElement; parameter: PhenotypeParameter }>();

  constructor(
    parameters: PhenotypeParameter[],
    private readonly onShape: (body: Body | null) => void,
  ) {
    const reset = make("button", { type: "button", className: "quiet-button", textContent: "Back to the reference body" });
    reset.addEventListener("click", () => this.reset());
    this.element = make("div", { className: "phenotypes" }, ...parameters.map((p) => this.row(p)), reset);
  }

  /** The body chosen; null is the reference body. Only what differs from the default is sent. */
  get body(): Body | null {
    const values: Record<string, number> = {};
    for (const [name, { input, parameter }] of this.sliders) {
      if (Math.abs(input.valueAsNumber - nearestStep(parameter)) > 1e-6) values[name] = input.valueAsNumber;
    }
    return Object.keys(values).length > 0 ? { kind: "phenotypes", values } : null;
  }

  apply(): void {
    this.onShape(this.body);
  }

  private row(parameter: PhenotypeParameter): HTMLElement {
    const id = `phenotype-${parameter.name}`;
    const input = make("input", { id, type: "range" });
    input.min = String(parameter.min);
    input.max = String(parameter.max);
    input.step = String(step(parameter));
    input.value = String(nearestStep(parameter));
    input.addEventListener("input", () => this.apply());
    this.sliders.set(parameter.name, { input, parameter });
    return make(
      "div",
      { className: "phenotype" },
      make("label", { htmlFor: id, textContent: parameter.label }),
      input,
      make("span", { className: "phenotype__low", textContent: parameter.low }),
      make("span", { className: "phenotype__high", textContent: parameter.high }),
    );
  }

  private reset(): void {
    for (const { input, parameter } of this.sliders.values()) input.value = String(nearestStep(parameter));
    this.apply();
  }
}

function step(parameter: PhenotypeParameter): number {
  return (parameter.max - parameter.min) / 100;
}

/** The default on the slider's grid: what the input holds when untouched. */
function nearestStep(parameter: PhenotypeParameter): number {
  const { min, default: value } = parameter;
  return Number((min + Math.round((value - min) / step(parameter)) * step(parameter)).toFixed(6));
}
