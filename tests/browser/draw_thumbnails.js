/** Writes the page's own picture of every demo outfit beside its GLB: `make thumbnails`. */
import { readFile, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { FittingRoom, launch, TOILE_URL } from "./fitting_room.js";

const GALLERY = new URL("../../model/artifacts/gallery/", import.meta.url);

async function pictureOf(page, id) {
  const numbers = await page.evaluate(async (outfit) => {
    const image = document.querySelector(`[data-outfit="${outfit}"] img`);
    return [...new Uint8Array(await (await fetch(image.src)).arrayBuffer())];
  }, id);
  return Buffer.from(numbers);
}

const exhibits = JSON.parse(await readFile(new URL("gallery.json", GALLERY), "utf8"));
const outfits = (await (await fetch(`${TOILE_URL}/v1/outfits?limit=100`)).json()).data;
const browser = await launch();
const room = await FittingRoom.open(browser);
await room.picturesDrawn();
for (const { file, name } of exhibits) {
  const outfit = outfits.find((candidate) => candidate.name === name);
  if (!outfit) throw new Error(`the service has no outfit named ${name}`);
  const target = new URL(file.replace(/\.glb$/, ".png"), GALLERY);
  await writeFile(target, await pictureOf(room.page, outfit.id));
  console.log(fileURLToPath(target));
}
await browser.close();
