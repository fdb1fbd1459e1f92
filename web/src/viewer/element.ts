import { type Drape, ToileApi } from "../api/client";
import { LatestRequest, type Work } from "../api/latest_request";
import { Problem } from "../api/problem";
import type { Body, Kinds, Method, Pose, VertexAttribute } from "../api/types";
import type { View } from "./camera_rig";
import { drapeRequest, parseBody, parsePose, replaces, sameVertices, type Wish } from "./drape_request";
import type { DrapeDetail, ViewerEventMap, ViewerStats } from "./events";
import type { Figure } from "./figure";
import { readVertexArrays } from "./glb_arrays";
import type { HeatSummary } from "./heat_map";
import { loadFigure } from "./load_figure";
import { Playback } from "./playback";
import { Stage } from "./stage";
import style from "./viewer.css?inline";

/**
 * `<toile-viewer api outfit body pose motion method heat>`: an outfit draped on a body, in 3D.
 *
 * Every attribute is a property too; `body` and `pose` take objects as properties. `kinds`, a property, says what kind of
 * garment each one is, for the method `garnet`. A change asks the service for a new
 * drape. Events: `toile-loading`, `toile-drape`, `toile-error`, `toile-playback`.
 */
export class ToileViewer extends HTMLElement {
  static readonly observedAttributes = ["api", "outfit", "body", "pose", "motion", "method", "heat"];

  private readonly canvas = document.createElement("canvas");
  private readonly tints = new Map<string, string>();
  private readonly resizer = new ResizeObserver(() => this.fit());
  private readonly requests = new LatestRequest((error) => this.fail(error), 12);
  private client = new ToileApi();
  private stage: Stage | undefined;
  private playback: Playback | undefined;
  private wish: Wish = { outfit: null, body: null, pose: null, motion: null, method: null, kinds: null, heat: null };
  private shown: Wish | undefined;
  private heatSummary: HeatSummary | undefined;
  private counts = { drapes: 0, inPlaceUpdates: 0 };

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    const sheet = document.createElement("style");
    sheet.textContent = style;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Outfit in 3D. Arrow keys turn it, plus and minus zoom, Home resets.");
    root.append(sheet, this.canvas, document.createElement("slot"));
  }

  connectedCallback(): void {
    try {
      this.stage ??= new Stage(this.canvas);
    } catch {
      const detail = "This browser or device has no WebGL 2.";
      this.fail(new Problem("3D cannot be shown", detail, { status: 0, code: "no-webgl" }));
      return;
    }
    this.stage.onFrame = (seconds) => this.playback?.advance(seconds) ?? false;
    this.resizer.observe(this);
    this.request();
  }

  disconnectedCallback(): void {
    this.resizer.disconnect();
    this.requests.cancel();
    this.stopPlayback();
    this.stage?.dispose();
    this.stage = undefined;
    this.shown = undefined;
  }

  attributeChangedCallback(name: string, _old: string | null, text: string | null): void {
    try {
      if (name === "api") this.client = new ToileApi(text ?? "");
      else if (name === "body") this.wish.body = parseBody(text);
      else if (name === "pose") this.wish.pose = parsePose(text);
      else Object.assign(this.wish, { [name]: text });
    } catch (error) {
      const title = `The attribute "${name}" is not valid JSON`;
      this.fail(new Problem(title, Problem.from(error).detail, { status: 0, code: "invalid-attribute" }));
      return;
    }
    this.request();
  }

  /** Changes several things at once: one request. Choosing a pose ends a motion. */
  set(change: Partial<Wish>): void {
    if (change.pose !== undefined && change.motion === undefined) change = { ...change, motion: null };
    Object.assign(this.wish, change);
    this.request();
  }

  get api(): string { return this.client.base; }
  set api(base: string) { this.client = new ToileApi(base); this.request(); }
  get outfit(): string | null { return this.wish.outfit; }
  set outfit(id: string | null) { this.set({ outfit: id }); }
  get body(): Body | null { return this.wish.body; }
  set body(body: Body | null) { this.set({ body }); }
  get pose(): Pose | null { return this.wish.pose; }
  set pose(pose: Pose | null) { this.set({ pose }); }
  get motion(): string | null { return this.wish.motion; }
  set motion(motion: string | null) { this.set({ motion }); }
  get method(): Method | null { return this.wish.method; }
  set method(method: Method | null) { this.set({ method }); }
  get kinds(): Kinds | null { return this.wish.kinds; }
  set kinds(kinds: Kinds | null) { this.set({ kinds }); }
  get heat(): VertexAttribute | null { return this.wish.heat; }
  set heat(heat: VertexAttribute | null) { this.set({ heat }); }

  /** Tints a garment, or all of them with `*`; without a colour it has its own again. No request. */
  tint(garment: string, color: string | undefined): void {
    if (color) this.tints.set(garment, color);
    else this.tints.delete(garment);
    this.showLook();
  }

  clearTints(): void {
    this.tints.clear();
    this.showLook();
  }

  look(view: View): void {
    this.stage?.rig.look(view);
  }

  /** From now on this viewer and another one look the same way, whichever of them is turned. Both are on the page. */
  shareView(other: ToileViewer): void {
    if (this.stage && other.stage) this.stage.rig.share(other.stage.rig);
  }

  /** Mean distance between the cloth of two viewers, metres; undefined where it is not of the same vertices, or moves. */
  distanceTo(other: ToileViewer): number | undefined {
    const [own, theirs] = [this.stage?.figure, other.stage?.figure];
    return own && theirs && !this.playback && !other.playback ? own.distanceTo(theirs) : undefined;
  }

  togglePlayback(playing?: boolean): void {
    this.playback?.toggle(playing);
    this.stage?.invalidate();
  }

  /** Shows the motion at a share of its length, 0 to 1, and pauses. */
  seek(share: number): void {
    this.playback?.toggle(false);
    this.playback?.seek(share);
    this.stage?.changed();
  }

  /** Asks again, after an error. */
  retry(): void {
    this.request();
  }

  stats(): ViewerStats {
    const figure = this.stage?.figure;
    const bounds = figure?.bounds();
    return {
      outfit: this.shown?.outfit ?? undefined,
      ...(figure?.stats() ?? { vertices: 0, triangles: 0, positionSum: 0 }),
      height: bounds && !bounds.isEmpty() ? bounds.max.y - bounds.min.y : 0,
      ...this.counts,
      heat: this.heatSummary,
      playback: this.playback?.state,
      busy: this.requests.busy,
    };
  }

  private request(): void {
    if (!this.stage) return;
    const { outfit } = this.wish;
    if (!outfit) {
      this.empty();
      return;
    }
    const wish = { ...this.wish, outfit };
    this.emit("toile-loading", { busy: true, first: this.shown?.outfit !== outfit });
    this.requests.submit(this.draping(wish), replaces(this.shown, wish));
  }

  private draping(wish: Wish & { outfit: string }): Work {
    return async (signal) => {
      if (sameVertices(this.shown, wish)) {
        const drape = await this.client.drape(drapeRequest(wish, false), signal);
        if (this.putInPlace(drape, wish)) {
          this.announce(drape, wish.outfit, true);
          return;
        }
      }
      const drape = await this.client.drape(drapeRequest(wish), signal);
      const fresh = await loadFigure(drape.glb);
      if (signal.aborted || !this.stage) {
        fresh.dispose();
        return;
      }
      this.exchange(fresh, wish);
      this.announce(drape, wish.outfit, false);
    };
  }

  /** Writes a drape into the buffers on the stage; false where it does not have their vertices. */
  private putInPlace(drape: Drape, wish: Wish): boolean {
    const arrays = readVertexArrays(drape.glb);
    if (!arrays || !this.stage?.figure?.update(arrays)) return false;
    this.shown = wish;
    this.counts.inPlaceUpdates++;
    this.showLook();
    this.stage.changed();
    return true;
  }

  private exchange(fresh: Figure, wish: Wish): void {
    const before = this.playback?.state;
    const phase = before && this.shown?.motion === wish.motion ? before : undefined;
    this.stopPlayback();
    if (this.shown?.outfit !== wish.outfit) this.tints.clear();
    this.shown = wish;
    if (fresh.animations.length > 0) {
      this.playback = new Playback(fresh, (state) => this.emit("toile-playback", state));
      if (phase) {
        this.playback.seek(phase.time / phase.duration);
        this.playback.toggle(phase.playing);
      }
    }
    this.heatSummary = fresh.show(this.currentLook);
    this.stage?.replace(fresh);
    this.emit("toile-playback", this.playback?.state);
  }

  private get currentLook(): { tints: ReadonlyMap<string, string>; heat: VertexAttribute | undefined } {
    return { tints: this.tints, heat: this.shown?.heat ?? undefined };
  }

  private showLook(): void {
    this.heatSummary = this.stage?.figure?.show(this.currentLook);
    this.stage?.invalidate();
  }

  private announce(drape: Drape, outfit: string, inPlace: boolean): void {
    this.counts.drapes++;
    const detail: DrapeDetail = {
      outfit,
      inPlace,
      bytes: drape.glb.byteLength,
      roundTrip: drape.roundTrip,
      stages: drape.stages,
      quality: drape.quality,
      heat: this.heatSummary,
      cloth: drape.cloth,
      garments: this.stage?.figure?.garments ?? [],
    };
    this.emit("toile-drape", detail);
    this.emit("toile-loading", { busy: false, first: false });
  }

  private empty(): void {
    this.requests.cancel();
    this.stopPlayback();
    this.stage?.clear();
    this.shown = undefined;
    this.emit("toile-loading", { busy: false, first: false });
  }

  private stopPlayback(): void {
    this.playback?.dispose();
    this.playback = undefined;
  }

  private fail(error: unknown): void {
    this.emit("toile-loading", { busy: false, first: false });
    this.emit("toile-error", { problem: Problem.from(error) });
  }

  private fit(): void {
    this.stage?.resize(this.clientWidth, this.clientHeight);
  }

  private emit<Name extends keyof ViewerEventMap>(name: Name, detail: ViewerEventMap[Name]["detail"]): void {
    this.dispatchEvent(new CustomEvent(name, { detail, bubbles: true, composed: true }));
  }
}
