// A field of the environment: a slice through it in colours, and the surface on which it has one value.
import { Box3, BufferAttribute, BufferGeometry, DataTexture, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, NearestFilter, PlaneGeometry, SRGBColorSpace, Vector3 } from "three";
import { scaleColour } from "./colours.js";
import type { Legend } from "./colours.js";

export interface Field {
  name: string;
  unit: string;
  cells: [number, number, number];
  position: [number, number, number]; // corner with the smallest coordinates
  cellSize: [number, number, number];
  values: Float64Array; // by cell, x fastest, then y, then z
}

export interface FieldLook {
  axis: 0 | 1 | 2;
  /** Where the slice is, as a part of the box along the axis. */
  place: number;
  /** The value of the surface, as a part of the range; null: no surface. */
  level: number | null;
}

/** Reads VTK image data (.vti) with one field as the server writes it: doubles in base64 after an 8-byte length. */
export function readVti(name: string, unit: string, text: string): Field {
  const xml = new DOMParser().parseFromString(text, "text/xml");
  const image = xml.querySelector("ImageData");
  const data = xml.querySelector("CellData DataArray");
  if (!image || !data) {
    throw new Error(`The server sent no image data for the field '${name}'.`);
  }
  const numbers = (attribute: string) => image.getAttribute(attribute)!.trim().split(/\s+/).map(Number);
  const [x0, x1, y0, y1, z0, z1] = numbers("WholeExtent");
  const bytes = Uint8Array.from(atob(data.textContent!.trim()), (character) => character.charCodeAt(0));
  const count = (x1 - x0) * (y1 - y0) * (z1 - z0);
  const view = new DataView(bytes.buffer);
  const head = bytes.length - 8 * count;
  const values = Float64Array.from({ length: count }, (_, i) => view.getFloat64(head + 8 * i, true));
  return {
    name,
    unit,
    cells: [x1 - x0, y1 - y0, z1 - z0],
    position: numbers("Origin") as Field["position"],
    cellSize: numbers("Spacing") as Field["cellSize"],
    values,
  };
}

export function fieldBox({ cells, position, cellSize }: Field): Box3 {
  const low = new Vector3(...position);
  return new Box3(low, new Vector3(...cells).multiply(new Vector3(...cellSize)).add(low));
}

export function rangeOf({ values }: Field): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (Number.isFinite(value)) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  return low <= high ? [low, high] : [0, 0];
}

/** The cells of a slice: their two axes, how many they are, and their values, row by row. */
export function sliceOf({ cells, values }: Field, { axis, place }: FieldLook): { right: number; up: number; width: number; height: number; values: Float64Array } {
  const [right, up] = [[2, 1], [0, 2], [0, 1]][axis];
  const [width, height] = [cells[right], cells[up]];
  const strides = [1, cells[0], cells[0] * cells[1]];
  const layer = Math.min(Math.floor(place * cells[axis]), cells[axis] - 1);
  const found = new Float64Array(width * height);
  for (let j = 0; j < height; ++j) {
    for (let i = 0; i < width; ++i) {
      found[j * width + i] = values[layer * strides[axis] + i * strides[right] + j * strides[up]];
    }
  }
  return { right, up, width, height, values: found };
}

// six tetrahedra of a cube about the diagonal from corner 0 to corner 7; bit 0 of a corner is x, bit 1 y, bit 2 z
const TETRAHEDRA = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/** Triangles on which the values between the centres of cells are `level` (marching tetrahedra; Doi and Koide, 1991). */
export function isoSurface({ cells, position, cellSize, values }: Field, level: number): Float32Array {
  const [nx, ny, nz] = cells;
  const corners: number[] = [];
  const places = Array.from({ length: 8 }, () => [0, 0, 0]);
  const held = new Float64Array(8);
  const cut = (a: number, b: number) => {
    const t = (level - held[a]) / (held[b] - held[a]);
    for (let axis = 0; axis < 3; ++axis) {
      corners.push(places[a][axis] + t * (places[b][axis] - places[a][axis]));
    }
  };
  for (let z = 0; z + 1 < nz; ++z) {
    for (let y = 0; y + 1 < ny; ++y) {
      for (let x = 0; x + 1 < nx; ++x) {
        let above = 0;
        for (let k = 0; k < 8; ++k) {
          const at = [x + (k & 1), y + ((k >> 1) & 1), z + (k >> 2)];
          held[k] = values[at[0] + nx * (at[1] + ny * at[2])];
          above += held[k] > level ? 1 : 0;
          places[k] = at.map((cell, axis) => position[axis] + (cell + 0.5) * cellSize[axis]);
        }
        if (above === 0 || above === 8) {
          continue;
        }
        for (const tetrahedron of TETRAHEDRA) {
          const inside = tetrahedron.filter((k) => held[k] > level);
          const outside = tetrahedron.filter((k) => !(held[k] > level));
          if (inside.length === 1 || outside.length === 1) {
            const [one, others] = inside.length === 1 ? [inside[0], outside] : [outside[0], inside];
            others.forEach((other) => cut(one, other));
          } else if (inside.length === 2) {
            const [[a, b], [c, d]] = [inside, outside];
            [[a, c], [a, d], [b, d], [a, c], [b, d], [b, c]].forEach(([from, to]) => cut(from, to));
          }
        }
      }
    }
  }
  return Float32Array.from(corners);
}

/** The part of the view that shows a field. */
export class FieldView {
  readonly group = new Group();
  legend: Legend | null = null;

  show(field: Field | null, look: FieldLook): void {
    for (const part of [...this.group.children] as Array<Mesh<BufferGeometry, MeshBasicMaterial>>) {
      this.group.remove(part);
      part.material.map?.dispose();
      part.material.dispose();
      part.geometry.dispose();
    }
    this.legend = null;
    if (!field) {
      return;
    }
    const [low, high] = rangeOf(field);
    this.group.add(slice(field, look, low, high));
    if (look.level !== null && high > low) {
      this.group.add(surface(field, low + look.level * (high - low), scaleColour(look.level)));
    }
    const colours = Array.from({ length: 9 }, (_, i) => `#${scaleColour(i / 8).toString(16).padStart(6, "0")}`);
    this.legend = { title: `${field.name}${field.unit && field.unit !== "1" ? `, ${field.unit}` : ""}`, scale: { colours, low, high } };
  }
}

function slice(field: Field, look: FieldLook, low: number, high: number): Mesh {
  const { right, up, width, height, values } = sliceOf(field, look);
  const pixels = new Uint8Array(4 * width * height);
  values.forEach((value, i) => {
    const colour = Number.isFinite(value) ? scaleColour((value - low) / (high - low || 1)) : 0x888888;
    pixels.set([colour >> 16, (colour >> 8) & 255, colour & 255, 255], 4 * i);
  });
  const texture = new DataTexture(pixels, width, height);
  texture.colorSpace = SRGBColorSpace;
  texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  const size = field.cells.map((count, axis) => count * field.cellSize[axis]);
  const mesh = new Mesh(new PlaneGeometry(size[right], size[up]), new MeshBasicMaterial({ map: texture, side: DoubleSide, transparent: true, opacity: 0.85, depthWrite: false }));
  // the plane's right and up become the axes of the slice
  const axes = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  axes[0][right] = 1;
  axes[1][up] = 1;
  axes[2][look.axis] = 1;
  mesh.matrix.set(axes[0][0], axes[1][0], axes[2][0], 0, axes[0][1], axes[1][1], axes[2][1], 0, axes[0][2], axes[1][2], axes[2][2], 0, 0, 0, 0, 1);
  const layer = Math.min(Math.floor(look.place * field.cells[look.axis]), field.cells[look.axis] - 1);
  const centre = field.position.map((corner, axis) => corner + (axis === look.axis ? (layer + 0.5) * field.cellSize[axis] : size[axis] / 2));
  mesh.matrix.setPosition(centre[0], centre[1], centre[2]);
  mesh.matrixAutoUpdate = false;
  mesh.matrixWorldNeedsUpdate = true;
  return mesh;
}

function surface(field: Field, level: number, colour: number): Mesh {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(isoSurface(field, level), 3));
  geometry.computeVertexNormals();
  return new Mesh(geometry, new MeshLambertMaterial({ color: colour, side: DoubleSide, transparent: true, opacity: 0.5, depthWrite: false }));
}
