import type { ToileApi } from "../api/client";
import { Problem } from "../api/problem";
import type { MendingReport, Outfit } from "../api/types";
import { count, icon, make } from "./dom";

/** The worn outfit: its garments, the report of what was found and mended, and deleting it. */
export class OutfitDetails {
  readonly element = make("div", { className: "details" });
  private shown: string | undefined;

  constructor(
    private readonly api: ToileApi,
    private readonly onDeleted: (id: string) => void,
  ) {}

  /** Shows an outfit; `open` unfolds the report, as after an upload. */
  async show(outfit: Outfit | undefined, open = false): Promise<void> {
    this.shown = outfit?.id;
    this.element.replaceChildren();
    if (!outfit) return;
    const full = outfit.report ? outfit : await this.api.outfit(outfit.id).catch(() => outfit);
    if (this.shown !== outfit.id) return;
    this.element.replaceChildren(this.facts(full, open), this.deleteButton(full));
  }

  private facts(outfit: Outfit, open: boolean): HTMLElement {
    const rows = outfit.garments.map((garment) =>
      fact(garment.name, `${count(garment.vertices, "vertex").replace("vertexs", "vertices")}`),
    );
    return make(
      "details",
      { className: "report", open },
      make("summary", { textContent: outfit.report ? "Details and mending report" : "Details" }),
      make("dl", { className: "facts" }, ...rows.flat()),
      outfit.report ? reportOf(outfit.report) : undefined,
    );
  }

  private deleteButton(outfit: Outfit): HTMLElement {
    const button = make(
      "button",
      { type: "button", className: "quiet-button quiet-button--danger", id: "delete-outfit" },
      icon("trash"),
      "Delete this outfit",
    );
    button.addEventListener("click", () => this.confirm(outfit));
    return button;
  }

  private confirm(outfit: Outfit): void {
    const error = make("p", { className: "field-error", role: "alert", hidden: true });
    const cancel = make("button", { type: "button", className: "quiet-button", textContent: "Keep it" });
    const remove = make("button", { type: "button", className: "solid-button solid-button--danger", textContent: "Delete" });
    const dialog = make(
      "dialog",
      { className: "dialog", aria: { labelledby: "delete-title" } },
      make("h2", { id: "delete-title", textContent: `Delete “${outfit.name}”?` }),
      make("p", { textContent: "It cannot be brought back. The file can be added again." }),
      error,
      make("div", { className: "dialog__actions" }, cancel, remove),
    );
    cancel.addEventListener("click", () => dialog.close());
    dialog.addEventListener("close", () => dialog.remove());
    remove.addEventListener("click", () => {
      void this.delete(outfit, dialog).catch((reason: unknown) => {
        error.textContent = Problem.from(reason).message;
        error.hidden = false;
      });
    });
    document.body.append(dialog);
    dialog.showModal();
  }

  private async delete(outfit: Outfit, dialog: HTMLDialogElement): Promise<void> {
    await this.api.deleteOutfit(outfit.id);
    dialog.close();
    this.onDeleted(outfit.id);
  }
}

function reportOf(report: MendingReport): HTMLElement {
  const mended: [string, number][] = [
    ["Welded vertices", report.welded_vertices],
    ["Flipped normals", report.flipped_normals],
    ["Degenerate faces removed", report.degenerate_faces_removed],
    ["Duplicate faces removed", report.duplicate_faces_removed],
    ["Non-manifold edges", report.non_manifold_edges],
    ["Components", report.components],
  ];
  const scale = report.scale_applied === 1 ? report.units : `${report.units}, scaled by ${report.scale_applied}`;
  const rows = [
    ...mended.filter(([, number]) => number > 0).map(([label, number]) => fact(label, number.toLocaleString("en"))),
    fact("Inside the body at rest", `${report.rest_penetration_percent.toFixed(1)} %`),
    fact("Edges through its own cloth", `${report.self_crossed_percent.toFixed(1)} %`),
    fact("Units", scale),
    fact("Up axis", report.up_axis.toUpperCase()),
  ];
  return make(
    "div",
    {},
    make("h3", { className: "eyebrow", textContent: "Found and mended" }),
    make("dl", { className: "facts" }, ...rows.flat()),
    make("ul", { className: "notes" }, ...report.notes.map((note) => make("li", { textContent: note }))),
  );
}

function fact(label: string, value: string): [HTMLElement, HTMLElement] {
  return [make("dt", { textContent: label }), make("dd", { textContent: value })];
}
