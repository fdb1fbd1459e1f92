import type { ToileApi } from "../api/client";
import type { Outfit } from "../api/types";
import { Box3 } from "three";
import type { Figure } from "./figure";
import { loadFigure } from "./load_figure";
import { Stage } from "./stage";

const WIDTH = 256;
const HEIGHT = 320;
/** Pictures of earlier visits; the number changes when pictures are to look different. */
const STORE = "toile-portraits-1";

/** Draws outfits on the reference body, one after the other, for those that the service has no picture of. */
export class PortraitStudio {
  private stage: Stage | undefined;
  private queue: Promise<unknown> = Promise.resolve();
  private pending = 0;
  private body: Promise<ArrayBuffer> | undefined;

  constructor(private readonly api: ToileApi) {}

  /** A blob URL of the picture; the caller revokes it. */
  draw(outfit: Pick<Outfit, "id" | "links">): Promise<string> {
    this.pending++;
    const drawn = this.queue.then(() => remembered(outfit.id, () => this.drawOne(outfit.links.static)));
    this.queue = drawn.catch(() => undefined).then(() => this.closeWhenIdle());
    return drawn.then((picture) => URL.createObjectURL(picture));
  }

  private async drawOne(staticPath: string): Promise<Blob> {
    this.body ??= this.api.bytes("/v1/body/reference.glb");
    const [outfit, body] = await Promise.all([this.api.bytes(staticPath), this.body]);
    const [dressed, mannequin] = await Promise.all([loadFigure(outfit), loadFigure(body)]);
    try {
      return await this.photograph(dressed, mannequin);
    } finally {
      mannequin.dispose();
    }
  }

  private async photograph(dressed: Figure, mannequin: Figure): Promise<Blob> {
    this.stage ??= new Stage(document.createElement("canvas"));
    this.stage.resize(WIDTH, HEIGHT, 1.5);
    dressed.show({ tints: new Map(), heat: undefined });
    const frame = portraitFrame(dressed.bounds(), mannequin.bounds());
    dressed.group.add(mannequin.group);
    this.stage.replace(dressed);
    this.stage.rig.frame(frame);
    const picture = await this.stage.picture();
    dressed.group.remove(mannequin.group);
    if (!picture) throw new Error("The picture could not be drawn.");
    return picture;
  }

  /** A WebGL context is scarce: it is given back when there is nothing more to draw. */
  private closeWhenIdle(): void {
    this.pending--;
    if (this.pending > 0) return;
    this.stage?.dispose();
    this.stage = undefined;
  }
}

const HEAD_ROOM = 0.4;

/** The outfit, and the head where it is worn near it: a picture does not cut a face in two. */
function portraitFrame(outfit: Box3, body: Box3): Box3 {
  const frame = outfit.clone().expandByScalar(0.05);
  if (body.max.y - outfit.max.y < HEAD_ROOM) frame.max.y = body.max.y;
  return frame;
}

/** The picture of an earlier visit, or a new one. An outfit's id is the hash of its content, so it never goes stale. */
async function remembered(id: string, draw: () => Promise<Blob>): Promise<Blob> {
  // Only secure contexts have a cache.
  const store = "caches" in globalThis ? await caches.open(STORE).catch(() => undefined) : undefined;
  const key = `/portraits/${id}.png`;
  const kept = await store?.match(key);
  if (kept) return kept.blob();
  const picture = await draw();
  await store?.put(key, new Response(picture)).catch(() => undefined);
  return picture;
}
