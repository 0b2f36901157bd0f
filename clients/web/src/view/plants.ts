// The plants of a simulation as meshes, from its columns. Unchanged parts of a frame are neither computed nor sent again.
import { Box3 } from "three";
import type { Vector3 } from "three";
import { NEW_ROWS, Rows } from "espalier";
import type { Geometry, GeometryChange, RowRange, TurtleTable } from "espalier";
import { painting } from "./colours.js";
import type { ColourMode, Legend, ModelPalette } from "./colours.js";
import { Bounds } from "./measures.js";
import { Organs } from "./organs.js";
import { Tubes } from "./tubes.js";

const HIGHLIGHT = 0xff7a1a;

const births = () => new Rows({ Step: { kind: "u4", width: 1 } });

export class Plants {
  readonly tubes = new Tubes();
  readonly organs = new Organs();
  geometry: Geometry | null = null;
  bounds = new Box3();
  legend: Legend | null = null;
  palette: ModelPalette | null = null;
  /** Parameters of the modules, for colours by parameter. */
  table: TurtleTable | null = null;
  /** The module that stands out. */
  picked: { plant: number; module: number } | null = null;
  /** In which step rows last changed. */
  private readonly births = { segments: births(), organs: births() };
  private step = 0;
  private readonly segmentBounds = new Bounds();
  private readonly organBounds = new Bounds();
  private organBox = new Box3();
  private key: string | null = null; // of the painting that the rows have

  /** Shows a frame. */
  update(geometry: Geometry, change: GeometryChange, step: number, mode: ColourMode): void {
    const isSame = this.geometry === geometry && !change.isWhole;
    const { segments, organs, vertices } = geometry;
    this.geometry = geometry;
    this.step = step;
    const changed = isSame ? change.segments : [{ begin: 0, end: segments.count }];
    this.tubes.update(geometry, changed);
    this.bear("segments", segments.count, isSame ? change.segmentRuns : null);
    const segmentBox = this.segmentBounds.update([segments.column("Start"), segments.column("End")], segments.count, changed);
    const hasOtherOrgans = !isSame || change.organs.length > 0 || organs.count !== this.organs.count;
    if (hasOtherOrgans) {
      this.organs.update(geometry);
      this.bear("organs", organs.count, isSame ? change.organRuns : null);
      this.organBox = this.organBounds.update([vertices.column("Position")], vertices.count, [{ begin: 0, end: vertices.count }]);
    }
    this.bounds = segmentBox.union(this.organBox);
    this.paint(mode, isSame ? changed : null, hasOtherOrgans);
  }

  /** While little changes at a time, the bounds also hold where things were. From now on they are those of what is there. False: they were. */
  tighten(): boolean {
    const { isLoose } = this.segmentBounds;
    if (isLoose) {
      this.bounds = this.segmentBounds.tighten().union(this.organBox);
    }
    return isLoose;
  }

  /** How far from `centre` a camera must be to see the plants from all sides. */
  distanceToSee(centre: Vector3, direction: Vector3, across: number, up: number): number {
    return Math.max(this.segmentBounds.distanceToSee(centre, direction, across, up), this.organBounds.distanceToSee(centre, direction, across, up));
  }

  private bear(kind: "segments" | "organs", count: number, runs: GeometryChange["segmentRuns"] | null): void {
    const steps = (rows: number) => () => new Uint32Array(rows).fill(this.step);
    if (runs) {
      this.births[kind].apply(runs, steps(runs.reduce((sum, run) => sum + (run.first === NEW_ROWS ? run.count : 0), 0)));
    } else {
      this.births[kind].replace(count, steps(count));
    }
  }

  /** Paints every row. */
  repaint(mode: ColourMode): void {
    this.paint(mode, null, true);
  }

  /** Paints the changed rows when the others keep their colours; `changed` null: every row. */
  private paint(mode: ColourMode, changed: RowRange[] | null, hasOtherOrgans: boolean): void {
    if (!this.geometry) {
      return;
    }
    const { segments, organs } = this.geometry;
    const ages = { segments: this.births.segments.column("Step"), organs: this.births.organs.column("Step"), step: this.step };
    const { segment, organ, legend, key } = painting(mode, this.geometry, this.palette, ages, this.table);
    const isOther = changed === null || key === null || key !== this.key;
    this.legend = legend;
    this.key = key;
    const chosen = this.picked;
    const highlighted = (plants: ArrayLike<number>, modules: ArrayLike<number>, plain: (i: number) => number) =>
      chosen ? (i: number) => (modules[i] === chosen.module && plants[i] === chosen.plant ? HIGHLIGHT : plain(i)) : plain;
    this.tubes.paint(isOther ? [{ begin: 0, end: segments.count }] : changed, highlighted(segments.column("Plant"), segments.column("Module"), segment));
    if (isOther || hasOtherOrgans) {
      this.organs.paint(highlighted(organs.column("Plant"), organs.column("Module"), organ));
    }
  }
}
