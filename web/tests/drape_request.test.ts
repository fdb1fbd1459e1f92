import { describe, expect, it } from "vitest";
import { drapeRequest, parsePose, replaces, sameVertices, type Wish } from "../src/viewer/drape_request";

const wish = { outfit: "abc", body: null, pose: null, motion: null, method: null, kinds: null, heat: null } satisfies Wish;

describe("drapeRequest", () => {
  it("leaves out what is not chosen", () => {
    expect(drapeRequest(wish)).toEqual({ outfit: "abc", output: { include: ["outfit", "body"] } });
  });

  it("says the kinds of the garments to the method that needs them", () => {
    const kinds = { shirt: "tee" } as const;
    expect(drapeRequest({ ...wish, kinds, method: "garnet" }).output).toMatchObject({ method: "garnet", kinds });
    expect(drapeRequest({ ...wish, kinds, method: "skinning" }).output.kinds).toBeUndefined();
  });

  it("asks for the heat map's attribute with a still pose, and not with a motion", () => {
    expect(drapeRequest({ ...wish, heat: "strain" }).output.attributes).toEqual(["strain"]);
    const moving = drapeRequest({ ...wish, heat: "strain", motion: "walk", pose: { kind: "preset", id: "squat" } });
    expect(moving.output.attributes).toBeUndefined();
    expect(moving).toMatchObject({ motion: "walk" });
    expect(moving.pose).toBeUndefined();
  });
});

it("reuses vertices for the same outfit in still poses only", () => {
  expect(sameVertices(wish, { ...wish, method: "skinning" })).toBe(true);
  expect(sameVertices(wish, { ...wish, outfit: "other" })).toBe(false);
  expect(sameVertices(wish, { ...wish, motion: "walk" })).toBe(false);
  expect(sameVertices(undefined, wish)).toBe(false);
});

it("leaves textures out where they are on the stage already", () => {
  expect(drapeRequest(wish, false).output.textures).toBe(false);
});

it("gives up a drape in flight for another outfit or motion, not for another body", () => {
  expect(replaces(wish, { ...wish, body: { kind: "phenotypes", values: { age: 1 } } })).toBe(false);
  expect(replaces(wish, { ...wish, motion: "walk" })).toBe(true);
  expect(replaces(wish, { ...wish, outfit: "other" })).toBe(true);
  expect(replaces(undefined, wish)).toBe(true);
});

it("reads a pose attribute as a preset or as joints", () => {
  expect(parsePose("squat")).toEqual({ kind: "preset", id: "squat" });
  expect(parsePose('{"kind":"joints","rotations":{}}')).toEqual({ kind: "joints", rotations: {} });
  expect(parsePose(null)).toBeNull();
});
