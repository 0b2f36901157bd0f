// All organs as one mesh: leaves, polygons, surfaces, spheres.
import { BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Mesh, MeshLambertMaterial, Sphere } from "three";
import type { Geometry } from "espalier";

export class Organs {
  readonly mesh: Mesh<BufferGeometry, MeshLambertMaterial>;
  count = 0;
  private begins = new Uint32Array(1); // first vertex of each organ, and the end

  constructor() {
    const material = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide });
    // the colours are bytes as a screen shows them; light needs them linear
    material.onBeforeCompile = (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace(
        "#include <color_fragment>",
        "#include <color_fragment>\ndiffuseColor.rgb = pow(diffuseColor.rgb, vec3(2.2));",
      );
    };
    this.mesh = new Mesh(new BufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
  }

  update({ organs, vertices, triangles }: Geometry): void {
    const { geometry } = this.mesh;
    const counts = organs.column("Vertices");
    const triangleCounts = organs.column("Triangles");
    this.begins = new Uint32Array(organs.count + 1);
    for (let i = 0; i < organs.count; ++i) {
      this.begins[i + 1] = this.begins[i] + counts[i];
    }
    const positions = new Float32Array(vertices.column("Position"));
    const corners = triangles.column("Corners");
    const index = new Uint32Array(corners.length);
    let at = 0;
    for (let organ = 0; organ < organs.count; ++organ) {
      const begin = this.begins[organ];
      for (const end = at + 3 * triangleCounts[organ]; at < end; ++at) {
        index[at] = begin + corners[at];
      }
    }
    const isLarger = positions.length > (geometry.getAttribute("position")?.array.length ?? 0) || index.length > (geometry.index?.array.length ?? 0);
    if (isLarger) {
      const room = Math.ceil((positions.length / 3) * 1.4) * 3;
      geometry.dispose();
      for (const name of ["position", "normal"]) {
        geometry.setAttribute(name, new BufferAttribute(new Float32Array(room), 3).setUsage(DynamicDrawUsage));
      }
      geometry.setAttribute("color", new BufferAttribute(new Uint8Array((room / 3) * 4), 4, true).setUsage(DynamicDrawUsage));
      geometry.setIndex(new BufferAttribute(new Uint32Array(Math.ceil(index.length * 1.4)), 1).setUsage(DynamicDrawUsage));
    }
    if (geometry.index) {
      (geometry.getAttribute("position").array as Float32Array).set(positions);
      (geometry.getAttribute("normal").array as Float32Array).set(normalsOf(positions, index));
      (geometry.index.array as Uint32Array).set(index);
      geometry.getAttribute("position").needsUpdate = true;
      geometry.getAttribute("normal").needsUpdate = true;
      geometry.index.needsUpdate = true;
    }
    geometry.setDrawRange(0, index.length);
    geometry.boundingSphere = new Sphere(undefined, Infinity);
    this.count = organs.count;
  }

  /** `paint(organ)` gives 0xRRGGBB. */
  paint(paint: (organ: number) => number): void {
    const colours = this.mesh.geometry.getAttribute("color") as BufferAttribute | undefined;
    if (!colours) {
      return;
    }
    for (let organ = 0; organ + 1 < this.begins.length; ++organ) {
      const colour = paint(organ);
      for (let i = this.begins[organ]; i < this.begins[organ + 1]; ++i) {
        colours.array[4 * i] = colour >> 16;
        colours.array[4 * i + 1] = (colour >> 8) & 255;
        colours.array[4 * i + 2] = colour & 255;
        colours.array[4 * i + 3] = 255;
      }
    }
    colours.needsUpdate = true;
  }
}

/** Smooth normals: the triangles of an organ share its vertices. */
function normalsOf(positions: Float32Array, index: Uint32Array): Float32Array {
  const normals = new Float32Array(positions.length);
  for (let i = 0; i < index.length; i += 3) {
    const [a, b, c] = [3 * index[i], 3 * index[i + 1], 3 * index[i + 2]];
    const ux = positions[b] - positions[a];
    const uy = positions[b + 1] - positions[a + 1];
    const uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a];
    const vy = positions[c + 1] - positions[a + 1];
    const vz = positions[c + 2] - positions[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    for (const corner of [a, b, c]) {
      normals[corner] += nx;
      normals[corner + 1] += ny;
      normals[corner + 2] += nz;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    normals[i] /= length;
    normals[i + 1] /= length;
    normals[i + 2] /= length;
  }
  return normals;
}
