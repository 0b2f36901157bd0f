// A table of columns whose rows change in place: most rows of a difference stay, some move, some are new.
import type { Column } from "./wire.js";

/** `count` rows from `first` of the old table; first NEW: the next new rows. `shift` is added to the modules. */
export interface Run {
  first: number;
  count: number;
  shift: number;
}

export const NEW_ROWS = 0xffffffff;

/** Rows of the present table that are not what they were: [begin, end). */
export interface RowRange {
  begin: number;
  end: number;
}

export interface ColumnShape {
  kind: "f8" | "u4";
  width: number;
}

export function runsOf(flat: Column | undefined): Run[] {
  const runs: Run[] = [];
  for (let i = 0; i < (flat?.length ?? 0); i += 3) {
    runs.push({ first: flat![i], count: flat![i + 1], shift: flat![i + 2] });
  }
  return runs;
}

/** Columns of equal length. The arrays have room for more rows; `column(name)` is the part in use. */
export class Rows<Name extends string> {
  count = 0;
  private capacity = 0;
  private arrays = {} as Record<Name, Float64Array | Uint32Array>;

  constructor(
    private readonly shapes: Record<Name, ColumnShape>,
    private readonly shifted: NoInfer<Name>[] = [],
  ) {
    this.names().forEach((name) => (this.arrays[name] = this.made(name, 0)));
  }

  private names(): Name[] {
    return Object.keys(this.shapes) as Name[];
  }

  private made(name: Name, rows: number): Float64Array | Uint32Array {
    const { kind, width } = this.shapes[name];
    return kind === "f8" ? new Float64Array(rows * width) : new Uint32Array(rows * width);
  }

  /** The values of a column, a view that the next change invalidates. */
  column(name: Name): Float64Array | Uint32Array {
    return this.arrays[name].subarray(0, this.count * this.shapes[name].width);
  }

  private reserve(count: number): void {
    if (count <= this.capacity) {
      return;
    }
    this.capacity = Math.max(count, Math.ceil(this.capacity * 1.5));
    for (const name of this.names()) {
      const larger = this.made(name, this.capacity);
      larger.set(this.column(name));
      this.arrays[name] = larger;
    }
  }

  /** Replaces all rows. `columnOf` gives the new values of a column. */
  replace(count: number, columnOf: (name: Name) => ArrayLike<number> | undefined): RowRange[] {
    this.count = 0;
    this.reserve(count);
    this.count = count;
    for (const name of this.names()) {
      const values = columnOf(name);
      if (values && values.length > 0) {
        this.arrays[name].set(values);
      }
    }
    return [{ begin: 0, end: count }];
  }

  /** Puts the table together from its own rows and new ones. Returns the rows that moved or are new. */
  apply(runs: Run[], columnOf: (name: Name) => ArrayLike<number> | undefined): RowRange[] {
    const before = this.count;
    const after = runs.reduce((sum, run) => sum + run.count, 0);
    this.reserve(Math.max(after, before));
    const dirty: RowRange[] = [];
    const placed = runs.map(((to) => (run: Run) => ({ ...run, to: (to += run.count) - run.count }))(0));
    const kept = placed.filter((run) => run.first !== NEW_ROWS);
    const isOrdered = kept.every((run, i) => i === 0 || kept[i - 1].first + kept[i - 1].count <= run.first);
    // rows in order: those that move up go last first, those that move down first last, and none overwrites another
    const up = kept.filter((run) => run.to > run.first).reverse();
    const down = kept.filter((run) => run.to < run.first);
    for (const name of this.names()) {
      const { width } = this.shapes[name];
      const array = this.arrays[name];
      const old = isOrdered ? array : array.slice(0, before * width);
      for (const { first, count, to } of isOrdered ? [...up, ...down] : kept) {
        if (isOrdered) {
          array.copyWithin(to * width, first * width, (first + count) * width);
        } else {
          array.set(old.subarray(first * width, (first + count) * width), to * width);
        }
      }
      const fresh = columnOf(name) ?? [];
      let from = 0;
      for (const { first, count, to } of placed) {
        if (first === NEW_ROWS) {
          for (let i = 0; i < count * width; ++i) {
            array[to * width + i] = fresh[from + i];
          }
          from += count * width;
        }
      }
    }
    for (const name of this.shifted) {
      const array = this.arrays[name];
      for (const { count, shift, to } of kept) {
        if (shift !== 0) {
          for (let i = to; i < to + count; ++i) {
            array[i] = (array[i] + shift) >>> 0;
          }
        }
      }
    }
    this.count = after;
    for (const { first, count, to, shift } of placed) {
      if (count > 0 && (first !== to || shift !== 0)) {
        const last = dirty[dirty.length - 1];
        if (last && last.end === to) {
          last.end = to + count;
        } else {
          dirty.push({ begin: to, end: to + count });
        }
      }
    }
    return dirty;
  }
}
