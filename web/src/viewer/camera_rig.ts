import { type Box3, PerspectiveCamera, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

export type View = "front" | "side" | "back";

const AZIMUTH: Record<View, number> = { front: 0.32, side: Math.PI / 2, back: Math.PI + 0.32 };
const POLAR = 1.46;
const KEY_STEP = 0.16;

/** The camera, its framing of the figure, and orbiting by pointer, touch and keyboard. */
export class CameraRig {
  readonly camera = new PerspectiveCamera(26, 1, 0.1, 30);
  private readonly controls: OrbitControls;
  private readonly target = new Vector3(0, 0.86, 0);
  private figureHeight = 1.75;
  private figureWidth = 1.4;
  /** From the target up to the highest point of the pose, metres. */
  private reach = 0;
  private framed = false;
  /** The distance that was last fitted; another one is the shopper's own, and is left alone. */
  private fitted = 0;
  private shared: CameraRig[] = [];

  constructor(element: HTMLElement, onChange: () => void) {
    this.controls = new OrbitControls(this.camera, element);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.09;
    this.controls.enablePan = false;
    this.controls.minPolarAngle = 0.35;
    this.controls.maxPolarAngle = 1.62;
    this.controls.minDistance = 0.9;
    this.controls.maxDistance = 9;
    this.controls.addEventListener("change", () => {
      for (const other of this.shared) other.lookAs(this);
      onChange();
    });
    element.addEventListener("keydown", (event) => {
      if (this.turnByKey(event.key)) event.preventDefault();
    });
    this.look("front");
  }

  /** From now on two cameras look the same way, whichever of them is moved; each ends it by `unshare`. */
  share(other: CameraRig): void {
    this.lookAs(other);
    this.shared.push(other);
    other.shared.push(this);
  }

  unshare(): void {
    for (const other of this.shared) other.shared = other.shared.filter((rig) => rig !== this);
    this.shared = [];
  }

  private lookAs(other: CameraRig): void {
    const same = this.camera.position.distanceToSquared(other.camera.position) < 1e-12;
    if (same && this.controls.target.equals(other.controls.target)) return;
    this.framed = other.framed;
    [this.figureHeight, this.figureWidth, this.fitted] = [other.figureHeight, other.figureWidth, other.fitted];
    this.target.copy(other.target);
    this.controls.target.copy(other.controls.target);
    this.camera.position.copy(other.camera.position);
    this.controls.update();
  }

  /** Lets the view coast; true while it still moves. */
  advance(): boolean {
    return this.controls.update();
  }

  resize(width: number, height: number): void {
    const narrower = Math.abs(this.camera.aspect - width / height) > 0.01;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (narrower) this.fitDistance();
  }

  /**
   * Frames the first figure. After that the distance stays, so that a taller body looks taller, unless a pose reaches
   * out of the picture: then the camera steps back, and forward again when the pose allows.
   */
  follow(bounds: Box3): void {
    if (bounds.isEmpty()) return;
    if (!this.framed) {
      this.framed = true;
      this.frame(bounds);
    }
    this.reach = bounds.max.y - this.target.y;
    this.fitDistance();
  }

  frame(bounds: Box3): void {
    this.figureHeight = Math.max(bounds.max.y - bounds.min.y, 0.3);
    this.figureWidth = Math.max(bounds.max.x - bounds.min.x, 0.3);
    // A little below the middle: room under the feet for what lies over the stage.
    this.target.set(0, bounds.min.y + this.figureHeight * 0.45, 0);
    this.reach = bounds.max.y - this.target.y;
    this.look("front");
  }

  look(view: View): void {
    this.fitted = this.fittingDistance();
    this.place(new Spherical(this.fitted, POLAR, AZIMUTH[view]));
  }

  private place(spherical: Spherical): void {
    this.controls.target.copy(this.target);
    this.camera.position.setFromSpherical(spherical).add(this.target);
    this.controls.update();
  }

  /** Moves to the fitting distance, unless the shopper has zoomed. */
  private fitDistance(): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    if (Math.abs(offset.length() / this.fitted - 1) > 0.01) return;
    this.fitted = this.fittingDistance();
    this.place(new Spherical().setFromVector3(offset.setLength(this.fitted)));
  }

  private fittingDistance(): number {
    const tall = this.figureHeight * 1.34;
    const wide = this.figureWidth * 1.2;
    const halfAngle = Math.tan((this.camera.fov * Math.PI) / 360);
    const reach = this.reach * 1.08;
    return Math.max(tall / 2 / halfAngle, wide / 2 / (halfAngle * this.camera.aspect), reach / halfAngle);
  }

  private turnByKey(key: string): boolean {
    const spherical = new Spherical().setFromVector3(this.camera.position.clone().sub(this.controls.target));
    if (key === "ArrowLeft") spherical.theta -= KEY_STEP;
    else if (key === "ArrowRight") spherical.theta += KEY_STEP;
    else if (key === "ArrowUp") spherical.phi -= KEY_STEP / 2;
    else if (key === "ArrowDown") spherical.phi += KEY_STEP / 2;
    else if (key === "+" || key === "=") spherical.radius *= 0.92;
    else if (key === "-") spherical.radius /= 0.92;
    else if (key === "Home") return this.lookFromFront();
    else return false;
    spherical.phi = Math.min(Math.max(spherical.phi, this.controls.minPolarAngle), this.controls.maxPolarAngle);
    this.place(spherical);
    return true;
  }

  private lookFromFront(): boolean {
    this.look("front");
    return true;
  }

  dispose(): void {
    this.unshare();
    this.controls.dispose();
  }
}
