import type { Kinds, Method, Outfit } from "../api/types";

/** The ways to drape, as they are told to shoppers. */
export const METHODS: readonly { id: Method; name: string; text: string }[] = [
  { id: "deepsd", name: "DeePSD", text: "Learned folds, in real time, for any garment." },
  { id: "garnet", name: "GarNet++", text: "A network for one kind of garment, which sees the body as points." },
  { id: "pixel_cloth", name: "Pixel cloth", text: "A network of this very garment, which draws its folds as images." },
  { id: "deepsd-concat", name: "DeePSD, as printed", text: "The paper's per-vertex network. Slower; for comparison." },
  { id: "skinning", name: "Skinning only", text: "Follows the bones; nothing learned." },
  { id: "simulation", name: "Simulation", text: "Simulated beforehand, on some bodies in some poses." },
];

export function methodName(id: Method): string {
  return METHODS.find((method) => method.id === id)?.name ?? id;
}

/** Whether a way can drape the outfit: GarNet++ needs a kind of every garment, pixel cloth a network, simulations be kept. */
export function canDrape(method: Method, outfit: Outfit, kinds: Kinds): boolean {
  if (method === "garnet") return outfit.garments.every(({ name }) => kinds[name] !== undefined);
  if (method === "pixel_cloth" || method === "simulation") return outfit.methods.includes(method);
  return true;
}
