import type { ToileApi } from "../api/client";
import { Problem } from "../api/problem";
import type { Outfit } from "../api/types";
import type { PortraitStudio } from "../viewer/portrait";
import { make } from "./dom";
import { OutfitCard } from "./outfit_card";
import { empty, failure } from "./placeholders";

const SKELETONS = 6;

/** The outfits of the service, page by page; one is worn. */
export class Gallery {
  readonly element = make("div", { className: "stack" });
  private readonly grid = make("ul", { className: "gallery", aria: { label: "Outfits" } });
  private readonly more = make("button", { type: "button", className: "quiet-button", textContent: "Show more" });
  private readonly message = make("div", { className: "gallery__message" });
  private readonly cards = new Map<string, OutfitCard>();
  private cursor: string | undefined;
  private worn: string | undefined;

  constructor(
    private readonly api: ToileApi,
    private readonly portraits: PortraitStudio,
    private readonly onChoose: (outfit: Outfit) => void,
  ) {
    this.more.hidden = true;
    this.more.addEventListener("click", () => void this.loadMore());
    this.element.append(this.grid, this.message, this.more);
  }

  /** Loads the first page; answers its outfits. */
  async load(): Promise<Outfit[]> {
    this.message.replaceChildren();
    this.grid.replaceChildren(...Array.from({ length: SKELETONS }, () => make("li", { className: "card card--skeleton" })));
    this.grid.setAttribute("aria-busy", "true");
    try {
      const page = await this.api.outfits();
      this.grid.replaceChildren();
      this.cards.clear();
      this.append(page.data, page.next_cursor);
      return page.data;
    } catch (error) {
      this.grid.replaceChildren();
      this.message.replaceChildren(failure(Problem.from(error), () => void this.load()));
      return [];
    } finally {
      this.grid.removeAttribute("aria-busy");
    }
  }

  /** Marks the outfit that is worn. */
  select(id: string | undefined): void {
    this.worn = id;
    for (const [key, card] of this.cards) card.select(key === id);
  }

  /** Puts a new outfit first. */
  add(outfit: Outfit): void {
    this.cards.get(outfit.id)?.element.remove();
    this.grid.prepend(this.card(outfit).element);
    this.showEmptiness();
  }

  /** Takes an outfit away; answers the one that is then first. */
  remove(id: string): Outfit | undefined {
    this.cards.get(id)?.dispose();
    this.cards.delete(id);
    this.showEmptiness();
    return this.cards.values().next().value?.outfit;
  }

  private async loadMore(): Promise<void> {
    this.more.disabled = true;
    try {
      const page = await this.api.outfits(this.cursor);
      this.append(page.data, page.next_cursor);
    } catch (error) {
      this.message.replaceChildren(failure(Problem.from(error), () => void this.loadMore()));
    }
    this.more.disabled = false;
  }

  private append(outfits: Outfit[], cursor: string | null): void {
    this.grid.append(...outfits.map((outfit) => this.card(outfit).element));
    this.cursor = cursor ?? undefined;
    this.more.hidden = cursor === null;
    this.showEmptiness();
  }

  private card(outfit: Outfit): OutfitCard {
    const card = new OutfitCard(outfit, this.api, this.portraits, () => this.onChoose(outfit));
    card.select(outfit.id === this.worn);
    this.cards.set(outfit.id, card);
    return card;
  }

  private showEmptiness(): void {
    const none = this.cards.size === 0;
    this.message.replaceChildren(...(none ? [empty("No outfits yet", "Add one below to see it worn.")] : []));
  }
}
