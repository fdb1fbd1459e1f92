/**
 * Reads the vertex arrays of a GLB (glTF 2.0 §3.6, §4.4) and nothing else: no textures, no materials, no scene.
 * A new drape of an outfit that is already on the stage differs only in these, and they are copied in place.
 */

export interface VertexArrays {
  /** `mesh/primitive`, the indices in the file: the same for every drape of an outfit. */
  key: string;
  position: Float32Array;
  normal: Float32Array | undefined;
  strain: Float32Array | undefined;
  penetration: Float32Array | undefined;
}

interface Accessor {
  bufferView?: number;
  byteOffset?: number;
  componentType: number;
  count: number;
  type: string;
  sparse?: unknown;
}

interface GltfDocument {
  accessors?: Accessor[];
  bufferViews?: { buffer: number; byteOffset?: number; byteStride?: number; extensions?: object }[];
  meshes?: { primitives: { attributes: Record<string, number>; targets?: unknown[] }[] }[];
}

interface Glb {
  document: GltfDocument;
  binary: ArrayBuffer;
  binaryOffset: number;
}

const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const FLOAT = 5126;
const WIDTH: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

/** The arrays of every primitive, or undefined where the file needs the full loader (compressed, animated, sparse). */
export function readVertexArrays(glb: ArrayBuffer): VertexArrays[] | undefined {
  const file = openGlb(glb);
  if (!file) return undefined;
  const arrays: VertexArrays[] = [];
  for (const [meshIndex, mesh] of (file.document.meshes ?? []).entries()) {
    for (const [index, primitive] of mesh.primitives.entries()) {
      const read = (name: string): Float32Array | undefined => readAccessor(file, primitive.attributes[name]);
      const position = read("POSITION");
      if (!position || primitive.targets?.length) return undefined;
      arrays.push({
        key: `${meshIndex}/${index}`,
        position,
        normal: read("NORMAL"),
        strain: read("_STRAIN"),
        penetration: read("_PENETRATION"),
      });
    }
  }
  return arrays.length > 0 ? arrays : undefined;
}

function openGlb(glb: ArrayBuffer): Glb | undefined {
  if (glb.byteLength < 20) return undefined;
  const view = new DataView(glb);
  const jsonLength = view.getUint32(12, true);
  const json = view.getUint32(0, true) === MAGIC && view.getUint32(16, true) === JSON_CHUNK;
  if (!json || 20 + jsonLength > glb.byteLength) return undefined;
  try {
    const text = new TextDecoder().decode(new Uint8Array(glb, 20, jsonLength));
    return { document: JSON.parse(text) as GltfDocument, binary: glb, binaryOffset: 20 + jsonLength + 8 };
  } catch {
    return undefined;
  }
}

function readAccessor(file: Glb, index: number | undefined): Float32Array | undefined {
  const accessor = index === undefined ? undefined : file.document.accessors?.[index];
  const bufferView = file.document.bufferViews?.[accessor?.bufferView ?? -1];
  const width = WIDTH[accessor?.type ?? ""];
  const plain = accessor && !accessor.sparse && accessor.componentType === FLOAT;
  if (!plain || !bufferView || bufferView.extensions || bufferView.buffer !== 0 || !width) return undefined;
  const start = file.binaryOffset + (bufferView.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const stride = bufferView.byteStride ?? width * 4;
  const end = start + (accessor.count - 1) * stride + width * 4;
  if (accessor.count < 1 || end > file.binary.byteLength) return undefined;
  if (stride === width * 4 && start % 4 === 0) return new Float32Array(file.binary, start, accessor.count * width);
  return gather(new DataView(file.binary), start, stride, accessor.count, width);
}

function gather(view: DataView, start: number, stride: number, count: number, width: number): Float32Array {
  const values = new Float32Array(count * width);
  for (let row = 0; row < count; row++) {
    for (let column = 0; column < width; column++) {
      values[row * width + column] = view.getFloat32(start + row * stride + column * 4, true);
    }
  }
  return values;
}
