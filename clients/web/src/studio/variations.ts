// Plants of a model for many values of its numbers, made beside the plant that is shown.
import type { Geometry, GeometryChange, Simulation } from "espalier";
import { guessedRange } from "./document.js";
import type { Define } from "./document.js";
import { createPlant } from "./plants.js";
import type { Studio } from "./studio.js";

export const SIDE = 6; // rows and columns

/** The value that changes along a side: a number of the model, or the seed. */
export interface Axis {
  name: string; // of a macro; "" is the seed
  low: number;
  high: number;
  step: number; // the values are multiples of it
}

export interface Variation {
  row: number;
  column: number;
  values: Record<string, number>;
  seed: number;
}

export interface Grown extends Variation {
  geometry: Geometry;
  change: GeometryChange;
}

/** A side about the value that a number has: six values that are near enough to be compared. */
export function axisOf(define: Define): Axis {
  const { low, high, step } = guessedRange(define.value);
  if (step === 1) {
    const first = Math.max(low, define.value - 3);
    return { name: define.name, low: first, high: first + SIDE - 1, step };
  }
  const reach = 0.4 * Math.abs(define.value) || 1;
  return { name: define.name, low: Math.max(low, define.value - reach), high: Math.min(high, define.value + reach), step };
}

export const seedAxis = (): Axis => ({ name: "", low: 0, high: SIDE - 1, step: 1 });

const valueOf = ({ low, high, step }: Axis, place: number): number => {
  const exact = low + ((high - low) * place) / (SIDE - 1);
  return Number((Math.round(exact / step) * step).toPrecision(12));
};

/** The plants of a table. Seeds along both sides are all different. */
export function variationsOf(across: Axis, down: Axis, seed: number): Variation[] {
  return Array.from({ length: SIDE * SIDE }, (_, i) => {
    const [row, column] = [Math.floor(i / SIDE), i % SIDE];
    const along = [[across, column], [down, row]] as const;
    const numbers = along.filter(([axis]) => axis.name !== "").map(([axis, place]) => [axis.name, valueOf(axis, place)]);
    const further = along.reduce((sum, [axis, place], side) => sum + (axis.name === "" ? place * (side === 1 && across.name === "" ? SIDE : 1) : 0), 0);
    return { row, column, values: Object.fromEntries(numbers) as Record<string, number>, seed: seed + further };
  });
}

/** Equal for plants that look the same. */
export function shapeOf({ segments, organs, vertices }: Geometry): string {
  // sums that notice what changed places
  const sum = (values: ArrayLike<number>) => Array.prototype.reduce.call(values, (all, value, i) => (all as number) + (value as number) * (1 + (i % 101)), 0);
  return [segments.count, organs.count, sum(segments.column("End")), sum(segments.column("EndWidth")), sum(segments.column("Colour")), sum(organs.column("Colour")), sum(vertices.column("Position"))].join(" ");
}

const HELPERS = 2; // simulations at once

/** Grows each plant to the step that is shown, and hands it over. Ends early when `signal` says so. */
export async function growVariations(studio: Studio, variations: Variation[], take: (grown: Grown) => void, signal: AbortSignal): Promise<void> {
  const until = studio.isFinished ? null : studio.step;
  const waiting = [...variations];
  await Promise.all(
    Array.from({ length: HELPERS }, async () => {
      const helper = await createPlant(studio.client, studio.document, studio.seed);
      try {
        for (let next = waiting.shift(); next && !signal.aborted; next = waiting.shift()) {
          take({ ...next, ...(await grow(helper, next, until, signal)) });
        }
      } catch (error) {
        if (!signal.aborted) {
          throw error;
        }
      } finally {
        await helper.delete().catch(() => {});
      }
    }),
  );
}

async function grow(helper: Simulation, { values, seed }: Variation, until: number | null, signal: AbortSignal): Promise<{ geometry: Geometry; change: GeometryChange }> {
  // one round trip: the server does them in order
  const derived = [Object.keys(values).length ? helper.set(values) : null, helper.reset(seed), until === null ? helper.run({ signal }) : helper.stepUntil(until, { signal })];
  const opened = helper.stream("columns", { credits: 1, precision: "single" });
  await Promise.all(derived);
  const stream = await opened;
  for await (const { geometry, change, step } of stream) {
    if (step === (await derived[2]!).step) {
      return { geometry, change };
    }
  }
  throw new Error("The server ended a plant of the table. Open the table again.");
}

/** Takes the numbers and the seed of a plant over, as sliders do. `steps`: of the digits that are written. */
export async function takeOver(studio: Studio, { values, seed }: Variation, steps: Record<string, number>): Promise<void> {
  for (const [name, value] of Object.entries(values)) {
    const define = studio.defines.find((one) => one.name === name);
    if (define) {
      studio.slide(define, value, steps[name] ?? 0.01, true);
    }
  }
  if (seed !== studio.seed) {
    await studio.setSeed(seed);
  }
}
