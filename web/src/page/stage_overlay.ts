import type { Problem } from "../api/problem";
import type { ClothPicture, Outfit } from "../api/types";
import type { View } from "../viewer/camera_rig";
import type { DrapeDetail } from "../viewer/events";
import { make } from "./dom";
import { heatLegend } from "./legend";
import { milliseconds, serviceTime } from "./timing_bar";

const VIEWS: readonly { view: View; label: string }[] = [
  { view: "front", label: "Front" },
  { view: "side", label: "Side" },
  { view: "back", label: "Back" },
];

export interface OverlayActions {
  look: (view: View) => void;
  retry: () => void;
  openInsight: () => void;
}

/** What lies over the stage: the outfit's name, views, progress, the heat map's legend, and problems. */
export class StageOverlay {
  readonly elements: HTMLElement[];
  private readonly title = make("h1", { className: "stage__title" });
  private readonly subtitle = make("p", { className: "stage__subtitle" });
  private readonly progress = make("div", { className: "stage__progress", role: "progressbar", hidden: true, aria: { label: "Draping" } });
  private readonly loading = make("p", { className: "stage__loading", role: "status", hidden: true }, make("span", { className: "spinner" }), "Draping…");
  private readonly notice = make("div", { className: "stage__notice", role: "alert", hidden: true });
  private readonly legend = make("div", { className: "stage__legend" });
  private readonly cloth = make("div", { className: "stage__cloth" });
  private readonly speed: HTMLButtonElement;
  private readonly blank = make("div", { className: "stage__blank", hidden: true }, make("p", { textContent: "Choose an outfit to see it worn." }));

  constructor(private readonly actions: OverlayActions) {
    this.speed = make("button", { type: "button", className: "stage__speed", hidden: true, onclick: actions.openInsight });
    const views = VIEWS.map(({ view, label }) => make("button", { type: "button", textContent: label, onclick: () => actions.look(view) }));
    this.elements = [
      this.progress,
      make("div", { className: "stage__caption" }, this.title, this.subtitle),
      make("div", { className: "stage__views", role: "group", aria: { label: "View" } }, ...views),
      this.blank,
      this.loading,
      this.legend,
      this.cloth,
      this.speed,
      this.notice,
    ];
  }

  showOutfit(outfit: Outfit | undefined): void {
    this.title.textContent = outfit?.name ?? "";
    this.subtitle.textContent = outfit ? garmentNames(outfit) : "";
    this.blank.hidden = outfit !== undefined;
    if (outfit) return;
    this.speed.hidden = true;
    this.cloth.replaceChildren();
  }

  showLoading(busy: boolean, first: boolean): void {
    this.progress.hidden = !busy;
    this.loading.hidden = !(busy && first);
    if (busy) this.showProblem(undefined);
  }

  showDrape(detail: DrapeDetail): void {
    const time = serviceTime(detail.stages);
    this.speed.hidden = time <= 0;
    this.speed.textContent = `Draped in ${milliseconds(time)}`;
    this.legend.replaceChildren(...(detail.heat ? [heatLegend(detail.heat)] : []));
    this.cloth.replaceChildren(...detail.cloth.map(clothPicture));
  }

  showProblem(problem: Problem | undefined): void {
    this.notice.hidden = !problem;
    if (!problem) return;
    const retry = make("button", { type: "button", className: "solid-button", textContent: "Try again", onclick: this.actions.retry });
    const words = make("div", {}, make("strong", { textContent: problem.title }), make("p", { textContent: problem.detail }));
    this.notice.replaceChildren(words, retry);
  }
}

/** A garment's cloth image beside the cloth. */
function clothPicture({ garment, url, preview }: ClothPicture): HTMLElement {
  const image = make("img", { src: preview, alt: `Cloth image of ${garment}`, width: 256, height: 128 });
  const words = make("figcaption", { textContent: "Cloth image: offsets along u, v and off the skin" });
  return make("a", { href: url, target: "_blank", title: "All 16 bits" }, make("figure", {}, image, words));
}

/** The garments' names, unless they only repeat the outfit's own. */
function garmentNames(outfit: Outfit): string {
  const names = outfit.garments.map((garment) => garment.name.replaceAll("_", " "));
  return names.length === 1 && names[0]?.toLowerCase() === outfit.name.toLowerCase() ? "" : names.join(" · ");
}
