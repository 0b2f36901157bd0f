// The colours that a published folder's command names: a colour map or a set of materials.
import type { ModelPalette } from "../view/colours.js";
import type { Document } from "./document.js";

export const bytesOf = (base64: string): Uint8Array => Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));

const base64Of = (bytes: Uint8Array): string => btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ""));

const RECORD_BYTES = 15; // of a material

/** The colour map or the materials that the folder's command names. */
export function paletteFile({ files, binary }: Document): string | null {
  const command = files["specifications"] ?? "";
  const named = (suffix: string) => Object.keys(binary).find((name) => name.endsWith(suffix) && new RegExp(`-[mM]\\d*\\s+${name}`).test(command));
  return named(".map") ?? named(".mat") ?? null;
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

/** The palette of the folder; nothing when its `specifications` name none. */
export function folderPalette(document: Document): ModelPalette | null {
  const name = paletteFile(document);
  if (!name) {
    return null;
  }
  const bytes = bytesOf(document.binary[name]);
  const colours = Array.from({ length: 256 }, (_, index): [number, number, number] => {
    if (name.endsWith(".map")) {
      return [bytes[3 * index] ?? 200, bytes[3 * index + 1] ?? 200, bytes[3 * index + 2] ?? 200];
    }
    const at = recordAt(bytes, index);
    // diffuse and emitted colour together
    return at < 0 ? [255, 255, 255] : ([5, 6, 7].map((i) => Math.min(255, bytes[at + i] + bytes[at + i + 3])) as [number, number, number]);
  });
  return { isOfModel: true, colours };
}

/** The file after a colour has changed: only its three bytes differ. Nothing when the file has no such material. */
export function withColour(name: string, base64: string, index: number, colour: [number, number, number]): string | null {
  const bytes = bytesOf(base64);
  const record = name.endsWith(".map") ? 3 * index : recordAt(bytes, index);
  if (record < 0 || record + 3 > bytes.length) {
    return null;
  }
  const at = name.endsWith(".map") ? record : record + 5;
  // a material shines by itself, too: its diffuse colour is the rest
  colour.forEach((value, i) => (bytes[at + i] = name.endsWith(".map") ? value : Math.max(0, value - bytes[at + i + 3])));
  return base64Of(bytes);
}
