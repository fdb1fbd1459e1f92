import {
  type AnimationClip,
  Box3,
  BufferAttribute,
  type BufferGeometry,
  DynamicDrawUsage,
  Group,
  type Material,
  Mesh,
  type Object3D,
} from "three";
import type { GLTF } from "three/addons/loaders/GLTFLoader.js";
import type { VertexAttribute } from "../api/types";
import { Cloth, heatMaterial, mannequinMaterial } from "./cloth";
import type { VertexArrays } from "./glb_arrays";
import { type HeatSummary, paintHeat, summarizeHeat } from "./heat_map";

/** What is drawn over the cloth: tints by garment name (`*` is every garment) or a heat map. */
export interface Look {
  tints: ReadonlyMap<string, string>;
  heat: VertexAttribute | undefined;
}

interface Part {
  key: string;
  garment: string;
  mesh: Mesh<BufferGeometry, Material>;
  /** Undefined for the body. */
  cloth: Cloth | undefined;
}

/** A dressed body on the stage. Its vertex buffers are made once per outfit; a new drape is copied into them. */
export class Figure {
  readonly group = new Group();
  readonly animations: AnimationClip[];
  private readonly parts: Part[] = [];
  private readonly heat = heatMaterial();
  private readonly skin = mannequinMaterial();

  constructor(gltf: GLTF) {
    this.animations = gltf.animations;
    this.group.add(gltf.scene);
    gltf.scene.traverse((object) => {
      if (object instanceof Mesh) this.parts.push(this.partOf(gltf, object as Mesh<BufferGeometry, Material>));
    });
  }

  /** Copies a drape into the buffers; false where the file does not have these vertices. */
  update(arrays: VertexArrays[]): boolean {
    const pairs = this.parts.map((part) => ({ part, array: arrays.find((array) => array.key === part.key) }));
    const same = pairs.every(({ part, array }) => {
      const position = part.mesh.geometry.getAttribute("position");
      return array?.position.length === position.count * 3;
    });
    if (!same || arrays.length !== this.parts.length) return false;
    for (const { part, array } of pairs) if (array) copyArrays(part.mesh.geometry, array);
    return true;
  }

  /** Puts on the look; answers a summary of the heat where one is shown. */
  show(look: Look): HeatSummary | undefined {
    const heated: (ArrayLike<number> & Iterable<number>)[] = [];
    for (const part of this.parts) {
      if (!part.cloth) continue;
      const values = look.heat && part.mesh.geometry.getAttribute(`_${look.heat}`);
      if (look.heat && values) {
        paintHeat(part.mesh.geometry, values.array, look.heat);
        part.mesh.material = this.heat;
        heated.push(values.array);
      } else {
        part.mesh.material = part.cloth.material(look.tints.get(part.garment) ?? look.tints.get("*"));
      }
    }
    return look.heat && heated.length > 0 ? summarizeHeat(look.heat, heated) : undefined;
  }

  /** The box around body and clothes, world space, metres. */
  bounds(): Box3 {
    const box = new Box3();
    const part = new Box3();
    for (const { mesh } of this.parts) {
      part.setFromBufferAttribute(mesh.geometry.getAttribute("position") as BufferAttribute);
      mesh.updateWorldMatrix(true, false);
      box.union(part.applyMatrix4(mesh.matrixWorld));
    }
    return box;
  }

  get garments(): { name: string; color: string }[] {
    const colors = new Map<string, string>();
    for (const { garment, cloth } of this.parts) if (cloth) colors.set(garment, cloth.ownColor);
    return [...colors].map(([name, color]) => ({ name, color }));
  }

  /** Vertex and triangle counts, and a figure that changes when any vertex moves. */
  stats(): { vertices: number; triangles: number; positionSum: number } {
    let vertices = 0;
    let triangles = 0;
    let positionSum = 0;
    for (const { mesh, cloth } of this.parts) {
      const position = mesh.geometry.getAttribute("position");
      for (const value of position.array) positionSum += Math.abs(value);
      if (!cloth) continue;
      vertices += position.count;
      triangles += (mesh.geometry.index?.count ?? position.count) / 3;
    }
    return { vertices, triangles, positionSum };
  }

  /** Mean distance of the cloth's vertices to those of another figure, metres; undefined where it has others. */
  distanceTo(other: Figure): number | undefined {
    let [sum, count] = [0, 0];
    for (const part of this.parts) {
      if (!part.cloth) continue;
      const here = part.mesh.geometry.getAttribute("position");
      const there = other.parts.find(({ key }) => key === part.key)?.mesh.geometry.getAttribute("position");
      if (there?.count !== here.count) return undefined;
      for (let i = 0; i < here.count; i++) {
        sum += Math.hypot(here.getX(i) - there.getX(i), here.getY(i) - there.getY(i), here.getZ(i) - there.getZ(i));
      }
      count += here.count;
    }
    return count > 0 ? sum / count : undefined;
  }

  dispose(): void {
    for (const { mesh, cloth } of this.parts) {
      mesh.geometry.dispose();
      cloth?.dispose();
    }
    this.heat.dispose();
    this.skin.dispose();
  }

  private partOf(gltf: GLTF, mesh: Mesh<BufferGeometry, Material>): Part {
    const place = gltf.parser.associations.get(mesh);
    const garment = garmentName(mesh, gltf.scene);
    const isBody = garment === "body";
    makeWritable(mesh.geometry);
    mesh.frustumCulled = false;
    mesh.castShadow = true;
    mesh.receiveShadow = true;
    const cloth = isBody ? undefined : new Cloth(mesh.material);
    if (isBody) mesh.material = this.skin;
    return { key: `${place?.meshes ?? 0}/${place?.primitives ?? 0}`, garment, mesh, cloth };
  }
}

/** The name of the node under the scene that holds the mesh. */
function garmentName(mesh: Object3D, scene: Object3D): string {
  let node = mesh;
  while (node.parent && node.parent !== scene) node = node.parent;
  return typeof node.userData.name === "string" ? node.userData.name : node.name;
}

function makeWritable(geometry: BufferGeometry): void {
  for (const name of ["position", "normal"]) {
    const source = geometry.getAttribute(name);
    if (!(source as typeof source | undefined)) continue;
    const values = new Float32Array(source.count * 3);
    for (let row = 0; row < source.count; row++) {
      values.set([source.getX(row), source.getY(row), source.getZ(row)], row * 3);
    }
    geometry.setAttribute(name, new BufferAttribute(values, 3).setUsage(DynamicDrawUsage));
  }
  if (!geometry.hasAttribute("normal")) geometry.computeVertexNormals();
}

function copyArrays(geometry: BufferGeometry, arrays: VertexArrays): void {
  copyInto(geometry, "position", arrays.position, 3);
  if (arrays.normal) copyInto(geometry, "normal", arrays.normal, 3);
  else geometry.computeVertexNormals();
  for (const name of ["strain", "penetration"] as const) {
    const values = arrays[name];
    if (values) copyInto(geometry, `_${name}`, values, 1);
    else geometry.deleteAttribute(`_${name}`);
  }
}

function copyInto(geometry: BufferGeometry, name: string, values: Float32Array, width: number): void {
  const attribute = geometry.getAttribute(name) as BufferAttribute | undefined;
  if (attribute?.array.length === values.length) {
    attribute.array.set(values);
    attribute.needsUpdate = true;
  } else {
    geometry.setAttribute(name, new BufferAttribute(values.slice(), width).setUsage(DynamicDrawUsage));
  }
}
