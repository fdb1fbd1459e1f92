/** A GLB of one tube per part: rings of vertices about the y axis, metres. */
export interface TubePart {
  name: string;
  radius: number;
  rings?: number;
  strain?: number;
}

interface Attributes {
  POSITION: number;
  NORMAL: number;
  _STRAIN?: number;
}

const SEGMENTS = 8;

export function tubeGlb(parts: TubePart[]): ArrayBuffer {
  const writer = new GlbWriter();
  for (const part of parts) writer.add(part);
  return writer.bytes();
}

class GlbWriter {
  private readonly chunks: Uint8Array[] = [];
  private length = 0;
  private readonly document = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [] as number[] }],
    nodes: [] as object[],
    meshes: [] as object[],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [0.2, 0.4, 0.6, 1] } }],
    accessors: [] as object[],
    bufferViews: [] as object[],
    buffers: [{ byteLength: 0 }],
  };

  add({ name, radius, rings = 3, strain }: TubePart): void {
    const { positions, normals, indices } = tube(radius, rings);
    const attributes: Attributes = {
      POSITION: this.accessor(positions, "VEC3"),
      NORMAL: this.accessor(normals, "VEC3"),
      ...(strain === undefined
        ? {}
        : { _STRAIN: this.accessor(new Float32Array(positions.length / 3).fill(strain), "SCALAR") }),
    };
    const primitive = { attributes, indices: this.accessor(indices, "SCALAR"), material: 0 };
    this.document.meshes.push({ primitives: [primitive] });
    this.document.scenes[0]?.nodes.push(this.document.nodes.length);
    this.document.nodes.push({ name, mesh: this.document.meshes.length - 1 });
  }

  bytes(): ArrayBuffer {
    this.document.buffers = [{ byteLength: this.length }];
    const text = JSON.stringify(this.document);
    const json = new TextEncoder().encode(text.padEnd(Math.ceil(text.length / 4) * 4));
    const glb = new Uint8Array(28 + json.length + this.length);
    const header = [0x46546c67, 2, glb.length, json.length, 0x4e4f534a];
    const view = new DataView(glb.buffer);
    header.forEach((word, index) => view.setUint32(index * 4, word, true));
    glb.set(json, 20);
    view.setUint32(20 + json.length, this.length, true);
    view.setUint32(24 + json.length, 0x004e4942, true);
    let offset = 28 + json.length;
    for (const chunk of this.chunks) {
      glb.set(chunk, offset);
      offset += chunk.length;
    }
    return glb.buffer;
  }

  private accessor(values: Float32Array | Uint32Array, type: "SCALAR" | "VEC3"): number {
    this.document.bufferViews.push({ buffer: 0, byteOffset: this.length, byteLength: values.byteLength });
    this.chunks.push(new Uint8Array(values.buffer, values.byteOffset, values.byteLength));
    this.length += values.byteLength;
    const componentType = values instanceof Float32Array ? 5126 : 5125;
    const count = values.length / (type === "VEC3" ? 3 : 1);
    const bounds = type === "VEC3" ? { min: [-9, -9, -9], max: [9, 9, 9] } : {};
    this.document.accessors.push({ bufferView: this.document.bufferViews.length - 1, componentType, count, type, ...bounds });
    return this.document.accessors.length - 1;
  }
}

function tube(radius: number, rings: number): { positions: Float32Array; normals: Float32Array; indices: Uint32Array } {
  const positions: number[] = [];
  const normals: number[] = [];
  const indices: number[] = [];
  for (let ring = 0; ring < rings; ring++) {
    for (let segment = 0; segment < SEGMENTS; segment++) {
      const angle = (segment / SEGMENTS) * 2 * Math.PI;
      positions.push(radius * Math.cos(angle), 0.8 + 0.1 * ring, radius * Math.sin(angle));
      normals.push(Math.cos(angle), 0, Math.sin(angle));
      const [a, b] = [ring * SEGMENTS + segment, ring * SEGMENTS + ((segment + 1) % SEGMENTS)];
      if (ring + 1 < rings) indices.push(a, a + SEGMENTS, b, b, a + SEGMENTS, b + SEGMENTS);
    }
  }
  return { positions: Float32Array.from(positions), normals: Float32Array.from(normals), indices: Uint32Array.from(indices) };
}
