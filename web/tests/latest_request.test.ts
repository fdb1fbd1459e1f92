import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { LatestRequest, type Work } from "../src/api/latest_request";

const never: Work = (signal) =>
  new Promise((_resolve, reject) => signal.addEventListener("abort", () => reject(new DOMException("", "AbortError"))));

describe("LatestRequest", () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it("runs the last of several submitted within the debounce", async () => {
    const done: number[] = [];
    const requests = new LatestRequest(() => undefined, 50);
    for (const id of [1, 2, 3]) requests.submit(async () => void done.push(id));
    await vi.advanceTimersByTimeAsync(60);
    expect(done).toEqual([3]);
    expect(requests.busy).toBe(false);
  });

  it("lets young work finish, then runs only the newest of what waits", async () => {
    const done: string[] = [];
    const requests = new LatestRequest(() => undefined);
    requests.submit(async () => {
      await new Promise((resolve) => setTimeout(resolve, 100));
      done.push("first");
    });
    await vi.advanceTimersByTimeAsync(10);
    requests.submit(async () => void done.push("second"));
    requests.submit(async () => void done.push("third"));
    await vi.advanceTimersByTimeAsync(200);
    expect(done).toEqual(["first", "third"]);
  });

  it("aborts work in flight when it is replaced, and reports no error for it", async () => {
    const errors: unknown[] = [];
    const done: string[] = [];
    const requests = new LatestRequest((error) => errors.push(error));
    requests.submit(never);
    await vi.advanceTimersByTimeAsync(10);
    requests.submit(async () => void done.push("replacement"), true);
    await vi.advanceTimersByTimeAsync(10);
    expect(done).toEqual(["replacement"]);
    expect(errors).toEqual([]);
  });

  it("aborts work that has been in flight too long", async () => {
    const done: string[] = [];
    const requests = new LatestRequest(() => undefined, 0, 500);
    requests.submit(never);
    await vi.advanceTimersByTimeAsync(700);
    requests.submit(async () => void done.push("next"));
    await vi.advanceTimersByTimeAsync(10);
    expect(done).toEqual(["next"]);
  });

  it("reports errors of work and goes on", async () => {
    const errors: unknown[] = [];
    const requests = new LatestRequest((error) => errors.push(error));
    requests.submit(() => Promise.reject(new Error("broken")));
    await vi.advanceTimersByTimeAsync(10);
    expect(errors).toHaveLength(1);
    expect(requests.busy).toBe(false);
  });
});
