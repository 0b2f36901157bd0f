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

interface Placed extends Run {
  to: number;
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
    const fresh: Placed[] = [];
    const moved: Placed[] = [];
    const shifted: Placed[] = [];
    const dirty: RowRange[] = [];
    let after = 0;
    let last = 0; // of the old rows that stay
    let isOrdered = true;
    for (const { first, count, shift } of runs) {
      const placed = { first, count, shift, to: after };
      after += count;
      if (first === NEW_ROWS) {
        fresh.push(placed);
      } else {
        isOrdered &&= last <= first;
        last = first + count;
        if (first !== placed.to) {
          moved.push(placed);
        }
        if (shift !== 0) {
          shifted.push(placed);
        }
      }
      if (count > 0 && (first !== placed.to || shift !== 0)) {
        const range = dirty[dirty.length - 1];
        if (range?.end === placed.to) {
          range.end = after;
        } else {
          dirty.push({ begin: placed.to, end: after });
        }
      }
    }
    this.reserve(Math.max(after, before));
    // rows in order: those that move up go last first, those that move down first last, and none overwrites another
    const up = moved.filter((run) => run.to > run.first).reverse();
    const down = moved.filter((run) => run.to < run.first);
    for (const name of this.names()) {
      const { width } = this.shapes[name];
      const array = this.arrays[name];
      if (isOrdered) {
        for (const { first, count, to } of [...up, ...down]) {
          array.copyWithin(to * width, first * width, (first + count) * width);
        }
      } else {
        const old = array.slice(0, before * width);
        for (const { first, count, to } of moved) {
          array.set(old.subarray(first * width, (first + count) * width), to * width);
        }
      }
      put(fresh, columnOf(name) ?? [], array, width);
    }
    for (const name of this.shifted) {
      for (const { count, shift, to } of shifted) {
        const array = this.arrays[name];
        for (let i = to; i < to + count; ++i) {
          array[i] = (array[i] + shift) >>> 0;
        }
      }
    }
    this.count = after;
    return dirty;
  }
}

/** Puts values one after the other in their places. */
function put(places: Placed[], values: ArrayLike<number>, array: Float64Array | Uint32Array, width: number): void {
  let from = 0;
  for (const { count, to } of places) {
    for (let at = to * width; at < (to + count) * width; ++at) {
      array[at] = values[from++];
    }
  }
}
