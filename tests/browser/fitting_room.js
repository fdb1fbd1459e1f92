/** Drives the try-on page in Chromium: what a test says, in the words of the page. */
import { mkdir } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const TOILE_URL = process.env.TOILE_URL ?? "http://127.0.0.1:8080";
/** Drawing in software is slow: how long one drape may take to appear, milliseconds. */
export const PATIENCE = 300_000;

const CHROMIUM_ARGUMENTS = [
  "--headless",
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
];

export function launch() {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  return chromium.launch({ executablePath, args: CHROMIUM_ARGUMENTS });
}

// Reduced motion: a spinner that turns would redraw the whole page, which software cannot do in time.
export const DESKTOP = { viewport: { width: 1280, height: 800 }, colorScheme: "light", reducedMotion: "reduce" };
export const PHONE = { ...DESKTOP, viewport: { width: 390, height: 844 }, colorScheme: "dark", hasTouch: true, isMobile: true };

export class FittingRoom {
  /** Errors of the page's own scripts, and failed requests other than pictures that an outfit does not have. */
  errors = [];

  static async open(browser, device = DESKTOP) {
    const page = await browser.newPage(device);
    page.setDefaultTimeout(PATIENCE);
    const room = new FittingRoom(page);
    await page.goto(TOILE_URL);
    await room.settled();
    return room;
  }

  constructor(page) {
    this.page = page;
    page.on("pageerror", (error) => this.errors.push(error.message));
    page.on("console", (message) => {
      const expected = message.location().url.endsWith("/thumbnail.png");
      if (message.type() === "error" && !expected) this.errors.push(`${message.text()} ${message.location().url}`);
    });
  }

  stats() {
    return this.page.evaluate(() => document.querySelector("toile-viewer").stats());
  }

  /** Waits until the viewer shows a drape and asks for no other. */
  async settled(after = 0) {
    await this.page.waitForFunction(
      (drapes) => {
        const stats = document.querySelector("toile-viewer")?.stats?.();
        return stats && stats.drapes > drapes && !stats.busy;
      },
      after,
      { timeout: PATIENCE },
    );
    return this.stats();
  }

  /** Does something that changes what is worn; answers the figures before and after. */
  async change(act) {
    const before = await this.stats();
    await act();
    return { before, after: await this.settled(before.drapes) };
  }

  tab(id) {
    return this.page.click(`#tab-${id}`);
  }

  async measure(name, text) {
    await this.page.fill(`#measure-${name}`, text);
    await this.page.press(`#measure-${name}`, "Enter");
  }

  pose(id) {
    return this.page.click(`[data-pose="${id}"]`);
  }

  async picturesDrawn() {
    await this.page.waitForFunction(() => !document.querySelector(".card--loading, .card--skeleton"));
  }

  async screenshot(name) {
    const folder = fileURLToPath(new URL("./output/", import.meta.url));
    await mkdir(folder, { recursive: true });
    await this.page.screenshot({ path: `${folder}${name}.png` });
  }

  close() {
    return this.page.close();
  }
}
