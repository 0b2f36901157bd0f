// Numbers of a model that only turn the turtle, and what a person should know about their values.
import { definesOf } from "./document.js";
import type { Define, Document } from "./document.js";

const FULL = 360;

/** Whether every use of a macro in the texts of the model is the whole argument of a turn, as in +(NAME) or &(-NAME). */
export function isTurn({ files }: Document, name: string): boolean {
  let uses = 0;
  let turns = 0;
  for (const [file, text] of Object.entries(files)) {
    if (/\.(md|json)$/.test(file)) {
      continue;
    }
    const code = text.replace(/\/\*[\s\S]*?\*\/|\/\/.*/g, "");
    uses += code.match(new RegExp(`\\b${name}\\b`, "g"))?.length ?? 0;
    uses -= definesOf(file, text).filter((define) => define.name === name).length;
    turns += code.match(new RegExp(`[-+&^\\\\/]\\(\\s*-?\\s*${name}\\s*\\)`, "g"))?.length ?? 0;
  }
  return uses > 0 && uses === turns;
}

/** A remark for a person on the value of a number; null: none. */
export function remarkOn(document: Document, { name, value }: Define): string | null {
  if (Math.abs(value) <= FULL || !isTurn(document, name)) {
    return null;
  }
  return `More than a full turn: ${value}° and ${Number((value % FULL).toPrecision(12))}° give the same plant.`;
}
