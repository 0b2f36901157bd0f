// The studio in Chromium, at a real server: two plants beside each other, and editors of files.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { cpSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { GALLERY, folder, keep, lineAt, open, problems, program, running, serve, shown, stopped, stringOf } from "./pages.js";

test("a fork stands beside the plant: both make the same steps, one camera looks at both, and a cut is seen in one", async () => {
  const page = await open(`${running.address}/#gallery=parametric-tree`);
  const last = await page.evaluate(() => studio.step);
  const whole = await stringOf(page);
  await page.evaluate(() => studio.goTo(studio.length - 2));
  await page.keyboard.press("b");
  const beside = (step) => page.waitForFunction((wanted) => document.getElementById("plant-beside")?.dataset.step === String(wanted), step);
  await beside(last - 2);
  // half as wide as before, and the plant is in it as a whole
  const sides = () => page.evaluate(() => [studio.view, studio.beside.view].flatMap((view) => {
    const { min, max } = view.plants.bounds;
    return [min, max].map((corner) => corner.clone().setY((min.y + max.y) / 2).project(view.camera).x);
  }));
  assert.ok((await sides()).every((x) => Math.abs(x) < 1), String(await sides()));
  // a cut in the middle of the first one
  const place = await lineAt(page);
  await page.mouse.click(place.x, place.y);
  await page.click("#prune");
  await page.waitForFunction(() => studio.counts.waiting === 0 && studio.picked === null);
  await page.evaluate(() => studio.goTo(studio.length));
  await beside(last);
  const string = () => page.evaluate(() => studio.beside.growth.simulation.string());
  assert.equal(await string(), whole);
  assert.notEqual(await stringOf(page), whole);
  await keep(page, "studio-fork");
  // one camera
  const right = await page.locator("#plant-beside").boundingBox();
  await page.mouse.move(right.x + 80, right.y + 120);
  await page.mouse.down();
  await page.mouse.move(right.x + 130, right.y + 130, { steps: 3 });
  await page.mouse.up();
  await page.waitForFunction(() => Math.abs(studio.view.camera.position.x - studio.view.controls.target.x) > 0.01);
  assert.ok(await page.evaluate(() => studio.view.camera.position.distanceTo(studio.beside.view.camera.position) < 1e-9));
  // back, and the other one is worked on
  await page.evaluate(() => studio.goTo(studio.length - 1));
  await beside(last - 1);
  // the link to watch is that of the plant on the left
  const shared = await page.evaluate(() => studio.simulation.id);
  await page.click("#swap");
  await page.waitForFunction(() => studio.counts.waiting === 0);
  assert.equal(await page.evaluate(() => studio.simulation.id), shared);
  await page.evaluate(() => studio.goTo(studio.length));
  await page.waitForFunction(async (wanted) => studio.counts.waiting === 0 && (await studio.simulation.string()) === wanted, whole);
  await page.keyboard.press("b");
  await page.waitForFunction(() => !document.getElementById("plant-beside"));
  await page.waitForFunction(async () => (await studio.list(), studio.simulations.filter(({ name }) => name.startsWith("parametric-tree")).length === 1));
  assert.deepEqual(await page.evaluate(() => studio.simulations.map(({ simulation }) => simulation).filter((id) => id === studio.simulation.id)), [shared]);
  assert.equal(await stringOf(page), whole);
  await page.close();
});

test("two plants with other numbers, seeds, cuts and environments exchange all of it", async () => {
  const page = await open(`${running.address}/#gallery=classic-algae`);
  const text = "#define W 30\nLsystem: 1\nderivation length: 6\nAxiom: F(1)A\nA --> F(1)[+(W*ran(1))F(1)?E(1)A][-(W)A]\nendlsystem\n";
  await page.evaluate((model) => studio.openDocument({ title: "pair", main: "m.l", binary: {}, environment: [{ type: "honda", radius: 0.5 }], gallery: null, files: { "m.l": model } }, 3), text);
  await page.waitForFunction(() => studio.counts.waiting === 0 && document.getElementById("plant").dataset.step === "3");
  await page.keyboard.press("b");
  await page.waitForFunction(() => document.getElementById("plant-beside")?.dataset.step === "3");
  const idle = () => page.waitForFunction(() => studio.counts.waiting === 0 && studio.answeredStep === 3);
  await page.evaluate(() => studio.setSeed(99));
  await page.fill('[aria-label="Value of W"]', "50");
  await page.keyboard.press("Tab");
  await idle();
  await page.evaluate(() => studio.act(() => studio.setProcesses([{ type: "honda", radius: 2 }])));
  await idle();
  // the slider once more: its number is then beside the text that the server has
  await page.fill('[aria-label="Value of W"]', "60");
  await page.keyboard.press("Tab");
  await idle();
  await page.evaluate(async () => { await studio.pick({ plant: 0, module: (await studio.simulation.get("turtle")).turtle?.module?.[3] ?? 3, symbol: "F", order: 0, kind: "segment", position: [0, 0, 0] }); await studio.change("prune"); });
  const both = () => page.evaluate(() => Promise.all([studio.simulation, studio.beside.growth.simulation].map(async (one) => {
    const [{ environment }, { information }, { stateHash }] = await Promise.all(["environment", "information", "state-hash"].map((what) => one.get(what)));
    return JSON.stringify([await one.string(), environment.map(({ radius }) => radius), information.seed, stateHash]);
  })));
  const before = await both();
  assert.notEqual(before[0], before[1]);
  for (const wanted of [[before[1], before[0]], before]) {
    await page.click("#swap");
    await idle();
    assert.deepEqual(await both(), wanted);
  }
  await page.close();
});

test("a control point of a surface is dragged: its line of the file changes, and the leaves of the plant", async () => {
  const page = await open(`${running.address}/#gallery=branch-tiers`);
  await page.evaluate(async () => {
    const lilac = await studio.client.call("model.read", { gallery: "lilac" });
    const files = { "leaves.l": "Lsystem: 1\nderivation length: 1\nAxiom: ~l\nendlsystem\n", "leaves.v": "surface: l leaf.s 1\n", "leaf.s": lilac.files["leaf.s"] };
    await studio.openDocument({ title: "leaves", main: "leaves.l", files, binary: {}, environment: null, gallery: null });
  });
  await shown(page);
  const original = await page.evaluate(() => studio.document.files["leaf.s"]);
  const highest = () => page.evaluate(() => Math.max(...studio.view.plants.geometry.vertices.column("Position").filter((_, i) => i % 3 === 1)));
  const before = await highest();
  await page.click("text=leaf.s");
  await page.waitForSelector(".surface circle");
  assert.equal(await page.locator(".surface circle").count(), 16);
  // looked at, and not written
  await page.click("text=oblique");
  assert.equal(await page.evaluate(() => studio.document.files["leaf.s"]), original);
  await page.click("text=front");
  await keep(page, "studio-surface");
  // the tip is four points at one place: they move together
  const place = await page.locator(".surface circle[aria-label='Point 16 of blade']").boundingBox();
  await page.mouse.move(place.x + place.width / 2, place.y + place.height / 2);
  await page.mouse.down();
  await page.mouse.move(place.x + place.width / 2, place.y + place.height / 2 + 20, { steps: 3 });
  await page.mouse.up();
  await page.waitForFunction((text) => studio.document.files["leaf.s"] !== text && !studio.isFollowing && studio.counts.waiting === 0, original);
  await shown(page);
  const lines = (await page.evaluate(() => studio.document.files["leaf.s"])).split("\n");
  const changed = lines.map((line, i) => [line, original.split("\n")[i]]).filter(([now, then]) => now !== then);
  assert.equal(changed.length, 1);
  assert.match(changed[0][0], /^ 0 (0\.\d+) -0\.14 {3}0 \1 -0\.14 {4}0 \1 -0\.14 {4}0 \1 -0\.14$/);
  assert.ok((await highest()) < before - 0.02, `${await highest()} after ${before}`);
  await page.close();
});

test("a field of the environment is shown as a slice and as a surface, and follows the plant", async () => {
  // from a plant whose environment has no fields, which the page has learnt
  const page = await open(`${running.address}/#gallery=branch-tiers`);
  await page.evaluate(() => studio.fields.refresh());
  await page.evaluate(() => studio.openDocument({
    title: "watered", main: "model.l", binary: {}, gallery: null,
    files: { "model.l": "Lsystem: 1\nderivation length: 3\nAxiom: F(1)A?E(0)\nA > ?E(h) --> F(0.5)A\nendlsystem\n" },
    environment: [{ type: "soil-water", gridSize: [8, 6, 4], cellSize: [0.25, 0.25, 0.25], position: [-1, -1.5, -0.5], initialHead: -0.5, rain: [[0, 0.002]], layers: [[2, 0.045, 0.43, 14.5, 2.68, 7.128]] }],
  }));
  await shown(page);
  await page.waitForSelector("#field option[value=waterContent]", { state: "attached" });
  await page.selectOption("#field", "waterContent");
  await page.waitForFunction(() => studio.view.fieldView.group.children.length === 1);
  const { fields } = await page.evaluate(async () => (await fetch(`/simulations/${studio.simulation.id}/fields`)).json());
  const water = fields.find(({ name }) => name === "waterContent");
  const legend = await page.evaluate(() => studio.view.fieldView.legend);
  assert.match(legend.title, /^waterContent/);
  assert.deepEqual([legend.scale.low, legend.scale.high], [water.least, water.greatest]);
  // the camera sees the soil, which lies below the plant
  const [left, right, low, high] = await page.evaluate(() => {
    const { view } = studio;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => view.controls.target.clone().set(k & 1 ? 1 : -1, k & 2 ? 0 : -1.5, k & 4 ? 0.5 : -0.5).project(view.camera));
    return [Math.min(...corners.map(({ x }) => x)), Math.max(...corners.map(({ x }) => x)), Math.min(...corners.map(({ y }) => y)), Math.max(...corners.map(({ y }) => y))];
  });
  assert.ok(left > -1 && right < 1 && low > -1 && high < 1, String([left, right, low, high]));
  await page.check("#field-surface");
  await page.waitForFunction(() => studio.view.fieldView.group.children.length === 2 && studio.view.fieldView.group.children[1].geometry.getAttribute("position").count > 0);
  await keep(page, "studio-field");
  // another step, other values
  await page.evaluate(() => studio.goTo(1));
  await page.waitForFunction((high) => studio.view.fieldView.legend && studio.view.fieldView.legend.scale.high !== high, legend.scale.high);
  await page.selectOption("#field", "");
  await page.waitForFunction(() => studio.view.fieldView.group.children.length === 0);
  await page.close();
});

test("a token that the server takes no more is asked for again, and the text of the page stays", async () => {
  const first = await serve("127.0.0.1:0", "--token", "old words");
  const page = await open(`${first.address}/#gallery=parametric-tree&token=old%20words`);
  await page.evaluate(() => studio.edit(studio.document.main, `${studio.document.files[studio.document.main]}/* mine */\n`));
  first.server.kill("SIGKILL");
  await page.waitForFunction(() => document.body.dataset.state === "lost");
  const second = await serve(new URL(first.address).host, "--token", "new words");
  await page.waitForSelector("#token-form");
  assert.match(await page.textContent("#token-form"), /does not take this token any more.*the text stays/);
  await keep(page, "studio-token");
  await page.fill("#token", "new words");
  await page.click("#token-form button");
  await page.waitForFunction(() => studio.connection === "connected");
  await shown(page);
  assert.match(await page.evaluate(() => studio.document.files[studio.document.main]), /mine/);
  const grown = await page.evaluate(async () => Object.values((await studio.simulation.get("model")).model.files).join());
  assert.match(grown, /mine/);
  await page.close();
  await stopped(second.server);
  problems.length = 0; // the browser tells of each attempt to connect
});

test("a full server grows the plant of a slider in place of the old one, and tells others that it is full", async () => {
  const full = await serve("127.0.0.1:0", "--limit", "simulations=1");
  const page = await open(`${full.address}/#gallery=parametric-tree`);
  const before = await stringOf(page);
  await page.evaluate(() => studio.setSeed(8));
  await page.evaluate(() => studio.act(() => studio.editContinuously(studio.document.main, studio.document.files[studio.document.main].replace(/#define R1\s+\S+/, "#define R1 0.5"))));
  await shown(page);
  assert.notEqual(await stringOf(page), before);
  const other = await open(`${full.address}/#gallery=parametric-tree`, "");
  await other.waitForFunction(() => /simulations/.test(document.getElementById("message").textContent));
  assert.match(await other.evaluate(() => studio.document.files[studio.document.main]), /Lsystem/i);
  await keep(other, "studio-full");
  // there is room again
  await page.evaluate(() => studio.simulation.delete());
  await other.evaluate(() => studio.act(() => studio.build()));
  await shown(other);
  await other.close();
  await page.close();
  await stopped(full.server);
});

test("a class watches what its teacher does, also through a new start of the server, and grows copies", async () => {
  const first = await serve("127.0.0.1:0");
  const teacher = await open(`${first.address}/#gallery=lilac`);
  const id = await teacher.evaluate(() => studio.simulation.id);
  const pupil = await open(`${first.address}/#watch=${id}`);
  const follows = (look, argument) => pupil.waitForFunction(look, argument);
  const grown = async (page) => {
    await page.waitForFunction(() => document.getElementById("plant")?.dataset.step !== undefined);
    await shown(page);
  };
  // a slider: the number is the same in the pupil's text, and in a copy
  await teacher.evaluate(() => studio.slide(studio.defines.find(({ name }) => name === "NODES"), 9, 1, true));
  await shown(teacher);
  await follows(() => studio.document.files["lilac.l"].includes("#define NODES 9 "));
  const plantsOf = (page) => page.evaluate(async () => (await Promise.all([...Array(studio.statistics.at(-1).plants ?? 1).keys()].map((plant) => studio.simulation.string(plant)))).join("\n"));
  const [own] = await Promise.all([pupil.waitForEvent("popup"), pupil.click("#copy-plant")]);
  await grown(own);
  assert.ok((await plantsOf(own)) === (await plantsOf(teacher)));
  assert.equal(await own.evaluate(() => studio.length), 22, "the last frame of the folder");
  const colours = (page) => page.evaluate(() => JSON.stringify(studio.palette.colours));
  assert.ok((await colours(own)) === (await colours(teacher)), "the colour map of the folder");
  await own.close();

  // another text, with the last frame of the folder as before; then a model with several plants: the link is the same
  await teacher.evaluate(() => studio.edit("lilac.l", `/* lesson */ ${studio.document.files["lilac.l"]}`));
  await follows(() => studio.document.files["lilac.l"].startsWith("/* lesson */") && studio.isFinished);
  await shown(teacher);
  assert.deepEqual(await teacher.evaluate(() => [studio.simulation.id, studio.length]), [id, 22]);
  await teacher.evaluate(() => studio.act(() => studio.openGallery("two-trees")));
  await follows(() => studio.document.title === "two-trees" && studio.isFinished);
  await shown(teacher);
  const [forest] = await Promise.all([pupil.waitForEvent("popup"), pupil.click("#copy-plant")]);
  await grown(forest);
  assert.ok((await plantsOf(forest)) === (await plantsOf(teacher)));
  assert.equal(await forest.evaluate(() => studio.statistics.at(-1).plants), 2);
  // its text is changed, and it is a forest still
  await forest.evaluate(() => studio.edit("two-trees.l", `/* mine */\n${studio.document.files["two-trees.l"]}`));
  await forest.waitForFunction(() => studio.counts.waiting === 0 && studio.simulation.created.plants === 2 && studio.isFinished && studio.step > 0);
  await forest.close();

  // a server that keeps nothing starts anew: the teacher's page brings the plant back under its name
  first.server.kill("SIGKILL");
  await pupil.waitForFunction(() => document.body.dataset.state === "lost");
  problems.length = 0; // the browser tells of each attempt
  const second = await serve(new URL(first.address).host);
  await teacher.waitForFunction((name) => document.body.dataset.state === "connected" && studio.simulation?.id === name && studio.isFinished, id);
  await follows(() => document.body.dataset.state === "connected" && studio.simulation && studio.isFinished && document.getElementById("plant").dataset.step === String(studio.step));
  problems.length = 0;
  await keep(pupil, "studio-class");
  await teacher.close();
  await pupil.close();
  await stopped(second.server);
});

test("a gallery model that changes on the server's disk stays as the page shows it, and the page says so", async () => {
  const models = join(folder, "models");
  cpSync(join(GALLERY, "parametric-tree"), join(models, "parametric-tree"), { recursive: true });
  const own = await serve("127.0.0.1:0", "--gallery", models);
  const page = await open(`${own.address}/#gallery=parametric-tree&seed=3`);
  const text = await stringOf(page);
  const file = join(models, "parametric-tree", await page.evaluate(() => studio.document.main));
  writeFileSync(file, readFileSync(file, "utf8").replace(/#define R1\s+\S+/, "#define R1 0.25"));
  await page.evaluate(() => studio.act(() => studio.build()));
  await shown(page);
  await page.waitForFunction(() => document.getElementById("message").textContent.startsWith("Changed on the server's disk: parametric-tree.l. This page keeps its own text"));
  assert.equal(await stringOf(page), text);
  await keep(page, "studio-changed");
  await page.evaluate(() => studio.act(() => studio.openGallery("parametric-tree")));
  await shown(page);
  assert.notEqual(await stringOf(page), text);
  await page.waitForFunction(() => document.getElementById("message").textContent === "");
  await page.close();
  await stopped(own.server);
});

test("a model is saved on the server, opened again, and two people do not write over each other", async () => {
  const models = join(folder, "saved models");
  mkdirSync(models);
  const keeping = await serve("127.0.0.1:0", "--models", models);
  const page = await open(`${keeping.address}/#gallery=shadow-trees`);
  // the files of a published environment count when they are changed
  const before = await page.evaluate(() => studio.counts.derivations);
  await page.evaluate(() => studio.edit("shadow-trees.spec", studio.document.files["shadow-trees.spec"].replace("shadow weight: 0.58", "shadow weight: 0.3")));
  await page.waitForFunction((old) => studio.counts.derivations > old, before);
  await shown(page);
  const grown = await stringOf(page);
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("Control+s");
  await page.waitForSelector("#save-on-server");
  await page.fill("#saved-name", "our trees");
  await keep(page, "studio-save-on-server");
  await page.click("#save-on-server button.primary");
  await page.waitForFunction(() => document.getElementById("message").textContent === "Saved on the server as “our trees”." && !studio.isChanged);
  assert.equal(await page.evaluate(() => studio.shownTitle), "our trees", "the plant is still the same one");
  await page.keyboard.press("Escape");
  const kept = spawnSync(program, ["derive", join(models, "our trees"), "--seed", String(await page.evaluate(() => studio.seed))], { encoding: "utf8", maxBuffer: 1e9 });
  assert.ok(kept.stdout.trim() === grown, "the command line derives the same plant");

  const other = await open(keeping.address);
  await other.click("#open-gallery");
  await other.click('[data-saved="our trees"]');
  await other.waitForFunction(() => studio.document.saved?.name === "our trees");
  await shown(other);
  assert.ok((await stringOf(other)) === grown, "so does the other page");
  await other.evaluate(() => studio.edit("shadow-trees.l", `/* mine */\n${studio.document.files["shadow-trees.l"]}`));
  await other.keyboard.press("Control+s");
  await other.waitForFunction(() => !studio.isChanged);
  // the first page does not know that text
  await page.evaluate(() => studio.edit("shadow-trees.l", `/* yours */\n${studio.document.files["shadow-trees.l"]}`));
  await page.keyboard.press("Control+s");
  await page.waitForSelector("#save-on-server");
  await page.click("#save-on-server button.primary");
  await page.waitForSelector("#save-over");
  assert.match(readFileSync(join(models, "our trees", "shadow-trees.l"), "utf8"), /^\/\* mine/);
  await keep(page, "studio-save-over");
  await page.click("#save-over");
  await page.waitForFunction(() => !studio.isChanged);
  assert.match(readFileSync(join(models, "our trees", "shadow-trees.l"), "utf8"), /^\/\* yours/);
  await page.close();
  await other.close();
  await stopped(keeping.server);
});

test("where pictures take long a plant that moves has no shadows, and has them again at rest or when they are asked for", async () => {
  const page = await open(`${running.address}/#gallery=parametric-tree`);
  const state = () => page.evaluate(() => [studio.view.plants.tubes.isCoarse, studio.view.renderer.shadowMap.enabled]);
  await page.waitForFunction(() => studio.view.renderer.shadowMap.enabled);
  const slide = (segments, milliseconds) =>
    page.evaluate(([count, time]) => {
      clearTimeout(studio.view.rest);
      Object.assign(studio.view, { isSlow: true, isFine: false, fine: { count, milliseconds: time } });
      studio.view.turn(0.1); // the camera moves
      return [studio.view.plants.tubes.isCoarse, studio.view.renderer.shadowMap.enabled];
    }, [segments, milliseconds]);
  assert.deepEqual(await slide(1, 200), [true, false]);
  await page.waitForFunction(() => !studio.view.plants.tubes.isCoarse && studio.view.renderer.shadowMap.enabled);
  // such a picture would take too long
  assert.deepEqual(await slide(1000, 5000), [true, false]);
  await page.waitForTimeout(1500);
  assert.deepEqual(await state(), [true, false]);
  await page.evaluate(() => studio.view.apply(studio.view.settings));
  assert.deepEqual(await state(), [false, true]);
  await page.close();
});

test("no page had an error, or asked for anything that its policy forbids", () => {
  assert.deepEqual(problems, []);
});
