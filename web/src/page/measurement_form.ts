import type { ToileApi } from "../api/client";
import { LatestRequest } from "../api/latest_request";
import { Problem } from "../api/problem";
import type { Body, BodyParameters, BodyRequest, SolvedBody } from "../api/types";
import { choiceButtons, make } from "./dom";
import { MeasurementRow } from "./measurement_row";
import type { UnitSystem } from "./units";

const GENDER_VALUES: Record<string, number | undefined> = { open: undefined, low: 0, high: 1 };

/** A tailor's measurements: the service finds the body that fits them best, and the form shows how well. */
export class MeasurementForm {
  readonly element: HTMLFormElement;
  private readonly rows: MeasurementRow[];
  private readonly error = make("p", { className: "field-error form-error", role: "alert", hidden: true });
  private readonly requests: LatestRequest;
  private gender: number | undefined;

  constructor(
    private readonly api: ToileApi,
    parameters: BodyParameters,
    private readonly onShape: (body: Body | null) => void,
  ) {
    this.requests = new LatestRequest((error) => this.fail(Problem.from(error)), 40);
    this.rows = parameters.measurements.map((parameter) => new MeasurementRow(parameter, () => this.solve()));
    this.element = make(
      "form",
      { className: "measurements", noValidate: true },
      make("p", { className: "hint", textContent: "Give what you know. The rest follows." }),
      make("div", { className: "measurements__top" }, this.genderChoice(parameters), this.unitChoice()),
      this.error,
      ...this.rows.map((row) => row.element),
      make("button", { type: "reset", className: "quiet-button", textContent: "Clear all measurements" }),
    );
    this.element.addEventListener("submit", (event) => event.preventDefault());
    this.element.addEventListener("reset", () => this.clear());
  }

  /** The measurements given, in the API's units. */
  get request(): BodyRequest {
    const given = this.rows.flatMap((row) => (row.value === undefined ? [] : [[row.parameter.name, row.value] as const]));
    return { measurements: Object.fromEntries(given), ...(this.gender === undefined ? {} : { gender: this.gender }) };
  }

  /** Sends the form again, when it comes back into view. */
  apply(): void {
    this.solve();
  }

  private genderChoice({ phenotypes }: BodyParameters): HTMLElement {
    const gender = phenotypes.find((phenotype) => phenotype.name === "gender");
    const choices = [
      { value: "open", label: "Any" },
      { value: "high", label: capital(gender?.high ?? "female") },
      { value: "low", label: capital(gender?.low ?? "male") },
    ];
    return choiceButtons("Body type", choices, "open", (value) => {
      this.gender = GENDER_VALUES[value];
      this.solve();
    }).element;
  }

  private unitChoice(): HTMLElement {
    const choices = [
      { value: "metric" as UnitSystem, label: "cm · kg" },
      { value: "imperial" as UnitSystem, label: "in · lb" },
    ];
    return choiceButtons("Units", choices, "metric", (system) => {
      for (const row of this.rows) row.useUnits(system);
      this.solve();
    }).element;
  }

  private solve(): void {
    const { request } = this;
    if (Object.keys(request.measurements).length === 0 && request.gender === undefined) {
      this.requests.cancel();
      this.showError(undefined);
      this.onShape(null);
      return;
    }
    this.requests.submit(async (signal) => this.show(await this.api.solveBody(request, signal)));
  }

  private show(solved: SolvedBody): void {
    this.showError(undefined);
    for (const row of this.rows) {
      const measurement = solved.measurements[row.parameter.name];
      row.showError(undefined);
      if (measurement) row.showSolved(measurement);
    }
    this.onShape(solved.shape);
  }

  private fail(problem: Problem): void {
    const row = this.rows.find((candidate) => candidate.parameter.name === problem.field);
    if (row) row.showError(problem.detail || problem.title);
    this.showError(row ? undefined : problem);
  }

  private showError(problem: Problem | undefined): void {
    this.error.textContent = problem ? [problem.title, problem.detail].filter(Boolean).join(": ") : "";
    this.error.hidden = !problem;
  }

  private clear(): void {
    for (const row of this.rows) {
      const { default: achieved } = row.parameter;
      row.value = undefined;
      row.showSolved({ requested: null, achieved, residual: null });
    }
    this.solve();
  }
}

function capital(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}
