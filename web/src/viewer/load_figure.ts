import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import { Figure } from "./figure";

const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);

/** Builds a figure from GLB bytes: geometry, textures, materials and animation. */
export async function loadFigure(glb: ArrayBuffer): Promise<Figure> {
  return new Figure(await loader.parseAsync(glb, ""));
}
