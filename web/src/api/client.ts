import { Problem, isAbort, problemFrom } from "./problem";
import { parseServerTiming, type Stage } from "./server_timing";
import type {
  BodyParameters,
  BodyRequest,
  ClothPicture,
  DrapeRequest,
  MotionPreset,
  Outfit,
  OutfitPage,
  PosePreset,
  Quality,
  SolvedBody,
} from "./types";

/** A draped outfit as GLB bytes, with what the service says of it. */
export interface Drape {
  glb: ArrayBuffer;
  stages: Stage[];
  quality: Quality | undefined;
  /** Cloth images of the method that has them. */
  cloth: ClothPicture[];
  /** Milliseconds from sending the request to having all bytes. */
  roundTrip: number;
}

/** A drape that the service keeps at a path. */
interface KeptDrape {
  url: string;
  quality: Quality;
  cloth?: ClothPicture[];
}

type Received = Pick<Drape, "glb" | "quality" | "cloth">;

const OVERLOAD_RETRIES = 3;

/** Typed client of the HTTP API. Every method throws `Problem`, or an `AbortError` when its signal fires. */
export class ToileApi {
  constructor(readonly base = "") {}

  url(path: string): string {
    return this.base.replace(/\/$/, "") + path;
  }

  async outfits(cursor?: string, signal?: AbortSignal): Promise<OutfitPage> {
    const query = new URLSearchParams({ limit: "24", ...(cursor ? { cursor } : {}) });
    return this.json<OutfitPage>(`/v1/outfits?${query}`, signal);
  }

  async outfit(id: string, signal?: AbortSignal): Promise<Outfit> {
    return this.json<Outfit>(`/v1/outfits/${encodeURIComponent(id)}`, signal);
  }

  async deleteOutfit(id: string): Promise<void> {
    await this.send(`/v1/outfits/${encodeURIComponent(id)}`, { method: "DELETE" });
  }

  async bodyParameters(): Promise<BodyParameters> {
    return this.json<BodyParameters>("/v1/body");
  }

  async solveBody(request: BodyRequest, signal?: AbortSignal): Promise<SolvedBody> {
    const answer = await this.send("/v1/bodies", jsonPost(request, signal));
    return (await answer.json()) as SolvedBody;
  }

  async poses(): Promise<PosePreset[]> {
    return (await this.json<{ data: PosePreset[] }>("/v1/poses")).data;
  }

  async motions(): Promise<MotionPreset[]> {
    return (await this.json<{ data: MotionPreset[] }>("/v1/motions")).data;
  }

  async bytes(path: string, signal?: AbortSignal): Promise<ArrayBuffer> {
    return (await this.send(path, signal ? { signal } : {})).arrayBuffer();
  }

  async drape(request: DrapeRequest, signal?: AbortSignal): Promise<Drape> {
    const started = performance.now();
    // Cloth images come with JSON answers alone.
    const drawn = request.output?.method === "pixel_cloth";
    const init = jsonPost(request, signal, drawn ? "application/json" : "model/gltf-binary");
    const answer = await this.sendPatiently("/v1/drapes", init);
    const drape = drawn ? await this.kept((await answer.json()) as KeptDrape, signal) : await received(answer);
    const stages = parseServerTiming(answer.headers.get("Server-Timing"));
    return { ...drape, stages, roundTrip: performance.now() - started };
  }

  private async kept({ url, quality, cloth = [] }: KeptDrape, signal?: AbortSignal): Promise<Received> {
    const at = (path: string): string => this.url(path);
    const pictures = cloth.map((picture) => ({ ...picture, url: at(picture.url), preview: at(picture.preview) }));
    return { glb: await this.bytes(url, signal), quality, cloth: pictures };
  }

  private async json<T>(path: string, signal?: AbortSignal): Promise<T> {
    const answer = await this.send(path, { headers: { Accept: "application/json" }, ...(signal ? { signal } : {}) });
    return (await answer.json()) as T;
  }

  /** Waits as long as an overloaded service asks for, a few times. */
  private async sendPatiently(path: string, init: RequestInit): Promise<Response> {
    for (let attempt = 0; ; attempt++) {
      try {
        return await this.send(path, init);
      } catch (error) {
        const seconds = error instanceof Problem ? error.retryAfter : undefined;
        if (seconds === undefined || attempt >= OVERLOAD_RETRIES) throw error;
        await wait(Math.min(seconds, 5) * 1000, init.signal ?? undefined);
      }
    }
  }

  private async send(path: string, init: RequestInit): Promise<Response> {
    let answer: Response;
    try {
      answer = await fetch(this.url(path), init);
    } catch (error) {
      throw isAbort(error) ? error : Problem.offline();
    }
    if (!answer.ok) throw problemFrom(answer.status, await answer.text(), answer.headers.get("Retry-After"));
    return answer;
  }
}

async function received(answer: Response): Promise<Received> {
  return { glb: await answer.arrayBuffer(), quality: parseQuality(answer.headers.get("X-Toile-Quality")), cloth: [] };
}

function jsonPost(body: unknown, signal?: AbortSignal, accept = "application/json"): RequestInit {
  return {
    method: "POST",
    headers: { "Content-Type": "application/json", Accept: accept },
    body: JSON.stringify(body),
    ...(signal ? { signal } : {}),
  };
}

function parseQuality(header: string | null): Quality | undefined {
  if (!header) return undefined;
  try {
    return JSON.parse(header) as Quality;
  } catch {
    return undefined;
  }
}

function wait(milliseconds: number, signal: AbortSignal | undefined): Promise<void> {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, milliseconds);
    signal?.addEventListener("abort", () => {
      clearTimeout(timer);
      reject(new DOMException("aborted", "AbortError"));
    });
  });
}
