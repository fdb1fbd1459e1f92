import { expect, it } from "vitest";
import { parseServerTiming } from "../src/api/server_timing";
import { milliseconds, serviceTime } from "../src/page/timing_bar";

it("reads stages and their durations, and leaves out entries without one", () => {
  const stages = parseServerTiming('parse;dur=0.1, static;desc="memory";dur=0.02,cache;desc=hit, encode; dur="2.5"');
  expect(stages).toEqual([
    { name: "parse", milliseconds: 0.1 },
    { name: "static", milliseconds: 0.02 },
    { name: "encode", milliseconds: 2.5 },
  ]);
  expect(parseServerTiming(null)).toEqual([]);
});

it("prefers the service's own total to the sum of its stages", () => {
  expect(serviceTime(parseServerTiming("body;dur=1, encode;dur=2"))).toBe(3);
  expect(serviceTime(parseServerTiming("body;dur=1, total;dur=5"))).toBe(5);
});

it("shows fewer digits for longer times", () => {
  expect([0.05, 2.34, 230, 1583].map(milliseconds)).toEqual(["0.05 ms", "2.3 ms", "230 ms", "1.6 s"]);
});
