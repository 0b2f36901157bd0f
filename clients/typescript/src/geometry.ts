// The shapes of plants: straight round segments, and organs that are meshes. protocol/README.md, Geometry.
import { NEW_ROWS, Rows, runsOf } from "./rows.js";
import type { Run, RowRange } from "./rows.js";
import type { Geometry as GeometryText } from "./protocol.js";
import type { Columns } from "./wire.js";

const u4 = { kind: "u4", width: 1 } as const;
const f8 = { kind: "f8", width: 1 } as const;
const vector = { kind: "f8", width: 3 } as const;
const triple = { kind: "u4", width: 3 } as const;

const SEGMENT = { Plant: u4, Module: u4, Symbol: u4, Colour: u4, Order: u4, Start: vector, End: vector, StartWidth: f8, EndWidth: f8 };
const ORGAN = { Plant: u4, Module: u4, Symbol: u4, Colour: u4, Order: u4, Kind: u4, Vertices: u4, Triangles: u4 };

/** How a frame changed the geometry. */
export interface GeometryChange {
  isWhole: boolean;
  segmentRuns: Run[];
  organRuns: Run[];
  segments: RowRange[]; // rows that moved or are new
  organs: RowRange[];
}

/** Names of the kinds of organs, by the number in the column Kind. */
export const ORGAN_KINDS = ["generalized cylinder", "polygon", "surface", "patch", "sphere or disc"];

function flat(values: unknown): ArrayLike<number> | undefined {
  return Array.isArray(values) ? (values.flat() as number[]) : (values as ArrayLike<number> | undefined);
}

/** Segments and organs as columns, kept up to date by frames. */
export class Geometry {
  widths: "world" | "pixels" = "world";
  symbols: string[] = [];
  readonly segments = new Rows(SEGMENT, ["Module"]);
  readonly organs = new Rows(ORGAN, ["Module"]);
  /** Of all organs, one after the other; triangles count from the first vertex of their organ. */
  readonly vertices = new Rows({ Position: vector });
  readonly triangles = new Rows({ Corners: triple });

  /** Takes the member `geometry` of a frame or of environment.step, with the blocks beside it. */
  apply(text: GeometryText, blocks: Columns): GeometryChange {
    this.widths = text.widths;
    this.symbols = text.symbols;
    const column = (name: string) => blocks[name] ?? flat((text as Record<string, unknown>)[name]);
    const segmentColumn = (name: string) => column(`segment${name}`);
    const organColumn = (name: string) => column(`organ${name}`);
    const vertices = column("vertices") ?? [];
    const triangles = column("triangles") ?? [];
    if (text.form === "whole") {
      const change = {
        isWhole: true,
        segmentRuns: [],
        organRuns: [],
        segments: this.segments.replace(segmentColumn("Plant")?.length ?? 0, segmentColumn),
        organs: this.organs.replace(organColumn("Plant")?.length ?? 0, organColumn),
      };
      this.vertices.replace(vertices.length / 3, () => vertices);
      this.triangles.replace(triangles.length / 3, () => triangles);
      return change;
    }
    const segmentRuns = runsOf(column("segmentRuns") as Columns[string]);
    const organRuns = runsOf(column("organRuns") as Columns[string]);
    // the meshes of organs follow their rows
    const vertexRuns = meshRuns(organRuns, this.organs.column("Vertices"), organColumn("Vertices") ?? []);
    const triangleRuns = meshRuns(organRuns, this.organs.column("Triangles"), organColumn("Triangles") ?? []);
    this.vertices.apply(vertexRuns, () => vertices);
    this.triangles.apply(triangleRuns, () => triangles);
    return {
      isWhole: false,
      segmentRuns,
      organRuns,
      segments: this.segments.apply(segmentRuns, segmentColumn),
      organs: this.organs.apply(organRuns, organColumn),
    };
  }
}

/** Runs of rows of the meshes of organs. `old` and `fresh`: how many rows each old and each new organ has. */
function meshRuns(organRuns: Run[], old: ArrayLike<number>, fresh: ArrayLike<number>): Run[] {
  const begins = new Float64Array(old.length + 1);
  for (let i = 0; i < old.length; ++i) {
    begins[i + 1] = begins[i] + old[i];
  }
  let next = 0;
  return organRuns.map(({ first, count }) => {
    if (first !== NEW_ROWS) {
      return { first: begins[first], count: begins[first + count] - begins[first], shift: 0 };
    }
    let sum = 0;
    for (let i = 0; i < count; ++i) {
      sum += fresh[next++];
    }
    return { first: NEW_ROWS, count: sum, shift: 0 };
  });
}
