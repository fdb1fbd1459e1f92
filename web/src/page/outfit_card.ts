import type { ToileApi } from "../api/client";
import type { Outfit } from "../api/types";
import type { PortraitStudio } from "../viewer/portrait";
import { make } from "./dom";

/** An outfit in the gallery: its picture and its name. */
export class OutfitCard {
  readonly element: HTMLLIElement;
  private readonly button: HTMLButtonElement;
  private readonly image: HTMLImageElement;
  private blob: string | undefined;

  constructor(
    readonly outfit: Outfit,
    private readonly api: ToileApi,
    private readonly portraits: PortraitStudio,
    onChoose: () => void,
  ) {
    this.image = make("img", { alt: "", width: 256, height: 320, decoding: "async" });
    const frame = make("span", { className: "card__frame" }, this.image);
    const name = make("span", { className: "card__name", textContent: outfit.name });
    const title = "Its draping has been refined for this outfit alone";
    const bake = make("span", { className: "card__bake", textContent: "refined", title, hidden: !outfit.links.bake });
    this.button = make(
      "button",
      { type: "button", className: "card__button", onclick: onChoose, data: { outfit: outfit.id } },
      frame,
      name,
      bake,
    );
    this.element = make("li", { className: "card card--loading" }, this.button);
    void this.picture();
  }

  select(worn: boolean): void {
    this.button.setAttribute("aria-pressed", String(worn));
  }

  dispose(): void {
    if (this.blob) URL.revokeObjectURL(this.blob);
    this.element.remove();
  }

  /** The service's picture, or one drawn here where it has none. */
  private async picture(): Promise<void> {
    this.blob = (await this.thumbnail()) ?? (await this.portraits.draw(this.outfit).catch(() => undefined));
    if (this.blob) this.image.src = this.blob;
    this.element.classList.remove("card--loading");
    this.element.classList.toggle("card--blank", !this.blob);
  }

  private async thumbnail(): Promise<string | undefined> {
    const { thumbnail } = this.outfit.links;
    if (!thumbnail) return undefined;
    try {
      const bytes = await this.api.bytes(thumbnail);
      return URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
    } catch {
      return undefined;
    }
  }
}
