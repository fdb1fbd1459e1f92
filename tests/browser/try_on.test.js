import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { bakeOf } from "./bake.js";
import { FittingRoom, launch, PATIENCE, PHONE, TOILE_URL } from "./fitting_room.js";
import { skirtGlb } from "./skirt.js";

let browser;
let room;

before(async () => {
  browser = await launch();
  room = await FittingRoom.open(browser);
});

after(() => browser?.close());

test("the page loads without errors and wears the first outfit", async () => {
  await room.picturesDrawn();
  const cards = await room.page.locator("[data-outfit]").count();
  assert.ok(cards >= 1, "the gallery is empty");
  assert.equal(await room.page.locator('[data-outfit][aria-pressed="true"]').count(), 1);
  const stats = await room.stats();
  assert.ok(stats.vertices > 100, `${stats.vertices} vertices`);
  assert.ok(stats.height > 1.2 && stats.height < 2.3, `a figure ${stats.height} m tall`);
  assert.deepEqual(room.errors, []);
  await room.screenshot("gallery");
});

test("every outfit of the gallery has a picture", async () => {
  await room.picturesDrawn();
  const blank = await room.page.locator(".card--blank").count();
  assert.equal(blank, 0);
});

test("choosing an outfit drapes it", async (context) => {
  const others = room.page.locator('[data-outfit][aria-pressed="false"]');
  if ((await others.count()) === 0) return context.skip("only one outfit");
  const id = await others.first().getAttribute("data-outfit");
  const { before: old, after: fresh } = await room.change(() => others.first().click());
  assert.equal(fresh.outfit, id);
  assert.notEqual(fresh.outfit, old.outfit);
  assert.match(room.page.url(), new RegExp(`outfit=${id}`));
});

test("a shorter body moves the cloth, in the buffers that are there", async () => {
  await room.tab("body");
  const { before: old, after: short } = await room.change(() => room.measure("height", "162"));
  assert.ok(Math.abs(short.height - 1.62) < 0.02 && old.height > 1.7, `${old.height} m became ${short.height} m`);
  assert.equal(short.vertices, old.vertices);
  assert.ok(short.inPlaceUpdates > old.inPlaceUpdates, "the buffers were made anew");
  await room.page.locator("#measure-height-note", { hasText: /\d/ }).waitFor();
  await room.screenshot("measurements");
});

test("a height in metres is refused next to its field, and the drape stays", async () => {
  const old = await room.stats();
  await room.measure("height", "1.68");
  const error = room.page.locator("#measure-height-error");
  await error.waitFor();
  assert.match(await error.textContent(), /cm/);
  assert.equal((await room.stats()).height, old.height);
  await room.screenshot("measurement-error");
  await room.change(() => room.page.click('.measurements [type="reset"]'));
});

test("a phenotype slider changes the body live", async () => {
  await room.page.click('#panel-body [data-value="shape"]');
  await room.settled();
  const { before: old, after: heavy } = await room.change(() => room.page.locator("#phenotype-weight").fill("0.9"));
  assert.notEqual(heavy.positionSum, old.positionSum);
  await room.screenshot("shape");
  await room.change(() => room.page.getByText("Back to the reference body").click());
});

test("a scan becomes the body that is nearest to it", async () => {
  await room.tab("body");
  await room.page.click('#panel-body [data-value="scan"]');
  await room.settled();
  const buffer = Buffer.from(await (await fetch(`${TOILE_URL}/v1/body/reference.glb`)).arrayBuffer());
  await room.change(() => room.page.setInputFiles("#scan-file", { name: "scan.glb", mimeType: "model/gltf-binary", buffer }));
  await room.page.getByText("off the scan").waitFor();
  await room.screenshot("scan");
  const letter = { name: "letter.glb", mimeType: "model/gltf-binary", buffer: Buffer.from("Dear Sir or Madam") };
  await room.page.setInputFiles("#scan-file", letter);
  await room.page.locator('#panel-body .field-error[role="alert"]:visible').waitFor();
  await room.change(() => room.page.click('#panel-body [data-value="measurements"]'));
});

test("a pose preset changes the drape", async () => {
  await room.tab("pose");
  const { before: old, after: posed } = await room.change(() => room.pose("arms-up"));
  assert.ok(Math.abs(posed.positionSum - old.positionSum) > 1, "nothing moved");
  assert.equal(await room.page.getAttribute('[data-pose="arms-up"]', "aria-pressed"), "true");
  await room.screenshot("pose");
});

test("the heat map shows its legend and goes away again", async () => {
  await room.tab("insight");
  const { after: hot } = await room.change(() => room.page.click('[data-value="strain"]'));
  assert.equal(hot.heat.kind, "strain");
  await room.page.locator(".legend").waitFor();
  await room.screenshot("heat-map");
  const { after: inside } = await room.change(() => room.page.click('[data-value="penetration"]'));
  assert.equal(inside.heat.kind, "penetration");
  const { after: plain } = await room.change(() => room.page.click('[data-value="none"]'));
  assert.equal(plain.heat, undefined);
  assert.equal(await room.page.locator(".legend").count(), 0);
});

test("the service's time is shown stage by stage", async () => {
  const stages = await room.page.locator(".timing__legend li").allTextContents();
  for (const name of ["body", "dynamic", "encode"]) {
    assert.ok(stages.some((stage) => stage.startsWith(name)), `no stage ${name} in ${stages}`);
  }
  await room.screenshot("insight");
});

test("skinning alone gives another drape than the network", async () => {
  await room.tab("insight");
  const { before: old, after: skinned } = await room.change(() => room.page.check('[name="method"][value="skinning"]'));
  assert.notEqual(skinned.positionSum, old.positionSum);
  await room.change(() => room.page.check('[name="method"][value="deepsd"]'));
});

test("a network of their kinds drapes garments whose kinds are known", async () => {
  const garnet = room.page.locator('[name="method"][value="garnet"]');
  const known = room.page.locator("[data-outfit]", { hasText: "Tea dress" });
  const worn = (await room.stats()).outfit;
  await room.tab("outfits");
  await room.change(() => known.click());
  await room.tab("insight");
  const { before: old, after: draped } = await room.change(() => garnet.check());
  assert.notEqual(draped.positionSum, old.positionSum);
  await room.screenshot("garnet");
  await room.tab("outfits");
  await room.change(() => room.page.locator(`[data-outfit="${worn}"]`).click());
  await room.tab("insight");
  const kinds = room.page.locator(".kinds select");
  for (const select of await kinds.all()) await select.selectOption("");
  await room.settled();
  assert.ok(await garnet.isDisabled(), "no kinds, no network");
  assert.ok(await room.page.isChecked('[name="method"][value="deepsd"]'));
});

test("pixel cloth shows its images beside the cloth, and they move with the pose", async () => {
  const pixel = room.page.locator('[name="method"][value="pixel_cloth"]');
  assert.ok(await pixel.isDisabled(), "another outfit has no network");
  const worn = (await room.stats()).outfit;
  await room.tab("outfits");
  await room.change(() => room.page.locator("[data-outfit]", { hasText: "Hero T-shirt" }).click());
  await room.tab("insight");
  await room.change(() => pixel.check());
  const image = room.page.locator(".stage__cloth img");
  const drawn = () => image.evaluate(async (i) => (await i.decode(), [i.naturalWidth, i.naturalHeight]));
  assert.deepEqual(await drawn(), [512, 256]);
  await room.tab("pose");
  await room.change(() => room.page.click('[data-pose="contrapposto"]'));
  const before = await image.getAttribute("src");
  await room.change(() => room.page.click('[data-pose="arms-up"]'));
  assert.notEqual(await image.getAttribute("src"), before);
  assert.deepEqual(await drawn(), [512, 256]);
  await room.screenshot("pixel_cloth");
  await room.tab("outfits");
  await room.change(() => room.page.locator(`[data-outfit="${worn}"]`).click());
  assert.equal(await image.count(), 0);
});

test("another method stands beside the drape, and the simulation where there is one", async () => {
  const wear = (name) => room.page.locator("[data-outfit]", { hasText: name }).click();
  const known = room.errors.length;
  const choice = room.page.locator('[name="compare"]');
  const other = room.page.locator(".compare__label--other");
  const beside = () => room.page.evaluate(() => document.querySelectorAll("toile-viewer")[1]?.stats());
  await room.tab("outfits");
  if (await room.page.locator('[data-outfit][aria-pressed="true"]', { hasText: "Oxford" }).count() === 0) await room.change(() => wear("Oxford"));
  assert.equal(await choice.locator('[value="simulation"]').count(), 0, "of this outfit there is none");
  await choice.selectOption("skinning");
  await other.filter({ hasText: "Skinning only" }).waitFor();
  assert.match(await other.textContent(), /ms · \d+\.\d cm apart/);
  assert.equal((await beside()).vertices, (await room.stats()).vertices);
  await room.change(() => wear("Hero T-shirt"));
  await choice.selectOption("simulation");
  const notice = room.page.locator(".compare__notice");
  await room.change(() => notice.getByRole("button", { name: "standing" }).click());
  await other.filter({ hasText: "Simulation" }).waitFor();
  assert.match(await other.textContent(), /\d+\.\d cm apart/);
  await room.screenshot("compare");
  await choice.selectOption("");
  assert.equal(await beside(), undefined);
  await room.change(() => wear("Oxford"));
  assert.deepEqual(room.errors.slice(known), []);
});

test("a colour tints the cloth without asking the service", async () => {
  await room.tab("fabric");
  const { drapes } = await room.stats();
  await room.page.click('[aria-label="Claret"]');
  assert.equal(await room.page.getAttribute('[aria-label="Claret"]', "aria-pressed"), "true");
  await room.screenshot("colour");
  assert.equal((await room.stats()).drapes, drapes);
});

test("the walk plays, pauses and can be scrubbed", async () => {
  await room.tab("pose");
  await room.change(() => room.page.click('[data-motion="walk"]'));
  await room.page.waitForFunction(() => document.querySelector("toile-viewer").stats().playback?.time > 0.1);
  await room.page.getByRole("button", { name: "Pause" }).click();
  const scrub = room.page.getByLabel("Position in the motion");
  await scrub.fill("0.5");
  const { playback } = await room.stats();
  assert.equal(playback.playing, false);
  assert.ok(Math.abs(playback.time / playback.duration - 0.5) < 0.02, `at ${playback.time} of ${playback.duration} s`);
  await room.screenshot("walk");
  const { after: still } = await room.change(() => room.page.getByLabel("Back to a still pose").click());
  assert.equal(still.playback, undefined);
});

test("a file that is not a garment is refused with the reason", async () => {
  await room.tab("outfits");
  const file = { name: "letter.glb", mimeType: "model/gltf-binary", buffer: Buffer.from("Dear Sir or Madam") };
  await room.page.setInputFiles("#upload-file", file);
  const error = room.page.locator("#panel-outfits .upload .field-error");
  await error.waitFor();
  assert.ok((await error.textContent()).length > 20);
  await room.screenshot("upload-error");
});

test("an uploaded skirt is worn with its mending report, and can be deleted", async () => {
  const flare = 1 + (Date.now() % 1000) / 5000;
  const file = { name: "tube_skirt.glb", mimeType: "model/gltf-binary", buffer: skirtGlb(flare) };
  const { after: worn } = await room.change(() => room.page.setInputFiles("#upload-file", file));
  const card = room.page.locator(`[data-outfit="${worn.outfit}"]`);
  assert.match(await card.textContent(), /Tube skirt/);
  await room.page.locator(".report[open]").getByText("Found and mended").waitFor();
  await room.picturesDrawn();
  await room.page.locator(".report").scrollIntoViewIfNeeded();
  await room.screenshot("upload");
  await room.page.click("#delete-outfit");
  await room.change(() => room.page.getByRole("button", { name: "Delete", exact: true }).click());
  assert.equal(await card.count(), 0);
});

test("an outfit that was refined says so", async () => {
  const id = await room.page.locator("[data-outfit]").first().getAttribute("data-outfit");
  const at = `${TOILE_URL}/v1/outfits/${id}`;
  assert.equal(await room.page.locator(".card__bake:visible").count(), 0);
  const file = Buffer.from(await (await fetch(`${at}/static.safetensors`)).arrayBuffer());
  const answer = await fetch(`${at}/bake`, { method: "PUT", body: bakeOf(file) });
  assert.equal(answer.status, 200, await answer.text());
  try {
    await room.page.reload();
    await room.settled();
    assert.equal(await room.page.locator(`[data-outfit="${id}"] .card__bake:visible`).count(), 1);
    assert.equal(await room.page.locator(".card__bake:visible").count(), 1);
    await room.screenshot("refined");
  } finally {
    await fetch(`${at}/bake`, { method: "DELETE" });
  }
});

test("a service that fails is reported, and trying again works", async () => {
  await room.tab("pose");
  const refusal = { title: "The service is stopping", detail: "Try again in a moment.", code: "stopping" };
  await room.page.route("**/v1/drapes", (route) => route.fulfill({ status: 503, json: refusal }));
  await room.pose("t-pose");
  const notice = room.page.locator(".stage__notice");
  await notice.waitFor();
  assert.match(await notice.textContent(), /stopping/);
  await room.screenshot("problem");
  await room.page.unroute("**/v1/drapes");
  await room.change(() => notice.getByRole("button", { name: "Try again" }).click());
  assert.equal(await notice.isVisible(), false);
});

test("the keyboard reaches the choices", async () => {
  await room.page.focus("#tab-outfits");
  await room.page.keyboard.press("ArrowRight");
  assert.equal(await room.page.getAttribute("#tab-body", "aria-selected"), "true");
  assert.equal(await room.page.locator("#panel-body").isVisible(), true);
});

test("the page fits a phone without scrolling sideways", async () => {
  const phone = await FittingRoom.open(browser, PHONE);
  const overflow = await phone.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(overflow <= 0, `${overflow} px too wide`);
  await phone.screenshot("phone");
  await phone.close();
});

test("the element works alone on another page", async () => {
  const { outfit } = await room.stats();
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE);
  const body = `<script type="module" src="/toile-viewer.js"></script>
    <toile-viewer outfit="${outfit}" pose="squat" style="width: 400px; height: 500px"></toile-viewer>`;
  await page.route("**/shop.html", (route) => route.fulfill({ contentType: "text/html", body }));
  await page.goto(`${TOILE_URL}/shop.html`, { waitUntil: "domcontentloaded", timeout: PATIENCE });
  const sumAfter = async (drapes) => {
    await page.waitForFunction((count) => document.querySelector("toile-viewer").stats?.().drapes === count, drapes);
    return page.evaluate(() => document.querySelector("toile-viewer").stats().positionSum);
  };
  const squatting = await sumAfter(1);
  await page.evaluate(() => document.querySelector("toile-viewer").setAttribute("pose", "t-pose"));
  assert.notEqual(await sumAfter(2), squatting);
});
