// Control panels of published folders, and the edits that their messages make.

export interface PanelItem {
  type: "slider" | "button" | "label";
  name: string;
  x: number; // of the top left corner, in pixels
  y: number;
  low: number;
  high: number;
  value: number;
  message: string;
  colours: string[]; // outline and text, then bar or on
  group: number | null; // only one button of a group is on
}

export interface Panel {
  title: string;
  width: number;
  height: number;
  background: string;
  items: PanelItem[];
  problems: string[];
}

const HEIGHTS = { slider: 39, button: 24, label: 20 };
const colourOf = (word: string): string => (/^\d+,\d+,\d+$/.test(word) ? `rgb(${word})` : "");

/** Whether a text is a panel: both formats begin in a way of their own. */
export const isPanel = (text: string): boolean => /^\s*(?:target:[^\n]*\r?\n\s*)?panel name:/.test(text) && /^type:/m.test(text);

interface Reader {
  lines: string[];
  at: number;
}

/** The words behind a keyword, when the next line has it. */
function take(reader: Reader, keyword: string): string | null {
  while (reader.at < reader.lines.length && reader.lines[reader.at].trim() === "") {
    ++reader.at;
  }
  const line = reader.lines[reader.at] ?? "";
  if (!line.trimStart().startsWith(keyword)) {
    return null;
  }
  ++reader.at;
  return line.trimStart().slice(keyword.length).replace(/^ /, "").replace(/\r$/, "");
}

const numbers = (text: string | null): number[] => (text ?? "").trim().split(/\s+/).map(Number);

export function parsePanel(text: string): Panel {
  const reader: Reader = { lines: text.split("\n"), at: 0 };
  const isNew = take(reader, "target:") !== null;
  const panel: Panel = { title: take(reader, "panel name:") ?? "", width: 0, height: 0, background: "rgb(0,0,0)", items: [], problems: [] };
  take(reader, "colourmap:");
  panel.background = colourOf((take(reader, "background:") ?? "").trim()) || panel.background;
  const size = take(reader, "size:");
  [panel.width, panel.height] = size ? numbers(size) : [0, 0];
  take(reader, "font:");
  let group = 0;
  const members = new Map<string, number>();
  for (let type = take(reader, "type:"); type !== null; type = take(reader, "type:")) {
    const kind = type.trim().toLowerCase();
    if (kind === "group") {
      ++group;
      take(reader, "color:");
      while (reader.at < reader.lines.length && reader.lines[reader.at].trim() !== "ENDGROUP") {
        members.set(reader.lines[reader.at++].replace(/\r$/, "").trim(), group);
      }
      ++reader.at;
    } else if (kind === "slider" || kind === "button" || kind === "label") {
      panel.items.push(readItem(reader, kind));
    } else {
      if (kind !== "page" && kind !== "menu") {
        panel.problems.push(`line ${reader.at}: expected PAGE, SLIDER, BUTTON, LABEL, GROUP or MENU, found "${type.trim()}"`);
      }
      skipItem(reader);
    }
    if (!/^\s*type:/.test(reader.lines[reader.at] ?? "") && (reader.lines[reader.at] ?? "").trim() !== "") {
      panel.problems.push(`line ${reader.at + 1}: "${reader.lines[reader.at].trim()}" is not expected here`);
      skipItem(reader);
    }
  }
  for (const item of panel.items) {
    item.group = item.type === "button" ? (members.get(item.name) ?? null) : null;
    if (!isNew) {
      // the old format counts from the bottom
      item.y = panel.height - item.y - HEIGHTS[item.type];
    }
  }
  if (!size) {
    panel.width = Math.max(...panel.items.map(({ x }) => x + 150), 160);
    panel.height = Math.max(...panel.items.map(({ y }) => y + 48), 60);
  }
  return panel;
}

function skipItem(reader: Reader): void {
  while (reader.at < reader.lines.length && !/^\s*type:/.test(reader.lines[reader.at])) {
    ++reader.at;
  }
}

function readItem(reader: Reader, type: PanelItem["type"]): PanelItem {
  const name = take(reader, "name:") ?? "";
  const colours = (take(reader, "colors:") ?? take(reader, "tricolor:") ?? take(reader, "color:") ?? "").trim().split(/\s+/).map(colourOf);
  const [x, y] = numbers(take(reader, "origin:"));
  const [low, high] = type === "slider" ? numbers(take(reader, "min/max:")) : [0, 1];
  const value = type === "label" ? 0 : Number(take(reader, "value:") ?? 0);
  const message = type === "label" ? "" : (take(reader, "message:") ?? "");
  return { type, name, x: x || 0, y: y || 0, low, high, value, message, colours, group: null };
}

/** A number as a data file has it: six digits, no exponent. */
function numberText(value: number): string {
  const text = String(Number(value.toPrecision(6)));
  return text.includes("e") ? value.toFixed(12).replace(/0+$/, "").replace(/\.$/, "") : text;
}

/** Replaces the bytes of the `index`-th word (from 1) of a line; nothing when there is none. */
function withWord(line: string, index: number, word: string): string | null {
  const words = [...line.matchAll(/\S+/g)];
  const found = index === -1 ? words[words.length - 1] : words[index - 1];
  if (!found) {
    return null;
  }
  const old = found[0];
  // a comma or comment glued to the word stays
  const rest = /^[^,]*?(\/\*.*|,)?$/.exec(old)?.[1] ?? "";
  return line.slice(0, found.index) + word + rest + line.slice(found.index + old.length);
}

/** The text after a message of a panel. Throws when the message cannot be understood. Only the addressed lines change. */
export function applyMessage(text: string, message: string, value: number): string {
  if (/%(?![d%])/.test(message)) {
    throw new Error(`The message "${message}" has a format other than %d.`);
  }
  const words = message.replace(/%d/g, String(value)).replace(/%%/g, "%").trim().split(/\s+/);
  const lines = text.split("\n");
  const change = (line: number, index: number, word: string) => {
    const changed = lines[line - 1] === undefined ? null : withWord(lines[line - 1], index, word);
    if (changed === null) {
      throw new Error(`The message "${message}" names word ${index} of line ${line}, which the file does not have.`);
    }
    lines[line - 1] = changed;
  };
  const scaled = (number: string, divisor: string | undefined) => {
    const by = divisor === undefined ? 1 : Number(divisor);
    if (!by) {
      throw new Error(`The message "${message}" divides by zero.`);
    }
    return numberText(Number(number) / by);
  };
  if (words[0] === "d") {
    const macro = /^(\s*#define\s+)(\S+)/;
    lines.forEach((line, i) => {
      if (macro.exec(line)?.[2] === words[1]) {
        lines[i] = withWord(line, 3, scaled(words[2], words[3])) ?? `${line.trimEnd()} ${scaled(words[2], words[3])}`;
      }
    });
  } else if (words[0] === "n") {
    change(Number(words[1]), Number(words[2]), numberText(Number(words[4]) * 10 ** Number(words[3])));
  } else if (words[0] === "o") {
    change(Number(words[1]), -1, words[2]);
  } else if (/^\d+$/.test(words[0])) {
    change(Number(words[0]), Number(words[1]), scaled(words[2], words[3]));
  }
  return lines.join("\n");
}

/** The value that a slider's message would have written to make the text what it is; nothing when it cannot be told. */
export function valueInText(text: string, { message }: PanelItem): number | null {
  const macro = /^d (\S+) %d(?: (\S+))?\s*$/.exec(message.trim());
  const found = macro && new RegExp(`^\\s*#define\\s+${macro[1].replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}\\s+([-+.\\d]+)`, "m").exec(text);
  const value = found ? Number(found[1]) * Number(macro[2] ?? 1) : NaN;
  return Number.isFinite(value) ? Number(value.toPrecision(9)) : null;
}

/** The file that a panel edits: the one that the folder's menu pipes it to, else that of the same suffix. */
export function targetOf(files: Record<string, string>, panel: string, main: string): string {
  for (const menu of Object.values(files)) {
    const found = new RegExp(`panel\\s+${panel.replace(/[.]/g, "\\.")}[^|\\n]*\\|\\s*(?:awkped|ped)\\s+(?:-lstudio\\s+)?(\\S+)`).exec(menu);
    if (found && found[1] in files) {
      return found[1];
    }
  }
  const suffix = panel.slice(panel.lastIndexOf("."));
  const stem = main.replace(/\.\w+$/, "");
  return `${stem}${suffix}` in files ? `${stem}${suffix}` : main;
}
