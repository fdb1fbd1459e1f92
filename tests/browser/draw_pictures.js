/** Draws the README's pictures from the page itself: `make pictures`. */
import { fileURLToPath } from "node:url";
import { FittingRoom, launch, TOILE_URL } from "./fitting_room.js";

const PICTURES = fileURLToPath(new URL("../../docs/pictures/", import.meta.url));
const HEIGHT = 460;
const WIDTH = 250;
/** What lies over the stage, left out of the row. */
const OVERLAYS = ".stage__caption, .stage__views, .stage__speed, .compare__choice";

/** What the row shows: outfit, pose, and the first body changes that a shopper would make. */
const LOOKS = [
  { outfit: "Blazer", pose: "contrapposto", body: {} },
  { outfit: "Polka-dot", pose: "walk-2", body: { height: "165", waist: "68" } },
  { outfit: "Flannel", pose: "hands-on-hips", body: { height: "185", waist: "94" } },
  { outfit: "Evening gown", pose: "look-back", body: { height: "176" } },
  { outfit: "Striped", pose: "wave", body: { height: "170", waist: "98", hip: "112" } },
  { outfit: "Tank top", pose: "walk-3", body: { height: "165" } },
  { outfit: "Shirt and tie", pose: "reach", body: { height: "180" } },
];

async function look(room, outfits, { outfit, pose, body }) {
  const { id } = outfits.find((candidate) => candidate.name.startsWith(outfit));
  const worn = room.page.locator(`[data-outfit="${id}"]`);
  if ((await worn.getAttribute("aria-pressed")) !== "true") await room.change(() => worn.click());
  await room.tab("body");
  for (const [name, value] of Object.entries(body)) await room.change(() => room.measure(name, value));
  await room.tab("pose");
  await room.change(() => room.pose(pose));
  await room.page.addStyleTag({ content: `${OVERLAYS} { visibility: hidden }` });
  const { x, y, width, height } = await room.page.locator("toile-viewer").boundingBox();
  const wide = Math.min(width, (height * WIDTH) / HEIGHT);
  const clip = { x: x + (width - wide) / 2, y, width: wide, height };
  return `data:image/png;base64,${(await room.page.screenshot({ clip })).toString("base64")}`;
}

async function wholePage(room) {
  await room.page.addStyleTag({ content: `${OVERLAYS} { visibility: visible !important }` });
  await room.tab("outfits");
  await room.picturesDrawn();
  await room.page.screenshot({ path: `${PICTURES}page.png` });
}

/** The stage with a learned drape and the simulated one. */
async function comparison(room) {
  await room.change(() => room.page.locator("[data-outfit]", { hasText: "Tea dress" }).click());
  await room.page.selectOption('[name="compare"]', "simulation");
  await room.change(() => room.page.locator(".compare__notice").getByRole("button", { name: "walk 2" }).click());
  await room.page.locator(".compare__label--other", { hasText: "Simulation" }).waitFor();
  // The second viewer's first frame.
  await room.page.waitForTimeout(3000);
  await room.page.locator(".stage").screenshot({ path: `${PICTURES}compare.jpg`, quality: 88, type: "jpeg" });
}

const outfits = (await (await fetch(`${TOILE_URL}/v1/outfits?limit=100`)).json()).data;
const browser = await launch();
const tiles = [];
for (const wanted of LOOKS) {
  const room = await FittingRoom.open(browser);
  tiles.push(await look(room, outfits, wanted));
  console.log(wanted.outfit);
  if (tiles.length === 2) await wholePage(room);
  await room.close();
}
const room = await FittingRoom.open(browser);
await comparison(room);
await room.close();
const row = await browser.newPage({ viewport: { width: WIDTH * LOOKS.length, height: HEIGHT } });
const tile = (source) => `<div style="width:${WIDTH}px;height:${HEIGHT}px;background:url(${source}) center/cover"></div>`;
await row.setContent(`<body style="margin:0;display:flex">${tiles.map(tile).join("")}</body>`);
await row.screenshot({ path: `${PICTURES}gallery.jpg`, quality: 88, type: "jpeg" });
await browser.close();
