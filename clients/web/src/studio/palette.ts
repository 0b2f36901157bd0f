// The colours that a published folder's command names: a colour map or a set of materials.
import type { ModelPalette } from "../view/colours.js";
import { fileOf } from "./document.js";
import type { Document } from "./document.js";

export const bytesOf = (base64: string): Uint8Array => Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));

const base64Of = (bytes: Uint8Array): string => btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ""));

type Colour = [number, number, number];

/** A material of a published folder. Colours and transparency from 0 to 255; shininess, the exponent of highlights, from 0 to 128. */
export interface Material {
  transparency: number;
  ambient: Colour;
  diffuse: Colour;
  emission: Colour;
  specular: Colour;
  shininess: number;
}

const UNDEFINED = 200; // bytes of a colour that a short map does not have
const RECORD_BYTES = 15; // of a material
const PLACES = { transparency: 1, ambient: 2, diffuse: 5, emission: 8, specular: 11, shininess: 14 } as const; // in a record
const UNNAMED: Material = { transparency: 0, ambient: [0, 0, 0], diffuse: [255, 255, 255], emission: [0, 0, 0], specular: [0, 0, 0], shininess: 0 };

/** The colour map or the materials that the folder's command names. */
export function paletteFile({ files, binary, main }: Document): string | null {
  const commands = (files["specifications"] ?? "").split("\n").filter((line) => /^[^#]*\b[cl]pfg\b/.test(line)).map((line) => line.trim().split(/\s+/));
  const command = commands.find((words) => words.includes(fileOf(main))) ?? [];
  const named = command.flatMap((name, i) => {
    const [, kind, number] = /^-([mM])(\d*)$/.exec(command[i - 1] ?? "") ?? [];
    return kind && name in binary ? [{ name, kind, isFirst: number === "" || number === "1" }] : [];
  });
  // the last switch says which kind counts; of several files, the first 256 colours
  const counting = named.filter(({ kind }) => kind === named.at(-1)!.kind);
  return counting.filter(({ isFirst }) => isFirst).at(-1)?.name ?? null;
}

/** Where the file has the record of a material; a later one wins. -1: nowhere. */
function recordAt(bytes: Uint8Array, index: number): number {
  for (let at = Math.floor(bytes.length / RECORD_BYTES - 1) * RECORD_BYTES; at >= 0; at -= RECORD_BYTES) {
    if (bytes[at] === index) {
      return at;
    }
  }
  return -1;
}

/** That of a number; one that the file does not have is white and dull. */
export function materialOf(base64: string, index: number): Material {
  const bytes = bytesOf(base64);
  const record = recordAt(bytes, index);
  if (record < 0) {
    return UNNAMED;
  }
  const colour = (place: number): Colour => [bytes[record + place], bytes[record + place + 1], bytes[record + place + 2]];
  const { transparency, ambient, diffuse, emission, specular, shininess } = PLACES;
  return {
    transparency: bytes[record + transparency],
    ambient: colour(ambient),
    diffuse: colour(diffuse),
    emission: colour(emission),
    specular: colour(specular),
    shininess: bytes[record + shininess],
  };
}

/** The file after parts of a material have changed: only their bytes differ. A material that the file does not have comes to its end. */
export function withMaterial(base64: string, index: number, parts: Partial<Material>): string {
  const before = bytesOf(base64);
  const found = recordAt(before, index);
  const record = found < 0 ? before.length - (before.length % RECORD_BYTES) : found;
  const bytes = new Uint8Array(Math.max(before.length, record + RECORD_BYTES));
  bytes.set(before);
  bytes[record] = index;
  for (const [name, value] of Object.entries(found < 0 ? { ...UNNAMED, ...parts } : parts)) {
    bytes.set([value].flat(), record + PLACES[name as keyof Material]);
  }
  return base64Of(bytes);
}

/** The palette of the folder; nothing when its `specifications` name none. */
export function folderPalette(document: Document): ModelPalette | null {
  const name = paletteFile(document);
  if (!name) {
    return null;
  }
  const bytes = bytesOf(document.binary[name]);
  const colours = Array.from({ length: 256 }, (_, index): Colour => {
    if (name.endsWith(".map")) {
      return [bytes[3 * index] ?? UNDEFINED, bytes[3 * index + 1] ?? UNDEFINED, bytes[3 * index + 2] ?? UNDEFINED];
    }
    const at = recordAt(bytes, index);
    // diffuse and emitted colour together
    return at < 0 ? UNNAMED.diffuse : ([5, 6, 7].map((i) => Math.min(255, bytes[at + i] + bytes[at + i + 3])) as Colour);
  });
  return { isOfModel: true, colours };
}

/** The file after a colour has changed: only its three bytes differ. */
export function withColour(name: string, base64: string, index: number, colour: Colour): string {
  if (!name.endsWith(".map")) {
    // a material shines by itself, too: its diffuse colour is the rest
    const { emission } = materialOf(base64, index);
    return withMaterial(base64, index, { diffuse: colour.map((value, i) => Math.max(0, value - emission[i])) as Colour });
  }
  const before = bytesOf(base64);
  const bytes = new Uint8Array(Math.max(before.length, 3 * (index + 1))).fill(UNDEFINED, before.length);
  bytes.set(before);
  bytes.set(colour, 3 * index);
  return base64Of(bytes);
}
