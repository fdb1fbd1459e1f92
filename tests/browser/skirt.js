/** A small skirt around the hips of the reference body, as a GLB: rest pose, metres, Y up, front +Z. */
const SEGMENTS = 32;
const RINGS = 12;
const WAIST = { y: 1.06, x: 0.19, z: 0.16 };
const HEM = { y: 0.58, x: 0.3, z: 0.26 };

/** `flare` scales the hem, so that two skirts have different bytes and so different ids. */
export function skirtGlb(flare = 1) {
  const { positions, indices } = skirt(flare);
  const binary = Buffer.concat([Buffer.from(positions.buffer), Buffer.from(indices.buffer)]);
  const text = JSON.stringify({
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ name: "skirt", mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: positions.length / 3, type: "VEC3", ...bounds(positions) },
      { bufferView: 1, componentType: 5125, count: indices.length, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: positions.byteLength },
      { buffer: 0, byteOffset: positions.byteLength, byteLength: indices.byteLength },
    ],
    buffers: [{ byteLength: binary.length }],
  });
  const json = Buffer.from(text.padEnd(Math.ceil(text.length / 4) * 4));
  const words = (...values) => Buffer.from(Uint32Array.from(values).buffer);
  const length = 28 + json.length + binary.length;
  return Buffer.concat([
    words(0x46546c67, 2, length, json.length, 0x4e4f534a),
    json,
    words(binary.length, 0x004e4942),
    binary,
  ]);
}

function skirt(flare) {
  const positions = [];
  const indices = [];
  for (let ring = 0; ring < RINGS; ring++) {
    const share = ring / (RINGS - 1);
    const along = (key) => WAIST[key] + (HEM[key] * (key === "y" ? 1 : flare) - WAIST[key]) * share;
    for (let segment = 0; segment < SEGMENTS; segment++) {
      const angle = (segment / SEGMENTS) * 2 * Math.PI;
      positions.push(along("x") * Math.sin(angle), along("y"), along("z") * Math.cos(angle));
      const a = ring * SEGMENTS + segment;
      const b = ring * SEGMENTS + ((segment + 1) % SEGMENTS);
      if (ring + 1 < RINGS) indices.push(a, a + SEGMENTS, b, b, a + SEGMENTS, b + SEGMENTS);
    }
  }
  return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

function bounds(positions) {
  const column = (axis) => positions.filter((_, index) => index % 3 === axis);
  return {
    min: [0, 1, 2].map((axis) => Math.min(...column(axis))),
    max: [0, 1, 2].map((axis) => Math.max(...column(axis))),
  };
}
