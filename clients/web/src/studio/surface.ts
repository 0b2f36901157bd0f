// Bicubic surfaces of model folders (.s): control points in a text, and the patches that they make.

export type Vector = [number, number, number];

/** A number of the file with its place in the text. */
interface Written {
  value: number;
  from: number;
  to: number;
}

export interface SurfacePoint {
  place: Vector;
  at: [Written, Written, Written];
}

export interface Surface {
  contact: Vector;
  end: Vector;
  /** Sixteen points each, row by row. */
  patches: Array<{ name: string; points: SurfacePoint[] }>;
}

const NUMBER = /[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?/y;
const BLANKS = /\s*/y;
const WORD = /\S+/y;
const NEIGHBOURS = ["AL:", "A:", "AR:", "L:", "R:", "BL:", "B:", "BR:"];

/** Reads the text from its begin; every reader gives null when something else stands there. */
class Reader {
  private place = 0;

  constructor(private readonly text: string) {}

  private take(pattern: RegExp): string | null {
    BLANKS.lastIndex = this.place;
    this.place += BLANKS.exec(this.text)![0].length;
    pattern.lastIndex = this.place;
    const found = pattern.exec(this.text);
    this.place += found?.[0].length ?? 0;
    return found?.[0] ?? null;
  }

  number(): Written | null {
    const found = this.take(NUMBER);
    return found === null ? null : { value: Number(found), from: this.place - found.length, to: this.place };
  }

  numbers(count: number): Written[] | null {
    const found = Array.from({ length: count }, () => this.number());
    return found.includes(null) ? null : (found as Written[]);
  }

  word(): string | null {
    return this.take(WORD);
  }

  /** The words of a text; blanks may stand between them. */
  keywords(words: string): boolean {
    const begin = this.place;
    for (const word of words.split(" ")) {
      BLANKS.lastIndex = this.place;
      this.place += BLANKS.exec(this.text)![0].length;
      if (!this.text.startsWith(word, this.place)) {
        this.place = begin;
        return false;
      }
      this.place += word.length;
    }
    return true;
  }

  vector(words: string): Vector | null {
    if (!this.keywords(words)) {
      return null;
    }
    const found = ["X:", "Y:", "Z:"].map((axis) => (this.keywords(axis) ? this.number() : null));
    return found.includes(null) ? null : (found.map((one) => one!.value) as Vector);
  }

  isAtEnd(): boolean {
    return this.text.slice(this.place).trim() === "";
  }
}

/** The surface of a `.s` file; null when the text is none. */
export function parseSurface(name: string, text: string): Surface | null {
  const reader = new Reader(text);
  if (!/\.s$/.test(name) || !reader.numbers(6)) {
    return null;
  }
  if (reader.keywords("PRECISION S:") && !(reader.number() && reader.keywords("T:") && reader.number())) {
    return null;
  }
  const [contact, end, heading, up] = ["CONTACT POINT", "END POINT", "HEADING", "UP"].map((words) => reader.vector(words));
  if (!contact || !end || !heading || !up || !reader.keywords("SIZE:") || !reader.number()) {
    return null;
  }
  const patches: Surface["patches"] = [];
  while (!reader.isAtEnd()) {
    const patch = reader.word()!;
    const hasColours = ["TOP COLOR:", "DIFFUSE:", "BOTTOM COLOR:", "DIFFUSE:"].every((words) => reader.keywords(words) && reader.number());
    const hasNeighbours = hasColours && NEIGHBOURS.every((words) => reader.keywords(words) && reader.word());
    const numbers = hasNeighbours ? reader.numbers(48) : null;
    if (!numbers) {
      return null;
    }
    const points = Array.from({ length: 16 }, (_, i): SurfacePoint => {
      const at = numbers.slice(3 * i, 3 * i + 3) as [Written, Written, Written];
      return { place: at.map(({ value }) => value) as Vector, at };
    });
    patches.push({ name: patch, points });
  }
  return patches.length > 0 ? { contact, end, patches } : null;
}

const short = (value: number): string => String(Number(value.toFixed(4)) || 0);

/** The points that lie where a point lies: an edge that two patches share, or a tip. */
export function pointsAt({ patches }: Surface, [x, y, z]: Vector): SurfacePoint[] {
  return patches.flatMap(({ points }) => points.filter(({ place }) => place[0] === x && place[1] === y && place[2] === z));
}

/** The text after points have moved to a place: only their numbers change, and of these only those that differ. */
export function withPoints(text: string, points: SurfacePoint[], to: Vector): string {
  const changes = points.flatMap(({ at }) => at.map((written, axis) => ({ ...written, text: short(to[axis]) })).filter((one) => Number(one.text) !== one.value));
  let changed = text;
  for (const { from, to: end, text: written } of changes.sort((a, b) => b.from - a.from)) {
    changed = changed.slice(0, from) + written + changed.slice(end);
  }
  return changed;
}

const bernstein = (t: number): number[] => [(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3];

/** Points of a patch on a grid of `count` × `count` squares, row by row. */
export function samplesOf(points: SurfacePoint[], count: number): Vector[][] {
  const weights = Array.from({ length: count + 1 }, (_, i) => bernstein(i / count));
  return weights.map((row) =>
    weights.map((column) => {
      const sum: Vector = [0, 0, 0];
      points.forEach(({ place }, i) => place.forEach((value, axis) => (sum[axis] += row[i >> 2] * column[i & 3] * value)));
      return sum;
    }),
  );
}
