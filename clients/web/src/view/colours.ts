// Which colour a segment or organ has: the model's, or a number of the module that drew it.
import type { Geometry, TurtleTable } from "espalier";

export type ColourMode = "model" | "order" | "age" | "plant" | "symbol" | `parameter ${number}`;

export interface ModelPalette {
  colours: Array<[number, number, number]>;
  isOfModel: boolean;
}

export interface Legend {
  title: string;
  /** Swatches with names, or the ends of a scale. */
  swatches?: Array<{ colour: string; name: string }>;
  scale?: { colours: string[]; low: number; high: number };
}

const DEFAULT_COLOUR = 128;
// Espalier's own colours of branches without colours: from the trunk to the twigs
const TRUNK = [104, 76, 54];
const TWIG = [106, 148, 74];
const LEAF = [96, 150, 66];
// distinguishable also for people who do not see red and green apart (after Okabe and Ito, 2008)
const CLASSES = [0x0072b2, 0xe69f00, 0x009e73, 0xcc79a7, 0x56b4e9, 0xd55e00, 0x8f8719, 0x7a5195, 0x5b5b5b, 0xb8860b];
// viridis
const SCALE = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];

const packed = ([r, g, b]: ArrayLike<number> & Iterable<number>): number => (Math.round(r) << 16) | (Math.round(g) << 8) | Math.round(b);
export const cssColour = (colour: number): string => `#${colour.toString(16).padStart(6, "0")}`;

function mixed(a: number[], b: number[], t: number): number {
  return packed([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])]);
}

export function scaleColour(t: number): number {
  const at = Math.min(Math.max(t, 0), 1) * (SCALE.length - 1);
  const low = Math.min(Math.floor(at), SCALE.length - 2);
  return mixed(SCALE[low], SCALE[low + 1], at - low);
}

/** Rows of modules in a turtle table, by plant and module. */
export function rowsByModule(table: TurtleTable): Map<number, number> {
  const rows = new Map<number, number>();
  for (let i = 0; i < table.count; ++i) {
    rows.set(table.plant[i] * 2 ** 32 + table.module[i], i);
  }
  return rows;
}

export interface Painting {
  segment: (row: number) => number;
  organ: (row: number) => number;
  legend: Legend | null;
  /** Paintings with equal keys give a row that stays the same colour; null: none does. */
  key: string | null;
}

export interface Births {
  segments: ArrayLike<number>; // step in which the row last changed
  organs: ArrayLike<number>;
  step: number;
}

/** The paint of each row in a mode. */
export function painting(mode: ColourMode, geometry: Geometry, palette: ModelPalette | null, births: Births, table: TurtleTable | null): Painting {
  const { segments, organs } = geometry;
  const of = (name: "Plant" | "Module" | "Symbol" | "Colour" | "Order") => [segments.column(name), organs.column(name)] as const;
  if (mode === "model") {
    return modelPainting(geometry, palette);
  }
  if (mode === "age") {
    const oldest = births.step;
    return scalePainting(`steps without a change`, 0, oldest, (isOrgan, i) => oldest - (isOrgan ? births.organs : births.segments)[i]);
  }
  if (mode === "order") {
    const [ofSegments, ofOrgans] = of("Order");
    const highest = Math.max(largest(ofSegments), largest(ofOrgans));
    if (highest < CLASSES.length) {
      return classPainting("branch order", (isOrgan, i) => (isOrgan ? ofOrgans : ofSegments)[i], Array.from({ length: highest + 1 }, (_, i) => String(i)));
    }
    return scalePainting("branch order", 0, highest, (isOrgan, i) => (isOrgan ? ofOrgans : ofSegments)[i]);
  }
  if (mode === "plant" || mode === "symbol") {
    const [ofSegments, ofOrgans] = of(mode === "plant" ? "Plant" : "Symbol");
    const used = [...new Set([...unique(ofSegments), ...unique(ofOrgans)])].sort((a, b) => a - b);
    const place = new Map(used.map((value, i) => [value, i]));
    const names = used.map((value) => (mode === "plant" ? `plant ${value}` : geometry.symbols[value]));
    return classPainting(mode === "plant" ? "plant" : "drawn by", (isOrgan, i) => place.get((isOrgan ? ofOrgans : ofSegments)[i])!, names);
  }
  const index = Number(mode.split(" ")[1]) - 1;
  return parameterPainting(geometry, table, index);
}

function parameterPainting(geometry: Geometry, table: TurtleTable | null, index: number): Painting {
  const [segmentPlant, organPlant] = [geometry.segments.column("Plant"), geometry.organs.column("Plant")];
  const [segmentModule, organModule] = [geometry.segments.column("Module"), geometry.organs.column("Module")];
  const rows = table ? rowsByModule(table) : new Map<number, number>();
  const value = (isOrgan: boolean, i: number): number => {
    const row = rows.get((isOrgan ? organPlant : segmentPlant)[i] * 2 ** 32 + (isOrgan ? organModule : segmentModule)[i]);
    const at = row === undefined ? -1 : table!.parameterOffset[row] + index;
    return row !== undefined && at < table!.parameterOffset[row + 1] ? table!.parameters[at] : NaN;
  };
  let low = Infinity;
  let high = -Infinity;
  for (const [count, isOrgan] of [[geometry.segments.count, false], [geometry.organs.count, true]] as const) {
    for (let i = 0; i < count; ++i) {
      const found = value(isOrgan, i);
      low = found < low ? found : low;
      high = found > high ? found : high;
    }
  }
  // the table may be another one, whose rows are not those of the frame before
  return { ...scalePainting(`parameter ${index + 1}`, low <= high ? low : 0, low <= high ? high : 0, value), key: null };
}

function modelPainting(geometry: Geometry, palette: ModelPalette | null): Painting {
  const colours = geometry.segments.column("Colour");
  const organColours = geometry.organs.column("Colour");
  const orders = geometry.segments.column("Order");
  const plants = geometry.segments.column("Plant");
  const isOfModel = palette?.isOfModel === true;
  const coloured = new Set<number>();
  let last = -1;
  for (let i = 0; i < colours.length; ++i) {
    if (plants[i] !== last && (isOfModel || colours[i] !== DEFAULT_COLOUR)) {
      last = plants[i];
      coloured.add(last);
    }
  }
  const highest = Math.max(largest(orders), 1);
  const ofOrder = Array.from({ length: highest + 1 }, (_, order) => mixed(TRUNK, TWIG, order / highest));
  const table = palette?.colours.map(packed) ?? [];
  const leaf = packed(LEAF);
  return {
    segment: (i) => (coloured.has(plants[i]) ? (table[colours[i] & 255] ?? leaf) : ofOrder[orders[i]]),
    organ: (i) => (!isOfModel && organColours[i] === DEFAULT_COLOUR ? leaf : (table[organColours[i] & 255] ?? leaf)),
    legend: null,
    key: `${highest} ${[...coloured].sort((a, b) => a - b).join()}`,
  };
}

function classPainting(title: string, classOf: (isOrgan: boolean, row: number) => number, names: string[]): Painting {
  const colour = (i: number) => CLASSES[i % CLASSES.length];
  const swatches = names.slice(0, CLASSES.length).map((name, i) => ({ colour: cssColour(colour(i)), name }));
  return { segment: (i) => colour(classOf(false, i)), organ: (i) => colour(classOf(true, i)), legend: { title, swatches }, key: names.join("\n") };
}

function scalePainting(title: string, low: number, high: number, value: (isOrgan: boolean, row: number) => number): Painting {
  const span = high - low || 1;
  const colour = (x: number) => (Number.isNaN(x) ? 0xb9b9b0 : scaleColour((x - low) / span));
  const colours = SCALE.map((entry) => cssColour(packed(entry)));
  return { segment: (i) => colour(value(false, i)), organ: (i) => colour(value(true, i)), legend: { title, scale: { colours, low, high } }, key: `${low} ${high}` };
}

function largest(values: ArrayLike<number>): number {
  let most = 0;
  for (let i = 0; i < values.length; ++i) {
    most = values[i] > most ? values[i] : most;
  }
  return most;
}

function unique(values: ArrayLike<number>): Set<number> {
  const found = new Set<number>();
  for (let i = 0; i < values.length; ++i) {
    if (i === 0 || values[i] !== values[i - 1]) {
      found.add(values[i]);
    }
  }
  return found;
}
