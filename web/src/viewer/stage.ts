import { NeutralToneMapping, PCFShadowMap, Scene, WebGLRenderer } from "three";
import { CameraRig } from "./camera_rig";
import { ContactShadow } from "./contact_shadow";
import type { Figure } from "./figure";
import { studioEnvironment, studioLights } from "./studio";

/** Renderer, light and camera around one figure. Draws only when something has changed. */
export class Stage {
  readonly rig: CameraRig;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly contact = new ContactShadow();
  private readonly environment;
  private shown: Figure | undefined;
  private request = 0;
  private shadowsStale = true;
  /** Called before each frame with its time, in seconds; true asks for another frame. */
  onFrame: ((seconds: number) => boolean) | undefined;

  /** Throws where the browser has no WebGL 2. */
  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.toneMappingExposure = 0.92;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.environment = studioEnvironment(this.renderer);
    this.scene.environment = this.environment;
    this.scene.environmentIntensity = 0.5;
    this.scene.add(studioLights(), this.contact.group);
    this.rig = new CameraRig(canvas, () => this.invalidate());
  }

  get figure(): Figure | undefined {
    return this.shown;
  }

  resize(width: number, height: number, pixelRatio = Math.min(globalThis.devicePixelRatio, 2)): void {
    if (width < 1 || height < 1) return;
    this.renderer.setPixelRatio(pixelRatio);
    this.renderer.setSize(width, height, false);
    this.rig.resize(width, height);
    this.drawNow();
  }

  /** Puts a new figure on; the old one stays until this one is ready to draw, so that nothing flickers. */
  replace(figure: Figure): void {
    const old = this.shown;
    this.scene.add(figure.group);
    if (old) this.scene.remove(old.group);
    this.shown = figure;
    this.changed();
    this.drawNow();
    old?.dispose();
  }

  clear(): void {
    if (this.shown) this.scene.remove(this.shown.group);
    this.shown?.dispose();
    this.shown = undefined;
    this.changed();
  }

  /** The figure's vertices have moved: shadows are drawn anew, on the ground under its lowest point. */
  changed(): void {
    const bounds = this.shown?.bounds();
    this.contact.group.position.y = bounds && !bounds.isEmpty() ? bounds.min.y : 0;
    if (bounds) this.rig.follow(bounds);
    this.shadowsStale = true;
    this.invalidate();
  }

  invalidate(): void {
    this.request ||= requestAnimationFrame((time) => {
      this.request = 0;
      const playing = this.onFrame?.(time / 1000) ?? false;
      if (playing) this.shadowsStale = true;
      const coasting = this.rig.advance();
      this.drawNow();
      if (playing || coasting) this.invalidate();
    });
  }

  async picture(): Promise<Blob | null> {
    this.drawNow();
    return new Promise((resolve) => this.canvas.toBlob(resolve, "image/png"));
  }

  dispose(): void {
    cancelAnimationFrame(this.request);
    this.clear();
    cancelAnimationFrame(this.request);
    this.rig.dispose();
    this.contact.dispose();
    this.environment.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  private drawNow(): void {
    if (this.shadowsStale) {
      this.contact.render(this.renderer, this.scene);
      this.renderer.shadowMap.needsUpdate = true;
      this.shadowsStale = false;
    }
    this.renderer.render(this.scene, this.rig.camera);
  }
}
