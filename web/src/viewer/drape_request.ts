import type { Body, DrapeRequest, Kinds, Method, Pose, VertexAttribute } from "../api/types";

/** What the viewer shows: the whole of a drape request, before it becomes one. */
export interface Wish {
  outfit: string | null;
  body: Body | null;
  pose: Pose | null;
  /** A motion instead of a pose, such as `walk`. */
  motion: string | null;
  method: Method | null;
  /** Kinds of the garments, for the method that needs them. */
  kinds: Kinds | null;
  heat: VertexAttribute | null;
}

/** The request for a wish. Textures are left out where a figure on the stage has them already. */
export function drapeRequest(wish: Wish & { outfit: string }, textures = true): DrapeRequest {
  // A heat map shows one still pose.
  const heat = wish.motion ? null : wish.heat;
  return {
    outfit: wish.outfit,
    ...(wish.body ? { body: wish.body } : {}),
    ...(wish.motion ? { motion: wish.motion } : wish.pose ? { pose: wish.pose } : {}),
    output: {
      include: ["outfit", "body"],
      ...(wish.method ? { method: wish.method } : {}),
      ...(wish.method === "garnet" && wish.kinds ? { kinds: wish.kinds } : {}),
      ...(heat ? { attributes: [heat] } : {}),
      ...(textures ? {} : { textures }),
    },
  };
}

/** Reads a `pose` attribute: a preset's id, or a pose as JSON. */
export function parsePose(text: string | null): Pose | null {
  if (!text) return null;
  return text.trimStart().startsWith("{") ? (JSON.parse(text) as Pose) : { kind: "preset", id: text };
}

/** Reads a `body` attribute: a body as JSON. */
export function parseBody(text: string | null): Body | null {
  return text ? (JSON.parse(text) as Body) : null;
}

/** True where a drape of `next` has the vertices of a drape of `before`, so that buffers can be reused. */
export function sameVertices(before: Wish | undefined, next: Wish): boolean {
  return before !== undefined && before.outfit === next.outfit && !before.motion && !next.motion;
}

/** True where what is in flight for `before` is of no use any more: another outfit, or a motion begun or ended. */
export function replaces(before: Wish | undefined, next: Wish): boolean {
  return before?.outfit !== next.outfit || before.motion !== next.motion;
}
