// Turtle records as columns: the modules that the turtle drew or asked at, with their parameters.
import type { Columns } from "./wire.js";

const NONE = 0xffffffff;

/** One row for each record. `parameters` of record i are those from `parameterOffset[i]` to `parameterOffset[i + 1]`. */
export interface TurtleTable {
  count: number;
  symbols: string[];
  plant: Uint32Array;
  module: Uint32Array;
  symbol: Uint32Array;
  colour: Uint32Array;
  branchOrder: Uint32Array;
  parent: Uint32Array; // row of the record it grows from; 4294967295: none
  position: ArrayLike<number>;
  heading: ArrayLike<number>;
  left: ArrayLike<number>;
  up: ArrayLike<number>;
  width: ArrayLike<number>;
  parameterOffset: Uint32Array;
  parameters: ArrayLike<number>;
}

const INTEGERS = ["plant", "module", "symbol", "colour", "branchOrder", "parent"] as const;
const REALS = [["position", 3], ["heading", 3], ["left", 3], ["up", 3], ["width", 1]] as const;

/** The table of a frame: whole, or made from the table before and the rows that the frame brings. */
export function turtleTable(params: { symbols?: string[]; count?: number }, blocks: Columns, before: TurtleTable | null): TurtleTable {
  const kept = blocks["kept"];
  const symbols = params.symbols ?? before?.symbols ?? [];
  if (!kept || !before) {
    return { ...(blocks as unknown as TurtleTable), symbols, count: blocks["plant"]?.length ?? 0 };
  }
  const count = params.count ?? 0;
  const table = { count, symbols } as unknown as Record<string, any>;
  // from which row of which table each row comes
  const from = new Int32Array(count).fill(-1);
  for (let i = 0; i < kept.length; i += 6) {
    for (let row = 0; row < kept[i + 2]; ++row) {
      from[kept[i] + row] = kept[i + 1] + row;
    }
  }
  const copy = (name: string, width: number, Kind: any) => {
    const values = new Kind(count * width);
    const old = before[name as "width"] as ArrayLike<number>;
    for (let row = 0, fresh = 0; row < count; ++row) {
      const source = from[row] >= 0 ? old : blocks[name];
      const at = (from[row] >= 0 ? from[row] : fresh++) * width;
      for (let i = 0; i < width; ++i) {
        values[row * width + i] = source[at + i];
      }
    }
    table[name] = values;
  };
  INTEGERS.forEach((name) => copy(name, 1, Uint32Array));
  REALS.forEach(([name, width]) => copy(name, width, Float64Array));
  for (let i = 0; i < kept.length; i += 6) {
    for (let row = kept[i]; row < kept[i] + kept[i + 2]; ++row) {
      table.module[row] += kept[i + 3];
      if (table.parent[row] !== NONE) {
        table.parent[row] += kept[i + 4];
      }
    }
  }
  const parameters: number[] = [];
  const offsets = new Uint32Array(count + 1);
  for (let row = 0, fresh = 0; row < count; ++row) {
    const [source, at] = from[row] >= 0 ? [before, from[row]] : [blocks as unknown as TurtleTable, fresh++];
    for (let i = source.parameterOffset[at]; i < source.parameterOffset[at + 1]; ++i) {
      parameters.push(source.parameters[i]);
    }
    offsets[row + 1] = parameters.length;
  }
  table.parameterOffset = offsets;
  table.parameters = Float64Array.from(parameters);
  return table as unknown as TurtleTable;
}
