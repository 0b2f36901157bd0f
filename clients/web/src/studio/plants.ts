// Simulations of documents, and what can become of a server while a page is open: it refuses the token, it is full, and the
// files of its gallery change.
import { Code, ServerError } from "espalier";
import type { Client, Diagnostic, Simulation } from "espalier";
import { mainsOf, modelOf } from "./document.js";
import type { Document } from "./document.js";
import type { Studio } from "./studio.js";

type Values = Record<string, number | string>;

/** A simulation of a document at its step 0, in the place of `simulation` when that is given. `parameters`: values that win over its numbers. */
export function createPlant(client: Client, document: Document, seed: number, simulation?: string, parameters: Values = {}): Promise<Simulation> {
  const { gallery, title, environment } = document;
  return client.create({
    ...(simulation ? { simulation } : {}),
    model: gallery ? { gallery } : modelOf(document),
    ...(Object.keys(parameters).length ? { parameters } : {}),
    seed,
    name: title,
    save: "request",
    countProductions: true,
    ...(environment && !gallery ? { environment: environment as [] } : {}),
  });
}

/** A plant as it is: the text that its simulation has, the numbers that sliders have set beside it, and its state. */
export interface Kept {
  document: Document;
  parameters: Values;
  snapshot: string;
}

export async function keptOf(simulation: Simulation, document: Document): Promise<Kept> {
  const [snapshot, { model }] = await Promise.all([simulation.save(), simulation.get("model")]);
  const { files, forest, parameters } = model!;
  const texts = Object.fromEntries(Object.entries(files).map(([name, text]) => [name.split("/").pop()!, text]));
  return { document: { ...document, files: forest ? document.files : { ...document.files, ...texts }, gallery: null }, parameters: parameters ?? {}, snapshot };
}

/** Gives a simulation that was made of it its state; null: it is refused, as that of another text, or by an environment that restores none. */
export async function restored(simulation: Simulation, { snapshot }: Kept): Promise<{ step: number; finished: boolean } | null> {
  return simulation.restore(snapshot).catch((error) => {
    if (!(error instanceof ServerError)) {
      throw error;
    }
    return null;
  });
}

/** Takes a simulation off the server. */
export async function deleteSimulation(studio: Studio, simulation: string): Promise<void> {
  await studio.client.call("simulation.delete", { simulation });
  await studio.list();
}

/** Compiles all models of a document. */
export async function checkDocument(client: Client, document: Document): Promise<{ isValid: boolean; diagnostics: Diagnostic[] }> {
  const results = await Promise.all(mainsOf(document).map((main) => client.check({ ...modelOf(document), main })));
  return { isValid: results.every(({ valid }) => valid), diagnostics: results.flatMap(({ diagnostics }) => diagnostics) };
}

/** The server does not know the token, or not any more. A role that is missing is another trouble. */
export function isTokenRefused(error: unknown): boolean {
  return error instanceof ServerError && error.code === Code.unauthorised && !["role", "roles", "path"].some((name) => name in error.data);
}

/** A text of the gallery that has changed on the disk of the server since the page opened it stays as the page shows it. */
export async function keepText(studio: Studio): Promise<void> {
  const { document, client } = studio;
  if (!document.gallery || studio.shownTitle !== document.title) {
    return;
  }
  const changed = await changedOnDisk(client, document);
  if (changed.length > 0) {
    studio.document = { ...document, gallery: null };
    studio.say(`Changed on the server's disk: ${changed.join(", ")}. This page keeps its own text; choose the model in the gallery again for the new one.`, true);
  }
}

/**
 * The names of the files of a gallery model that are not on the server's disk as the page shows them; empty: all are. A model
 * that is not there any more has all of them.
 */
async function changedOnDisk(client: Client, { gallery, files, binary }: Document): Promise<string[]> {
  try {
    const now = await client.call("model.read", { gallery: gallery! });
    const differs = (mine: Record<string, string>, theirs: Record<string, string>) =>
      [...new Set([...Object.keys(mine), ...Object.keys(theirs)])].filter((name) => mine[name] !== theirs[name]);
    return [...differs(files, now.files), ...differs(binary, now.binaryFiles)];
  } catch (error) {
    if (error instanceof ServerError) {
      return Object.keys(files);
    }
    throw error;
  }
}

/** An error in words, with what the model has printed before it. */
export function textOfError(error: unknown): string {
  const { message, data } = error as Error & { data?: { printed?: string } };
  return `${message} ${textOfSteps({ printed: data?.printed })}`.trim();
}

/** What the model and its environments said in steps, as one line: warnings, then the last that was printed. */
export function textOfSteps({ warnings = [], printed = "" }: { warnings?: string[]; printed?: string }): string {
  const lines = printed.trim().split("\n").slice(-5);
  return [...warnings.map((text) => `Warning: ${text.split("\n")[0].replace(" warning:", "")}`), ...(printed.trim() ? [`The model printed: ${lines.join(" · ").slice(-300)}`] : [])].join(" ");
}
