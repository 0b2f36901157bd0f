// Control panels of published folders, and the edits that their messages make.

export interface PanelItem {
  type: "slider" | "button" | "label" | "menu";
  page: number; // of Panel.pages; menu items belong to none
  name: string;
  x: number; // of the top left corner, in pixels
  y: number;
  low: number;
  high: number;
  value: number; // of a button 0, 1, or 2: it is on while it is pressed
  message: string;
  colours: string[]; // outline and text, then bar or on
  group: number | null; // only one button of a group is on
}

/** The program that writes a panel's messages into a file. They understand a message in different ways. */
export type PanelEditor = "awkped" | "awkped -lstudio" | "ped";

export interface Panel {
  title: string;
  width: number;
  height: number;
  background: string;
  items: PanelItem[];
  pages: Array<{ name: string; message: string }>; // one is shown at a time
  problems: string[];
}

const HEIGHTS = { slider: 39, button: 24, label: 20, menu: 0 };
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
  const panel: Panel = { title: take(reader, "panel name:") ?? "", width: 0, height: 0, background: "rgb(0,0,0)", items: [], pages: [], problems: [] };
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
    } else if (kind === "page") {
      const { name, message } = readItem(reader, "page");
      panel.pages.push({ name, message });
    } else if (kind === "slider" || kind === "button" || kind === "label" || kind === "menu") {
      panel.items.push({ ...readItem(reader, kind), type: kind, page: Math.max(panel.pages.length - 1, 0) });
    } else {
      panel.problems.push(`line ${reader.at}: expected PAGE, SLIDER, BUTTON, LABEL, GROUP or MENU, found "${type.trim()}"`);
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

function readItem(reader: Reader, type: PanelItem["type"] | "page"): Omit<PanelItem, "type" | "page"> {
  const name = take(reader, "name:") ?? "";
  const colours = (take(reader, "colors:") ?? take(reader, "tricolor:") ?? take(reader, "color:") ?? "").trim().split(/\s+/).map(colourOf);
  const [x, y] = numbers(take(reader, "origin:"));
  const [low, high] = type === "slider" ? numbers(take(reader, "min/max:")) : [0, 1];
  const value = type === "slider" || type === "button" ? Number(take(reader, "value:") ?? 0) : 0;
  const message = type === "label" ? "" : (take(reader, "message:") ?? "");
  return { name, x: x || 0, y: y || 0, low, high, value, message, colours, group: null };
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

/** The numbers of a line as `ped` counts them: behind the first colon, behind the first comma, behind the second. */
function pedNumber(line: string, index: number): { from: number; to: number } | null {
  const colon = line.indexOf(":");
  const commas = [...line.slice(colon + 1).matchAll(/,/g)].map((found) => colon + 1 + found.index);
  const before = index === 1 ? colon : (commas[index - 2] ?? -1);
  const number = before < 0 || index < 1 || index > 3 ? null : /^[ \t]*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)/.exec(line.slice(before + 1));
  return number && { from: before + 1 + number[0].length - number[1].length, to: before + 1 + number[0].length };
}

/** The text after a message of a panel. Throws when the message cannot be understood. Only the addressed words change. */
export function applyMessage(text: string, message: string, value: number, editor: PanelEditor = "awkped"): string {
  if (/%(?![d%])/.test(message)) {
    throw new Error(`The message "${message}" has a format other than %d.`);
  }
  const words = message.replace(/%d/g, String(value)).replace(/%%/g, "%").trim().split(/\s+/);
  const lines = text.split("\n");
  const isMissing = (line: string, index: string) => new Error(`The message "${message}" names word ${index} of line ${line}, which the file does not have.`);
  const change = (line: string, index: string, to: (line: string, index: number) => string | null) => {
    const changed = lines[Number(line) - 1] === undefined ? null : to(lines[Number(line) - 1], Number(index));
    if (changed === null) {
      throw isMissing(line, index);
    }
    lines[Number(line) - 1] = changed;
  };
  const word = (written: string) => (line: string, index: number) => {
    // this editor counts from behind the first colon
    const begin = editor === "awkped -lstudio" ? line.indexOf(":") + 1 : 0;
    const changed = withWord(line.slice(begin), index, written);
    return changed === null ? null : line.slice(0, begin) + changed;
  };
  const scaled = (number: string, divisor: string | undefined) => {
    const by = divisor === undefined ? 1 : Number(divisor);
    if (!by) {
      throw new Error(`The message "${message}" divides by zero.`);
    }
    return numberText(Number(number) / by);
  };
  const [kind, first, second, third, fourth] = words;
  if (editor === "ped") {
    if (kind === "n") {
      const exponent = Number(third);
      const written = exponent === 0 ? String(Math.round(Number(fourth))) : (Number(fourth) * 10 ** exponent).toFixed(4);
      change(first, second, (line, index) => {
        const place = pedNumber(line, index);
        return place && line.slice(0, place.from) + written + line.slice(place.to);
      });
    } else if (kind === "o") {
      change(first, "1", (line) => (line.includes(":") ? line.replace(/^([^:]*:[ \t]*)\S*/, `$1${Number(second) === 0 ? "off" : "on"}`) : null));
    }
  } else if (kind === "d") {
    const macro = /^(\s*#define\s+)(\S+)/;
    lines.forEach((line, i) => {
      if (macro.exec(line)?.[2] === first) {
        lines[i] = withWord(line, 3, scaled(second, third)) ?? `${line.trimEnd()} ${scaled(second, third)}`;
      }
    });
  } else if (kind === "n") {
    change(first, second, word(numberText(Number(fourth) * 10 ** Number(third))));
  } else if (kind === "o") {
    change(first, "-1", (line) => withWord(line, -1, second));
  } else if (/^\d+$/.test(kind)) {
    change(kind, first, word(scaled(second, third)));
  }
  return lines.join("\n");
}

/** The value that a slider's message would have written to make the text what it is; nothing when it cannot be told. */
export function valueInText(text: string, { message }: PanelItem, editor: PanelEditor = "awkped"): number | null {
  const macro = /^d (\S+) %d(?: (\S+))?\s*$/.exec(message.trim());
  const place = /^n (\d+) (\d+) (\S+) %d\s*$/.exec(message.trim());
  let value = NaN;
  if (macro && editor !== "ped") {
    const found = new RegExp(`^\\s*#define\\s+${macro[1].replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}\\s+([-+.\\d]+)`, "m").exec(text);
    value = found ? Number(found[1]) * Number(macro[2] ?? 1) : NaN;
  } else if (place) {
    const line = text.split("\n")[Number(place[1]) - 1] ?? "";
    const number = editor === "ped" ? pedNumber(line, Number(place[2])) : null;
    const words = (editor === "awkped -lstudio" ? line.slice(line.indexOf(":") + 1) : line).match(/\S+/g) ?? [];
    value = Number(number ? line.slice(number.from, number.to) : editor === "ped" ? NaN : words[Number(place[2]) - 1]) / 10 ** Number(place[3]);
  }
  return Number.isFinite(value) ? Number(value.toPrecision(9)) : null;
}

/** The file that a panel edits, and how: as the folder's menu pipes it, else the one of the same suffix. */
export function targetOf(files: Record<string, string>, panel: string, main: string): { file: string; editor: PanelEditor } {
  for (const menu of Object.values(files)) {
    const found = new RegExp(`panel\\s+${panel.replace(/[.]/g, "\\.")}[^|\\n]*\\|\\s*(awkped|ped)\\s+(-lstudio\\s+)?(\\S+)`).exec(menu);
    if (found && found[3] in files) {
      return { file: found[3], editor: found[1] === "ped" ? "ped" : found[2] ? "awkped -lstudio" : "awkped" };
    }
  }
  const suffix = panel.slice(panel.lastIndexOf("."));
  const stem = main.replace(/\.\w+$/, "");
  return { file: `${stem}${suffix}` in files ? `${stem}${suffix}` : main, editor: "awkped" };
}
