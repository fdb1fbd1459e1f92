import { expect, it, vi } from "vitest";
import type { Outfit } from "../src/api/types";
import { canDrape } from "../src/page/methods";
import { MethodPanel } from "../src/page/method_panel";

const outfit = (kinds?: Outfit["kinds"]): Outfit => ({
  id: "abc",
  name: "Sweater and jeans",
  vertices: 2,
  triangles: 1,
  garments: ["jeans", "sweater"].map((name, layer) => ({ name, vertices: 1, triangles: 1, layer })),
  methods: ["deepsd"],
  created_at: "",
  links: { self: "", static: "", thumbnail: null, bake: null },
  ...(kinds ? { kinds } : {}),
});

function input(panel: MethodPanel, method: string): HTMLInputElement {
  const found = panel.element.querySelector<HTMLInputElement>(`[value="${method}"]`);
  if (!found) throw new Error(`no ${method}`);
  return found;
}

function choose(panel: MethodPanel, method: string): void {
  input(panel, method).checked = true;
  input(panel, method).dispatchEvent(new Event("change"));
}

function setKind(panel: MethodPanel, garment: string, kind: string): void {
  const select = panel.element.querySelector<HTMLSelectElement>(`[name="kind of ${garment}"]`);
  if (!select) throw new Error(`no ${garment}`);
  select.value = kind;
  select.dispatchEvent(new Event("change"));
}

it("offers GarNet once the kind of every garment is known", () => {
  const chosen = vi.fn();
  const panel = new MethodPanel(chosen);
  expect(panel.showOutfit(outfit())).toEqual({ method: "deepsd", kinds: {} });
  expect(input(panel, "garnet").disabled).toBe(true);
  setKind(panel, "jeans", "jeans");
  expect(input(panel, "garnet").disabled).toBe(true);
  setKind(panel, "sweater", "sweater");
  expect(input(panel, "garnet").disabled).toBe(false);
  expect(chosen).not.toHaveBeenCalled();
  choose(panel, "garnet");
  expect(chosen).toHaveBeenLastCalledWith({ method: "garnet", kinds: { jeans: "jeans", sweater: "sweater" } });
});

it("goes back to DeePSD where a kind is taken away, or another outfit has none", () => {
  const chosen = vi.fn();
  const panel = new MethodPanel(chosen);
  panel.showOutfit(outfit({ jeans: "jeans", sweater: "tee" }));
  choose(panel, "garnet");
  expect(panel.showOutfit(outfit({ jeans: "jeans", sweater: "sweater" })).method).toBe("garnet");
  setKind(panel, "jeans", "");
  expect(chosen).toHaveBeenLastCalledWith({ method: "deepsd", kinds: { sweater: "sweater" } });
  expect(input(panel, "deepsd").checked).toBe(true);
  expect(panel.showOutfit(outfit()).method).toBe("deepsd");
});

it("offers pixel cloth where the outfit's garments have a network", () => {
  const chosen = vi.fn();
  const panel = new MethodPanel(chosen);
  panel.showOutfit(outfit());
  expect(input(panel, "pixel_cloth").disabled).toBe(true);
  panel.showOutfit({ ...outfit(), methods: ["deepsd", "pixel_cloth"] });
  expect(input(panel, "pixel_cloth").disabled).toBe(false);
  choose(panel, "pixel_cloth");
  expect(chosen).toHaveBeenLastCalledWith({ method: "pixel_cloth", kinds: {} });
  expect(panel.showOutfit(outfit()).method).toBe("deepsd");
});

it("knows which methods can stand beside a drape", () => {
  const simulated = { ...outfit(), methods: ["deepsd", "simulation"] };
  expect(canDrape("simulation", simulated, {})).toBe(true);
  expect(canDrape("simulation", outfit(), {})).toBe(false);
  expect(canDrape("garnet", outfit(), { jeans: "jeans" })).toBe(false);
  expect(canDrape("skinning", outfit(), {})).toBe(true);
});
