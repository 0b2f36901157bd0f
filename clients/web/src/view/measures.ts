// What is where: bounds of the plants, and the thing that a ray meets.
import { Box3, Vector3 } from "three";
import type { Geometry } from "espalier";

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

export function boundsOf({ segments, vertices }: Geometry): Box3 {
  const box = new Box3();
  const point = new Vector3();
  for (const values of [segments.column("Start"), segments.column("End"), vertices.column("Position")]) {
    for (let i = 0; i < values.length; i += 3) {
      box.expandByPoint(point.set(values[i], values[i + 1], values[i + 2]));
    }
  }
  return box;
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
