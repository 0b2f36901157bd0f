// Panels and curves of published folders: what they read, and that an edit changes only its own bytes.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { timesOf } from "./webm.js";

const here = dirname(fileURLToPath(import.meta.url));

async function load(name) {
  const { outputFiles } = await build({ entryPoints: [join(here, "../src/studio", name)], tsconfig: join(here, "../tsconfig.json"), bundle: true, format: "esm", write: false });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

const panel = await load("panel.ts");
const curve = await load("curve.ts");
const model = await load("document.ts");
const palette = await load("palette.ts");
const surface = await load("surface.ts");
const turns = await load("turns.ts");
const { archiveOf } = await load("archive.ts");
const { Frames } = await load("frames.ts");
const { textOfError } = await load("plants.ts");
const { webmOf } = await load("webm.ts");

const NEW_PANEL = `target: Lsystem
panel name: Growth
background: 0,0,0
size: 210 320
font: Arial,14,-1,5,50,0,0,0,0,0

type: SLIDER
name: Leaves
colors: 255,255,255 0,160,0
origin: 24 40
min/max: 1 24
value: 8
message: d LEAVES %d 1

type: GROUP

Show
Hide
ENDGROUP

type: BUTTON
name: Show
origin: 10 90
value: 1
message: d SHOW 1 1

type: BUTTON
name: Hide
origin: 10 120
value: 0
message: d SHOW 0 1

type: KNOB
name: none

type: LABEL
name: shape
origin: 5 5
`;

test("an error of a step says what the model has printed before it", () => {
  const failed = Object.assign(new Error("step 2: A became NaN."), { data: { step: 1, printed: "x is 1\nx is -1\n" } });
  assert.equal(textOfError(failed), "step 2: A became NaN. The model printed: x is 1 · x is -1");
  assert.equal(textOfError(new Error("No answer.")), "No answer.");
});

test("a panel is read in both formats, and its mistakes are named", () => {
  assert.ok(panel.isPanel(NEW_PANEL));
  assert.ok(!panel.isPanel("Lsystem: 1\nAxiom: F\nendlsystem\n"));
  const read = panel.parsePanel(NEW_PANEL);
  assert.deepEqual([read.title, read.width, read.height], ["Growth", 210, 320]);
  assert.deepEqual(read.items.map(({ type, name, x, y, group }) => [type, name, x, y, group]), [
    ["slider", "Leaves", 24, 40, null],
    ["button", "Show", 10, 90, 1],
    ["button", "Hide", 10, 120, 1],
    ["label", "shape", 5, 5, null],
  ]);
  assert.equal(read.problems.length, 1);
  assert.match(read.problems[0], /KNOB/);
  const old = panel.parsePanel("panel name: Light\r\nbackground: 0\r\nsize: 160 84\r\n\r\ntype: SLIDER\r\nname: Shade\r\ncolors: 7 1\r\norigin: 12 30\r\nmin/max: 0 100\r\nvalue: 35\r\nmessage: d SHADE %d 100\r\n");
  // it counts from the bottom: 84 - 30 - 39
  assert.deepEqual([old.items[0].name, old.items[0].y, old.items[0].message], ["Shade", 15, "d SHADE %d 100"]);
});

test("a panel has pages and menu items, and a button that is on while it is pressed", () => {
  const item = (type, name, more) => `type: ${type}\nname: ${name}\n${more}`;
  const text = ["target: Lsystem", "panel name: Two", "size: 100 100", "", item("PAGE", "Leaves", "color: 1,2,3\norigin: 0 0\nmessage: d PAGE 1\n"), item("LABEL", "a", "origin: 1 2\n"),
    item("PAGE", "Stem", "message: d PAGE 2\n"), item("BUTTON", "b", "origin: 1 2\nvalue: 2\nmessage: d B %d\n"), item("MENU", "all", "message: d ALL 1\n")].join("\n");
  const read = panel.parsePanel(text);
  assert.deepEqual(read.pages, [{ name: "Leaves", message: "d PAGE 1" }, { name: "Stem", message: "d PAGE 2" }]);
  assert.deepEqual(read.items.map(({ type, name, page, value, message }) => [type, name, page, value, message]), [["label", "a", 0, 0, ""], ["button", "b", 1, 2, "d B %d"], ["menu", "all", 1, 0, "d ALL 1"]]);
  assert.deepEqual(read.problems, []);
});

test("a panel with a mistake keeps the items that can be read", () => {
  const head = "target: Lsystem\npanel name: Growth\nsize: 210 320\n\n";
  const slider = "type: SLIDER\nname: Leaves\norigin: 24 40\nmin/max: 1 24\nvalue: 8\nmessage: d LEAVES %d 1\n";
  const button = (name) => `\ntype: BUTTON\nname: ${name}\norigin: 10 10\nvalue: 0\nmessage: d SHOW 0 1\n`;
  const read = (text) => {
    const { items, problems } = panel.parsePanel(head + text);
    return [items.map(({ name, group }) => `${name}|${group ?? ""}`), problems];
  };
  const [unended, noEnd] = read(`type: GROUP\nA\nB\n${button("A")}${button("B")}\n${slider}`);
  assert.deepEqual([unended, noEnd], [["A|1", "B|1", "Leaves|"], ["line 5: the group has no ENDGROUP"]]);
  assert.deepEqual(read(`${button("A")}\ntype: GROUP\nA\nNobody\nENDGROUP\n${slider}`), [["A|1", "Leaves|"], ['line 14: the group names the button "Nobody", which its page does not have']]);
  // the same names on two pages, and a name with a blank at its end
  const page = (name) => `type: PAGE\nname: ${name}\nmessage: p 1\n${button("On")}${button("Off ")}\ntype: GROUP\nOn\nOff \nENDGROUP\n\n`;
  assert.deepEqual(read(page("one") + page("two")), [["On|1", "Off |1", "On|2", "Off |2"], []]);
  // limits and values
  assert.deepEqual(read(slider.replace("value: 8\n", "") + button("A")), [["A|"], ['line 9: expected a number behind value: of the slider "Leaves", found "message:"']]);
  assert.deepEqual(read(slider.replace("1 24", "1") + button("A")), [["A|"], ['line 9: expected two numbers behind min/max: of the slider "Leaves", found "value:"']]);
  assert.deepEqual(read(slider.replace("min/max: 1 24\nvalue: 8", "value: 8\nmin/max: 1 24") + button("A")), [["A|"], ['line 8: expected two numbers behind min/max: of the slider "Leaves", found "value:"']]);
  const swapped = panel.parsePanel(head + slider.replace("1 24", "24 1"));
  assert.deepEqual([swapped.items[0].low, swapped.items[0].high, swapped.problems.length], [1, 24, 1]);
  const worded = panel.parsePanel(head + slider.replace("value: 8", "value: eight"));
  assert.deepEqual([worded.items[0].value, worded.items[0].message], [1, "d LEAVES %d 1"]);
  assert.deepEqual(worded.problems, ['line 9: the value "eight" of the slider "Leaves" is no number']);
  assert.deepEqual(read(slider.replace("origin", "colours: 1,1,1\norigin"))[0], []);
  // line ends do not matter, a line that does not belong there does
  const lines = panel.parsePanel(head + slider.replace("origin: 24 40", "origin:\n24\n40"));
  assert.deepEqual([lines.items[0].x, lines.items[0].y, lines.problems], [24, 40, []]);
  assert.deepEqual(read(`${slider}\njunk\n${button("A")}`), [["Leaves|", "A|"], ['line 12: "junk" is not expected here']]);
});

test("a message changes the bytes of its word and nothing else", () => {
  const text = "#define  LEAVES\t8   /* of  a shoot */\r\n#define LEAVES2 8\n# define LEAVES 8\n  #define LEAVES 8\nswap interval: 2\nflag: off\n";
  assert.equal(panel.applyMessage(text, "d LEAVES %d 1", 9), text.replace("LEAVES\t8", "LEAVES\t9").replace("  #define LEAVES 8", "  #define LEAVES 9"));
  assert.equal(panel.applyMessage(text, "d LEAVES %d 100", 45), text.replace("LEAVES\t8", "LEAVES\t0.45").replace("  #define LEAVES 8", "  #define LEAVES 0.45"));
  assert.equal(panel.applyMessage(text, "n 5 3 -1 %d", 25), text.replace("interval: 2", "interval: 2.5"));
  assert.equal(panel.applyMessage(text, "o 6 on", 1), text.replace("flag: off", "flag: on"));
  assert.equal(panel.applyMessage(text, "d NONE %d 1", 9), text);
  assert.equal(panel.applyMessage("#define A 1\n", "d A %d 1000000", 1), "#define A 0.000001\n");
  assert.throws(() => panel.applyMessage(text, "d LEAVES %d 0", 9), /divides by zero/);
  assert.throws(() => panel.applyMessage(text, "d LEAVES %s 1", 9), /format other than %d/);
  assert.throws(() => panel.applyMessage(text, "d LEAVES %d%% 1", 9), /has "9%" where a number is expected/);
  assert.equal(panel.applyMessage("a: b\n", "o 1 %d%%", 9), "a: 9%\n");
  assert.equal(panel.applyMessage("at: 1,2, 3\n", "n 1 2 0 %d", 9), "at: 9, 3\n");
  assert.equal(panel.valueInText("#define L\n 12\n", { message: "d L %d 1" }), null);
  assert.throws(() => panel.applyMessage(text, "n 5 9 0 %d", 9), /does not have/);
  assert.equal(panel.valueInText("#define S 0.45\n", { message: "d S %d 100" }), 45);
});

test("the menu of the folder says which file a panel edits", () => {
  const files = { specifications: "a.l\n*\nL-system:\n\tpanel panel.l | awkped plant.v\n", "plant.l": "", "plant.v": "", "panel.l": "", "panel.v": "" };
  assert.deepEqual(panel.targetOf(files, "panel.l", "plant.l"), { file: "plant.v", editor: "awkped" });
  assert.deepEqual(panel.targetOf({ ...files, specifications: "" }, "panel.v", "plant.l"), { file: "plant.v", editor: "awkped" });
  assert.equal(panel.targetOf({ ...files, specifications: "\tpanel panel(1).l | awkped plant.v\n" }, "panel(1).l", "plant.l").file, "plant.v");
  const by = (command) => panel.targetOf({ ...files, specifications: `panel panel.v | ${command} plant.v` }, "panel.v", "plant.l").editor;
  assert.deepEqual([by("ped"), by("awkped -lstudio")], ["ped", "awkped -lstudio"]);
});

test("each editor of messages finds the number in its own way", () => {
  const text = "a\nb: off\nc: 1.5, 2 ,3 rest\nelasticity increment: 0.1\n";
  const ped = (message, value) => panel.applyMessage(text, message, value, "ped");
  assert.equal(ped("n 4 1 -2 %d", 35), text.replace("increment: 0.1", "increment: 0.3500"));
  assert.equal(ped("n 3 2 0 %d", 7), text.replace(", 2 ,", ", 7 ,"));
  assert.equal(ped("n 3 3 -1 %d", 45), text.replace(",3 rest", ",4.5000 rest"));
  assert.equal(ped("o 2 %d", 1), text.replace("b: off", "b: on"));
  assert.equal(ped("d a %d 1", 4), text);
  assert.throws(() => ped("n 1 1 0 %d", 9), /does not have/);
  assert.equal(panel.applyMessage(text, "n 4 3 -2 %d", 35), text.replace("0.1", "0.35"));
  assert.equal(panel.applyMessage(text, "4 1 %d 100", 35, "awkped -lstudio"), text.replace("0.1", "0.35"));
  // the slider shows what the file says
  assert.equal(panel.valueInText(text, { message: "n 4 1 -2 %d" }, "ped"), 10);
  assert.equal(panel.valueInText(text, { message: "n 4 3 -2 %d" }), 10);
  assert.equal(panel.valueInText(text, { message: "n 4 1 -2 %d" }), null);
});

test("a control point of a function moves, and the other lines keep their bytes", () => {
  const text = readFileSync(join(here, "../../gallery/lilac/height.func"), "utf8");
  const [read] = curve.parseCurves("height.func", text);
  assert.deepEqual(read.points.map(({ x, y }) => [x, y]), [[0, 0.75], [0.1, 1.05], [0.4, 0.9], [0.8, 0.35], [1, 0.12]]);
  const moved = curve.withPoint(text, read, 1, 0.25, 1.2);
  assert.equal(moved, text.replace("0.1 1.05 1", "0.25 1.2 1"));
  // x stays between the neighbours, and the ends stay at 0 and 1
  assert.equal(curve.withPoint(text, read, 1, 0.9, 1.05), text.replace("0.1 1.05 1", "0.4 1.05 1"));
  assert.equal(curve.withPoint(text, read, 4, 0.5, 0.2), text.replace("1.0 0.12 1", "1.0 0.2 1"));
  // an open spline begins and ends in its end points
  const line = curve.spline(read);
  assert.deepEqual([line[0], line.at(-1)], [[0, 0.75], [1, 0.12]]);
  assert.deepEqual(curve.parseCurves("a.l", text), []);
});

test("every function, contour and set of them opens, and a point that moves changes only its line", () => {
  const folders = ["../../gallery", "../../../tests/conformance/cases"].map((name) => join(here, name));
  const files = folders.flatMap((folder) => readdirSync(folder, { recursive: true }).filter((name) => /\.(func|fset|con|cset)$/.test(name)).map((name) => join(folder, name)));
  assert.ok(files.length >= 5 && files.some((name) => name.endsWith(".fset")), `${files.length} files`);
  for (const file of files) {
    const text = readFileSync(file, "utf8");
    const found = curve.parseCurves(file, text);
    assert.equal(found.length, text.match(/^points:/gm).length, file);
    for (const one of found) {
      one.points.forEach(({ x, y }, i) => {
        assert.equal(curve.withPoint(text, one, i, x, y).split("\n").length, text.split("\n").length);
        const changed = curve.withPoint(text, one, i, x, y + 0.125).split("\n").filter((line, k) => line !== text.split("\n")[k]);
        assert.equal(changed.length, 1, file);
      });
    }
  }
  const set = readFileSync(join(folders[1], "043-func-set-macros/set.fset"), "utf8");
  const [rise, fall] = curve.parseCurves("set.fset", set);
  assert.deepEqual([rise.name, fall.name], ["rise", "Fall"]);
  assert.equal(curve.withPoint(set, fall, 1, 0.4, 0.75), set.replace("0.400000 0.500000", "0.400000 0.75"));
});

test("every surface file opens, and a control point that moves changes only its own numbers", () => {
  const folders = ["../../gallery", "../../../tests/conformance/cases", "../../../tests/gltf"].map((name) => join(here, name));
  const files = folders.flatMap((folder) => readdirSync(folder, { recursive: true }).filter((name) => name.endsWith(".s")).map((name) => join(folder, name)));
  assert.ok(files.length >= 4, `${files.length} files`);
  for (const file of files) {
    const text = readFileSync(file, "utf8");
    const read = surface.parseSurface(file, text);
    assert.ok(read, file);
    // nothing moves: nothing is written
    for (const { points } of read.patches) {
      points.forEach((point) => assert.equal(surface.withPoints(text, surface.pointsAt(read, point.place), point.place), text));
    }
    const [point] = read.patches[0].points.slice(5);
    const moved = surface.withPoints(text, [point], [point.place[0], 7.25, point.place[2]]);
    const differ = moved.split("\n").filter((line, i) => line !== text.split("\n")[i]);
    assert.equal(differ.length, 1, file);
    assert.deepEqual(surface.parseSurface(file, moved).patches[0].points[5].place, [point.place[0], 7.25, point.place[2]]);
    // corners of the grid are corners of the patch
    const rows = surface.samplesOf(read.patches[0].points, 4);
    assert.deepEqual([rows[0][0], rows[4][4]], [read.patches[0].points[0].place, read.patches[0].points[15].place]);
  }
  const leaf = readFileSync(join(folders[0], "lilac/leaf.s"), "utf8");
  assert.equal(surface.parseSurface("leaf.s", leaf.replace("HEADING", "HEADNG")), null);
  assert.equal(surface.parseSurface("leaf.l", leaf), null);
  const tip = surface.parseSurface("leaf.s", leaf);
  const changed = surface.withPoints(leaf, surface.pointsAt(tip, [0, 1, -0.14]), [0, 0.9, -0.14]);
  assert.equal(changed, leaf.replace(/0 1 -0\.14/g, "0 0.9 -0.14"));
});

test("the specifications of a folder decide about its own model, and a forest has sliders for all its models", () => {
  const plain = { ...model.newDocument(), main: "tree.l", files: { "tree.l": "#define A 1\n", "fern.l": "#define B 2\n" } };
  assert.equal(model.modelOf(plain).main, "tree.l");
  const published = { ...plain, files: { ...plain.files, specifications: "tree.l\n*\n\tcpfg -a -m tree.map tree.l tree.v tree.a\n" } };
  assert.equal("main" in model.modelOf(published), false);
  assert.equal(model.modelOf({ ...published, main: "fern.l" }).main, "fern.l");
  assert.deepEqual(model.definesOfDocument(plain).map(({ name }) => name), ["A"]);
  const forest = model.withForest({ ...plain, environment: [{ type: "honda" }] }, { models: [{ name: "tree", file: "tree.l" }, { name: "fern", file: "fern.l" }], plants: [] });
  assert.deepEqual(model.definesOfDocument(forest).map(({ name }) => name), ["A", "B"]);
  assert.deepEqual(model.processesOf(forest.files["forest.json"]), [{ type: "honda" }]);
  assert.deepEqual(JSON.parse(model.withProcesses(forest, null).files["forest.json"]).environment, undefined);
});

test("plants that look the same have the same shape, also when a part has moved and another one has moved back", async () => {
  const { shapeOf } = await load("variations.ts");
  const rows = (values) => ({ count: 2, column: () => Float64Array.from(values) });
  const plant = (values) => ({ segments: rows(values), organs: rows([]), vertices: rows([]) });
  assert.equal(shapeOf(plant([1, 2])), shapeOf(plant([1, 2])));
  assert.notEqual(shapeOf(plant([1, 2])), shapeOf(plant([2, 1])));
});

test("sliders are moved faster than the page draws, and only the number changes", async () => {
  globalThis.location = { hash: "" };
  const { Studio } = await load("studio.ts");
  const studio = new Studio();
  studio.document = { ...studio.document, main: "m.l", files: { "m.l": "#define A 45 /* a */\n#define B 2\nLsystem: 1\n" } };
  const [drawn] = studio.defines; // as the page has drawn it
  [44.9, 100, 9, 45.1, 47].forEach((value) => studio.slide(drawn, value, 0.1, false));
  assert.equal(studio.document.files["m.l"], "#define A 47 /* a */\n#define B 2\nLsystem: 1\n");
});

test("sliders are made for numeric macros only, and write a number as it was meant", () => {
  const text = "#define A 0.5  /* half */\n#define B (A + 1)\n#define C(x) 2\n  #  define D -3 // three\n#define E 1e-2\n#define F x1\n";
  const found = model.definesOf("a.l", text);
  assert.deepEqual(found.map(({ name, value, comment, line }) => [name, value, comment, line]), [["A", 0.5, "half", 1], ["D", -3, "three", 4], ["E", 0.01, "", 5]]);
  found.forEach(({ from, to, value }) => assert.equal(Number(text.slice(from, to)), value));
  for (const value of [0.86, 34, -3, 0, 1, 250, 0.004]) {
    const { low, high, step } = model.guessedRange(value);
    assert.ok(low <= value && value <= high && step > 0, String(value));
  }
  assert.equal(model.numberText(0.30000000000000004, 0.01), "0.3");
  assert.equal(model.numberText(4e-13, 1e-15), "4e-13");
  assert.equal(model.guessedRange(1e308).high, Number.MAX_VALUE);
});

test("a colour changes three bytes of a colour map, and a part of a material its bytes of the last record", () => {
  const map = Uint8Array.from({ length: 768 }, (_, i) => i % 256);
  const text = Buffer.from(map).toString("base64");
  const changed = Buffer.from(palette.withColour("a.map", text, 7, [1, 2, 3]), "base64");
  assert.deepEqual([...changed.entries()].filter(([i, byte]) => byte !== map[i]), [[21, 1], [22, 2], [23, 3]]);
  const record = (index, diffuse, emission) => [index, 0, 9, 9, 9, ...diffuse, ...emission, 8, 8, 8, 20];
  const materials = Uint8Array.from([...record(3, [10, 20, 30], [5, 0, 0]), ...record(4, [1, 1, 1], [0, 0, 0]), ...record(3, [100, 0, 0], [10, 0, 0])]);
  const document = { main: "a.l", files: { specifications: "\tcpfg -M1 a.mat a.l a.v\n" }, binary: { "a.mat": Buffer.from(materials).toString("base64") } };
  assert.equal(palette.paletteFile(document), "a.mat");
  assert.deepEqual(palette.folderPalette(document).colours.slice(3, 6), [[110, 0, 0], [1, 1, 1], [255, 255, 255]]);
  // the command of the model counts, on it the kind of the last switch, and of several files the first 256 colours
  const files = (specifications, main = "b.l") => palette.paletteFile({ main, files: { specifications }, binary: { "a.map": "", "b.map": "", "c++.map": "", "b.mat": "" } });
  assert.equal(files("\tcpfg -m a.map a.l a.v\n\tcpfg -m b.map b.l b.v\n"), "b.map");
  assert.equal(files("\tcpfg -m a.map -M b.mat b.l b.v\n"), "b.mat");
  assert.equal(files("\tcpfg -M b.mat -m c++.map b.l b.v\n"), "c++.map");
  assert.equal(files("\tcpfg -m1 a.map -m2 b.map b.l b.v\n"), "a.map");
  assert.equal(files("#\tcpfg -m a.map b.l b.v\n\tcpfg -m b.map b.l b.v\n"), "b.map");
  assert.equal(files("\tcpfg -m a.map a.l a.v\n"), null);
  const painted = Buffer.from(palette.withColour("a.mat", document.binary["a.mat"], 3, [60, 5, 250]), "base64");
  assert.deepEqual([...painted.entries()].filter(([i, byte]) => byte !== materials[i]), [[35, 50], [36, 5], [37, 250]]);
  const shining = Buffer.from(palette.withMaterial(document.binary["a.mat"], 3, { shininess: 90, specular: [8, 200, 8], transparency: 7 }), "base64");
  assert.deepEqual([...shining.entries()].filter(([i, byte]) => byte !== materials[i]), [[31, 7], [42, 200], [44, 90]]);
  assert.deepEqual(palette.materialOf(shining.toString("base64"), 3), { transparency: 7, ambient: [9, 9, 9], diffuse: [100, 0, 0], emission: [10, 0, 0], specular: [8, 200, 8], shininess: 90 });
  // a material that the file does not have is white and dull, until it comes to its end
  const longer = Buffer.from(palette.withColour("a.mat", document.binary["a.mat"], 9, [1, 2, 3]), "base64");
  assert.deepEqual([...longer], [...materials, 9, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0]);
  // so does a colour of a short map
  const short = Buffer.from(palette.withColour("a.map", Buffer.from([1, 2, 3]).toString("base64"), 2, [7, 8, 9]), "base64");
  assert.deepEqual([...short], [1, 2, 3, 200, 200, 200, 7, 8, 9]);
});

test("a slice of a field has its cells, and the surface of a value is where the field has it", async () => {
  const { isoSurface, rangeOf, sliceOf } = await load("../view/fields.ts");
  const cells = [12, 10, 8];
  const centre = [1.5, 1.25, 1];
  const values = Float64Array.from({ length: 960 }, (_, i) => Math.hypot(((i % 12) + 0.5) * 0.25 - centre[0], ((Math.floor(i / 12) % 10) + 0.5) * 0.25 - centre[1], (Math.floor(i / 120) + 0.5) * 0.25 - centre[2]));
  const field = { name: "distance", unit: "m", cells, position: [0, 0, 0], cellSize: [0.25, 0.25, 0.25], values };
  const corners = isoSurface(field, 0.7);
  assert.ok(corners.length > 900 && corners.length % 9 === 0);
  let area = 0;
  for (let i = 0; i < corners.length; i += 9) {
    const [a, b, c] = [0, 3, 6].map((k) => [...corners.slice(i + k, i + k + 3)]);
    for (const point of [a, b, c]) {
      assert.ok(Math.abs(Math.hypot(...point.map((x, axis) => x - centre[axis])) - 0.7) < 0.03, String(point));
    }
    const [u, v] = [b, c].map((point) => point.map((x, axis) => x - a[axis]));
    area += Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
  }
  assert.ok(Math.abs(area / (4 * Math.PI * 0.49) - 1) < 0.06, `area ${area}`);
  // across y, in the middle: z to the right, or x; every value is the field's own
  const { right, up, width, height, values: found } = sliceOf(field, { axis: 1, place: 0.55, level: null });
  assert.deepEqual([right, up, width, height], [0, 2, 12, 8]);
  for (const [i, j] of [[0, 0], [11, 0], [3, 7]]) {
    assert.equal(found[j * 12 + i], values[i + 12 * (5 + 10 * j)]);
  }
  assert.equal(sliceOf(field, { axis: 2, place: 1, level: null }).values[0], values[120 * 7]);
  assert.deepEqual(rangeOf({ ...field, values: Float64Array.from([NaN, 2, -1]) }), [-1, 2]);
});

test("the environment of a document is a file of it, unless a published file says it", () => {
  const plain = { ...model.newDocument(), main: "tree.l", files: { "tree.l": "" } };
  const shaded = model.withProcesses(plain, [{ type: "shadow" }]);
  assert.deepEqual(JSON.parse(shaded.files["tree.json"]), { type: "shadow" });
  assert.deepEqual(model.withText(shaded, "tree.json", '[{"type": "honda"}, {"type": "wind"}]').environment, [{ type: "honda" }, { type: "wind" }]);
  assert.deepEqual(model.withText(shaded, "tree.json", "{").environment, [{ type: "shadow" }]);
  // with the last process the file goes too, so that the model does not find it again
  assert.deepEqual(Object.keys(model.withProcesses(shaded, null).files), ["tree.l"]);
  const published = { ...plain, files: { ...plain.files, "tree.e": "", "tree.json": "{}" }, environment: [{ type: "gallery", model: "tree" }], gallery: "tree" };
  assert.equal(model.withText(published, "tree.e", "changed").environment, null);
  assert.equal(model.withProcesses(published, [{ type: "honda" }]).files["tree.json"], "{}");
});

test("a value of more than a full turn is remarked on, where the number only turns", () => {
  const text = (value) => `#define ANGLE ${value}\n#define BEND ${value} /* ANGLE, too */\n#define SIZE 900\nLsystem: 1\nAxiom: F(SIZE)[+(ANGLE)F][&( -ANGLE )F]-(BEND*2) // ANGLE\n`;
  const remarks = (value) => {
    const document = { files: { "model.l": text(value), "README.md": "ANGLE is an angle" }, main: "model.l", binary: {}, environment: null, gallery: null, title: "" };
    return Object.fromEntries(model.definesOfDocument(document).map((define) => [define.name, turns.remarkOn(document, define)]));
  };
  assert.deepEqual(remarks(900), { ANGLE: "More than a full turn: 900° and 180° give the same plant.", BEND: null, SIZE: null });
  assert.equal(remarks(-400.5).ANGLE, "More than a full turn: -400.5° and -40.5° give the same plant.");
  assert.deepEqual(remarks(360), { ANGLE: null, BEND: null, SIZE: null });
});

test("an archive has the files as they were, for another program's reader", async () => {
  const files = new Map([["tree-seed-7.glb", Uint8Array.from({ length: 1000 }, (_, i) => i % 251)], ["Bäume.txt", new TextEncoder().encode("leer")], ["empty", new Uint8Array()]]);
  const place = mkdtempSync(join(tmpdir(), "espalier-archive-"));
  try {
    writeFileSync(join(place, "all.zip"), new Uint8Array(await archiveOf(files).arrayBuffer()));
    const read = spawnSync("python3", ["-c", "import json, sys, zipfile; z = zipfile.ZipFile(sys.argv[1]); print(json.dumps([z.testzip(), {n: z.read(n).hex() for n in z.namelist()}]))", join(place, "all.zip")], { encoding: "utf8" });
    assert.deepEqual(JSON.parse(read.stdout), [null, Object.fromEntries([...files].map(([name, bytes]) => [name, Buffer.from(bytes).toString("hex")]))], read.stderr);
  } finally {
    rmSync(place, { recursive: true });
  }
});

test("a film has all its pictures at their times, for another program's reader", async (context) => {
  const pictures = Array.from({ length: 150 }, (_, i) => ({ data: Uint8Array.of(i % 60 ? 1 : 0, 2, 3, i), milliseconds: 70 * i, isKey: i % 60 === 0 }));
  const bytes = new Uint8Array(await webmOf(pictures, "V_VP8", 320, 240, 10_500).arrayBuffer());
  assert.deepEqual(timesOf(bytes), pictures.map(({ milliseconds }) => milliseconds));
  const place = mkdtempSync(join(tmpdir(), "espalier-film-"));
  try {
    writeFileSync(join(place, "film.webm"), bytes);
    const read = spawnSync("ffprobe", ["-v", "error", "-show_entries", "format=format_name,duration:stream=codec_name:packet=size,flags", "-of", "compact", join(place, "film.webm")], { encoding: "utf8" });
    if (read.error) {
      context.diagnostic("ffprobe is not installed");
      return;
    }
    assert.match(read.stdout, /codec_name=vp8/);
    assert.match(read.stdout, /format_name=matroska,webm\|duration=10\.5/);
    assert.equal(read.stdout.match(/packet\|size=4\|flags=K/g).length, 3, read.stdout);
    assert.equal(read.stdout.match(/packet\|size=4/g).length, 150);
  } finally {
    rmSync(place, { recursive: true });
  }
});

test("changes of colours are taken back in the order in which they and the texts were made", async () => {
  const { Recolours } = await load("recolours.ts");
  const recolours = new Recolours();
  const [first, second] = [{ "a.l": "1" }, { "a.l": "2" }];
  recolours.add("a.map", "0", "1", first);
  recolours.add("a.map", "1", "2", { ...first }); // a drag goes on
  recolours.add("b.map", "x", "y", first);
  // the text was changed since: it is the editor's turn, until it has taken that back
  assert.equal(recolours.take(false, second), null);
  assert.deepEqual(recolours.take(false, first), { file: "b.map", bytes: "x" });
  assert.deepEqual(recolours.take(false, first), { file: "a.map", bytes: "0" });
  assert.equal(recolours.take(false, first), null);
  assert.deepEqual(recolours.take(true, first), { file: "a.map", bytes: "2" });
  assert.equal(recolours.take(true, second), null);
  recolours.add("a.map", "2", "3", second);
  assert.equal(recolours.take(true, second), null, "a new change forgets what was taken back");
});

test("a card that draws slowly is found, and a busy page is not taken for one", async () => {
  const { GpuClock } = await load("../view/frames.ts");
  globalThis.document = { hidden: false };
  const begins = [];
  const pause = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  const clockOf = (drawn, busy) => {
    const context = { SIGNALED: 1, SYNC_GPU_COMMANDS_COMPLETE: 0, SYNC_STATUS: 0, fenceSync: () => ({ begun: performance.now() }), flush() {}, deleteSync() {}, isContextLost: () => false };
    context.getSyncParameter = (sync) => (performance.now() - sync.begun >= drawn ? 1 : 0);
    const found = { slow: 0, ready: 0 };
    const clock = new GpuClock(context, () => ++found.slow, () => ++found.ready);
    clock.start();
    return { found, draw: () => { clock.begin(); for (const end = performance.now() + busy; performance.now() < end; ) begins.push(0); } };
  };
  for (const [drawn, busy, slow] of [[100, 0, 1], [0, 90, 0], [5, 0, 0]]) {
    const { found, draw } = clockOf(drawn, busy);
    for (let i = 0; i < 2; ++i) {
      draw();
      while (found.ready === i) {
        await pause(5);
      }
    }
    assert.equal(found.slow, slow, `${drawn} ms, busy for ${busy} ms`);
  }
  delete globalThis.document;
});

test("a frame that comes before the page has a view is shown, also when it is newer than the last answer", async () => {
  globalThis.requestAnimationFrame = (work) => setTimeout(work);
  globalThis.cancelAnimationFrame = clearTimeout;
  const shown = [];
  const view = { element: { dataset: {} }, setPalette() {}, forgetFit() {}, update: (geometry, change, step) => shown.push(step) };
  const studio = { view: null, palette: null, step: 9, answeredStep: 9, document: { files: {}, main: "model.l" }, changed() {}, stepped() {} };
  const frames = new Frames(studio);
  async function* one() {
    yield { geometry: {}, change: {}, step: 10, finished: true };
  }
  await frames.open({ stream: async (kind) => (kind === "columns" ? one() : (async function* () {})()) });
  frames.read();
  await new Promise((done) => setTimeout(done, 20));
  assert.deepEqual(shown, []);
  frames.stage(view);
  await new Promise((done) => setTimeout(done, 20));
  assert.deepEqual(shown, [10]);
  assert.equal(view.element.dataset.step, "10");
});

test("a held frame is shown when patience ends, and left out when it is on the way", async () => {
  globalThis.requestAnimationFrame = (work) => setTimeout(work);
  globalThis.cancelAnimationFrame = clearTimeout;
  const shownAfter = async (work, steps) => {
    const shown = [];
    const view = { element: { dataset: {} }, setPalette() {}, forgetFit() {}, update: (geometry, change, step) => shown.push(step) };
    const studio = { view, palette: null, step: 9, answeredStep: 9, document: { files: {}, main: "model.l" }, changed() {}, stepped() {} };
    const frames = new Frames(studio);
    async function* columns() {
      for (const step of steps) {
        yield { geometry: {}, change: {}, step, finished: true };
      }
    }
    await frames.open({ stream: async (kind) => (kind === "columns" ? columns() : (async function* () {})()) });
    void frames.hold(work);
    frames.read();
    await new Promise((done) => setTimeout(done, 1000));
    return shown;
  };
  // the answer of the work is late, and the last frame is newer than what the page knows
  assert.deepEqual(await shownAfter(() => new Promise(() => {}), [10]), [10]);
  assert.deepEqual(await shownAfter(() => new Promise((done) => setTimeout(done, 20)), [5, 9]), [9]);
});
