import type { Problem } from "../api/problem";
import type { Stage as TimedStage } from "../api/server_timing";
import type { ClothPicture, Quality } from "../api/types";
import type { HeatSummary } from "./heat_map";
import type { PlaybackState } from "./playback";

/** A drape is on the stage. */
export interface DrapeDetail {
  outfit: string;
  bytes: number;
  roundTrip: number;
  stages: TimedStage[];
  quality: Quality | undefined;
  heat: HeatSummary | undefined;
  /** Cloth images of the method that has them. */
  cloth: ClothPicture[];
  garments: { name: string; color: string }[];
  /** True where the vertex buffers were written in place. */
  inPlace: boolean;
}

export interface ViewerEventMap {
  "toile-loading": CustomEvent<{ busy: boolean; first: boolean }>;
  "toile-drape": CustomEvent<DrapeDetail>;
  "toile-error": CustomEvent<{ problem: Problem }>;
  "toile-playback": CustomEvent<PlaybackState | undefined>;
}

/** Figures about what is on the stage, for tests and for shops that measure. */
export interface ViewerStats {
  outfit: string | undefined;
  vertices: number;
  triangles: number;
  /** Sum of the absolute coordinates of every vertex: changes when the geometry does. */
  positionSum: number;
  /** Height of the figure, metres. */
  height: number;
  drapes: number;
  inPlaceUpdates: number;
  heat: HeatSummary | undefined;
  playback: PlaybackState | undefined;
  busy: boolean;
}
