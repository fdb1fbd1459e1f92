import { ToileApi } from "../api/client";
import type { Body, Outfit, SimulatedOn, VertexAttribute } from "../api/types";
import { PortraitStudio } from "../viewer/portrait";
import type { ToileViewer } from "../viewer/element";
import type { DrapeDetail, ViewerEventMap } from "../viewer/events";
import { BodyPanel } from "./body_panel";
import { CompareView } from "./compare_view";
import { make } from "./dom";
import { FabricPanel } from "./fabric_panel";
import { Gallery } from "./gallery";
import { InsightPanel } from "./insight_panel";
import { OutfitDetails } from "./outfit_details";
import { Player } from "./player";
import { type PoseChoice, PosePanel } from "./pose_panel";
import { StageOverlay } from "./stage_overlay";
import { Tabs } from "./tabs";
import { UploadZone } from "./upload_zone";

/** The try-on page: panels of choices on one side, the viewer that shows them on the other. */
export class FittingRoom {
  private readonly api = new ToileApi();
  private readonly gallery = new Gallery(this.api, new PortraitStudio(this.api), (outfit) => this.wear(outfit));
  private readonly details = new OutfitDetails(this.api, (id) => this.forget(id));
  private readonly upload = new UploadZone(this.api, (outfit) => this.welcome(outfit));
  private readonly poses = new PosePanel(this.api, (choice) => this.pose(choice));
  private readonly fabric = new FabricPanel((garment, color) => this.tint(garment, color));
  private readonly bodyPanel = new BodyPanel(this.api, (body: Body | null) => { this.viewer.body = body; });
  private readonly insight: InsightPanel;
  private readonly overlay: StageOverlay;
  private readonly compare: CompareView;
  private readonly player: Player;
  private readonly tabs: Tabs;
  private worn: string | undefined;
  private chosen: Outfit | undefined;
  private lastPose = "a-pose";

  constructor(
    private readonly viewer: ToileViewer,
    stage: HTMLElement,
    panel: HTMLElement,
  ) {
    this.insight = new InsightPanel(
      (heat: VertexAttribute | null) => { this.viewer.heat = heat; },
      (choice) => {
        this.viewer.set(choice);
        this.compare.showOutfit(this.chosen, choice.kinds);
      },
    );
    this.overlay = new StageOverlay({
      look: (view) => this.viewer.look(view),
      retry: () => this.viewer.retry(),
      openInsight: () => this.tabs.open("insight"),
    });
    this.player = new Player({
      toggle: () => this.viewer.togglePlayback(),
      seek: (share) => this.viewer.seek(share),
      close: () => this.pose({ kind: "pose", id: this.lastPose }),
    });
    this.compare = new CompareView(viewer, stage, (on) => this.goTo(on));
    this.tabs = this.buildTabs();
    stage.append(...this.overlay.elements, ...this.compare.elements, this.player.element);
    panel.append(this.tabs.element);
    document.body.append(this.upload.veil);
    this.listen();
  }

  async open(): Promise<void> {
    const outfits = await this.gallery.load();
    const wanted = new URLSearchParams(location.search).get("outfit");
    const first = outfits.find((outfit) => outfit.id === wanted) ?? outfits[0];
    if (first) this.wear(first);
    else this.undress();
  }

  private buildTabs(): Tabs {
    const outfits = make("div", { className: "stack" }, this.gallery.element, this.upload.element, this.details.element);
    return new Tabs("Choices", [
      { id: "outfits", label: "Outfits", content: outfits },
      { id: "body", label: "Body", content: this.bodyPanel.element },
      { id: "pose", label: "Pose", content: this.poses.element },
      { id: "fabric", label: "Fabric", content: this.fabric.element },
      { id: "insight", label: "Insight", content: this.insight.element },
    ]);
  }

  private listen(): void {
    this.on("toile-loading", ({ busy, first }) => this.overlay.showLoading(busy, first));
    this.on("toile-error", ({ problem }) => this.overlay.showProblem(problem));
    this.on("toile-playback", (state) => {
      this.player.show(state);
      if (state) this.compare.seek(state.time / state.duration);
    });
    this.on("toile-drape", (detail) => this.showDrape(detail));
  }

  private on<Name extends keyof ViewerEventMap>(name: Name, handle: (detail: ViewerEventMap[Name]["detail"]) => void): void {
    this.viewer.addEventListener(name, (event) => handle((event as ViewerEventMap[Name]).detail));
  }

  private showDrape(detail: DrapeDetail): void {
    this.overlay.showDrape(detail);
    this.compare.showDrape(detail);
    this.insight.showDrape(detail);
    this.fabric.show(detail.garments, this.worn !== detail.outfit);
    this.worn = detail.outfit;
  }

  private wear(outfit: Outfit, openReport = false): void {
    this.gallery.select(outfit.id);
    this.overlay.showOutfit(outfit);
    void this.details.show(outfit, openReport);
    this.chosen = outfit;
    const choice = this.insight.showOutfit(outfit);
    this.compare.showOutfit(outfit, choice.kinds);
    this.viewer.set({ outfit: outfit.id, ...choice });
    history.replaceState(null, "", `?outfit=${encodeURIComponent(outfit.id)}`);
  }

  private undress(): void {
    this.gallery.select(undefined);
    this.overlay.showOutfit(undefined);
    this.chosen = undefined;
    this.compare.showOutfit(undefined, {});
    void this.details.show(undefined);
    this.viewer.outfit = null;
    history.replaceState(null, "", location.pathname);
  }

  private tint(garment: string, color: string | undefined): void {
    this.viewer.tint(garment, color);
    this.compare.tint(garment, color);
  }

  /** Shows what the simulation beside it is of. */
  private goTo({ pose }: SimulatedOn): void {
    if (this.viewer.body) this.bodyPanel.reset();
    if (pose.kind === "preset") {
      this.lastPose = pose.id;
      this.poses.select({ kind: "pose", id: pose.id });
    }
    this.viewer.set({ body: null, pose });
  }

  private pose(choice: PoseChoice): void {
    this.poses.select(choice);
    if (choice.kind === "motion") {
      this.viewer.motion = choice.id;
      return;
    }
    this.lastPose = choice.id;
    this.viewer.pose = { kind: "preset", id: choice.id };
  }

  private welcome(outfit: Outfit): void {
    this.gallery.add(outfit);
    this.wear(outfit, true);
  }

  private forget(id: string): void {
    const next = this.gallery.remove(id);
    if (next) this.wear(next);
    else this.undress();
  }
}
