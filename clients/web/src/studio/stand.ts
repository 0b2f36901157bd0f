// Many plants of one model, each with a seed of its own, as files of an archive.
import { archiveOf } from "./archive.js";
import { createPlant } from "./plants.js";
import type { Studio } from "./studio.js";

export const MOST_PLANTS = 200;

/** The name of the file of a plant. */
export const nameOfPlant = (name: string, seed: number, suffix: string): string => `${name}-seed-${seed}.${suffix}`;

/**
 * Grows plants of the shown model to the shown step beside the shown one, with the seeds from `seed` on, and gives an archive of
 * their files. `told` hears how many there are. `signal` ends it early: the archive has the plants that were made.
 */
export async function standOf(studio: Studio, name: string, seed: number, count: number, suffix: string, told: (made: number) => void, signal: AbortSignal): Promise<Blob> {
  const until = studio.isFinished ? null : studio.step;
  const files = new Map<string, Uint8Array<ArrayBuffer>>();
  const helper = await createPlant(studio.client, studio.document, seed);
  try {
    for (let one = seed; one < seed + count && !signal.aborted; ++one) {
      await helper.reset(one);
      await (until === null ? helper.run() : helper.stepUntil(until));
      const file = await studio.fetchFile(`/simulations/${helper.id}/${name}.${suffix}`);
      files.set(nameOfPlant(name, one, suffix), new Uint8Array(await file.arrayBuffer()));
      told(files.size);
    }
  } finally {
    await helper.delete().catch(() => {});
  }
  return archiveOf(files);
}
