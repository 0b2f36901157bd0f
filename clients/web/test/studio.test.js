// The studio in Chromium, at a real server.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { PATIENCE, derived, folder, keep, lineAt, open, problems, program, running, serve, shown, stopped, stringOf } from "./pages.js";

/** A model of few modules, where the plant does not matter: a browser without a graphics card draws slowly. */
const SMALL = (address = running.address) => `${address}/#gallery=branch-tiers`;
const here = dirname(fileURLToPath(import.meta.url));

test("a page without a model in its address shows a tree whose buds ask for light", async () => {
  const page = await open(`${running.address}/`);
  const { title, environment, queries } = await page.evaluate(() => ({ title: studio.document.title, environment: studio.document.environment, queries: studio.statistics.at(-1).queries }));
  assert.equal(title, "light-tree");
  assert.equal(environment[0].type, "shadow");
  assert.ok(queries > 100, `${queries} queries`);
  assert.equal(await page.textContent(".problems p, .problems li"), "none");
  assert.equal(await page.evaluate(() => studio.isChanged), false);
  await keep(page, "studio-first");
  await page.close();
});

test("a page whose first hello came too late connects again when it is made", async () => {
  // the server hangs up on a peer that says no hello for ten seconds; a busy machine takes longer to make the page
  const page = await open(`${running.address}/#gallery=parametric-tree`, "shown", () => {
    let isFirst = true;
    const WithLateHello = class extends WebSocket {
      send(data) {
        if (isFirst) {
          isFirst = false;
          this.close();
        } else {
          super.send(data);
        }
      }
    };
    window.WebSocket = WithLateHello;
  });
  assert.equal(await page.evaluate(() => studio.connection), "connected");
  await page.close();
});

test("a gallery model grows, with few draw calls and 32 bytes a segment", async () => {
  const page = await open(`${running.address}/#gallery=parametric-tree`);
  assert.equal(await page.title(), "parametric-tree – Espalier");
  const figures = await page.evaluate(() => studio.view.figures());
  assert.equal(figures.segmentBytes, 32);
  assert.ok(figures.segments > 100, `${figures.segments} segments`);
  assert.ok(figures.calls <= 20, `${figures.calls} draw calls`);
  // the scale becomes that of the last step, and the plant fills the view
  await page.waitForFunction(() => {
    const width = parseFloat(document.querySelector(".scale span").style.width);
    return Math.abs(Number(document.querySelector(".scale").textContent) / (width * studio.view.unitsPerPixel()) - 1) < 0.01;
  });
  const height = await page.evaluate(() => studio.view.plantHeight() / studio.view.foot().unitsPerPixel / document.getElementById("plant").offsetHeight);
  assert.ok(height > 0.4 && height < 1, `${height}`);
  // seen from where its view file says: from 1,0.5,3 toward 0,2,0
  const direction = await page.evaluate(() => studio.view.camera.position.clone().sub(studio.view.controls.target).normalize().toArray());
  assert.deepEqual(direction.map((value) => value.toFixed(3)), [1, -1.5, 3].map((value) => (value / 3.5).toFixed(3)));
  await keep(page, "studio-tree");

  await page.click("#open-gallery");
  await page.waitForFunction(() => document.querySelector(".card img")?.naturalWidth > 0);
  await page.fill("input[type=search]", "growth to");
  await keep(page, "studio-gallery");
  // Enter opens the first of them
  await page.press("input[type=search]", "Enter");
  await page.waitForFunction(() => studio.document.title === "growth-to-a-height");
  await shown(page);
  // the environment of the gallery model answers
  assert.ok(await page.evaluate(() => studio.statistics.some(({ queries }) => queries > 0)));
  assert.equal(await page.textContent('[data-figure="modules"]'), (await page.evaluate(() => studio.statistics.at(-1).modules)).toLocaleString("en"));
  await page.close();
});

test("a model with textures shows them, and its colours by number without them", async () => {
  const page = await open(`${running.address}/#gallery=textured-tree`);
  await page.waitForFunction(() => studio.view.figures().textures === 2, null, PATIENCE);
  await keep(page, "studio-textures");
  await page.selectOption("#mode", "order");
  await page.waitForFunction(() => studio.view.figures().textures === 0);
  await page.selectOption("#mode", "model");
  // the next state of the plant has them too
  await page.evaluate(() => studio.act(() => studio.goTo(2)));
  await page.waitForFunction(() => document.getElementById("plant").dataset.textured === "2");
  assert.ok((await page.evaluate(() => studio.view.figures().textures)) > 0);
  await page.close();
});

test("a material is changed in all its parts, and seen when it is", async () => {
  const page = await open(`${running.address}/#gallery=classic-algae`);
  const record = (number, transparency) => [number, transparency, 9, 9, 9, 40, 120, 30, 0, 0, 0, 8, 8, 8, 20];
  await page.evaluate((bytes) => studio.openDocument({
    title: "stem", main: "stem.l", environment: null, gallery: null,
    files: { "stem.l": "Lsystem: 1\nderivation length: 2\nAxiom: ;(2)!(0.2)F(1);(3)F(1)\nendlsystem\n", "stem.v": "\n", "specifications": "stem.l\nstem.v\nstem.mat\nignore:\n*\nstem:\n\tcpfg -M stem.mat stem.l stem.v\n" },
    binary: { "stem.mat": btoa(String.fromCharCode(...bytes)) },
  }), [...record(2, 0), ...record(3, 0)]);
  await shown(page);
  const seen = () => page.evaluate(() => {
    const found = [];
    studio.view.other?.traverse((part) => part.material && found.push([part.material.name, part.material.opacity.toFixed(2), part.material.roughness.toFixed(2)].join(" ")));
    return found.sort().join(", ");
  });
  assert.equal(await seen(), "", "columns have no materials");
  await page.getByTitle("Everything about material 3").click();
  // faster than the page is drawn
  await page.evaluate(() => {
    for (const [name, value] of Object.entries({ "material-transparency": "102", "material-shininess": "126", "material-emission": "#010203" })) {
      Object.assign(document.getElementById(name), { value }).dispatchEvent(new Event("input", { bubbles: true }));
    }
  });
  assert.deepEqual(await page.evaluate(() => [...atob(studio.document.binary["stem.mat"])].map((one) => one.charCodeAt(0))), [...record(2, 0), 3, 102, 9, 9, 9, 40, 120, 30, 1, 2, 3, 8, 8, 8, 126]);
  await page.waitForFunction(() => { let found = false; studio.view.other?.traverse(({ material }) => (found ||= material?.alphaHash && Math.abs(material.opacity - 0.6) < 0.01)); return found; });
  await keep(page, "studio-materials");
  assert.deepEqual(await seriousOf(page), []);
  // the three changes are one, as of a drag; Ctrl Z takes them back and not the text before
  const bytes = () => page.evaluate(() => studio.document.binary["stem.mat"]);
  const changed = await bytes();
  await page.locator("body").click({ position: { x: 5, y: 5 } });
  await page.keyboard.press("Control+z");
  await page.waitForFunction((one) => studio.document.binary["stem.mat"] !== one, changed);
  assert.deepEqual([...Buffer.from(await bytes(), "base64")], [...record(2, 0), ...record(3, 0)]);
  await page.keyboard.press("Control+y");
  await page.waitForFunction((one) => studio.document.binary["stem.mat"] === one, changed);
  // what was pruned stays pruned
  await page.evaluate(() => studio.act(() => studio.pick({ plant: 0, module: 4, symbol: "F", order: 0, kind: "segment", position: [0, 0, 0] })));
  await page.evaluate(() => studio.act(() => studio.change("prune")));
  const pruned = await stringOf(page);
  await page.fill("#colour-2", "#102030");
  await page.waitForFunction(() => studio.counts.waiting === 0 && studio.palette.colours[2][2] === 0x30);
  assert.equal(await stringOf(page), pruned);
  // the newest wish counts
  await page.evaluate(() => { const box = document.getElementById("show-materials"); box.click(); box.click(); box.click(); });
  await page.waitForTimeout(500);
  assert.equal(await page.evaluate(() => studio.view.other), null);
  await page.check("#show-materials");
  await page.waitForFunction(() => studio.view.other !== null);
  await page.uncheck("#show-materials");
  await page.waitForFunction(() => studio.view.other === null);
  assert.equal(await seen(), "");
  await page.close();
});

test("a slider that moves two hundred times has one derivation under way and ends with its newest value", async () => {
  const page = await open(`${running.address}/#gallery=parametric-tree`);
  const before = await page.evaluate(() => studio.counts.derivations);
  await page.evaluate(async () => {
    const slider = document.getElementById("define-A0");
    for (let i = 0; i < 200; ++i) {
      slider.value = String(20 + (i % 31));
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      if (i % 20 === 0) {
        await new Promise((done) => setTimeout(done, 1));
      }
    }
    slider.value = "47";
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await page.waitForFunction(() => studio.counts.inFlight === 0 && studio.isFinished);
  const { derivations, mostInFlight } = await page.evaluate(() => studio.counts);
  assert.equal(mostInFlight, 1);
  assert.ok(derivations - before < 200, `${derivations - before} derivations`);
  await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes("#define A0 47     /*"));
  // only the number changed in the text, and the plant is what the text says
  const original = readFileSync(join(here, "../../gallery/parametric-tree/parametric-tree.l"), "utf8");
  assert.equal(await page.evaluate(() => studio.document.files["parametric-tree.l"]), original.replace("A0 45", "A0 47"));
  const grown = await stringOf(page);
  assert.equal(grown, await derived(page));
  // figures that come late tell of a step before the last answer: the next plant has all its steps still
  for (const value of ["46", "47"]) {
    await page.evaluate((next) => {
      studio.stepped({ step: 3, finished: false, statistics: { ...studio.statistics[3] } });
      const slider = document.getElementById("define-A0");
      slider.value = next;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }, value);
    await page.waitForFunction(() => studio.counts.waiting === 0 && studio.isFinished);
  }
  assert.equal(await stringOf(page), grown);

  // while a slider moves, the counts behind the productions wait
  const lenses = await page.evaluate(async () => {
    const slider = document.getElementById("define-A0");
    const send = studio.editorMessage.bind(studio);
    let count = 0;
    studio.editorMessage = (message) => ((count += message.includes("codeLens") ? 1 : 0), send(message));
    const move = (value) => { slider.value = value; slider.dispatchEvent(new Event("input", { bubbles: true })); };
    move("48");
    for (let i = 0; i < 10; ++i) {
      await new Promise((done) => setTimeout(done, 100));
      move(String(48 + (i % 2)));
    }
    const during = count;
    move("47");
    return during;
  });
  assert.ok(lenses <= 1, `${lenses} while the slider moved`); // one may have been on its way
  await page.waitForFunction(() => studio.counts.waiting === 0 && studio.isFinished);
  assert.equal(await stringOf(page), grown);

  // back to a step, and to the end again
  await page.evaluate(() => studio.goTo(3));
  assert.equal(await page.evaluate(() => studio.step), 3);
  await page.evaluate(() => studio.goTo(studio.length));
  assert.equal(await stringOf(page), grown);

  // the link makes the same plant in another page
  await page.keyboard.press("l");
  await page.waitForFunction(() => document.getElementById("share-link").value.includes("#model="));
  assert.match(await page.textContent("#only-here"), /^This page came from 127\.0\.0\.1:\d+, an address of this computer that no other reaches\./);
  const other = await open(await page.inputValue("#share-link"));
  assert.equal(await stringOf(other), grown);
  await other.close();
  await page.keyboard.press("Escape");

  // numbers of other lengths, faster than the page draws: only the number changes, and its slider stays
  await page.evaluate(() => {
    const slider = document.getElementById("define-A0");
    for (const value of ["44.9", "100", "9", "45.1", "47"]) {
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }
  });
  assert.equal(await page.evaluate(() => studio.document.files["parametric-tree.l"]), original.replace("A0 45", "A0 47"));
  await page.waitForFunction(() => studio.counts.inFlight === 0 && studio.isFinished);

  // a slider's change is taken back by the keyboard, wherever it is
  await page.evaluate(() => {
    const slider = document.getElementById("define-A0");
    slider.value = "60";
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes("#define A0 60"));
  await page.keyboard.press("Control+z");
  await page.waitForFunction(() => studio.document.files["parametric-tree.l"].includes("#define A0 47"));
  await page.waitForFunction(async (wanted) => studio.counts.waiting === 0 && (await studio.simulation.string()) === wanted, grown);
  await page.close();
});

test("a table of variations grows beside the plant, and a click takes one over", async () => {
  const page = await open(`${running.address}/#gallery=parametric-tree`);
  const before = await stringOf(page);
  const simulations = () => page.evaluate(async () => (await studio.list(), studio.simulations.length));
  const count = await simulations();
  await page.keyboard.press("v");
  await page.waitForFunction(() => document.querySelectorAll(".variations .picture img").length === 36);
  await keep(page, "studio-variations");
  assert.equal(await page.getAttribute('[data-variation="0 0"]', "title"), "R1 0.54, R2 0.36");
  const pictures = await page.evaluate(() => new Set([...document.querySelectorAll(".variations .picture img")].map(({ src }) => src)).size);
  assert.equal(pictures, 36);
  assert.equal(await stringOf(page), before);
  await page.click('[data-variation="4 5"]');
  await page.waitForFunction(() => studio.counts.waiting === 0 && studio.isFinished && /R1 1 .*R2 0.74 /s.test(studio.document.files["parametric-tree.l"]));
  assert.equal(await stringOf(page), await derived(page));

  // seeds along both sides: 36 trees of one model
  await page.keyboard.press("v");
  await page.selectOption(".axis:nth-child(1) select", "");
  await page.selectOption(".axis:nth-child(2) select", "");
  assert.equal(await page.getAttribute('[data-variation="5 5"]', "title"), "seed 42");
  await page.click("#more-seeds");
  await page.waitForFunction(() => document.querySelector('[data-variation="0 0"]').title === "seed 43");
  await page.fill("#first-seed", "7");
  await page.keyboard.press("Tab");
  await page.waitForFunction(() => document.querySelector('[data-variation="0 0"]').title === "seed 7");
  await page.click('[data-variation="1 2"]');
  await page.waitForFunction(() => studio.counts.waiting === 0 && studio.seed === 15 && studio.isFinished);
  // simulations that were given up half-way are gone from the server
  await page.waitForFunction(async (wanted) => (await studio.list(), studio.simulations.length === wanted), count);
  await page.close();
});

test("the environment has forms, is seen, and a solid that is dragged changes the plant", async () => {
  const page = await open(`${running.address}/#gallery=roots-in-soil`);
  await page.setViewportSize({ width: 1200, height: 640 });
  const given = await page.evaluate(() => studio.document.environment);
  assert.equal((await page.evaluate(() => studio.view.surroundings.figures())).solids, given[0].spheres.length + 1); // and the box of the grid
  await page.click("#tab-Set-up");
  // a setting from its schema: a wrong value is refused with words, a right one grows the plant again
  await page.fill("#environment-0-cellSize", "1, 2");
  await page.keyboard.press("Tab");
  assert.equal(await page.textContent(".setting [role=alert]"), "Write 3 numbers.");
  const before = await stringOf(page);
  await page.fill("#environment-0-initialHead", "-0.3");
  await page.keyboard.press("Tab");
  await page.waitForFunction(() => studio.document.environment[0].initialHead === -0.3);
  await shown(page);
  const wetter = await stringOf(page);
  assert.notEqual(wetter, before);
  await keep(page, "studio-environment");

  // a stone, dragged; a busy browser may still turn to the new plant between the look and the hand
  const stones = await page.evaluate(() => JSON.stringify(studio.document.environment[0].spheres));
  const areMoved = () => page.waitForFunction((old) => JSON.stringify(studio.document.environment[0].spheres) !== old, stones, { timeout: 5000 }).then(() => true, () => false);
  let isMoved = false;
  for (let i = 0; i < 5 && !isMoved; ++i) {
    const place = await page.evaluate(() => {
      const { left, top, width, height } = document.querySelector("#plant canvas").getBoundingClientRect();
      for (let y = top + 5; y < top + height; y += 4) {
        for (let x = left + 5; x < left + width; x += 4) {
          // no button lies over it
          if (document.elementFromPoint(x, y)?.tagName === "CANVAS" && studio.view.solidAt(x, y)?.solid.list === "spheres") {
            return { x, y };
          }
        }
      }
      return null;
    });
    await page.mouse.move(place.x, place.y);
    await page.mouse.down();
    await page.mouse.move(place.x + 10, place.y + 30, { steps: 4 });
    await page.mouse.up();
    isMoved = await areMoved();
  }
  assert.ok(isMoved);
  await shown(page);
  assert.notEqual(await stringOf(page), wetter);
  // one derivation at a time, however many moves
  assert.equal(await page.evaluate(() => studio.counts.mostInFlight), 1);
  await page.click("#show-queries");
  await page.waitForFunction(() => studio.view.surroundings.figures().queries > 0);
  await keep(page, "studio-queries");
  await page.close();
});

test("a model is written, broken, and mended by its hint", async () => {
  const page = await open(SMALL());
  await page.click("#open-gallery");
  await page.click("text=New model");
  await page.waitForFunction(() => studio.document.title === "untitled");
  await shown(page);
  const write = async (text) => {
    await page.click(".cm-content");
    await page.keyboard.press("Control+a");
    await page.keyboard.insertText(text);
  };
  const LINES = ["Lsystem: 1", "derivation length: 4", "Axiom: F(1)A(1)", "A(size) --> F(sise)[+(30)A(size*0.8)][-(30)A(size*0.8)]", "endlsystem", ""];
  await write(LINES.join("\n"));
  await page.waitForFunction(() => studio.diagnostics.some(({ message }) => message.includes("'sise'")));
  const mark = page.locator(".cm-lintRange-warning", { hasText: "sise" });
  assert.equal(await mark.textContent(), "sise");
  assert.match(await page.textContent("#problems"), /model\.l:4:15.*did you mean 'size'\?/s);
  await keep(page, "studio-problem");
  // the hint mends it
  await page.click("#problems .remedy");
  await page.waitForFunction(() => studio.document.files["model.l"].includes("F(size)"));
  const wanted = await derived(page);
  await page.waitForFunction(async (text) => studio.diagnostics.length === 0 && (await studio.simulation.string()) === text, wanted);
  // an error leaves the plant as it was, and is marked
  await write(LINES.join("\n").replace("sise", "size").replace("A(1)", "A("));
  await page.waitForFunction(() => studio.diagnostics.some(({ severity, range }) => severity === "error" && range.begin.line === 3));
  await page.waitForSelector(".cm-lintRange-error");
  await page.close();
});

test("no letter is lost while somebody types and the plant grows again and again", async () => {
  const page = await open(SMALL());
  await page.evaluate(() => studio.openDocument({ title: "typed", main: "model.l", binary: {}, environment: null, gallery: null, files: { "model.l": "Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> FA\nendlsystem\n" } }));
  await shown(page);
  await page.click(".cm-content");
  await page.keyboard.press("Control+Home");
  const words = Array.from({ length: 8 }, (_, i) => `// line ${i} with some words`);
  for (const line of words) {
    await page.keyboard.type(line);
    await page.keyboard.press("Enter");
  }
  const text = await page.evaluate(() => document.querySelector(".code").editor.view.state.doc.toString());
  assert.equal(text, `${words.join("\n")}\nLsystem: 1\nderivation length: 3\nAxiom: A\nA --> FA\nendlsystem\n`);
  assert.equal(await page.evaluate(() => studio.document.files["model.l"]), text);
  await page.close();
});

test("no letter of a number is lost while the page is drawn again", async () => {
  const page = await open(SMALL());
  await page.evaluate(() => studio.openDocument({ title: "typed", main: "model.l", binary: {}, environment: null, gallery: null, files: { "model.l": "#define ANGLE 45\nLsystem: 1\nderivation length: 1\nAxiom: +(ANGLE)F\nendlsystem\n" } }));
  await shown(page);
  const redrawn = () => page.evaluate(() => new Promise((done) => { studio.say(String(Math.random())); const look = () => (document.getElementById("message").textContent === studio.message.text ? done() : setTimeout(look, 20)); look(); }));
  await page.focus('[aria-label="Value of ANGLE"]');
  await page.keyboard.press("Control+a");
  await page.keyboard.type("3");
  await redrawn();
  await page.keyboard.type("2");
  await redrawn();
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => studio.document.files["model.l"].startsWith("#define ANGLE 32\n"));
  // what is not done with is forgotten, and the field follows its slider
  await page.evaluate(() => studio.slide(studio.defines[0], 50, 1, true));
  await page.waitForFunction(() => document.querySelector('[aria-label="Value of ANGLE"]').value === "50");
  await page.close();
});

test("the language server completes, explains, finds the definition and renames in all files of the model", async () => {
  const page = await open(SMALL());
  await page.evaluate(() => studio.openDocument({
    title: "helped", main: "model.l", binary: {}, environment: null, gallery: null,
    files: {
      "angles.h": "#define SPREAD 25\n",
      "model.l": '#include "angles.h"\n#define LENGTH 1.5\nLsystem: 1\nderivation length: 2\nAxiom: A(LENGTH)\nA(size) --> F(size)[+(SPREAD)A(size*0.8)]\nendlsystem\n',
    },
  }));
  await shown(page);
  const word = (text, nth = 0) => page.evaluate(([wanted, which]) => {
    // the place of a word on the page
    const walker = document.createTreeWalker(document.querySelector(".cm-content"), NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(), left = which; node; node = walker.nextNode()) {
      const at = node.data.indexOf(wanted);
      if (at >= 0 && left-- === 0) {
        const range = document.createRange();
        range.setStart(node, at);
        range.setEnd(node, at + wanted.length);
        const { left: x, top: y, width, height } = range.getBoundingClientRect();
        return { x: x + width / 2, y: y + height / 2 };
      }
    }
    return null;
  }, [text, nth]);
  const tree = await word("SPREAD");
  await page.mouse.move(tree.x, tree.y);
  await page.waitForFunction(() => document.querySelector(".cm-lsp-hover-tooltip")?.textContent.includes("#define SPREAD 25"));
  await keep(page, "studio-hover");

  // a rename from the use reaches the other file
  await page.mouse.click(tree.x, tree.y);
  await page.keyboard.press("F2");
  await page.fill(".cm-lsp-rename-panel input", "FORK");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => studio.document.files["angles.h"] === "#define FORK 25\n" && studio.document.files["model.l"].includes("+(FORK)A"));

  const renamed = await word("FORK");
  await page.mouse.click(renamed.x, renamed.y);
  await page.keyboard.press("F12");
  await page.waitForFunction(() => studio.openFile === "angles.h" && document.querySelector(".cm-content").textContent.includes("#define FORK 25"));

  await page.click("text=model.l");
  await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes("LENGTH"));
  // when the text stands still
  let length = await word("LENGTH", 1);
  for (let before = null; !length || length.x !== before?.x || length.y !== before?.y; length = await word("LENGTH", 1)) {
    before = length;
    await page.waitForTimeout(300);
  }
  await page.mouse.dblclick(length.x, length.y);
  await page.keyboard.type("LEN");
  await page.waitForFunction(() => studio.document.files["model.l"].includes("A(LEN)"));
  // on a slow machine the list may have come and gone: ask for it as a person does
  for (let asked = 0; asked < 10 && !(await page.isVisible(".cm-tooltip-autocomplete")); ++asked) {
    await page.waitForTimeout(1500);
    if (!(await page.isVisible(".cm-tooltip-autocomplete"))) {
      await page.keyboard.press("Control+Space");
    }
  }
  await page.waitForSelector(".cm-tooltip-autocomplete");
  await keep(page, "studio-completion");
  await page.keyboard.press("Tab");
  await page.waitForFunction(() => studio.document.files["model.l"].includes("A(LENGTH)\n"));
  // a mistyped word is not offered, also when the caret stands inside it
  await page.keyboard.type("X");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("Control+Space");
  await page.waitForTimeout(1500);
  const labels = await page.locator(".cm-completionLabel").allTextContents();
  assert.ok(!labels.includes("LENGTHX"), String(labels));
  await page.close();
});

test("each production says how often the run has applied it", async () => {
  const page = await open(SMALL());
  const model = "Lsystem: 1\nderivation length: 4\nAxiom: A\nA --> F[+A]A\nF --> FF\nB --> A\nendlsystem\n";
  await page.evaluate((text) => studio.openDocument({ title: "counted", main: "model.l", binary: {}, environment: null, gallery: null, files: { "model.l": text } }), model);
  await shown(page);
  // by line of the text: the number of the line and what stands behind it
  await page.evaluate(() => (window.lenses = () => [...document.querySelectorAll(".cm-line")].flatMap((line, i) => (line.querySelector(".cm-lens") ? [`${i + 1}: ${line.querySelector(".cm-lens").textContent}`] : []))));
  const become = async (expected) => {
    await page.waitForFunction((wanted) => JSON.stringify(lenses()) === JSON.stringify(wanted), expected, PATIENCE).catch(() => {});
    assert.deepEqual(await page.evaluate(() => lenses()), expected);
  };
  await become(["4: applied 15 times, 8 in step 4", "5: applied 17 times, 12 in step 4", "6: never applied in 4 steps"]);
  await keep(page, "studio-lenses");
  // back in time, and an edit that moves the lines
  await page.evaluate(() => studio.goTo(1));
  await become(["4: applied 1 time, 1 in step 1", "5: never applied in 1 step", "6: never applied in 1 step"]);
  await page.evaluate((text) => studio.edit("model.l", `// a comment\n${text}`), model);
  await become(["5: applied 1 time, 1 in step 1", "6: never applied in 1 step", "7: never applied in 1 step"]);
  await page.close();
});

test("a click explains a module as the command line does, and prunes there", async () => {
  const page = await open(`${running.address}/#gallery=classic-weed`);
  await page.evaluate(() => studio.goTo(studio.length - 1));
  await page.waitForFunction(() => document.getElementById("plant").dataset.step === String(studio.step));
  const place = await lineAt(page);
  await page.mouse.click(place.x, place.y);
  await page.waitForFunction(() => document.getElementById("explanation")?.textContent.startsWith("Step "));
  const { module, step, seed } = await page.evaluate(() => ({ module: studio.picked.module, step: studio.step, seed: studio.seed }));
  const explained = spawnSync(program, ["explain", join(here, "../../gallery/classic-weed"), "--step", String(step + 1), "--module", String(module), "--seed", String(seed)], { encoding: "utf8" });
  const withoutFolders = (text) => text.replace(/[^\s(]*\/(?=classic-weed)/g, "").trim();
  assert.equal(withoutFolders(await page.textContent("#explanation")), withoutFolders(explained.stdout));
  await keep(page, "studio-module");
  const segments = await page.evaluate(() => studio.view.figures().segments);
  await page.click("#prune");
  await page.waitForFunction((before) => studio.view.figures().segments < before, segments);
  await page.close();
});

test("the page watches what another program does, and lives through a new start of its server", async () => {
  const data = join(folder, "data");
  const first = await serve("127.0.0.1:0", "--data", data);
  const { host } = new URL(first.address);
  const page = await open(SMALL(first.address));
  const made = await page.evaluate(async () => {
    const watched = await studio.simulation.client.create({ model: { gallery: "classic-weed" }, seed: 1, environment: [{ type: "honda", radius: 0.5 }] });
    await watched.step(2);
    return watched.id;
  });
  const viewer = await open(`${first.address}/#simulation=${made}`, "");
  await viewer.waitForFunction(() => document.getElementById("plant")?.dataset.step === "2");
  await page.evaluate((id) => studio.simulation.client.simulation(id).step(), made);
  await viewer.waitForFunction(() => document.getElementById("plant").dataset.step === "3");
  await viewer.close();

  // a link to watch changes nothing
  const pupil = await open(`${first.address}/#watch=${made}`, "");
  await pupil.waitForFunction(() => document.getElementById("plant")?.dataset.step === "3");
  assert.ok(await pupil.isDisabled("#step"));
  await pupil.keyboard.press("ArrowRight");
  await pupil.evaluate(() => studio.act(() => studio.setProcesses([{ type: "honda" }])));
  await pupil.waitForFunction(() => document.getElementById("message").textContent.startsWith("This page only watches"));
  assert.match(await pupil.evaluate(() => studio.simulation.step().then(() => "", (error) => error.message)), /role|controller/);
  await page.evaluate((id) => studio.simulation.client.simulation(id).step(), made);
  await pupil.waitForFunction(() => document.getElementById("plant").dataset.step === "4");

  // a copy of one's own, with its environment, in a page of its own
  const [own] = await Promise.all([pupil.waitForEvent("popup"), pupil.click("#copy-plant")]);
  await own.waitForFunction(() => document.getElementById("plant")?.dataset.step === "4");
  assert.deepEqual(await own.evaluate(() => studio.document.environment), [{ type: "honda", radius: 0.5 }]);
  const hashes = await Promise.all([own, pupil].map((one) => one.evaluate(() => studio.simulation.stateHash())));
  assert.equal(hashes[0], hashes[1]);
  assert.ok(!(await own.isDisabled("#step")));
  await own.close();
  await pupil.close();

  first.server.kill("SIGKILL");
  await page.waitForFunction(() => document.getElementById("message").textContent.startsWith("The server has stopped or cannot be reached."));
  problems.length = 0; // the browser tells of each attempt
  const second = await serve(host, "--data", data);
  await page.waitForFunction(() => document.body.dataset.state === "connected" && studio.simulation);
  await shown(page);
  problems.length = 0;
  await page.evaluate(() => studio.act(() => studio.goTo(2)));
  assert.equal(await page.evaluate(() => studio.step), 2);
  await page.close();
  await stopped(second.server);
});

test("a server with a token asks for it", async () => {
  const closed = await serve("127.0.0.1:0", "--token", "secret words");
  const page = await open(SMALL(closed.address), "");
  await page.waitForSelector("#token-form");
  assert.match(await page.textContent("#token-form"), /needs a token/);
  await page.fill("#token", "wrong");
  await page.click("#token-form button");
  await page.waitForFunction(() => !document.querySelector("#token-form .error").textContent.includes("needs a token"));
  await page.fill("#token", "secret words");
  await page.click("#token-form button");
  await shown(page);
  await page.close();
  await stopped(closed.server);
});

test("a message says what a viewer's token may do, and a token of an earlier start", async () => {
  const tokens = ["controller", "viewer"].map((role) => spawnSync(program, ["token", "new", role, "--role", role], { encoding: "utf8" }).stdout.split("\n"));
  const file = join(folder, "tokens.toml");
  writeFileSync(file, `[tokens]\n${tokens.map(([, line]) => line).join("\n")}\n`);
  const closed = await serve("127.0.0.1:0", "--config", file);
  const grown = await open(`${SMALL(closed.address)}&token=${tokens[0][0]}`);
  const page = await open(`${closed.address}/#token=${tokens[1][0]}`, "");
  await page.waitForFunction(() => document.getElementById("message")?.textContent.startsWith("This page only watches: choose a plant under Server."));
  await page.click('[role="tab"]:has-text("Server")');
  await page.click("#simulations .link");
  await page.waitForFunction(() => Number(document.getElementById("plant").dataset.step) > 0);
  assert.equal(await page.textContent("#message"), "");
  assert.ok(await page.isDisabled("#step"));
  await page.close();

  const old = await open(`${closed.address}/#token=of-yesterday`, "");
  await old.waitForSelector("#token-form");
  assert.match(await old.textContent("#token-form"), /is of an earlier start of the server: use the token, or the link, that the server has now/);
  // another token makes the page whole
  await old.fill("#token", tokens[0][0]);
  await old.click("#token-form button");
  await shown(old);
  await old.close();
  await grown.close();
  await stopped(closed.server);
});

test("a message says that the server has stopped", async () => {
  const other = await serve();
  const page = await open(SMALL(other.address));
  await stopped(other.server);
  await page.waitForFunction(() => document.getElementById("message").textContent === "The server has stopped or cannot be reached. Trying again …");
  problems.length = 0; // the browser tells of each attempt
  await page.close();
});

test("the text is made wider and narrower, by mouse and by keys, and long lines go on below", async () => {
  const page = await open(SMALL());
  const width = () => page.evaluate(() => Math.round(document.querySelector(".text").getBoundingClientRect().width));
  const usual = await width();
  const divider = page.locator('[role="separator"]');
  const { x, y } = await divider.boundingBox();
  await page.mouse.move(x + 4, y + 60);
  await page.mouse.down();
  await page.mouse.move(x + 104, y + 80, { steps: 4 });
  await page.mouse.up();
  const wide = await width();
  assert.ok(Math.abs(wide - usual - 104) <= 8, `${usual}, then ${wide}`);
  // the arrows belong to the divider, not to time
  const step = await page.evaluate(() => studio.step);
  await divider.press("ArrowLeft");
  assert.equal(await width(), wide - 24);
  assert.equal(await page.evaluate(() => studio.step), step);
  // the whole of a long line can be read, and the width is still there when the page opens again
  assert.ok(await page.evaluate(() => { const code = document.querySelector(".cm-scroller"); return code.scrollWidth <= code.clientWidth + 1; }));
  await page.reload();
  await shown(page);
  assert.equal(await width(), wide - 24);
  await divider.dblclick({ position: { x: 4, y: 60 } });
  assert.equal(await width(), usual);
  await page.close();
});

/** Serious findings of axe on a page. */
async function seriousOf(page) {
  // the policy of the page allows no other script; the browser's own channel runs it
  await page.evaluate(readFileSync(join(here, "../node_modules/axe-core/axe.min.js"), "utf8"));
  return page.evaluate(async () => {
    const { violations } = await axe.run(document, { resultTypes: ["violations"] });
    return violations.filter(({ impact }) => impact === "serious" || impact === "critical").map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join("; ")}`);
  });
}

test("axe finds nothing serious, in light and dark, and the keyboard reaches everything", async () => {
  const page = await open(SMALL());
  for (const theme of ["light", "dark"]) {
    assert.deepEqual(await seriousOf(page), [], theme);
    await page.keyboard.press("d");
  }
  await page.keyboard.press("Home");
  await page.waitForFunction(() => studio.step === 0);
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(() => studio.step === 1);
  await page.keyboard.press("Home");
  await page.waitForFunction(() => studio.step === 0);
  // the window closes, and the keys are the page's again: Space runs the plant and opens no window
  await page.click('[aria-label="Keyboard (?)"]');
  await page.waitForSelector("dialog[open] .keys");
  await page.click("dialog [aria-label=Close]");
  await page.waitForFunction(() => !document.querySelector("dialog"));
  await page.keyboard.press(" ");
  await page.waitForFunction(() => studio.isFinished && !studio.isRunning && studio.step === studio.length);
  assert.equal(await page.locator("dialog").count(), 0);
  // a slider that was moved does not keep Space
  await page.evaluate(() => document.getElementById("scrub").focus());
  await page.keyboard.press(" ");
  await page.waitForFunction(() => studio.isRunning || studio.step < studio.length);
  await page.close();
});

test("no page had an error, or asked for anything that its policy forbids", () => {
  assert.deepEqual(problems.filter((text) => !/401|ERR_CONNECTION_REFUSED|WebSocket/.test(text)), []);
});
