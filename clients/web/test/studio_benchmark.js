// How fast the studio is, in Chromium at a real server: rows for `./dev bench studio`, as JSON in the file ESPALIER_ROWS. The browser
// draws without a graphics card, so everything that draws is slower than on a desk. So each time is measured twice: with the pictures
// drawn, and without (the page does everything, up to the calls that have the card draw triangles).
import { writeFileSync } from "node:fs";
import { test } from "node:test";
import { open, running } from "./pages.js";

const rows = [];
let isDrawn = true;
const share = (times, part) => [...times].sort((a, b) => a - b)[Math.min(times.length - 1, Math.floor(times.length * part))];
/** `target`: milliseconds for 95 of 100 times; null: only measured. */
function add(what, times, target) {
  const shares = { median: share(times, 0.5), p95: share(times, 0.95) };
  if (isDrawn) {
    rows.push({ what, times: times.length, ...shares, target });
  } else {
    rows.find((row) => row.what === what).undrawn = shares;
  }
  writeFileSync(process.env.ESPALIER_ROWS, JSON.stringify(rows));
}

const ROW_MILLISECONDS = 240_000; // longest time of a row: the others are measured all the same
const pages = [];

/** A new page; while `isDrawn` is false, its calls that draw triangles do nothing. */
const openPage = async (address, ready) => {
  const page = await open(address, ready, isDrawn ? undefined : () => {
    for (const call of ["drawElements", "drawArrays", "drawElementsInstanced", "drawArraysInstanced"]) {
      WebGL2RenderingContext.prototype[call] = () => {};
    }
  });
  pages.push(page);
  return page;
};

/** Measures twice: with and without drawing. */
const measure = (name, act) =>
  test(name, { timeout: ROW_MILLISECONDS }, async () => {
    try {
      for (isDrawn of [true, false]) {
        await act();
      }
    } finally {
      await Promise.all(pages.splice(0).map((page) => page.close().catch(() => {})));
    }
  });

/** In the page: `timed(act)` is the time from an action to the end of the frame that draws its plant. */
const prepare = async (page) => {
  // the shadows of the first picture are made after it; a person needs as long to reach for the mouse
  await page.waitForTimeout(3000);
  await page.evaluate(() => {
    const { view } = studio;
    const update = view.update.bind(view);
    let drawn = () => {};
    view.update = (...frame) => {
      const begin = performance.now();
      update(...frame);
      window.updateTime = performance.now() - begin;
      requestAnimationFrame(() => setTimeout(() => drawn()));
    };
    window.timed = (act) =>
      new Promise((done) => {
        const begin = performance.now();
        drawn = () => done(performance.now() - begin);
        act();
      });
  });
};

const grown = (page, title, text, until) =>
  page.evaluate(([name, model, step]) => studio.openDocument({ title: name, main: "model.l", binary: {}, environment: null, gallery: null, files: { "model.l": model } }, step ?? undefined), [title, text, until]);

measure("opening", async () => {
  const first = [];
  const whole = [];
  for (let i = 0; i < 5; ++i) {
    // an open window: the browser's own work for a new one is not of the page
    const page = await openPage("about:blank", "opened");
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 1000))));
    const begin = performance.now();
    await page.goto(`${running.address}/`, { waitUntil: "commit" });
    await page.waitForFunction(() => document.getElementById("plant")?.dataset.step !== undefined, null, { polling: 10 });
    first.push(performance.now() - begin);
    await page.waitForFunction(() => studio.isFinished && document.getElementById("plant").dataset.step === String(studio.step), null, { polling: 10 });
    whole.push(performance.now() - begin);
    await page.close();
  }
  add("open the page, to the first plant", first, 1500);
  add("open the page, to the plant of the last step", whole, null);
});

measure("slider", async () => {
  const page = await openPage(`${running.address}/#gallery=parametric-tree&seed=1`);
  await prepare(page);
  const modules = await page.evaluate(() => studio.statistics.at(-1).modules);
  const times = await page.evaluate(async () => {
    const slider = document.getElementById("define-A0");
    const found = [];
    for (let i = 0; i < 60; ++i) {
      found.push(await timed(() => {
        slider.value = String(20 + (i % 31));
        slider.dispatchEvent(new Event("input", { bubbles: true }));
      }));
    }
    return found;
  });
  add(`slider to drawn frame, parametric-tree (${modules} modules)`, times, 100);
  const begin = performance.now();
  await page.keyboard.press("v");
  await page.waitForFunction(() => document.body.textContent.includes("36 of 36"), null, { polling: 20 });
  add("table of 36 variations, parametric-tree", [performance.now() - begin], 3000);
  await page.close();
});

measure("time", async () => {
  const page = await openPage(`${running.address}/#gallery=branch-tiers`);
  await grown(page, "long", "Lsystem: 1\nderivation length: 500\nAxiom: A\nA --> F(0.1)[+F(0.05)]/(137)A\nendlsystem\n");
  await page.waitForFunction(() => studio.step === 500 && studio.counts.waiting === 0);
  await prepare(page);
  const times = await page.evaluate(async () => {
    const found = [];
    for (let i = 0; i < 40; ++i) {
      const step = 1 + ((i * 197) % 499);
      found.push(await timed(() => void studio.goTo(step)));
    }
    return found;
  });
  add("scrub to any of 500 steps", times, 150);
  await page.close();
});

measure("changes", async () => {
  const page = await openPage(`${running.address}/#gallery=branch-tiers`);
  // a quarter of a million segments (more would be drawn for minutes); then one in sixty, in branches of its own, grows
  const model = "Lsystem: 1\nderivation length: 100\nAxiom: A(9)\nA(n) : n == 3 --> A(2)A(2)A(2)A(2)[+G(1)]\nA(n) : n > 0 --> A(n-1)A(n-1)A(n-1)A(n-1)\nA(n) --> F(0.1)+(1)\nG(l) --> G(l*1.01)\nendlsystem\n";
  // shadows and ground do not matter here
  await page.getByLabel("shadows").uncheck();
  await page.getByLabel("ground").uncheck();
  await grown(page, "million", model, 10);
  await page.waitForFunction(() => studio.step === 10 && document.getElementById("plant").dataset.step === "10", null, { timeout: 300_000 });
  await prepare(page);
  const { times, figures } = await page.evaluate(async (steps) => {
    const found = [];
    for (let i = 0; i < steps; ++i) {
      await timed(() => void studio.stepOnce());
      found.push(window.updateTime);
    }
    return { times: found, figures: studio.view.figures() };
  }, isDrawn ? 4 : 30); // a drawn step takes seconds
  add(`script for a frame, 1.6 % of ${figures.segments} segments new, ${figures.calls} draw calls, ${figures.segmentBytes} bytes a segment`, times, 8);
  await page.close();
});

measure("language", async () => {
  const page = await openPage(`${running.address}/#gallery=branch-tiers`);
  const times = await page.evaluate(async () => {
    const lines = Array.from({ length: 2000 }, (_, i) => `A(x) : x == ${i} --> F(x*${i})[+(20)B(x+${i})]A(x+1)`);
    const text = `Lsystem: 1\nderivation length: 1\nAxiom: A(1)\n${lines.join("\n")}\nendlsystem\n`;
    const send = (message) => studio.client.call("editor.message", { message: JSON.stringify({ jsonrpc: "2.0", ...message }) });
    const textDocument = { uri: "long.l", version: 1 };
    await send({ method: "textDocument/didOpen", params: { textDocument: { ...textDocument, languageId: "espalier", text } } });
    const found = [];
    for (let i = 0; i < 60; ++i) {
      const at = { line: 1000, character: 5 };
      const begin = performance.now();
      await send({ method: "textDocument/didChange", params: { textDocument: { ...textDocument, version: i + 2 }, contentChanges: [{ range: { start: at, end: at }, text: " " }] } });
      found.push(performance.now() - begin);
    }
    return found;
  });
  add("messages after a keystroke in 2,000 lines", times, 50);
  await page.close();
});
