import { beforeEach, describe, expect, it, vi } from "vitest";
import { Box3, Vector3 } from "three";
import { CameraRig } from "../src/viewer/camera_rig";

const figure = (height: number): Box3 => new Box3(new Vector3(-0.7, 0, -0.2), new Vector3(0.7, height, 0.2));

describe("CameraRig", () => {
  let element: HTMLElement;
  let rig: CameraRig;
  const distance = (): number => rig.camera.position.distanceTo(new Vector3(0, 1.8 * 0.45, 0));
  const press = (key: string): void => {
    element.dispatchEvent(new KeyboardEvent("keydown", { key }));
  };

  beforeEach(() => {
    element = document.createElement("div");
    document.body.append(element);
    rig = new CameraRig(element, () => undefined);
    rig.resize(800, 800);
    rig.follow(figure(1.8));
  });

  it("keeps its distance to a shorter body and steps back for raised arms", () => {
    const first = distance();
    rig.follow(figure(1.6));
    expect(distance()).toBeCloseTo(first, 5);
    rig.follow(figure(2.4));
    expect(distance()).toBeGreaterThan(first * 1.1);
    rig.follow(figure(1.8));
    expect(distance()).toBeCloseTo(first, 5);
  });

  it("leaves the zoom to the shopper until the view is reset", () => {
    const first = distance();
    press("+");
    press("+");
    const near = distance();
    expect(near).toBeLessThan(first);
    rig.follow(figure(2.4));
    expect(distance()).toBeCloseTo(near, 5);
    press("Home");
    expect(distance()).toBeGreaterThan(first);
  });

  it("still steps back when the figure has only been turned", () => {
    const first = distance();
    press("ArrowLeft");
    rig.follow(figure(2.4));
    expect(distance()).toBeGreaterThan(first * 1.1);
  });

  it("looks where another one does, whichever of them is turned, until it goes", () => {
    const [there, redrawn] = [document.createElement("div"), vi.fn()];
    const other = new CameraRig(there, redrawn);
    other.resize(800, 800);
    press("ArrowLeft");
    other.share(rig);
    expect(other.camera.position.distanceTo(rig.camera.position)).toBeLessThan(1e-6);
    press("ArrowUp");
    expect(other.camera.position.distanceTo(rig.camera.position)).toBeLessThan(1e-6);
    expect(redrawn).toHaveBeenCalled();
    there.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
    expect(other.camera.position.distanceTo(rig.camera.position)).toBeLessThan(1e-6);
    other.dispose();
    const last = other.camera.position.clone();
    press("ArrowLeft");
    expect(other.camera.position.distanceTo(last)).toBe(0);
  });
});
