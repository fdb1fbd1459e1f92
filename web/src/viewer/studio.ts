import {
  BackSide,
  BoxGeometry,
  Color,
  DirectionalLight,
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  PlaneGeometry,
  PMREMGenerator,
  PointLight,
  Scene,
  type Texture,
  type WebGLRenderer,
} from "three";

interface Softbox {
  size: [width: number, height: number];
  at: [x: number, y: number, z: number];
  intensity: number;
}

const SOFTBOXES: Softbox[] = [
  { size: [3.2, 4.2], at: [-4.2, 3.2, 3.4], intensity: 9 },
  { size: [2.4, 4.2], at: [4.6, 2.6, 2.2], intensity: 4 },
  { size: [5, 3], at: [0, 4.9, 0], intensity: 5 },
  { size: [1.2, 4.4], at: [2.8, 2.4, -4.6], intensity: 7 },
  { size: [1.2, 4.4], at: [-3.4, 2.4, -4.4], intensity: 5 },
];

/** A photographer's studio as an environment map: a pale room with softboxes. */
export function studioEnvironment(renderer: WebGLRenderer): Texture {
  const room = new Scene();
  const walls = new MeshStandardMaterial({ color: new Color("#d9d4cd"), side: BackSide, roughness: 1, metalness: 0 });
  const box = new Mesh(new BoxGeometry(11, 10, 11), walls);
  const bulb = new PointLight("#ffffff", 95, 30, 2);
  bulb.position.set(0, 3.4, 1);
  room.add(box, bulb, ...SOFTBOXES.map(softboxMesh));
  const generator = new PMREMGenerator(renderer);
  const { texture } = generator.fromScene(room, 0.035);
  generator.dispose();
  room.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    const { geometry, material } = object as Mesh<BoxGeometry, MeshBasicMaterial>;
    geometry.dispose();
    material.dispose();
  });
  return texture;
}

function softboxMesh({ size, at, intensity }: Softbox): Mesh {
  const material = new MeshBasicMaterial({ color: new Color(1, 0.985, 0.96).multiplyScalar(intensity) });
  const mesh = new Mesh(new PlaneGeometry(...size), material);
  mesh.position.set(...at);
  mesh.lookAt(0, 1, 0);
  return mesh;
}

/** A key light that casts the shadows of folds, and a rim light from behind. */
export function studioLights(): Group {
  const key = new DirectionalLight("#fff6ea", 2.0);
  key.position.set(-1.9, 3.6, 3.0);
  key.target.position.set(0, 0.9, 0);
  key.castShadow = true;
  key.shadow.mapSize.set(2048, 2048);
  key.shadow.radius = 5;
  key.shadow.bias = -0.0004;
  key.shadow.normalBias = 0.012;
  Object.assign(key.shadow.camera, { left: -1.2, right: 1.2, top: 1.35, bottom: -1.35, near: 1, far: 8 });
  const rim = new DirectionalLight("#e8efff", 1.0);
  rim.position.set(2.2, 2.6, -3);
  const lights = new Group();
  lights.add(key, key.target, rim);
  return lights;
}
