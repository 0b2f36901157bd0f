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
export const isPanel = (text: string): boolean => /^\s*(?:target:[^\r\n]*[\r\n]\s*)?panel name:/.test(text) && /^type:/m.test(text);

/** A place in the text of a panel. */
class Reader {
  private at = 0;
  private lineAt = 0; // the place that `lineThere` is the line of
  private lineThere = 1;

  constructor(private readonly text: string) {}

  get line(): number {
    this.lineThere += this.text.slice(this.lineAt, this.at).split("\n").length - 1;
    this.lineAt = this.at;
    return this.lineThere;
  }
  /** The next word, wherever its line is; "" at the end. */
  peek(): string {
    this.at += /^\s*/.exec(this.text.slice(this.at))![0].length;
    return /^\S*/.exec(this.text.slice(this.at))![0];
  }
  word(): string {
    const word = this.peek();
    this.at += word.length;
    return word;
  }
  isNext(keyword: string): boolean {
    this.peek();
    return this.text.startsWith(keyword, this.at);
  }
  take(keyword: string): boolean {
    const isNext = this.isNext(keyword);
    this.at += isNext ? keyword.length : 0;
    return isNext;
  }
  /** The rest of the line, blanks included. */
  rest(): string {
    const end = this.text.indexOf("\n", this.at);
    const rest = this.text.slice(this.at, end < 0 ? undefined : end);
    this.at = end < 0 ? this.text.length : end + 1;
    return rest;
  }
  /** The text behind a keyword without its first character; nothing when another keyword is next. */
  textOf(keyword: string): string | null {
    return this.take(keyword) ? this.rest().slice(1) : null;
  }
  colours(...keywords: string[]): string[] {
    const colours: string[] = [];
    if (keywords.some((keyword) => this.take(keyword))) {
      while (this.peek() !== "" && !this.peek().includes(":")) {
        colours.push(colourOf(this.word()));
      }
    }
    return colours;
  }
  /** The numbers behind a keyword; nothing when one of them is missing. */
  numbers(keyword: string, count: number): number[] | null {
    const numbers: number[] = [];
    if (this.take(keyword)) {
      while (numbers.length < count && Number.isFinite(Number(this.peek() || NaN))) {
        numbers.push(Number(this.word()));
      }
    }
    return numbers.length === count ? numbers : null;
  }
  /** Passes the lines before the next item. */
  skipItem(): void {
    while (this.peek() !== "" && !this.isNext("type:")) {
      this.rest();
    }
  }
}

export function parsePanel(text: string): Panel {
  const reader = new Reader(text.replace(/\r\n?/g, "\n"));
  const isNew = reader.textOf("target:") !== null;
  const panel: Panel = { title: reader.textOf("panel name:") ?? "", width: 0, height: 0, background: "rgb(0,0,0)", items: [], pages: [], problems: [] };
  const groups: Member[][] = [];
  reader.textOf("colourmap:");
  panel.background = reader.colours("background:")[0] || panel.background;
  const size = reader.numbers("size:", 2);
  [panel.width, panel.height] = size ?? [0, 0];
  reader.textOf("font:");
  while (reader.peek() !== "") {
    if (!reader.take("type:")) {
      panel.problems.push(`line ${reader.line}: "${reader.rest().trim()}" is not expected here`);
      reader.skipItem();
      continue;
    }
    const line = reader.line;
    const type = reader.word();
    const kind = type.toLowerCase();
    const page = Math.max(panel.pages.length - 1, 0);
    if (kind === "group") {
      groups.push(readGroup(reader, page, panel.problems));
    } else if (kind === "page" || kind === "slider" || kind === "button" || kind === "label" || kind === "menu") {
      const item = readItem(reader, kind, panel.problems);
      if (kind === "page") {
        panel.pages.push({ name: item.name, message: item.message });
      } else if (Number.isFinite(item.low)) {
        panel.items.push({ ...item, type: kind, page });
      }
    } else {
      panel.problems.push(`line ${line}: expected PAGE, SLIDER, BUTTON, LABEL, GROUP or MENU, found "${type}"`);
      reader.skipItem();
    }
  }
  groups.forEach((members, i) => join(members, i + 1, panel));
  if (!isNew) {
    // the old format counts from the bottom
    for (const item of panel.items) {
      item.y = panel.height - item.y - HEIGHTS[item.type];
    }
  }
  if (!size) {
    panel.width = Math.max(...panel.items.map(({ x }) => x + 150), 160);
    panel.height = Math.max(...panel.items.map(({ y }) => y + 48), 60);
  }
  return panel;
}

/** A button that a group names. */
interface Member {
  name: string;
  page: number;
  line: number;
}

function readGroup(reader: Reader, page: number, problems: string[]): Member[] {
  const members: Member[] = [];
  const begin = reader.line;
  reader.rest();
  reader.textOf("color:");
  while (reader.peek() !== "" && !reader.isNext("type:")) {
    const line = reader.line;
    const name = reader.rest();
    if (name.trim() === "ENDGROUP") {
      return members;
    }
    members.push({ name, page, line });
  }
  problems.push(`line ${begin}: the group has no ENDGROUP`);
  return members;
}

/** Puts the buttons that a group names into it. */
function join(members: Member[], group: number, panel: Panel): void {
  for (const { name, page, line } of members) {
    const buttons = panel.items.filter((item) => item.type === "button" && item.page === page);
    const exact = buttons.filter((button) => button.name === name);
    const found = exact.length > 0 ? exact : buttons.filter((button) => button.name.trim() === name.trim());
    for (const button of found) {
      button.group = group;
    }
    if (found.length === 0) {
      panel.problems.push(`line ${line}: the group names the button "${name}", which its page does not have`);
    }
  }
}

/** An item, or one with `low` NaN and a problem when a part of it is missing. */
function readItem(reader: Reader, type: PanelItem["type"] | "page", problems: string[]): Omit<PanelItem, "type" | "page"> {
  const item = { name: "", x: 0, y: 0, low: 0, high: 1, value: 0, message: "", colours: [] as string[], group: null };
  const report = (problem: string) => problems.push(`line ${reader.line}: ${problem}`);
  const without = (part: string) => {
    report(`expected ${part} of the ${type} "${item.name}", found "${reader.peek()}"`);
    reader.skipItem();
    return { ...item, low: NaN };
  };
  const name = reader.textOf("name:");
  if (name === null) {
    return without("name:");
  }
  item.name = name;
  item.colours = reader.colours("colors:", "tricolor:", "color:");
  const origin = reader.numbers("origin:", 2);
  if (!origin && type !== "page" && type !== "menu") {
    return without("two numbers behind origin:");
  }
  [item.x, item.y] = origin ?? [0, 0];
  if (type === "slider") {
    const limits = reader.numbers("min/max:", 2);
    if (!limits) {
      return without("two numbers behind min/max:");
    }
    if (limits[0] > limits[1]) {
      report(`the first limit of the slider "${name}" is larger than the second`);
    }
    item.low = Math.min(...limits);
    item.high = Math.max(...limits);
  }
  if (type === "slider" || type === "button") {
    const value = reader.numbers("value:", 1);
    if (!value && !/^[^:]+$/.test(reader.peek())) {
      return without("a number behind value:");
    }
    if (!value) {
      report(`the value "${reader.peek()}" of the ${type} "${name}" is no number`);
      reader.rest();
    }
    item.value = value?.[0] ?? item.low;
  }
  if (type !== "label") {
    const message = reader.textOf("message:");
    if (message === null) {
      return without("message:");
    }
    item.message = message;
  }
  return item;
}

// a text that stands for itself in a regular expression
const escaped = (text: string): string => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

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
  // a comma at the end, and a comment glued to the word, stay
  const comment = /\/\*.*/.exec(old)?.[0] ?? "";
  const rest = (old.slice(0, old.length - comment.length).endsWith(",") ? "," : "") + comment;
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
  if (/%(?!d)/.test(message.replaceAll("%%", ""))) {
    throw new Error(`The message "${message}" has a format other than %d.`);
  }
  const words = message.replace(/%[d%]/g, (format) => (format === "%d" ? String(value) : "%")).trim().split(/\s+/);
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
  const numberOf = (written: string) => {
    if (!Number.isFinite(Number(written))) {
      throw new Error(`The message "${message}" has "${written}" where a number is expected.`);
    }
    return Number(written);
  };
  const scaled = (number: string, divisor: string | undefined) => {
    const by = divisor === undefined ? 1 : Number(divisor);
    if (!by) {
      throw new Error(`The message "${message}" divides by zero.`);
    }
    return numberText(numberOf(number) / by);
  };
  const [kind, first, second, third, fourth] = words;
  if (editor === "ped") {
    if (kind === "n") {
      const exponent = Number(third);
      const written = exponent === 0 ? String(Math.round(numberOf(fourth))) : (numberOf(fourth) * 10 ** exponent).toFixed(4);
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
    change(first, second, word(numberText(numberOf(fourth) * 10 ** Number(third))));
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
    const found = new RegExp(`^[ \\t]*#define[ \\t]+${escaped(macro[1])}[ \\t]+([-+.\\d]+)`, "m").exec(text);
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
    const found = new RegExp(`panel\\s+${escaped(panel)}[^|\\n]*\\|\\s*(awkped|ped)\\s+(-lstudio\\s+)?(\\S+)`).exec(menu);
    if (found && found[3] in files) {
      return { file: found[3], editor: found[1] === "ped" ? "ped" : found[2] ? "awkped -lstudio" : "awkped" };
    }
  }
  const suffix = panel.slice(panel.lastIndexOf("."));
  const stem = main.replace(/\.\w+$/, "");
  return { file: `${stem}${suffix}` in files ? `${stem}${suffix}` : main, editor: "awkped" };
}
