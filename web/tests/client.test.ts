import { afterEach, describe, expect, it, vi } from "vitest";
import { ToileApi } from "../src/api/client";
import { Problem } from "../src/api/problem";

const request = { outfit: "abc", output: { include: ["outfit" as const] } };

function answers(...responses: Response[]): ReturnType<typeof vi.fn> {
  const fetch = vi.fn();
  for (const response of responses) fetch.mockResolvedValueOnce(response);
  vi.stubGlobal("fetch", fetch);
  return fetch;
}

function problem(status: number, document: object, headers: Record<string, string> = {}): Response {
  return new Response(JSON.stringify(document), { status, headers });
}

describe("ToileApi", () => {
  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  it("gives the drape with its timing and quality", async () => {
    const headers = { "Server-Timing": "body;dur=0.4", "X-Toile-Quality": '{"p95_edge_strain":0.02}' };
    const fetch = answers(new Response(new Uint8Array([1, 2, 3]), { headers }));
    const drape = await new ToileApi("http://shop.example/").drape(request);
    expect(drape.glb.byteLength).toBe(3);
    expect(drape.stages).toEqual([{ name: "body", milliseconds: 0.4 }]);
    expect(drape.quality?.p95_edge_strain).toBe(0.02);
    expect(fetch.mock.calls[0]?.[0]).toBe("http://shop.example/v1/drapes");
  });

  it("asks for cloth images with pixel cloth and fetches the drape from where it is kept", async () => {
    const cloth = [{ garment: "tee", url: "/v1/drapes/a/cloth.png", preview: "/v1/drapes/b/cloth.png" }];
    const kept = { url: "/v1/drapes/c/drape.glb", quality: { p95_edge_strain: 0.1 }, cloth };
    const fetch = answers(new Response(JSON.stringify(kept)), new Response(new Uint8Array(5)));
    const drape = await new ToileApi("http://shop.example").drape({ outfit: "abc", output: { include: ["outfit"], method: "pixel_cloth" } });
    expect(drape.glb.byteLength).toBe(5);
    expect(drape.quality?.p95_edge_strain).toBe(0.1);
    expect(drape.cloth[0]?.preview).toBe("http://shop.example/v1/drapes/b/cloth.png");
    expect(fetch.mock.calls[1]?.[0]).toBe("http://shop.example/v1/drapes/c/drape.glb");
  });

  it("throws the service's problem with the field that it points to", async () => {
    answers(problem(422, { title: "Out of range", detail: "Too tall", code: "measurement-out-of-range", pointer: "/measurements/height" }));
    const error = await new ToileApi().solveBody({ measurements: { height: 300 } }).catch((reason: unknown) => reason);
    expect(error).toBeInstanceOf(Problem);
    expect(error).toMatchObject({ title: "Out of range", detail: "Too tall", code: "measurement-out-of-range", field: "height" });
  });

  it("gives a title to a failure that is not a problem document", async () => {
    answers(new Response("<html>Bad gateway</html>", { status: 502 }));
    await expect(new ToileApi().poses()).rejects.toMatchObject({ title: "The service answered 502" });
  });

  it("waits as an overloaded service asks, then tries again", async () => {
    vi.useFakeTimers();
    const fetch = answers(problem(503, { code: "overloaded" }, { "Retry-After": "1" }), new Response(new Uint8Array(8)));
    const drape = new ToileApi().drape(request);
    await vi.advanceTimersByTimeAsync(900);
    expect(fetch).toHaveBeenCalledTimes(1);
    await vi.advanceTimersByTimeAsync(200);
    expect((await drape).glb.byteLength).toBe(8);
  });

  it("says so when the service cannot be reached", async () => {
    vi.stubGlobal("fetch", vi.fn().mockRejectedValue(new TypeError("failed")));
    await expect(new ToileApi().outfits()).rejects.toMatchObject({ code: "unreachable" });
  });
});
