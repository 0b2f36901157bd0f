// The common parts of the tests of the pages: a server, Chromium, and functions that wait. ESPALIER_PROGRAM and ESPALIER_CHROMIUM
// name the programs; ESPALIER_PICTURES a folder for pictures of the pages; ESPALIER_STUDIO a folder with studio.js and studio.css, which
// the pages get instead of those in the program: a changed page is tried without building the program.
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, before } from "node:test";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const GALLERY = join(dirname(fileURLToPath(import.meta.url)), "../../gallery");
export const program = process.env.ESPALIER_PROGRAM;
export const folder = mkdtempSync(join(tmpdir(), "espalier-"));
export const PATIENCE = { timeout: 60_000 };
// the browser draws without a graphics card
const SIZE = process.env.ESPALIER_PICTURES ? { width: 1280, height: 720 } : { width: 1100, height: 560 };

export function serve(http = "127.0.0.1:0", ...more) {
  const server = spawn(program, ["serve", "--listen", "127.0.0.1:0", "--http", http, ...(more.includes("--gallery") ? [] : ["--gallery", GALLERY]), "--log-level", "off", ...more]);
  return new Promise((ready) => {
    let text = "";
    server.stdout.on("data", (chunk) => {
      text += chunk;
      const found = /http on (\S+)\n/.exec(text);
      if (found) {
        ready({ server, address: `http://${found[1]}` });
      }
    });
  });
}

export const stopped = (child) => new Promise((done) => (child.exitCode === null ? (child.once("exit", done), child.kill()) : done()));

/** The server of a test file, and the errors of its pages. */
export const running = { server: null, address: "" };
export const problems = [];
let browser;

/** A new page at `address`; `script`: what runs in it before all other scripts. */
export async function open(address, ready = "shown", script = null) {
  const page = await browser.newPage({ viewport: SIZE });
  for (const file of process.env.ESPALIER_STUDIO ? ["studio.js", "studio.css"] : []) {
    await page.context().route(`**/${file}`, (route) => route.fulfill({ path: join(process.env.ESPALIER_STUDIO, file) }));
  }
  if (script) {
    await page.addInitScript(script);
  }
  page.setDefaultTimeout(PATIENCE.timeout);
  // looks by the clock: a browser without a graphics card may stop drawing frames for a while
  const waitForFunction = page.waitForFunction.bind(page);
  page.waitForFunction = (look, argument, options) => waitForFunction(look, argument, { polling: 100, ...options });
  page.on("pageerror", (error) => problems.push(error.message));
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  await page.goto(address);
  if (ready === "shown") {
    await shown(page);
  }
  return page;
}

/** Waits until the plant is derived and drawn. */
export const shown = (page) =>
  page.waitForFunction(() => studio.counts.waiting === 0 && studio.simulation && studio.isFinished && document.getElementById("plant").dataset.step === String(studio.step), null, PATIENCE);

export async function keep(page, name) {
  if (process.env.ESPALIER_PICTURES) {
    await page.screenshot({ path: join(process.env.ESPALIER_PICTURES, `${name}.png`) });
  }
}

export const stringOf = (page) => page.evaluate(() => studio.simulation.string());

/** A place of the page where a line of the plant is, and no button above it. */
export async function lineAt(page) {
  const found = await page.waitForFunction(() => {
    const { left, top, width, height } = document.querySelector("#plant canvas").getBoundingClientRect();
    for (let y = top + height * 0.35; y < top + height * 0.8; y += 4) {
      for (let x = left + width * 0.4; x < left + width * 0.6; x += 3) {
        if (document.elementFromPoint(x, y)?.tagName === "CANVAS" && studio.view.pickAt(x, y)) {
          return { x, y };
        }
      }
    }
    return null;
  });
  return found.jsonValue();
}

/** The string that the command line derives from the files of the page. */
export async function derived(page) {
  const { files, main, seed } = await page.evaluate(() => ({ files: studio.document.files, main: studio.document.main, seed: studio.seed }));
  for (const [name, text] of Object.entries(files)) {
    writeFileSync(join(folder, name), text);
  }
  const made = spawnSync(program, ["derive", join(folder, main), "--seed", String(seed)], { encoding: "utf8", maxBuffer: 1e9 });
  return made.stdout.trim();
}

before(async () => {
  Object.assign(running, await serve());
  browser = await chromium.launch({
    executablePath: process.env.ESPALIER_CHROMIUM,
    args: ["--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
});
after(async () => {
  await browser.close();
  await stopped(running.server);
  rmSync(folder, { recursive: true });
});
