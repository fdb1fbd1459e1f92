import { beforeEach, describe, expect, it } from "vitest";
import type { BufferGeometry, Mesh } from "three";
import type { Figure } from "../src/viewer/figure";
import { readVertexArrays } from "../src/viewer/glb_arrays";
import { loadFigure } from "../src/viewer/load_figure";
import { type TubePart, tubeGlb } from "./glb_fixture";

const outfit = (radius: number, strain?: number): TubePart[] => [
  { name: "dress", radius, ...(strain === undefined ? {} : { strain }) },
  { name: "body", radius: 0.1 },
];

const plain = { tints: new Map<string, string>(), heat: undefined };

function meshNamed(figure: Figure, name: string): Mesh<BufferGeometry> {
  const mesh = figure.group.getObjectByName(name);
  if (!mesh) throw new Error(`no mesh ${name}`);
  return mesh as Mesh<BufferGeometry>;
}

describe("Figure", () => {
  let figure: Figure;
  beforeEach(async () => {
    figure = await loadFigure(tubeGlb(outfit(0.2)));
  });

  it("writes a new drape into the buffers it already has", () => {
    const position = meshNamed(figure, "dress").geometry.getAttribute("position");
    const { array } = position;
    const before = figure.stats().positionSum;
    expect(figure.update(readVertexArrays(tubeGlb(outfit(0.25))) ?? [])).toBe(true);
    expect(meshNamed(figure, "dress").geometry.getAttribute("position")).toBe(position);
    expect(position.array).toBe(array);
    expect(position.array[0]).toBeCloseTo(0.25);
    expect(figure.stats().positionSum).toBeGreaterThan(before);
  });

  it("refuses a drape of another outfit and keeps what it shows", () => {
    const other = readVertexArrays(tubeGlb([{ name: "dress", radius: 0.3, rings: 5 }, { name: "body", radius: 0.1 }]));
    expect(figure.update(other ?? [])).toBe(false);
    expect(meshNamed(figure, "dress").geometry.getAttribute("position").array[0]).toBeCloseTo(0.2);
  });

  it("tells how far its cloth is from another drape's, and not the body", async () => {
    const wider = await loadFigure(tubeGlb([{ name: "dress", radius: 0.23 }, { name: "body", radius: 0.15 }]));
    expect(figure.distanceTo(wider)).toBeCloseTo(0.03, 5);
    expect(figure.distanceTo(figure)).toBe(0);
    const finer = await loadFigure(tubeGlb([{ name: "dress", radius: 0.2, rings: 5 }, { name: "body", radius: 0.1 }]));
    expect(figure.distanceTo(finer)).toBeUndefined();
  });

  it("counts the garments and not the body", () => {
    expect(figure.stats()).toMatchObject({ vertices: 24, triangles: 32 });
    expect(figure.garments.map(({ name }) => name)).toEqual(["dress"]);
  });

  it("tints one garment and gives its own colour back", () => {
    figure.show({ ...plain, tints: new Map([["dress", "#6d1f2f"]]) });
    expect(meshNamed(figure, "dress").material).toHaveProperty("color");
    const tinted = meshNamed(figure, "dress").material;
    figure.show(plain);
    expect(meshNamed(figure, "dress").material).not.toBe(tinted);
  });

  it("paints heat from the drape's attribute and sums it up", () => {
    figure.update(readVertexArrays(tubeGlb(outfit(0.2, 0.1))) ?? []);
    const summary = figure.show({ ...plain, heat: "strain" });
    expect(summary?.max).toBeCloseTo(0.1);
    expect(summary?.share).toBe(1);
    expect(meshNamed(figure, "dress").geometry.getAttribute("color").count).toBe(24);
    expect(figure.show({ ...plain, heat: "penetration" })).toBeUndefined();
  });
});
