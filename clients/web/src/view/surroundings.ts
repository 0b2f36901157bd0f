// The things around the plants, from the settings of the environment: solids, boxes of grids, directions, and the last queries.
import {
  ArrowHelper,
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  EdgesGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  PlaneGeometry,
  Points,
  PointsMaterial,
  SphereGeometry,
  Vector3,
} from "three";
import type { Object3D, Raycaster } from "three";
import { scaleColour } from "./colours.js";
import type { Legend } from "./colours.js";

/** A solid of a process: the row of a list of its settings. */
export interface Solid {
  process: number;
  list: string;
  row: number;
}

type Process = Record<string, unknown>;

const SOLID = 0x7d8a94;
const POINT = 0xe0a020;
const ARROW = 0xd07a10;

const rows = (process: Process, list: string, length: number): number[][] =>
  (Array.isArray(process[list]) ? (process[list] as unknown[]) : []).filter((row): row is number[] => Array.isArray(row) && row.length >= length && row.every(Number.isFinite));
const triple = (value: unknown): number[] | null => (Array.isArray(value) && value.length === 3 && value.every(Number.isFinite) ? (value as number[]) : null);

/** How many numbers of a row are places that move with the solid. */
const PLACES: Record<string, number> = { spheres: 3, boxes: 6, capsules: 6, points: 3 };

/** The processes after a solid has moved. */
export function withMoved(processes: unknown[], { process, list, row }: Solid, by: number[]): unknown[] {
  const moved = (numbers: number[]) => numbers.map((x, i) => (i < PLACES[list] ? Number((x + by[i % 3]).toPrecision(6)) : x));
  return processes.map((one, i) => (i === process ? { ...(one as Process), [list]: ((one as Process)[list] as number[][]).map((numbers, k) => (k === row ? moved(numbers) : numbers)) } : one));
}

export class Surroundings {
  readonly group = new Group();
  legend: Legend | null = null;
  private readonly solids = new Group();
  private readonly queries = new Points(new BufferGeometry(), new PointsMaterial({ size: 7, sizeAttenuation: false, vertexColors: true }));

  constructor() {
    this.queries.visible = false;
    this.queries.frustumCulled = false;
    this.group.add(this.solids, this.queries);
  }

  /** Shows the processes of an environment. `radius`: half the size of the plants. */
  show(processes: unknown[], centre: Vector3, radius: number): void {
    for (const object of [...this.solids.children]) {
      this.solids.remove(object);
      object.traverse((part) => (part as Mesh).geometry?.dispose());
    }
    processes.forEach((one, process) => {
      const settings = one as Process;
      const add = (object: Object3D, list: string, row: number) => {
        object.userData = { process, list, row } satisfies Solid;
        this.solids.add(object);
      };
      rows(settings, "spheres", 4).forEach(([x, y, z, r], row) => add(at(solid(new SphereGeometry(r, 32, 20)), x, y, z), "spheres", row));
      rows(settings, "boxes", 6).forEach(([a, b, c, d, e, f], row) => add(at(boxOf(new BoxGeometry(d - a, e - b, f - c), Math.max(d - a, e - b, f - c) > 2 * radius), (a + d) / 2, (b + e) / 2, (c + f) / 2), "boxes", row));
      rows(settings, "capsules", 7).forEach((numbers, row) => add(capsule(numbers), "capsules", row));
      rows(settings, "points", 3).slice(0, 500).forEach(([x, y, z], row) => add(at(solid(new SphereGeometry(radius * 0.03, 16, 10), POINT, 0.9), x, y, z), "points", row));
      rows(settings, "planes", 6).forEach((numbers) => this.solids.add(plane(numbers, radius)));
      this.grid(settings);
      const arrow = settings.type === "light" && settings.sun === "direction" ? triple(settings.sunDirection ?? [0, 1, 0]) : settings.type === "wind" ? triple(settings.direction ?? [1, 0, 0]) : null;
      if (arrow) {
        this.solids.add(arrowOf(new Vector3(...arrow), settings.type === "light", centre, radius));
      }
    });
  }

  private grid({ position, domainSize, gridSize, cellSize }: Process): void {
    const corner = triple(position);
    const cells = triple(gridSize);
    const each = typeof cellSize === "number" ? [cellSize, cellSize, cellSize] : triple(cellSize);
    const size = triple(domainSize) ?? (cells && each ? cells.map((n, i) => n * each[i]) : null);
    if (corner && size) {
      const edges = new LineSegments(new EdgesGeometry(new BoxGeometry(...(size as [number, number, number]))), new LineBasicMaterial({ color: SOLID }));
      this.solids.add(at(edges, ...(corner.map((x, i) => x + size[i] / 2) as [number, number, number])));
    }
  }

  /** Shows where the last step asked, coloured by the first number of the answer; nothing: not at all. */
  showQueries(found: Array<{ position: number[]; answer: number }> | null): void {
    this.queries.visible = found !== null && found.length > 0;
    this.legend = null;
    if (!found || found.length === 0) {
      return;
    }
    const answers = found.map(({ answer }) => answer).filter(Number.isFinite);
    const low = answers.reduce((least, x) => Math.min(least, x), Infinity);
    const high = answers.reduce((most, x) => Math.max(most, x), -Infinity);
    const colourOf = (x: number) => (Number.isFinite(x) ? scaleColour((x - low) / (high - low || 1)) : 0x888888);
    const geometry = this.queries.geometry;
    geometry.dispose();
    geometry.setAttribute("position", new BufferAttribute(Float32Array.from(found.flatMap(({ position }) => position)), 3));
    const bytes = found.flatMap(({ answer }) => [colourOf(answer) >> 16, (colourOf(answer) >> 8) & 255, colourOf(answer) & 255]);
    geometry.setAttribute("color", new BufferAttribute(Float32Array.from(bytes, (byte) => (byte / 255) ** 2.2), 3));
    const colours = Array.from({ length: 9 }, (_, i) => `#${scaleColour(i / 8).toString(16).padStart(6, "0")}`);
    this.legend = answers.length > 0 ? { title: "answers of the last step", scale: { colours, low, high } } : null;
  }

  /** The nearest solid that a ray meets. */
  pick(caster: Raycaster): { solid: Solid; point: Vector3; distance: number } | null {
    const [hit] = this.group.visible ? caster.intersectObjects(this.solids.children, false).filter(({ object }) => object instanceof Mesh && "list" in object.userData) : [];
    return hit ? { solid: hit.object.userData as Solid, point: hit.point, distance: hit.distance } : null;
  }

  /** How many solids are shown, and how many queries. */
  figures(): { solids: number; queries: number } {
    return { solids: this.solids.children.length, queries: this.queries.visible ? this.queries.geometry.getAttribute("position").count : 0 };
  }
}

function at<T extends Object3D>(object: T, x: number, y: number, z: number): T {
  object.position.set(x, y, z);
  return object;
}

function solid(geometry: BufferGeometry, colour = SOLID, opacity = 0.45): Mesh {
  return new Mesh(geometry, new MeshLambertMaterial({ color: colour, transparent: true, opacity, depthWrite: opacity > 0.8 }));
}

/** A box that is larger than the plants would hide them: only its edges are shown. */
function boxOf(geometry: BoxGeometry, isLarge: boolean): Object3D {
  return isLarge ? new LineSegments(new EdgesGeometry(geometry), new LineBasicMaterial({ color: SOLID })) : solid(geometry);
}

function capsule([ax, ay, az, bx, by, bz, radius]: number[]): Mesh {
  const along = new Vector3(bx - ax, by - ay, bz - az);
  const mesh = at(solid(new CapsuleGeometry(radius, along.length(), 8, 20)), (ax + bx) / 2, (ay + by) / 2, (az + bz) / 2);
  mesh.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), along.lengthSq() > 0 ? along.normalize() : new Vector3(0, 1, 0));
  return mesh;
}

function plane([x, y, z, nx, ny, nz]: number[], radius: number): Object3D {
  const edges = new LineSegments(new EdgesGeometry(new PlaneGeometry(3 * radius, 3 * radius)), new LineBasicMaterial({ color: SOLID }));
  edges.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(nx, ny, nz).normalize());
  return at(edges, x, y, z);
}

/** Of the sun: towards the plants. Of wind: across them. */
function arrowOf(direction: Vector3, isSun: boolean, centre: Vector3, radius: number): Object3D {
  const unit = direction.clone().normalize();
  const begin = centre.clone().addScaledVector(unit, isSun ? 1.3 * radius : -1.15 * radius);
  return new ArrowHelper(isSun ? unit.negate() : unit, begin, radius * 0.5, ARROW, radius * 0.14, radius * 0.07);
}
