import { describe, expect, it } from "vitest";
import { readVertexArrays } from "../src/viewer/glb_arrays";
import { tubeGlb } from "./glb_fixture";

describe("readVertexArrays", () => {
  it("reads positions, normals and the heat attribute of every primitive in file order", () => {
    const arrays = readVertexArrays(tubeGlb([{ name: "dress", radius: 0.2, strain: 0.05 }, { name: "body", radius: 0.1 }]));
    expect(arrays?.map((array) => array.key)).toEqual(["0/0", "1/0"]);
    expect(arrays?.[0]?.position).toHaveLength(24 * 3);
    expect(arrays?.[0]?.position[0]).toBeCloseTo(0.2);
    expect(arrays?.[1]?.position[0]).toBeCloseTo(0.1);
    expect(arrays?.[0]?.normal?.[0]).toBeCloseTo(1);
    expect(arrays?.[0]?.strain?.[7]).toBeCloseTo(0.05);
    expect(arrays?.[1]?.strain).toBeUndefined();
  });

  it("leaves what is not a GLB to the full loader", () => {
    expect(readVertexArrays(new TextEncoder().encode("this is not a GLB at all").buffer)).toBeUndefined();
    expect(readVertexArrays(new ArrayBuffer(4))).toBeUndefined();
  });

  it("does not read past the end of a truncated file", () => {
    const glb = tubeGlb([{ name: "dress", radius: 0.2 }]);
    expect(readVertexArrays(glb.slice(0, glb.byteLength - 700))).toBeUndefined();
  });
});
