// The colours that a published folder's command names: a colour map or a set of materials.
import type { ModelPalette } from "../view/colours.js";
import type { Document } from "./document.js";

const bytesOf = (base64: string): Uint8Array => Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));

/** The palette of the folder; nothing when its `specifications` name none. */
export function folderPalette({ files, binary }: Document): ModelPalette | null {
  const command = files["specifications"] ?? "";
  const named = (suffix: string) => Object.keys(binary).find((name) => name.endsWith(suffix) && new RegExp(`-[mM]\\d*\\s+${name}`).test(command));
  const map = named(".map");
  if (map) {
    const bytes = bytesOf(binary[map]);
    return { isOfModel: true, colours: Array.from({ length: 256 }, (_, i) => [bytes[3 * i] ?? 200, bytes[3 * i + 1] ?? 200, bytes[3 * i + 2] ?? 200]) };
  }
  const materials = named(".mat");
  if (!materials) {
    return null;
  }
  const colours: ModelPalette["colours"] = Array.from({ length: 256 }, () => [255, 255, 255]);
  const bytes = bytesOf(binary[materials]);
  for (let i = 0; i + 15 <= bytes.length; i += 15) {
    // diffuse and emitted colour together
    colours[bytes[i]] = [5, 6, 7].map((at) => Math.min(255, bytes[i + at] + bytes[i + at + 3])) as [number, number, number];
  }
  return { isOfModel: true, colours };
}
