import type { ToileApi } from "../api/client";
import { Problem } from "../api/problem";
import type { Body } from "../api/types";
import { choiceButtons, make } from "./dom";
import { MeasurementForm } from "./measurement_form";
import { failure, loading } from "./placeholders";
import { PhenotypeSliders } from "./phenotype_sliders";
import { ScanPanel } from "./scan_panel";

/** The shopper's body, by measurements, by shape or by a scan. */
export class BodyPanel {
  readonly element = make("div", { className: "stack" });

  constructor(
    private readonly api: ToileApi,
    private readonly onBody: (body: Body | null) => void,
  ) {
    void this.load();
  }

  /** Forgets what was given: the reference body's own figures stand again. Tells nobody. */
  reset(): void {
    void this.load();
  }

  private async load(): Promise<void> {
    this.element.replaceChildren(loading("Loading the body…"));
    try {
      const parameters = await this.api.bodyParameters();
      const form = new MeasurementForm(this.api, parameters, this.onBody);
      const sliders = new PhenotypeSliders(parameters.phenotypes, this.onBody);
      const scan = new ScanPanel(this.api, parameters, this.onBody);
      const panels = { measurements: form, shape: sliders, scan };
      for (const panel of [sliders, scan]) panel.element.hidden = true;
      const modes = [
        { value: "measurements", label: "Measurements" },
        { value: "shape", label: "Shape" },
        { value: "scan", label: "Scan" },
      ] as const;
      const chooser = choiceButtons("Describe the body by", modes, "measurements", (mode) => {
        for (const [name, panel] of Object.entries(panels)) panel.element.hidden = name !== mode;
        panels[mode].apply();
      });
      chooser.element.classList.add("segmented--wide");
      this.element.replaceChildren(chooser.element, form.element, sliders.element, scan.element);
    } catch (error) {
      this.element.replaceChildren(failure(Problem.from(error), () => void this.load()));
    }
  }
}
