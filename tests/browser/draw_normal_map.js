/** Draws docs/pictures/normal-map.jpg: an outfit's fine drape beside the coarse one, without and with its normal map.
 * Of a running service: `TOILE_URL=… node draw_normal_map.js [outfit's name] [pose] [method]`. */
import { readFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { launch, TOILE_URL } from "./fitting_room.js";

const PICTURE = process.env.PICTURE ?? fileURLToPath(new URL("../../docs/pictures/normal-map.jpg", import.meta.url));
const THREE = new URL("../../web/node_modules/three/", import.meta.url);
const [NAME = "Hero", POSE = "arms-up", METHOD = "pixel_cloth"] = process.argv.slice(2);
const [WIDTH, HEIGHT] = [420, 560];
const PAGE = "http://normal-map.test/";

/** Runs in the page: draws a GLB, with or without its normal maps, lit from the side. */
const SCRIPT = `
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
window.draw = async (base64, withMap, view) => {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const { scene: outfit } = await new GLTFLoader().parseAsync(bytes.buffer, "");
  outfit.traverse(({ material }) => {
    if (!material) return;
    Object.assign(material, { map: null, color: new THREE.Color(0.55, 0.58, 0.65), sheen: 0 });
    if (!withMap) material.normalMap = null;
    material.needsUpdate = true;
  });
  const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  renderer.setSize(${WIDTH}, ${HEIGHT});
  const scene = new THREE.Scene();
  scene.background = new THREE.Color("#f2f0ec");
  const light = new THREE.DirectionalLight("#ffffff", 3);
  light.position.set(-3 * Math.cos(view), 2, 3 * Math.sin(view)).add(new THREE.Vector3(Math.sin(view), 0, Math.cos(view)));
  scene.add(outfit, light, new THREE.HemisphereLight("#ffffff", "#555555", 0.7));
  const box = new THREE.Box3().setFromObject(outfit);
  const [middle, size] = [box.getCenter(new THREE.Vector3()), box.getSize(new THREE.Vector3())];
  const camera = new THREE.PerspectiveCamera(25, ${WIDTH / HEIGHT}, 0.1, 20);
  const away = Math.max(size.y, (size.x * ${HEIGHT}) / ${WIDTH}) * 2.45;
  camera.position.set(away * Math.sin(view), 0, away * Math.cos(view)).add(middle);
  camera.lookAt(middle);
  renderer.render(scene, camera);
  return renderer.domElement.toDataURL();
};
window.ready = true;`;
const HTML = `<script type="importmap">{"imports": {"three": "${PAGE}build/three.module.js", "three/addons/": "${PAGE}examples/jsm/"}}</script>
<script type="module">${SCRIPT}</script>`;

async function drape(outfit, output) {
  const request = { outfit, pose: { kind: "preset", id: POSE }, output: { method: METHOD, textures: false, ...output } };
  const body = JSON.stringify(request);
  const answer = await fetch(`${TOILE_URL}/v1/drapes`, { method: "POST", headers: { "content-type": "application/json" }, body });
  if (!answer.ok) throw new Error(await answer.text());
  console.log(output.detail ?? "mesh", answer.headers.get("server-timing"));
  return Buffer.from(await answer.arrayBuffer());
}

/** Triangles of a GLB, and bytes of its pictures. */
function figures(glb) {
  const { meshes, accessors, images = [], bufferViews } = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)));
  const sum = (numbers) => numbers.reduce((total, number) => total + number, 0);
  const counts = meshes.flatMap(({ primitives }) => primitives.map(({ indices }) => accessors[indices].count / 3));
  return { triangles: sum(counts), pictures: sum(images.map((image) => bufferViews[image.bufferView].byteLength)) };
}

const { data } = await (await fetch(`${TOILE_URL}/v1/outfits?limit=100`)).json();
const { id } = data.find(({ name }) => name.toLowerCase().startsWith(NAME.toLowerCase()));
const [fine, coarse] = [await drape(id, {}), await drape(id, { detail: "normal_map" })];
const { triangles, pictures } = figures(coarse);
const kilobytes = (bytes) => `${(bytes / 1000).toFixed(0)} kB`;
const tiles = [
  { label: `fine: ${figures(fine).triangles} triangles, ${kilobytes(fine.length)}`, glb: fine, map: false },
  { label: `coarse: ${triangles} triangles, ${kilobytes(coarse.length - pictures)}`, glb: coarse, map: false },
  { label: `coarse with normal map: ${kilobytes(coarse.length)}`, glb: coarse, map: true },
];
console.log(tiles.map(({ label }) => label).join("; "));
const browser = await launch();
const page = await browser.newPage({ viewport: { width: WIDTH * tiles.length, height: 2 * HEIGHT + 30 } });
page.on("pageerror", (error) => console.error(error.message));
await page.route(`${PAGE}**`, async (route) => {
  const path = new URL(route.request().url()).pathname.slice(1);
  if (path === "") return route.fulfill({ contentType: "text/html", body: HTML });
  return route.fulfill({ contentType: "text/javascript", body: await readFile(new URL(path, THREE)) });
});
await page.goto(PAGE);
await page.waitForFunction("window.ready");
let body = "";
for (const { label, glb, map } of tiles) {
  const draw = (view) => page.evaluate(`draw("${glb.toString("base64")}", ${map}, ${view})`);
  const views = [await draw(0), await draw(Math.PI)].map((source) => `<img src="${source}" style="display:block">`);
  body += `<div style="width:${WIDTH}px">${views.join("")}<p style="margin:6px;font:15px sans-serif">${label}</p></div>`;
}
await page.setContent(`<body style="margin:0;display:flex;background:#f2f0ec">${body}</body>`);
await page.screenshot({ path: PICTURE, quality: 82, type: "jpeg" });
await browser.close();
