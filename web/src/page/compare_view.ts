import type { Kinds, Method, Outfit, SimulatedOn } from "../api/types";
import type { ToileViewer } from "../viewer/element";
import type { DrapeDetail, ViewerEventMap } from "../viewer/events";
import { make } from "./dom";
import { canDrape, METHODS, methodName } from "./methods";
import { milliseconds, serviceTime } from "./timing_bar";

/** What tells one drape from another beside it. */
interface Label {
  method: Method;
  time: number;
}

/**
 * The same outfit, body and pose by another method, beside the viewer: a choice of the method, a second viewer that
 * looks from where the first one does, the name and time of each, and how far apart the cloth lies.
 */
export class CompareView {
  readonly elements: HTMLElement[];
  private readonly select = make("select", { className: "compare__choice", name: "compare", aria: { label: "Compare with" } });
  private readonly none = make("option", { value: "" });
  private readonly own = make("p", { className: "compare__label compare__label--own", hidden: true });
  private readonly theirs = make("p", { className: "compare__label compare__label--other", hidden: true });
  private readonly notice = make("div", { className: "compare__notice", role: "status", hidden: true });
  private other: ToileViewer | undefined;
  private outfit: Outfit | undefined;
  private kinds: Kinds = {};
  private chosen: Method | undefined;
  private shown: Label | undefined;

  constructor(
    private readonly viewer: ToileViewer,
    private readonly stage: HTMLElement,
    private readonly onSimulated: (on: SimulatedOn) => void,
  ) {
    this.select.addEventListener("change", () => this.choose(METHODS.find(({ id }) => id === this.select.value)?.id));
    this.elements = [this.select, this.own, this.theirs, this.notice];
  }

  /** Offers what can drape the outfit, where `kinds` are those of its garments. */
  showOutfit(outfit: Outfit | undefined, kinds: Kinds): void {
    this.outfit = outfit;
    this.kinds = kinds;
    const able = outfit ? METHODS.filter(({ id }) => canDrape(id, outfit, kinds)) : [];
    const options = able.map(({ id, name }) => make("option", { value: id, textContent: name }));
    this.select.replaceChildren(this.none, ...options);
    this.choose(able.find(({ id }) => id === this.chosen)?.id);
  }

  /** The viewer shows a drape: the other one follows. */
  showDrape(detail: DrapeDetail): void {
    this.shown = { method: this.viewer.method ?? "deepsd", time: serviceTime(detail.stages) };
    this.follow();
  }

  tint(garment: string, color: string | undefined): void {
    this.other?.tint(garment, color);
  }

  seek(share: number): void {
    this.other?.seek(share);
  }

  private choose(method: Method | undefined): void {
    this.chosen = method;
    this.select.value = method ?? "";
    this.none.textContent = method ? "Nothing beside it" : "Compare with…";
    this.stage.classList.toggle("stage--split", method !== undefined);
    this.notice.hidden = true;
    if (method) this.follow();
    else this.close();
  }

  private close(): void {
    this.other?.remove();
    this.other = undefined;
    this.own.hidden = this.theirs.hidden = true;
  }

  private follow(): void {
    const { chosen, outfit, viewer } = this;
    if (!chosen || outfit?.id !== viewer.outfit || !this.shown) return;
    if (chosen === "simulation" && !this.isSimulated()) {
      this.showSimulated();
      return;
    }
    this.other ??= this.open();
    const { body, pose, motion, heat } = viewer;
    this.other.set({ outfit: outfit.id, body, pose, motion, heat, method: chosen, kinds: this.kinds });
  }

  private open(): ToileViewer {
    const other = document.createElement("toile-viewer");
    other.classList.add("compare__viewer");
    this.viewer.after(other);
    other.shareView(this.viewer);
    const on = <Name extends keyof ViewerEventMap>(name: Name, handle: (detail: ViewerEventMap[Name]["detail"]) => void): void => {
      other.addEventListener(name, (event) => {
        // What the other one says is told here, not by whoever listens to the page's own viewer.
        event.stopPropagation();
        handle((event as ViewerEventMap[Name]).detail);
      });
    };
    on("toile-drape", (detail) => this.showOther(detail));
    on("toile-error", ({ problem }) => this.showNotice(make("p", { textContent: problem.detail })));
    return other;
  }

  private showOther(detail: DrapeDetail): void {
    if (!this.chosen || !this.shown) return;
    this.notice.hidden = true;
    this.other?.classList.remove("compare__viewer--stale");
    // It does not play by itself: it is where the viewer's own motion is.
    const playback = this.viewer.stats().playback;
    if (playback) this.seek(playback.time / playback.duration);
    const apart = this.other?.distanceTo(this.viewer);
    this.label(this.own, this.shown);
    const time = this.chosen === "simulation" ? 0 : serviceTime(detail.stages);
    this.label(this.theirs, { method: this.chosen, time }, apart === undefined ? undefined : `${(100 * apart).toFixed(1)} cm apart`);
  }

  private label(element: HTMLElement, { method, time }: Label, apart?: string): void {
    const facts = [time > 0 ? milliseconds(time) : undefined, apart].filter((fact) => fact !== undefined);
    element.hidden = false;
    element.replaceChildren(make("strong", { textContent: methodName(method) }), facts.join(" · "));
  }

  /** Whether a simulation of what the viewer shows was kept. */
  private isSimulated(): boolean {
    const { body, pose, motion } = this.viewer;
    const id = pose?.kind === "preset" ? pose.id : undefined;
    return !body && !motion && this.simulatedPoses().some((on) => on.id === id);
  }

  private simulatedPoses(): { id: string; on: SimulatedOn }[] {
    const all = this.outfit?.simulated ?? [];
    return all.flatMap((on) => (on.pose.kind === "preset" ? [{ id: on.pose.id, on }] : []));
  }

  private showSimulated(): void {
    // What is still on its way to the other viewer is no answer to this.
    this.close();
    const chip = ({ id, on }: { id: string; on: SimulatedOn }): HTMLElement =>
      make("button", { type: "button", className: "chip", textContent: id.replaceAll("-", " "), onclick: () => this.onSimulated(on) });
    const words = make("p", { textContent: "This outfit was simulated on the reference body in these poses:" });
    this.showNotice(words, make("div", { className: "chips" }, ...this.simulatedPoses().map(chip)));
  }

  /** Instead of the other drape. */
  private showNotice(...content: HTMLElement[]): void {
    this.other?.classList.add("compare__viewer--stale");
    this.theirs.hidden = true;
    this.notice.hidden = false;
    this.notice.replaceChildren(...content);
  }
}
