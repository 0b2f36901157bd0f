// Plants from columns: whatever a frame changes, the meshes are those of a view that sees the last frame alone.
import assert from "node:assert/strict";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));

async function load() {
  const contents = `export { Plants } from "./plants.js"; export { Bounds } from "./measures.js"; export { Vector3 } from "three"; export { Geometry } from "espalier";`;
  const { outputFiles } = await build({
    stdin: { contents, resolveDir: join(here, "../src/view"), loader: "ts" },
    tsconfig: join(here, "../tsconfig.json"),
    bundle: true,
    format: "esm",
    write: false,
  });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

const { Plants, Bounds, Vector3, Geometry } = await load();
const SYMBOLS = ["F", "G", "L", "X"];
const NEW = 0xffffffff;

/** Numbers at random, the same in every run (Park and Miller, 1988). */
function random(seed) {
  let state = seed;
  const next = () => (state = (state * 48271) % 0x7fffffff) / 0x7fffffff;
  return { below: (n) => Math.floor(next() * n), real: (scale) => (next() - 0.5) * scale };
}

/** A row of segments, or an organ of one triangle. The value of `born` is the step. */
function made({ below, real }, born, module) {
  const point = () => [real(10), real(10), real(10)];
  return { born, Plant: below(3), Module: module, Symbol: below(4), Colour: below(4) ? 128 : below(200), Order: below(born > 30 ? 14 : 4), Start: point(), End: point(), Width: below(9) / 8, corners: [point(), point(), point()] };
}

const segmentsOf = (rows) => ({
  ...Object.fromEntries(["Plant", "Module", "Symbol", "Colour", "Order"].map((name) => [`segment${name}`, rows.map((row) => row[name])])),
  segmentStart: rows.flatMap((row) => row.Start),
  segmentEnd: rows.flatMap((row) => row.End),
  segmentStartWidth: rows.map((row) => row.Width),
  segmentEndWidth: rows.map((row) => row.Width / 2),
});
const organsOf = (rows) => ({
  ...Object.fromEntries(["Plant", "Module", "Symbol", "Colour", "Order"].map((name) => [`organ${name}`, rows.map((row) => row[name])])),
  organKind: rows.map(() => 1),
  organVertices: rows.map(() => 3),
  organTriangles: rows.map(() => 1),
  vertices: rows.flatMap((row) => row.corners.flat()),
  triangles: rows.flatMap(() => [0, 1, 2]),
});

/** Some rows of a table stay, some go, some are new; the modules of what stays may be counted anew. */
function grown(numbers, before, step) {
  const runs = [];
  const rows = [];
  const fresh = [];
  let at = 0;
  while (at < before.length || numbers.below(3) === 0) {
    const count = 1 + numbers.below(40);
    const choice = numbers.below(8);
    if (choice < 1 + (before.length < 200)) {
      const added = Array.from({ length: 1 + numbers.below(4) }, () => made(numbers, step, numbers.below(1000)));
      runs.push([NEW, added.length, 0]);
      fresh.push(...added);
      rows.push(...added);
      at += numbers.below(2) * added.length; // in the place of others, or between them
    } else if (at < before.length) {
      const kept = before.slice(at, at + count);
      const shift = numbers.below(4) ? 0 : 1;
      runs.push([at, kept.length, shift]);
      rows.push(...kept.map((row) => ({ ...row, Module: row.Module + shift })));
      at += kept.length + (numbers.below(6) ? 0 : 1 + numbers.below(4)); // some go
    }
  }
  return { runs: runs.flat(), rows, fresh };
}

const used = (attribute, rows) => Array.from(attribute?.array.subarray(0, rows * attribute.itemSize) ?? []);
function seen(plants) {
  const { segmentStart, segmentEnd, segmentWidths, segmentColour } = plants.tubes.mesh.geometry.attributes;
  const count = plants.tubes.count;
  const organs = plants.organs.mesh.geometry;
  return {
    count,
    tubes: [segmentStart, segmentEnd, segmentWidths, segmentColour].map((one) => used(one, count)),
    organs: ["position", "normal", "color"].map((name) => used(organs.attributes[name], 3 * plants.organs.count)),
    bounds: [plants.bounds.min.toArray(), plants.bounds.max.toArray()],
    legend: plants.legend,
  };
}

for (const mode of ["model", "order", "age", "plant", "symbol"]) {
  test(`differences leave the plants of the last frame, coloured by ${mode}`, () => {
    const numbers = random(mode.length * 7919);
    const [plants, geometry] = [new Plants(), new Geometry()];
    let segments = Array.from({ length: 100 }, (_, i) => made(numbers, 0, i));
    let organs = Array.from({ length: 20 }, (_, i) => made(numbers, 0, i));
    plants.update(geometry, geometry.apply({ form: "whole", widths: "world", symbols: SYMBOLS, ...segmentsOf(segments), ...organsOf(organs) }, {}), 0, mode);
    for (let step = 1; step < 60; ++step) {
      const [newSegments, newOrgans] = [grown(numbers, segments, step), grown(numbers, organs, step)];
      [segments, organs] = [newSegments.rows, newOrgans.rows];
      const text = { form: "difference", widths: "world", symbols: SYMBOLS, ...segmentsOf(newSegments.fresh), ...organsOf(newOrgans.fresh) };
      plants.update(geometry, geometry.apply({ ...text, segmentRuns: newSegments.runs, organRuns: newOrgans.runs }, {}), step, mode);

      const [whole, alone] = [new Plants(), new Geometry()];
      whole.update(alone, alone.apply({ form: "whole", widths: "world", symbols: SYMBOLS, ...segmentsOf(segments), ...organsOf(organs) }, {}), step, mode);
      if (mode === "age") {
        for (const [kind, rows] of Object.entries({ segments, organs })) {
          whole.births[kind].replace(rows.length, () => rows.map((row) => row.born));
        }
        whole.repaint(mode);
      }
      // where little changed, the bounds may hold places that were left
      assert.ok(plants.bounds.containsBox(whole.bounds), `step ${step}`);
      assert.deepEqual({ ...seen(plants), bounds: null }, { ...seen(whole), bounds: null }, `step ${step}`);
      if (step % 5 === 0) {
        plants.tighten();
        assert.deepEqual(plants.bounds, whole.bounds, `step ${step}`);
      }
    }
  });
}

test("a frame that changes few rows paints and sends few", () => {
  const numbers = random(1);
  const [plants, geometry] = [new Plants(), new Geometry()];
  const rows = Array.from({ length: 10_000 }, (_, i) => ({ ...made(numbers, 0, i), Order: i % 4 }));
  plants.update(geometry, geometry.apply({ form: "whole", widths: "world", symbols: SYMBOLS, ...segmentsOf(rows), ...organsOf([]) }, {}), 0, "model");
  const { attributes } = plants.tubes.mesh.geometry;
  Object.values(attributes).forEach((one) => one.clearUpdateRanges());
  const fresh = { ...made(numbers, 1, 5000), Plant: rows[5000].Plant, Order: 1, Colour: 128 };
  const text = { form: "difference", widths: "world", symbols: SYMBOLS, ...segmentsOf([fresh]), ...organsOf([]) };
  plants.update(geometry, geometry.apply({ ...text, segmentRuns: [0, 5000, 0, NEW, 1, 0, 5001, 4999, 0], organRuns: [] }, {}), 1, "model");
  for (const name of ["segmentStart", "segmentEnd", "segmentWidths", "segmentColour"]) {
    assert.deepEqual(attributes[name].updateRanges, [{ start: 5000 * attributes[name].itemSize, count: attributes[name].itemSize }]);
  }
});

test("a segment that goes at the end takes its place out of the bounds", () => {
  const numbers = random(2);
  const [plants, geometry] = [new Plants(), new Geometry()];
  const rows = Array.from({ length: 40 }, (_, i) => made(numbers, 0, i));
  rows[38].End = [0, 100, 0];
  const whole = { form: "whole", widths: "world", symbols: SYMBOLS, ...segmentsOf(rows), ...organsOf([]) };
  plants.update(geometry, geometry.apply(whole, {}), 0, "model");
  assert.equal(plants.bounds.max.y, 100);
  const none = { form: "difference", widths: "world", symbols: SYMBOLS, ...segmentsOf([]), ...organsOf([]) };
  plants.update(geometry, geometry.apply({ ...none, segmentRuns: [0, 38, 0], organRuns: [] }, {}), 1, "model");
  assert.ok(plants.bounds.max.y <= 5);
});

test("a camera sees all of a plant from all sides, and is not much farther than it must be", () => {
  const numbers = random(11);
  for (let round = 0; round < 20; ++round) {
    // a crown on a stem
    const points = Array.from({ length: 400 }, (_, i) => (i < 100 ? [0, i / 50, 0] : [numbers.real(3), 2 + numbers.real(2), numbers.real(3)]));
    const bounds = new Bounds();
    bounds.update([points.flat()], points.length, [{ begin: 0, end: points.length }]);
    const centre = new Vector3(0, 1.5, 0);
    const [across, up] = [0.2 + numbers.below(5) / 10, 0.3];
    const tilt = numbers.real(2);
    const distance = bounds.distanceToSee(centre, new Vector3(0, Math.sin(tilt), Math.cos(tilt)), across, up);
    /** The largest part of half the picture that a point needs, over a turn. */
    const reach = (away) => {
      let most = 0;
      for (let turn = 0; turn < 2 * Math.PI; turn += 0.1) {
        const toCamera = new Vector3(Math.sin(turn) * Math.cos(tilt), Math.sin(tilt), Math.cos(turn) * Math.cos(tilt));
        const right = new Vector3(Math.cos(turn), 0, -Math.sin(turn));
        const over = toCamera.clone().cross(right);
        for (const point of points) {
          const from = new Vector3(...point).sub(centre);
          const depth = away - from.dot(toCamera);
          most = Math.max(most, Math.abs(from.dot(right)) / depth / across, Math.abs(from.dot(over)) / depth / up);
        }
      }
      return most;
    };
    assert.ok(reach(distance) <= 1 + 1e-9, `${reach(distance)} at ${tilt}`);
    assert.ok(reach(0.6 * distance) > 1, `${reach(0.6 * distance)} at ${tilt}`);
  }
});
