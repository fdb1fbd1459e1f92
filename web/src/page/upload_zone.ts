import type { ToileApi } from "../api/client";
import { Problem } from "../api/problem";
import type { Outfit, OutfitMetadata } from "../api/types";
import { upload } from "../api/upload";
import { icon, make } from "./dom";

const ACCEPT = ".glb,.gltf,.obj,model/gltf-binary,model/gltf+json,model/obj";

/** Adds an outfit: a button, a form for what the file does not say, and dropping a file anywhere on the page. */
export class UploadZone {
  readonly element: HTMLElement;
  readonly veil = make("div", { className: "drop-veil", hidden: true }, make("p", { textContent: "Drop to add the outfit" }));
  private readonly input = make("input", { type: "file", accept: ACCEPT, className: "visually-hidden", id: "upload-file" });
  private readonly status = make("p", { className: "upload__status", role: "status" });
  private readonly bar = make("progress", { max: 1, value: 0, hidden: true, aria: { label: "Upload" } });
  private readonly error = make("div", { className: "field-error", role: "alert", hidden: true });
  private readonly units = select("upload-units", [["", "Detect"], ["m", "Metres"], ["cm", "Centimetres"], ["mm", "Millimetres"], ["in", "Inches"]]);
  private readonly up = select("upload-up", [["", "Detect"], ["y", "Y is up"], ["z", "Z is up"]]);

  constructor(
    private readonly api: ToileApi,
    private readonly onUploaded: (outfit: Outfit) => void,
  ) {
    const label = make(
      "label",
      { htmlFor: this.input.id, className: "upload__label" },
      icon("upload"),
      make("span", {}, make("strong", { textContent: "Add an outfit" }), " GLB, glTF or OBJ. Drop it here or choose a file."),
    );
    const options = make(
      "details",
      { className: "upload__options" },
      make("summary", { textContent: "About the file" }),
      make("label", {}, "Units", this.units),
      make("label", {}, "Axis", this.up),
    );
    this.element = make("div", { className: "upload" }, this.input, label, options, this.bar, this.status, this.error);
    this.input.addEventListener("change", () => {
      const file = this.input.files?.[0];
      this.input.value = "";
      if (file) void this.send(file);
    });
    this.listenForDrops();
  }

  private listenForDrops(): void {
    let depth = 0;
    const show = (step: number): void => {
      depth = Math.max(depth + step, 0);
      this.veil.hidden = depth === 0;
    };
    const carriesFile = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
    window.addEventListener("dragenter", (event) => { if (carriesFile(event)) show(1); });
    window.addEventListener("dragleave", (event) => { if (carriesFile(event)) show(-1); });
    window.addEventListener("dragover", (event) => { if (carriesFile(event)) event.preventDefault(); });
    window.addEventListener("drop", (event) => {
      const file = event.dataTransfer?.files[0];
      show(-depth);
      if (!file) return;
      event.preventDefault();
      void this.send(file);
    });
  }

  private async send(file: File): Promise<void> {
    this.begin(file);
    try {
      const outfit = await upload<Outfit>(this.api.url("/v1/outfits"), file, this.metadata(file), (share) => {
        this.bar.value = share;
        this.status.textContent = share < 1 ? `Sending ${file.name}…` : `Reading and mending ${file.name}…`;
      });
      this.status.textContent = `${outfit.name} was added.`;
      this.onUploaded(outfit);
    } catch (error) {
      this.fail(file, Problem.from(error));
    }
    this.bar.hidden = true;
  }

  private begin(file: File): void {
    this.error.hidden = true;
    this.bar.hidden = false;
    this.bar.value = 0;
    this.status.textContent = `Sending ${file.name}…`;
  }

  private fail(file: File, problem: Problem): void {
    const retry = make("button", { type: "button", className: "quiet-button", textContent: "Try again" });
    retry.addEventListener("click", () => void this.send(file));
    const text = [problem.title, problem.detail].filter(Boolean).join(": ");
    this.status.textContent = "";
    this.error.replaceChildren(make("p", { textContent: text }), retry);
    this.error.hidden = false;
  }

  private metadata(file: File): OutfitMetadata {
    return {
      name: nameFromFile(file.name),
      ...(this.units.value ? { units: this.units.value as NonNullable<OutfitMetadata["units"]> } : {}),
      ...(this.up.value ? { up: this.up.value as NonNullable<OutfitMetadata["up"]> } : {}),
    };
  }
}

/** `summer_dress-02.glb` is called "Summer dress 02". */
export function nameFromFile(file: string): string {
  const stem = file.replace(/\.[^.]*$/, "").replaceAll(/[_-]+/g, " ").trim();
  return stem ? stem.charAt(0).toUpperCase() + stem.slice(1) : "Outfit";
}

function select(id: string, options: [value: string, label: string][]): HTMLSelectElement {
  return make("select", { id }, ...options.map(([value, label]) => make("option", { value, textContent: label })));
}
