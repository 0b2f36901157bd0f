// The files of a model, and the numbers in them that sliders move.

import { ServerError } from "espalier";
import type { Client } from "espalier";

/** A model that is being edited. Contents are texts; bytes of other files stay in base64. */
export interface Document {
  title: string;
  main: string; // FILE or FILE:ENTRY
  files: Record<string, string>;
  binary: Record<string, string>;
  environment: unknown[] | null; // of simulation.create; null: none
  /** The gallery entry it came from, as long as nothing is changed: it may bring more than files. */
  gallery: string | null;
  /** The model of the server's disk that it is saved as. */
  saved?: { name: string; revision: string; files: string[] } | null;
}

/** A `#define NAME NUMBER` of a file. */
export interface Define {
  file: string;
  name: string;
  value: number;
  comment: string;
  line: number; // from 1
  from: number; // of the number's text, in the file
  to: number;
}

export const fileOf = (main: string): string => main.split(":")[0];

/** The file of a suffix that belongs to the model. */
export const besides = ({ main }: Document, suffix: string): string => fileOf(main).replace(/\.[^.]*$/, "") + suffix;
/** The file beside the model that has the environment as JSON. */
export const environmentFileOf = (document: Document): string => (FOREST in document.files ? FOREST : besides(document, ".json"));
/** The same of the published environments. */
export const publishedFileOf = (document: Document): string => besides(document, ".e");

/** The direction from the plant to the viewer that the view file says; null: it says none, or the front. */
export function directionToViewer(document: Document): number[] | null {
  const text = document.files[besides(document, ".v")] ?? "";
  const triple = (command: string) => {
    const found = [...text.matchAll(new RegExp(`^\\s*${command}:\\s*([^/\\r\\n]*)`, "gm"))].at(-1)?.[1];
    const numbers = found?.split(/[\s,]+/).filter(Boolean).slice(0, 3).map(Number);
    return numbers?.length === 3 && numbers.every(Number.isFinite) ? numbers : null;
  };
  const from = triple("viewpoint");
  const to = triple("view reference point") ?? [0, 0, 0];
  const direction = from?.map((value, i) => value - to[i]);
  return direction?.some((value, i) => i < 2 ? value !== 0 : value < 0) ? direction : null;
}

/** The processes that a configuration or a forest names; null: none, or no configuration. */
export function processesOf(text: string): unknown[] | null {
  try {
    const read = JSON.parse(text);
    const list = [read.models ? (read.environment ?? []) : read].flat().filter((one) => typeof one === "object");
    return list.length > 0 ? list : null;
  } catch {
    return null;
  }
}

/** Plants of several models, or at several places: their file beside the models. */
const FOREST = "forest.json";

/** The files of the models that a forest names; without a forest the main file. */
export function mainsOf({ main, files }: Document): string[] {
  try {
    const { models } = JSON.parse(files[FOREST] ?? "{}") as { models?: Array<{ file: string }> };
    return models ? models.map(({ file }) => file) : [main];
  } catch {
    return [main];
  }
}

/** The processes that a person wrote: a name, or JSON. Throws when it is neither. */
export function processesWritten(text: string): unknown[] | null {
  const trimmed = text.trim();
  return trimmed === "" ? null : /^[[{]/.test(trimmed) ? [JSON.parse(trimmed)].flat() : [{ type: trimmed }];
}

/** The document with other processes. Its file has them too, or goes with the last of them, unless a published file says them. */
export function withProcesses(document: Document, environment: unknown[] | null): Document {
  const file = environmentFileOf(document);
  const files = { ...document.files };
  if (file === FOREST) {
    const { environment: _, ...forest } = JSON.parse(files[FOREST]);
    files[FOREST] = `${JSON.stringify({ ...forest, ...(environment && { environment }) }, null, 2)}\n`;
  } else if (!(publishedFileOf(document) in files)) {
    delete files[file];
    Object.assign(files, environment && { [file]: `${JSON.stringify(environment.length === 1 ? environment[0] : environment, null, 2)}\n` });
  }
  return { ...document, environment, files, gallery: null };
}

/** The document with plants of several models, or at several places. */
export function withForest(document: Document, forest: Record<string, unknown>): Document {
  return withProcesses({ ...document, files: { ...document.files, [FOREST]: JSON.stringify(forest) } }, document.environment);
}

/** The document with another text of a file. An environment that stands in files follows them. */
export function withText(document: Document, file: string, text: string): Document {
  const files = { ...document.files, [file]: text };
  const isOfFiles = publishedFileOf(document) in files && document.environment?.every((one) => (one as { type?: string }).type === "gallery");
  const environment = isOfFiles ? null : file === environmentFileOf(document) ? (processesOf(text) ?? document.environment) : document.environment;
  return { ...document, files, environment, gallery: null };
}

const NUMBER = /^([ \t]*#[ \t]*define[ \t]+)([A-Za-z_]\w*)([ \t]+)([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)[ \t]*(?:\/\*([^*]*)\*\/|\/\/(.*))?[ \t]*\r?$/gm;

/** The numeric macros of a text, in its order. */
export function definesOf(file: string, text: string): Define[] {
  return [...text.matchAll(NUMBER)].map((match) => {
    const from = match.index + match[1].length + match[2].length + match[3].length;
    return {
      file,
      name: match[2],
      value: Number(match[4]),
      comment: (match[5] ?? match[6] ?? "").trim(),
      line: text.slice(0, match.index).split("\n").length,
      from,
      to: from + match[4].length,
    };
  });
}

/** The macros of the main file and of the files beside it that a C preprocessor reads. */
export function definesOfDocument(document: Document): Define[] {
  const mains = [...new Set(mainsOf(document).map(fileOf))];
  return [...mains, ...Object.keys(document.files).filter((name) => !mains.includes(name) && /\.(v|h|inc)$/.test(name))].flatMap((name) =>
    definesOf(name, document.files[name] ?? ""),
  );
}

/** A number as a person writes it: no more digits than the step of a slider has. */
export function numberText(value: number, step: number): string {
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  return String(digits > 12 ? Number(value.toPrecision(6)) : Number(value.toFixed(digits)));
}

/** A range for a slider around the value in the file. */
export function guessedRange(value: number): { low: number; high: number; step: number } {
  if (value === 0) {
    return { low: -1, high: 1, step: 0.01 };
  }
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 20) {
    return { low: value < 0 ? 2 * value : 0, high: value < 0 ? 0 : Math.max(2 * value, 5), step: 1 };
  }
  // numbers between 0 and 1 are often fractions
  const high = size < 1 && size >= 0.1 ? 1 : Math.min(2 * size, Number.MAX_VALUE);
  const step = 10 ** (Math.floor(Math.log10(high)) - 2);
  return { low: value < 0 ? -high : 0, high: value < 0 ? 0 : high, step };
}

/** Whether its view file names textures. */
export const hasTextures = ({ files }: Document): boolean => Object.values(files).some((text) => /^\s*texture:/m.test(text));

/** The model as the protocol takes it. The `specifications` of a published folder say more than the name of its model. */
export function modelOf({ files, binary, main }: Document): { files: Record<string, string>; binaryFiles: Record<string, string>; main?: string } {
  const command = /\b(?:cpfg|lpfg)\b.*/.exec(files["specifications"] ?? "")?.[0] ?? "";
  return { files, binaryFiles: binary, ...(command.split(/\s+/).includes(main) ? {} : { main }) };
}

export const EMPTY_MODEL = `/* A tree that forks. Change a number and look at the plant. */
#define ANGLE 32     /* degrees between the forks */
#define RATIO 0.78   /* length of a shoot, as a part of its mother's */
#define THINNER 0.7  /* width, likewise */
Lsystem: 1
derivation length: 9
Axiom: A(1,0.14)
A(s,w) : w > 0.004 --> !(w)F(s)[+(ANGLE)/(95)A(s*RATIO,w*THINNER)][-(ANGLE)/(95)A(s*RATIO,w*THINNER)]
endlsystem
`;

/** A model of the server's gallery. */
export async function galleryDocument(client: Client, name: string): Promise<Document> {
  const { main, files, binaryFiles, environment } = await client.call("model.read", { gallery: name });
  return { title: name, main, files, binary: binaryFiles, environment: environment ?? processesOf(files[FOREST] ?? ""), gallery: name };
}

/** The document of a page without a model in its address: a tree of the gallery whose buds ask for light, and shadow for it. */
export async function firstDocument(client: Client): Promise<Document> {
  try {
    return withProcesses(await galleryDocument(client, "light-tree"), [{ type: "shadow", shadowWeight: 0.1 }]);
  } catch (error) {
    if (error instanceof ServerError) {
      return newDocument(); // the server's gallery has other models
    }
    throw error;
  }
}

export function newDocument(): Document {
  return {
    title: "untitled",
    main: "model.l",
    files: { "model.l": EMPTY_MODEL, "model.v": "line style: cylinder\ninitial line width: 0.14\ninitial color: 60\n" },
    binary: {},
    environment: null,
    gallery: null,
  };
}

/** The texts in the order in which a person needs them: the model, its view, the rest. */
export function orderedFiles({ main, files }: Document): string[] {
  const first = fileOf(main);
  const rank = (name: string) => (name === first ? 0 : name.endsWith(".v") ? 1 : name === "README.md" ? 3 : 2);
  return Object.keys(files).sort((a, b) => rank(a) - rank(b) || a.localeCompare(b));
}
