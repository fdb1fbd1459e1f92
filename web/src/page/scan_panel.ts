import type { ToileApi } from "../api/client";
import { Problem } from "../api/problem";
import type { Body, BodyParameters, SolvedBody } from "../api/types";
import { upload } from "../api/upload";
import { icon, make } from "./dom";
import { formatMeasure } from "./units";

/** A scan of the shopper: the service finds the body that is nearest to it. */
export class ScanPanel {
  readonly element: HTMLElement;
  private readonly input = make("input", { type: "file", accept: ".glb,.gltf,.obj", className: "visually-hidden", id: "scan-file" });
  private readonly status = make("p", { className: "upload__status", role: "status" });
  private readonly bar = make("progress", { max: 1, value: 0, hidden: true, aria: { label: "Upload" } });
  private readonly error = make("p", { className: "field-error", role: "alert", hidden: true });
  private readonly facts = make("dl", { className: "facts" });
  private shape: Body | null = null;

  constructor(
    private readonly api: ToileApi,
    private readonly parameters: BodyParameters,
    private readonly onShape: (body: Body | null) => void,
  ) {
    const text = " A mesh of a person in the A-pose: GLB, glTF or OBJ. Holes and noise do not matter.";
    const label = make(
      "label",
      { htmlFor: this.input.id, className: "upload__label" },
      icon("upload"),
      make("span", {}, make("strong", { textContent: "Use a scan" }), text),
    );
    this.element = make("div", { className: "upload" }, this.input, label, this.bar, this.status, this.error, this.facts);
    this.input.addEventListener("change", () => {
      const file = this.input.files?.[0];
      this.input.value = "";
      if (file) void this.send(file);
    });
  }

  /** Shows the last scan's body again, when the panel comes back into view. */
  apply(): void {
    this.onShape(this.shape);
  }

  private async send(file: File): Promise<void> {
    this.error.hidden = true;
    this.bar.hidden = false;
    try {
      const solved = await upload<SolvedBody>(this.api.url("/v1/bodies"), file, {}, (share) => {
        this.bar.value = share;
        this.status.textContent = share < 1 ? `Sending ${file.name}…` : "Looking for the nearest body…";
      });
      this.show(solved);
    } catch (error) {
      const problem = Problem.from(error);
      this.status.textContent = "";
      this.error.textContent = [problem.title, problem.detail].filter(Boolean).join(": ");
      this.error.hidden = false;
    }
    this.bar.hidden = true;
  }

  private show({ shape, scan, measurements }: SolvedBody): void {
    this.status.textContent = scan ? `The nearest body is ${scan.distance_mm.toFixed(1)} mm off the scan.` : "";
    const rows = this.parameters.measurements.map(({ name, label, unit }) => {
      const achieved = measurements[name]?.achieved;
      return [label, achieved === undefined ? "" : `${formatMeasure(achieved)} ${unit}`] as const;
    });
    this.facts.replaceChildren(
      ...rows.flatMap(([label, value]) => [make("dt", { textContent: label }), make("dd", { textContent: value })]),
    );
    this.shape = shape;
    this.onShape(shape);
  }
}
