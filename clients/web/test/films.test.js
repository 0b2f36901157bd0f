// The studio in Chromium, at a real server: pictures, films and archives of a plant, and a photograph behind it.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { keep, open, problems, running, shown, stopped } from "./pages.js";
import { timesOf } from "./webm.js";

const SMALL = (address = running.address) => `${address}/#gallery=branch-tiers`;
const here = dirname(fileURLToPath(import.meta.url));

test("the growth is saved as a film, and a photograph stands behind the plant at its scale", async () => {
  const page = await open(`${running.address}/#gallery=classic-weed`);
  const last = await page.evaluate(() => studio.step);
  await page.click("#open-export");
  // the files of the model, the model first
  const [model] = await Promise.all([page.waitForEvent("download"), page.click("#save-all")]);
  const names = spawnSync("python3", ["-c", "import sys, zipfile; print(*zipfile.ZipFile(sys.argv[1]).namelist())", await model.path()], { encoding: "utf8" });
  assert.equal(`${model.suggestedFilename()}: ${names.stdout.trim()}`, "classic-weed.zip: classic-weed.l classic-weed.v README.md");
  const [film] = await Promise.all([page.waitForEvent("download"), page.click("#film")]);
  assert.equal(film.suggestedFilename(), "classic-weed.webm");
  // every step has its picture at its time, and the last one stays: also in a browser that draws slowly
  assert.deepEqual(timesOf(readFileSync(await film.path())), [...Array.from({ length: last + 1 }, (_, i) => 100 * i), 100 * last + 1200]);
  assert.equal(await page.evaluate(() => studio.step), last);
  await shown(page);

  await page.setInputFiles("#photograph", join(here, "../../gallery/textured-tree/textured-tree.png"));
  await page.waitForFunction(() => document.querySelector("img.photograph")?.naturalWidth > 0);
  // when it stands still
  const first = await page.evaluate(() => new Promise((done) => {
    let before = 0;
    const look = () => {
      const { height } = document.querySelector("img.photograph").getBoundingClientRect();
      height > 0 && height === before ? done(height) : setTimeout(look, 300);
      before = height;
    };
    look();
  }));
  const height = Number(await page.inputValue("#photograph-height"));
  await keep(page, "studio-photograph");
  await page.fill("#photograph-height", String(height / 2));
  // in units of the view as it is now, which may still be placed anew after the film
  await page.waitForFunction((size) => Math.abs(document.querySelector("img.photograph").getBoundingClientRect().height - size / studio.view.foot().unitsPerPixel) < 1, height / 2);
  const left = () => page.evaluate(() => document.querySelector("img.photograph").getBoundingClientRect().left);
  const begin = await left();
  const grip = await page.locator("#photograph-move").boundingBox();
  await page.mouse.move(grip.x + 5, grip.y + 5);
  await page.mouse.down();
  await page.mouse.move(grip.x - 35, grip.y + 5, { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction((from) => Math.abs(document.querySelector("img.photograph").getBoundingClientRect().left - (from - 40)) < 1.5, begin);
  // or by a drag in the view itself, while the button is pressed
  await page.click("#photograph-move");
  const middle = await page.locator("#photograph-hold").boundingBox();
  const camera = await page.evaluate(() => studio.view.camera.position.toArray());
  const dragged = await left();
  await page.mouse.move(middle.x + 100, middle.y + 100);
  await page.mouse.down();
  await page.mouse.move(middle.x + 130, middle.y + 100, { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction((from) => Math.abs(document.querySelector("img.photograph").getBoundingClientRect().left - (from + 30)) < 1.5, dragged);
  assert.deepEqual(await page.evaluate(() => studio.view.camera.position.toArray()), camera);
  await page.click("#photograph-move");
  assert.equal(await page.locator("#photograph-hold").count(), 0);
  // seen through the plant
  await page.fill("#plant-strength", "0.5");
  await page.waitForFunction(() => document.querySelector("#plant canvas").style.opacity === "0.5");
  // ruler and protractor: two legs of the same length; then the first one lies on something that is 3 long
  await page.locator("#plant-strength").blur();
  await page.keyboard.press("m");
  // the tools lie below the view now, and cover nothing of it
  const boxes = await page.evaluate(() => ["#plant", ".photograph-tools"].map((name) => document.querySelector(name).getBoundingClientRect().toJSON()));
  assert.ok(boxes[1].top >= boxes[0].bottom - 1, JSON.stringify(boxes));
  // when the view has found its new size
  await page.waitForFunction(() => {
    const [[x, y], [x1, y1]] = [...document.querySelectorAll(".measure-point")].map(({ style }) => [parseFloat(style.left), parseFloat(style.top)]);
    return Math.abs(Number(document.getElementById("measured").textContent.split(/[° ·]+/)[1]) / (Math.hypot(x1 - x, y1 - y) * studio.view.foot().unitsPerPixel) - 1) < 0.006;
  });
  const measured = async () => (await page.textContent("#measured")).split(/[° ·]+/).map(Number);
  const [angle, leg, otherLeg] = await measured();
  const points = await page.evaluate(() => [...document.querySelectorAll(".measure-point")].map(({ style }) => [parseFloat(style.left), parseFloat(style.top)]));
  const across = points[1][0] - points[0][0];
  const down = points[1][1] - points[0][1];
  assert.ok(Math.abs(angle - (2 * Math.atan2(across, down) * 180) / Math.PI) < 0.06, String(angle));
  assert.equal(leg, otherLeg);
  const sized = Number(await page.inputValue("#photograph-height"));
  await page.fill("#known-length", "3");
  await page.locator("#known-length").blur();
  await page.waitForFunction(() => document.getElementById("measured").textContent.split(/[° ·]+/)[1] === "3");
  assert.deepEqual((await measured())[0], angle);
  const ratio = Number(await page.inputValue("#photograph-height")) / sized;
  assert.ok(Math.abs(ratio / (3 / leg) - 1) < 0.01, `${ratio} of ${3 / leg}`);
  await page.focus(".measure-point >> nth=2");
  await page.keyboard.press("Shift+ArrowRight");
  await page.waitForFunction((before) => parseFloat(document.getElementById("measured").textContent) > before, angle);
  // another plant, and a camera that comes nearer: the points and the photograph go together
  const places = () => page.evaluate(() => [...document.querySelectorAll("img.photograph, .measure-point")].map((element) => (({ left, top, width, height }) => [left + width / 2, top + height / 2])(element.getBoundingClientRect())));
  const quiet = async () => (await page.evaluate(() => new Promise((done) => setTimeout(done, 600))), places());
  const standing = await quiet();
  await page.evaluate(() => studio.act(() => studio.goTo(2)));
  await page.waitForFunction(() => document.getElementById("plant").dataset.step === "2");
  for (const [i, [x, y]] of (await quiet()).entries()) {
    assert.ok(Math.hypot(x - standing[i][0], y - standing[i][1]) < 0.5, `${i}: ${[x, y]} was at ${standing[i]}`);
  }
  const lengths = await measured();
  await page.evaluate(() => { const { camera, controls } = studio.view; camera.position.sub(controls.target).multiplyScalar(0.7).add(controls.target); controls.update(); });
  const nearer = await quiet();
  const between = (found, i, j) => Math.hypot(found[i][0] - found[j][0], found[i][1] - found[j][1]);
  const growth = between(nearer, 1, 3) / between(standing, 1, 3);
  assert.ok(growth > 1.1 && Math.abs(between(nearer, 0, 2) / between(standing, 0, 2) / growth - 1) < 0.02, `${growth}, ${nearer}, ${standing}`);
  assert.deepEqual(await measured(), lengths);
  await page.evaluate(() => { const { camera, controls } = studio.view; camera.position.sub(controls.target).divideScalar(0.7).add(controls.target); controls.update(); });
  await page.uncheck("#measure");
  // the picture of the view has the photograph behind the plant
  const pixels = await page.evaluate(async () => {
    const { element } = studio.view;
    const bitmap = await createImageBitmap(await studio.view.picture());
    const context = Object.assign(document.createElement("canvas"), { width: bitmap.width, height: bitmap.height }).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return { size: [bitmap.width, bitmap.height], wanted: [element.clientWidth, element.clientHeight], corner: [...context.getImageData(2, 2, 1, 1).data] };
  });
  assert.deepEqual(pixels.size, pixels.wanted);
  assert.equal(pixels.corner[3], 255, "the picture is not see-through");
  await page.click("#open-export");
  const [picture] = await Promise.all([page.waitForEvent("download"), page.click("#save-view")]);
  assert.equal(picture.suggestedFilename(), "classic-weed-view.png");
  assert.equal(readFileSync(await picture.path()).subarray(1, 4).toString(), "PNG");
  await page.keyboard.press("Escape");
  await page.fill("#photograph-height", String(sized));
  // it follows the camera
  await page.mouse.move(400, 200);
  await page.evaluate(() => { studio.view.camera.position.sub(studio.view.controls.target).multiplyScalar(2).add(studio.view.controls.target); studio.view.controls.update(); });
  await page.waitForFunction((before) => document.querySelector("img.photograph").getBoundingClientRect().height < before * 0.3, first);
  await page.close();
});

test("plants of many seeds are saved in one archive, and a turn around the plant as a film", async () => {
  const page = await open(SMALL());
  await page.evaluate(() => studio.openDocument({ title: "seeds", main: "model.l", binary: {}, environment: null, gallery: null, files: { "model.l": "#define ANGLE 25\nLsystem: 1\nderivation length: 3\nAxiom: A\nA --> F[+(ANGLE)A][-(ANGLE)A] : 0.5\nA --> FFA : 0.5\nendlsystem\n" } }));
  await shown(page);
  const before = await page.evaluate(async () => (await studio.list(), studio.simulations.length));
  await page.keyboard.press("s");
  await page.fill("#many-count", "3");
  const [saved] = await Promise.all([page.waitForEvent("download"), page.click("#many-plants button")]);
  assert.equal(saved.suggestedFilename(), "seeds-seeds.zip");
  const read = spawnSync("python3", ["-c", "import sys, zipfile; z = zipfile.ZipFile(sys.argv[1]); print(z.testzip(), *[(n, z.read(n)[:4].decode()) for n in z.namelist()])", await saved.path()], { encoding: "utf8" });
  assert.equal(read.stdout.trim(), "None ('seeds-seed-7.glb', 'glTF') ('seeds-seed-8.glb', 'glTF') ('seeds-seed-9.glb', 'glTF')", read.stderr);
  assert.equal(await page.evaluate(async () => (await studio.list(), studio.simulations.length)), before);
  assert.equal(await page.evaluate(() => studio.seed), 7);
  // a turn that is stopped is as long as it was; the camera is where it was
  const place = await page.evaluate(() => studio.view.camera.position.toArray());
  await page.keyboard.press("s");
  const [film] = await Promise.all([page.waitForEvent("download"), page.click("#film-turn").then(() => page.waitForTimeout(500)).then(() => page.click("#stop-work"))]);
  assert.equal(film.suggestedFilename(), "seeds-turn.webm");
  await page.waitForFunction((at) => studio.longWork === null && studio.view.camera.position.toArray().every((value, i) => Math.abs(value - at[i]) < 1e-6), place);
  // an angle of more than a full turn is remarked on
  await page.fill('[aria-label="Value of ANGLE"]', "900");
  await page.keyboard.press("Tab");
  await page.waitForFunction(() => document.querySelector(".remark")?.textContent === "More than a full turn: 900° and 180° give the same plant.");
  await page.close();
});

test("a film has the mesh of each step where a model has textures, and ends when another model is opened", async () => {
  const page = await open(`${running.address}/#gallery=textured-tree`);
  await page.waitForFunction(() => document.getElementById("plant").dataset.textured === "7");
  await page.evaluate(() => {
    window.seen = [];
    const composed = studio.view.composed.bind(studio.view);
    studio.view.composed = () => (window.seen.push(`${studio.view.element.dataset.step}/${studio.view.element.dataset.textured}`), composed());
  });
  await page.click("#open-export");
  await Promise.all([page.waitForEvent("download"), page.click("#film")]);
  assert.deepEqual(await page.evaluate(() => seen), [...Array.from({ length: 8 }, (_, i) => `${i}/${i}`), "7/7"]);
  // a film of many steps; meanwhile another model
  const opened = (title, length) => page.evaluate(([name, steps]) => studio.openDocument({ title: name, main: "m.l", binary: {}, environment: null, gallery: null, files: { "m.l": `Lsystem: 1\nderivation length: ${steps}\nAxiom: A\nA --> F[+F]A\nendlsystem\n` } }), [title, length]);
  await opened("long", 200);
  await shown(page);
  await page.click("#open-export");
  const saved = page.waitForEvent("download");
  await page.click("#film");
  await page.waitForFunction(() => studio.step > 2 && studio.step < 150);
  await opened("short", 3);
  assert.equal((await saved).suggestedFilename(), "long.webm");
  await page.waitForFunction(() => studio.longWork === null && studio.counts.waiting === 0);
  assert.equal(await page.evaluate(() => `${studio.document.title} ${studio.step}`), "short 3");
  await page.close();
});

test("no page had an error, or asked for anything that its policy forbids", () => {
  assert.deepEqual(problems, []);
});
