/** Wire types of the HTTP API (docs/api.md). Centimetres and kilograms in measurements, metres elsewhere. */

export type Method = "deepsd" | "deepsd-concat" | "garnet" | "pixel_cloth" | "simulation" | "skinning";
/** Kinds of garments that GarNet++ is trained on. */
export type GarmentKind = "tee" | "sweater" | "dress" | "jeans";
/** Kinds by the garments' names. */
export type Kinds = Record<string, GarmentKind>;
export type VertexAttribute = "strain" | "penetration";
export type Quaternion = readonly [x: number, y: number, z: number, w: number];

export interface Garment {
  name: string;
  vertices: number;
  triangles: number;
  layer: number;
}

/** What reading an upload found and mended. */
export interface MendingReport {
  scale_applied: number;
  up_axis: string;
  units: string;
  welded_vertices: number;
  degenerate_faces_removed: number;
  duplicate_faces_removed: number;
  components: number;
  non_manifold_edges: number;
  flipped_normals: number;
  rest_penetration_percent: number;
  self_crossed_percent: number;
  notes: string[];
}

/** What a pixel-cloth network said of a garment: PNGs at paths of the API. */
export interface ClothPicture {
  garment: string;
  url: string;
  preview: string;
}

/** A pose that an outfit was simulated in, on the reference body. */
export interface SimulatedOn {
  body: Body;
  pose: Pose;
}

export interface Outfit {
  id: string;
  name: string;
  vertices: number;
  triangles: number;
  garments: Garment[];
  methods: string[];
  kinds?: Kinds;
  simulated?: SimulatedOn[];
  created_at: string;
  links: { self: string; static: string; thumbnail: string | null; bake: string | null };
  report?: MendingReport;
}

export interface OutfitPage {
  data: Outfit[];
  next_cursor: string | null;
}

export interface OutfitMetadata {
  name?: string;
  units?: "m" | "cm" | "mm" | "in";
  up?: "y" | "z";
}

export interface PhenotypeParameter {
  name: string;
  label: string;
  min: number;
  max: number;
  default: number;
  low: string;
  high: string;
}

export interface MeasurementParameter {
  name: string;
  label: string;
  unit: string;
  min: number;
  max: number;
  default: number;
  description: string;
}

export interface BodyParameters {
  phenotypes: PhenotypeParameter[];
  measurements: MeasurementParameter[];
}

export type Body =
  | { kind: "phenotypes" | "measurements"; values: Record<string, number> }
  /** A scan's, as `POST /v1/bodies` answered. */
  | { kind: "scan"; id: string };

export interface BodyRequest {
  measurements: Record<string, number>;
  gender?: number;
}

export interface SolvedMeasurement {
  requested: number | null;
  achieved: number;
  residual: number | null;
}

export interface SolvedBody {
  phenotypes: Record<string, number>;
  local_changes: Record<string, number>;
  measurements: Record<string, SolvedMeasurement>;
  shape: Body;
  /** How near the body is to the scan that it was found for. */
  scan?: { distance_mm: number; unseen_percent: number };
}

export interface PosePreset {
  id: string;
  label: string;
  group: string;
}

export interface MotionPreset {
  id: string;
  label: string;
  frames: number;
  frame_rate: number;
}

export type Pose =
  | { kind: "preset"; id: string }
  | { kind: "joints"; rotations: Record<string, Quaternion> };

export interface DrapeRequest {
  outfit: string;
  body?: Body;
  pose?: Pose;
  motion?: string;
  output: { include: ("outfit" | "body")[]; method?: Method; kinds?: Kinds; attributes?: VertexAttribute[]; textures?: boolean };
}

export interface Quality {
  penetration_before_percent: number;
  penetration_after_percent: number;
  p95_edge_strain: number;
  max_edge_stretch: number;
}
