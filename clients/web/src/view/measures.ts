// The places of things: bounds of the plants, and the thing that a ray meets.
import { Box3, Vector3 } from "three";
import type { Geometry, RowRange } from "espalier";

export interface Picked {
  plant: number;
  module: number;
  symbol: string;
  order: number;
  kind: "segment" | "organ";
  length?: number;
  width?: number;
  position: [number, number, number];
}

const BLOCK = 16; // rows whose box is kept

/**
 * The box of all points of a table. Of a block of which some rows changed only these rows are looked at: its box then also holds the
 * places where they were, until `tighten`.
 */
export class Bounds {
  private boxes = new Float64Array(0); // of each block: lows, highs
  private columns: ArrayLike<number>[] = [];
  private count = 0;
  /** The boxes also hold places where rows were. */
  isLoose = false;

  /** `columns`: three coordinates a row each; `changed`: ascending ranges of rows. */
  update(columns: ArrayLike<number>[], count: number, changed: RowRange[]): Box3 {
    const blocks = Math.ceil(count / BLOCK);
    if (this.boxes.length < 6 * blocks) {
      const larger = new Float64Array(9 * blocks);
      larger.set(this.boxes);
      this.boxes = larger;
    }
    const before = this.count;
    this.columns = columns;
    this.count = count;
    for (const { begin, end } of changed) {
      for (let block = Math.floor(begin / BLOCK); BLOCK * block < end; ++block) {
        const first = BLOCK * block;
        const last = Math.min(first + BLOCK, count);
        if ((begin <= first && end >= last) || first >= before) {
          this.measure(block, first, last, false);
        } else {
          this.measure(block, Math.max(begin, first), Math.min(end, last), true);
          this.isLoose = true;
        }
      }
    }
    if (count < before && blocks > 0) {
      this.measure(blocks - 1, BLOCK * (blocks - 1), count, false);
    }
    return this.union();
  }

  /** The box of the points alone. */
  tighten(): Box3 {
    for (let block = 0; this.isLoose && BLOCK * block < this.count; ++block) {
      this.measure(block, BLOCK * block, Math.min(BLOCK * (block + 1), this.count), false);
    }
    this.isLoose = false;
    return this.union();
  }

  /** The box of a block holds the rows from `begin` to `end`, and what it held before when `isKept`. */
  private measure(block: number, begin: number, end: number, isKept: boolean): void {
    const { boxes } = this;
    const to = 6 * block;
    let lowX = isKept ? boxes[to] : Infinity;
    let lowY = isKept ? boxes[to + 1] : Infinity;
    let lowZ = isKept ? boxes[to + 2] : Infinity;
    let highX = isKept ? boxes[to + 3] : -Infinity;
    let highY = isKept ? boxes[to + 4] : -Infinity;
    let highZ = isKept ? boxes[to + 5] : -Infinity;
    for (const values of this.columns) {
      for (let i = 3 * begin; i < 3 * end; i += 3) {
        const x = values[i];
        const y = values[i + 1];
        const z = values[i + 2];
        lowX = x < lowX ? x : lowX;
        lowY = y < lowY ? y : lowY;
        lowZ = z < lowZ ? z : lowZ;
        highX = x > highX ? x : highX;
        highY = y > highY ? y : highY;
        highZ = z > highZ ? z : highZ;
      }
    }
    boxes[to] = lowX;
    boxes[to + 1] = lowY;
    boxes[to + 2] = lowZ;
    boxes[to + 3] = highX;
    boxes[to + 4] = highY;
    boxes[to + 5] = highZ;
  }

  /**
   * How far from `centre` a camera must be, in `direction`, to see everything, also when it turns about the vertical through `centre`.
   * `across`, `up`: half of what it sees at distance 1.
   */
  distanceToSee(centre: Vector3, direction: Vector3, across: number, up: number): number {
    const rise = direction.y;
    const level = Math.sqrt(Math.max(0, 1 - rise * rise));
    const sideways = Math.hypot(1 / across, level);
    // a point above and one below the middle of the picture
    const above = Math.abs(level - rise / up);
    const below = Math.abs(level + rise / up);
    const { boxes } = this;
    let distance = 0;
    for (let at = 0; at < 6 * Math.ceil(this.count / BLOCK); at += 6) {
      const x = Math.max(Math.abs(boxes[at] - centre.x), Math.abs(boxes[at + 3] - centre.x));
      const z = Math.max(Math.abs(boxes[at + 2] - centre.z), Math.abs(boxes[at + 5] - centre.z));
      const radius = Math.hypot(x, z);
      for (const y of [boxes[at + 1] - centre.y, boxes[at + 4] - centre.y]) {
        const upright = Math.max((y * level) / up + radius * above, (-y * level) / up + radius * below);
        distance = Math.max(distance, y * rise + Math.max(upright, radius * sideways));
      }
    }
    return distance;
  }

  private union(): Box3 {
    const blocks = Math.ceil(this.count / BLOCK);
    const low = [0, 0, 0];
    const high = [0, 0, 0];
    for (let axis = 0; axis < 3; ++axis) {
      let lowest = Infinity;
      let highest = -Infinity;
      for (let at = axis; at < 6 * blocks; at += 6) {
        lowest = this.boxes[at] < lowest ? this.boxes[at] : lowest;
        highest = this.boxes[at + 3] > highest ? this.boxes[at + 3] : highest;
      }
      low[axis] = lowest;
      high[axis] = highest;
    }
    return new Box3(new Vector3(...low), new Vector3(...high));
  }
}

/** Those of a box. */
export function boundsOf({ min, max }: Box3): Bounds {
  const bounds = new Bounds();
  bounds.update([[...min.toArray(), ...max.toArray()]], 2, [{ begin: 0, end: 2 }]);
  return bounds;
}

/** The nearest segment or organ on a ray, or nothing. `onePixel`: its size at distance 1; thin lines get some pixels. */
export function pick(geometry: Geometry, origin: Vector3, direction: Vector3, onePixel: number): Picked | null {
  const { segments, organs } = geometry;
  let nearest = Infinity;
  let found: Picked | null = null;
  const describe = (table: typeof segments | typeof organs, row: number) => ({
    plant: table.column("Plant" as never)[row],
    module: table.column("Module" as never)[row],
    symbol: geometry.symbols[table.column("Symbol" as never)[row]],
    order: table.column("Order" as never)[row],
  });
  const segment = nearestSegment(geometry, origin, direction, onePixel);
  if (segment) {
    nearest = segment.distance;
    const start = segments.column("Start").subarray(3 * segment.row, 3 * segment.row + 3);
    const end = segments.column("End").subarray(3 * segment.row, 3 * segment.row + 3);
    found = {
      ...describe(segments, segment.row),
      kind: "segment",
      length: Math.hypot(end[0] - start[0], end[1] - start[1], end[2] - start[2]),
      width: segments.column("StartWidth")[segment.row],
      position: [start[0], start[1], start[2]],
    };
  }
  const organ = nearestOrgan(geometry, origin, direction);
  if (organ && organ.distance < nearest) {
    const at = origin.clone().addScaledVector(direction, organ.distance);
    found = { ...describe(organs, organ.row), kind: "organ", position: [at.x, at.y, at.z] };
  }
  return found;
}

function nearestSegment({ segments, widths }: Geometry, origin: Vector3, direction: Vector3, onePixel: number): { row: number; distance: number } | null {
  const start = segments.column("Start");
  const end = segments.column("End");
  const width = segments.column("StartWidth");
  let best: { row: number; distance: number } | null = null;
  for (let row = 0; row < segments.count; ++row) {
    const i = 3 * row;
    // nearest points of the ray o + t d and the segment a + s u
    const ux = end[i] - start[i];
    const uy = end[i + 1] - start[i + 1];
    const uz = end[i + 2] - start[i + 2];
    const wx = origin.x - start[i];
    const wy = origin.y - start[i + 1];
    const wz = origin.z - start[i + 2];
    const uu = ux * ux + uy * uy + uz * uz;
    const ud = ux * direction.x + uy * direction.y + uz * direction.z;
    const uw = ux * wx + uy * wy + uz * wz;
    const dw = direction.x * wx + direction.y * wy + direction.z * wz;
    const denominator = uu - ud * ud;
    const s = denominator > 1e-12 * uu ? Math.min(Math.max((uw - ud * dw) / denominator, 0), 1) : 0;
    const t = s * ud - dw;
    if (t <= 0 || (best && t >= best.distance)) {
      continue;
    }
    const dx = wx + t * direction.x - s * ux;
    const dy = wy + t * direction.y - s * uy;
    const dz = wz + t * direction.z - s * uz;
    const radius = Math.max(widths === "world" ? width[row] / 2 : 0, 4 * onePixel * t);
    if (dx * dx + dy * dy + dz * dz <= radius * radius) {
      best = { row, distance: t };
    }
  }
  return best;
}

function nearestOrgan({ organs, vertices, triangles }: Geometry, origin: Vector3, direction: Vector3): { row: number; distance: number } | null {
  const positions = vertices.column("Position");
  const corners = triangles.column("Corners");
  const vertexCounts = organs.column("Vertices");
  const triangleCounts = organs.column("Triangles");
  const [a, b, c, e1, e2, p, q, s] = Array.from({ length: 8 }, () => new Vector3());
  let best: { row: number; distance: number } | null = null;
  let vertex = 0;
  let corner = 0;
  for (let row = 0; row < organs.count; ++row) {
    for (const last = corner + 3 * triangleCounts[row]; corner < last; corner += 3) {
      a.fromArray(positions as never, 3 * (vertex + corners[corner]));
      b.fromArray(positions as never, 3 * (vertex + corners[corner + 1]));
      c.fromArray(positions as never, 3 * (vertex + corners[corner + 2]));
      // Möller and Trumbore, 1997
      e1.subVectors(b, a);
      e2.subVectors(c, a);
      p.crossVectors(direction, e2);
      const determinant = e1.dot(p);
      if (Math.abs(determinant) < 1e-14) {
        continue;
      }
      s.subVectors(origin, a);
      const u = s.dot(p) / determinant;
      q.crossVectors(s, e1);
      const v = direction.dot(q) / determinant;
      const t = e2.dot(q) / determinant;
      if (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && (!best || t < best.distance)) {
        best = { row, distance: t };
      }
    }
    vertex += vertexCounts[row];
  }
  return best;
}
