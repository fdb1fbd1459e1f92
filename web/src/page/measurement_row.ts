import type { MeasurementParameter, SolvedMeasurement } from "../api/types";
import { icon, make } from "./dom";
import { formatMeasure, formatResidual, fromShown, shownUnit, toShown, type UnitSystem } from "./units";

const TYPING_PAUSE = 600;

/** One measurement: number, slider, what the solved body achieves, and its error. Not given until touched. */
export class MeasurementRow {
  readonly element: HTMLElement;
  private readonly number: HTMLInputElement;
  private readonly slider: HTMLInputElement;
  private readonly unit = make("span", { className: "measure__unit" });
  private readonly note: HTMLElement;
  private readonly error: HTMLElement;
  private readonly release: HTMLButtonElement;
  private requested: number | undefined;
  private achieved: number;
  private system: UnitSystem = "metric";
  private typing: ReturnType<typeof setTimeout> | undefined;

  constructor(
    readonly parameter: MeasurementParameter,
    private readonly onChange: () => void,
  ) {
    const { name, label, description } = parameter;
    const id = `measure-${name}`;
    this.achieved = parameter.default;
    this.number = make("input", { id, type: "text", inputMode: "decimal", autocomplete: "off", title: description });
    this.number.setAttribute("aria-describedby", `${id}-note ${id}-error`);
    this.slider = make("input", { type: "range", step: "0.1", aria: { label: `${label}, slider` } });
    this.note = make("p", { id: `${id}-note`, className: "measure__note" });
    this.error = make("p", { id: `${id}-error`, className: "field-error", role: "alert", hidden: true });
    this.release = make(
      "button",
      { type: "button", className: "icon-button measure__release", title: "Leave open", aria: { label: `Leave ${label} open` } },
      icon("close"),
    );
    const caption = make("label", { htmlFor: id, className: "measure__label", textContent: label });
    const field = make("span", { className: "measure__field" }, this.number, this.unit);
    this.element = make(
      "div",
      { className: "measure", data: { name } },
      caption, this.slider, this.release, field, this.note, this.error,
    );
    this.listen();
    this.draw();
  }

  /** The value asked for, in the API's unit. */
  get value(): number | undefined {
    return this.requested;
  }

  set value(value: number | undefined) {
    this.requested = value;
    this.showError(undefined);
    this.draw();
  }

  useUnits(system: UnitSystem): void {
    this.system = system;
    this.draw();
  }

  showSolved(solved: SolvedMeasurement): void {
    this.achieved = solved.achieved;
    this.draw(solved);
  }

  showError(text: string | undefined): void {
    this.error.textContent = text ?? "";
    this.error.hidden = !text;
    this.number.setAttribute("aria-invalid", String(Boolean(text)));
  }

  private listen(): void {
    this.slider.addEventListener("input", () => this.accept(this.slider.value));
    this.number.addEventListener("change", () => this.accept(this.number.value));
    this.number.addEventListener("input", () => {
      clearTimeout(this.typing);
      this.typing = setTimeout(() => this.accept(this.number.value), TYPING_PAUSE);
    });
    this.release.addEventListener("click", () => {
      this.value = undefined;
      this.onChange();
      this.number.focus();
    });
  }

  private accept(text: string): void {
    clearTimeout(this.typing);
    const trimmed = text.trim().replace(",", ".");
    const shown = Number(trimmed);
    if (trimmed !== "" && !Number.isFinite(shown)) {
      this.showError("Enter a number.");
      return;
    }
    const next = trimmed === "" ? undefined : fromShown(shown, this.parameter.unit, this.system);
    if (next === this.requested) return;
    this.value = next;
    this.onChange();
  }

  private draw(solved?: SolvedMeasurement): void {
    const { unit, min, max } = this.parameter;
    const show = (value: number): number => toShown(value, unit, this.system);
    this.slider.min = String(show(min));
    this.slider.max = String(show(max));
    this.slider.value = String(show(this.requested ?? this.achieved));
    this.unit.textContent = shownUnit(unit, this.system);
    this.number.placeholder = formatMeasure(show(this.achieved));
    // What is being typed is left alone, whatever answer arrives meanwhile.
    if (document.activeElement !== this.number) {
      this.number.value = this.requested === undefined ? "" : formatMeasure(show(this.requested));
    }
    this.release.hidden = this.requested === undefined;
    this.element.classList.toggle("measure--given", this.requested !== undefined);
    this.note.textContent = solved ? this.describe(solved) : "";
  }

  private describe(solved: SolvedMeasurement): string {
    if (solved.requested === null || solved.residual === null) return "";
    const { unit } = this.parameter;
    const residual = formatResidual(toShown(solved.residual, unit, this.system));
    const achieved = formatMeasure(toShown(solved.achieved, unit, this.system));
    const text = `${achieved} ${shownUnit(unit, this.system)}`;
    return residual ? `Closest body: ${text} (${residual})` : `Met: ${text}`;
  }
}
