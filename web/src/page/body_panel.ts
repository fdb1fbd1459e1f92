import type { ToileApi } from "../api/client";
import { Problem } from "../api/problem";
import type { Body } from "../api/types";
import { choiceButtons, make } from "./dom";
import { MeasurementForm } from "./measurement_form";
import { failure, loading } from "./placeholders";
import { PhenotypeSliders } from "./phenotype_sliders";

/** The shopper's body, by measurements or by shape. */
export class BodyPanel {
  readonly element = make("div", { className: "stack" });

  constructor(
    private readonly api: ToileApi,
    private readonly onBody: (body: Body | null) => void,
  ) {
    void this.load();
  }

  private async load(): Promise<void> {
    this.element.replaceChildren(loading("Loading the body…"));
    try {
      const parameters = await this.api.bodyParameters();
      const form = new MeasurementForm(this.api, parameters, this.onBody);
      const sliders = new PhenotypeSliders(parameters.phenotypes, this.onBody);
      sliders.element.hidden = true;
      const modes = [
        { value: "measurements", label: "Measurements" },
        { value: "shape", label: "Shape" },
      ] as const;
      const chooser = choiceButtons("Describe the body by", modes, "measurements", (mode) => {
        form.element.hidden = mode !== "measurements";
        sliders.element.hidden = mode !== "shape";
        (mode === "shape" ? sliders : form).apply();
      });
      chooser.element.classList.add("segmented--wide");
      this.element.replaceChildren(chooser.element, form.element, sliders.element);
    } catch (error) {
      this.element.replaceChildren(failure(Problem.from(error), () => void this.load()));
    }
  }
}
