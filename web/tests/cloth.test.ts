import { expect, it } from "vitest";
import { equalize } from "../src/viewer/cloth";

it("turns a dark coloured weave into grey of the same contrast", () => {
  const bytes = Uint8ClampedArray.of(20, 20, 60, 255, 10, 10, 30, 255);
  equalize(bytes);
  const [bright = 0, , , alpha] = bytes;
  const dark = bytes[4] ?? 0;
  expect([bytes[0], bytes[1], bytes[2]]).toEqual([bright, bright, bright]);
  expect(bright / dark).toBeCloseTo(255 / 153, 1);
  expect(alpha).toBe(255);
});
