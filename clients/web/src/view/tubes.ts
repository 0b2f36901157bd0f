// Segments as instanced tubes: 32 bytes each on the GPU, one draw call.
import {
  BufferAttribute,
  DynamicDrawUsage,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  DataUtils,
  Mesh,
  MeshDepthMaterial,
  MeshLambertMaterial,
  RGBADepthPacking,
  Sphere,
  Vector2,
} from "three";
import type { WebGLProgramParametersWithUniforms } from "three";
import type { Geometry, RowRange } from "espalier";

// more segments get simpler tubes
const MANY = 150_000;
const VERY_MANY = 500_000;
const NEAR = 512; // rows

type Caps = "none" | "pointed" | "round";

/** A tube of unit length and radius. Of each vertex: the place around the axis in two radii, the place along it (0 or 1), and how many radii it lies beyond the end. */
function tube(sides: number, caps: Caps): { positions: Float32Array; index: number[] } {
  // rings: place along the axis (0 or 1), radius, beyond the end
  const round = caps === "round" ? [0, Math.SQRT1_2, 1] : [0, 1];
  const rings = caps !== "none"
    ? [...round.map((r) => [0, r, -Math.sqrt(1 - r * r)]), ...round.reverse().map((r) => [1, r, Math.sqrt(1 - r * r)])]
    : [[0, 1, 0], [1, 1, 0]];
  const positions: number[] = [];
  const index: number[] = [];
  rings.forEach(([along, radius, beyond], ring) => {
    for (let side = 0; side < sides; ++side) {
      const angle = (2 * Math.PI * side) / sides;
      positions.push(radius * Math.cos(angle), radius * Math.sin(angle), along, beyond);
      if (ring > 0) {
        const a = (ring - 1) * sides + side;
        const b = (ring - 1) * sides + ((side + 1) % sides);
        index.push(a, b, a + sides, b, b + sides, a + sides);
      }
    }
  });
  return { positions: Float32Array.from(positions), index };
}

const DECLARATIONS = /* glsl */ `
attribute vec4 ring;
attribute vec3 segmentStart;
attribute vec3 segmentEnd;
attribute vec2 segmentWidths;
attribute vec4 segmentColour;
uniform float pixelScale;
uniform float leastPixels;
uniform vec2 lowest;
varying vec3 tubeColour;
vec3 tubeNormal;
vec3 tubePosition() {
  vec3 axis = segmentEnd - segmentStart;
  float segmentLength = max(length(axis), 1e-9);
  axis /= segmentLength;
  vec3 side = normalize(abs(axis.y) < 0.9 ? cross(axis, vec3(0.0, 1.0, 0.0)) : cross(axis, vec3(1.0, 0.0, 0.0)));
  vec3 other = cross(axis, side);
  vec3 outwards = ring.x * side + ring.y * other + ring.w * axis;
  vec3 centre = mix(segmentStart, segmentEnd, ring.z);
  float depth = max(-(modelViewMatrix * vec4(centre, 1.0)).z, 0.0);
  float onePixel = pixelScale * depth;
  float radius = 0.5 * mix(segmentWidths.x, segmentWidths.y, ring.z) * (lowest.x > 0.5 ? onePixel : 1.0);
  radius = max(radius, 0.5 * leastPixels * onePixel);
  tubeNormal = normalize(outwards + axis * (segmentWidths.x - segmentWidths.y) * 0.5 / segmentLength);
  return centre + radius * outwards;
}
`;

/** Lets a material of three.js draw tubes. */
function patch(uniforms: Record<string, { value: unknown }>, isLit: boolean) {
  return (shader: WebGLProgramParametersWithUniforms) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>\n${DECLARATIONS}`)
      .replace("#include <begin_vertex>", `vec3 transformed = ${isLit ? "tubePlace" : "tubePosition()"};\ntubeColour = segmentColour.rgb;`);
    if (isLit) {
      shader.vertexShader = shader.vertexShader.replace("#include <beginnormal_vertex>", "vec3 tubePlace = tubePosition();\nvec3 objectNormal = tubeNormal;");
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", "#include <common>\nvarying vec3 tubeColour;")
        .replace("#include <color_fragment>", "diffuseColor.rgb *= pow(tubeColour, vec3(2.2));");
    }
  };
}

/** Ranges that lie close together as one: to send the rows between them costs less than another call. */
function joined(ranges: RowRange[]): RowRange[] {
  const found: RowRange[] = [];
  for (const { begin, end } of ranges) {
    const last = found[found.length - 1];
    if (last && begin - last.end < NEAR) {
      last.end = end;
    } else {
      found.push({ begin, end });
    }
  }
  return found;
}

export class Tubes {
  isCoarse = false; // fewer sides, for a browser that draws slowly
  isSmall = false; // fewest sides, for small pictures
  readonly mesh: Mesh<InstancedBufferGeometry, MeshLambertMaterial>;
  private readonly uniforms = { pixelScale: { value: 0 }, leastPixels: { value: 0.7 }, lowest: { value: new Vector2() } };
  private capacity = 0;
  private shaped = ""; // sides and caps
  private readonly attributes: Record<string, InstancedBufferAttribute> = {};

  constructor() {
    const material = new MeshLambertMaterial();
    material.onBeforeCompile = patch(this.uniforms, true);
    const depth = new MeshDepthMaterial({ depthPacking: RGBADepthPacking });
    depth.onBeforeCompile = patch(this.uniforms, false);
    this.mesh = new Mesh(new InstancedBufferGeometry(), material);
    this.mesh.customDepthMaterial = depth;
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
    this.mesh.geometry.instanceCount = 0;
  }

  /** World units for one pixel at distance 1. */
  setPixelScale(scale: number): void {
    this.uniforms.pixelScale.value = scale;
  }

  /** Bytes on the GPU of one segment. */
  get bytesEach(): number {
    return Object.values(this.attributes).reduce((sum, one) => sum + one.itemSize * one.array.BYTES_PER_ELEMENT, 0);
  }

  get count(): number {
    return this.mesh.geometry.instanceCount;
  }

  /** Takes the rows of `ranges` over. */
  update(geometry: Geometry, ranges: RowRange[]): void {
    const { segments } = geometry;
    const count = segments.count;
    const sides = this.isSmall || count > VERY_MANY ? 4 : this.isCoarse || count > MANY ? 5 : count > 20_000 ? 6 : 10;
    const hasCaps = !this.isSmall && count <= MANY && geometry.widths === "world";
    this.shape(sides, !hasCaps ? "none" : this.isCoarse ? "pointed" : "round");
    const isNew = this.reserve(count);
    const start = segments.column("Start");
    const end = segments.column("End");
    const startWidth = segments.column("StartWidth");
    const endWidth = segments.column("EndWidth");
    const to = { start: this.attributes.segmentStart.array, end: this.attributes.segmentEnd.array, widths: this.attributes.segmentWidths.array };
    for (const { begin, end: last } of isNew ? [{ begin: 0, end: count }] : ranges) {
      for (let i = 3 * begin; i < 3 * last; ++i) {
        to.start[i] = start[i];
        to.end[i] = end[i];
      }
      for (let i = begin; i < last; ++i) {
        to.widths[2 * i] = DataUtils.toHalfFloat(Math.min(startWidth[i], 60000));
        to.widths[2 * i + 1] = DataUtils.toHalfFloat(Math.min(endWidth[i], 60000));
      }
    }
    if (!isNew) {
      this.touch(["segmentStart", "segmentEnd", "segmentWidths"], ranges);
    }
    this.uniforms.lowest.value.set(geometry.widths === "pixels" ? 1 : 0, 0);
    // a width in pixels has no size in the light's picture
    this.mesh.castShadow = geometry.widths === "world";
    this.mesh.geometry.instanceCount = count;
  }

  /** The colours of rows, four bytes each; `paint(i)` gives 0xRRGGBB. */
  paint(ranges: RowRange[], paint: (row: number) => number): void {
    const colours = this.attributes.segmentColour?.array;
    if (!colours) {
      return;
    }
    for (const { begin, end } of ranges) {
      for (let i = begin; i < end; ++i) {
        const colour = paint(i);
        colours[4 * i] = colour >> 16;
        colours[4 * i + 1] = (colour >> 8) & 255;
        colours[4 * i + 2] = colour & 255;
      }
    }
    this.touch(["segmentColour"], ranges);
  }

  private touch(names: string[], ranges: RowRange[]): void {
    const sent = joined(ranges);
    for (const name of names) {
      const attribute = this.attributes[name];
      for (const { begin, end } of sent) {
        attribute.addUpdateRange(begin * attribute.itemSize, (end - begin) * attribute.itemSize);
      }
      attribute.needsUpdate = true;
    }
  }

  private shape(sides: number, caps: Caps): void {
    const shape = `${sides} ${caps}`;
    if (this.shaped === shape) {
      return;
    }
    this.shaped = shape;
    const { positions, index } = tube(sides, caps);
    const { geometry } = this.mesh;
    geometry.setAttribute("ring", new BufferAttribute(positions, 4));
    // three.js counts the vertices of `position`
    geometry.setAttribute("position", new BufferAttribute(new Float32Array((positions.length / 4) * 3), 3));
    geometry.setIndex(index);
    geometry.boundingSphere = new Sphere(undefined, Infinity);
  }

  /** Whether the buffers are new, so that every row must be written. */
  private reserve(count: number): boolean {
    if (count <= this.capacity && this.attributes.segmentStart) {
      return false;
    }
    this.capacity = Math.max(count, 64, Math.ceil(this.capacity * 1.5));
    // frees the buffers, and the number of instances that three.js remembers for them
    this.mesh.geometry.dispose();
    const make = (name: string, array: Float32Array | Uint16Array | Uint8Array, size: number, isNormalized = false) => {
      const attribute = new InstancedBufferAttribute(array, size, isNormalized);
      if (array instanceof Uint16Array) {
        (attribute as unknown as { isFloat16BufferAttribute: boolean }).isFloat16BufferAttribute = true;
      }
      attribute.setUsage(DynamicDrawUsage);
      const before = this.attributes[name]?.array;
      if (before) {
        (attribute.array as Float32Array).set(before as Float32Array);
      }
      this.attributes[name] = attribute;
      this.mesh.geometry.setAttribute(name, attribute);
    };
    make("segmentStart", new Float32Array(3 * this.capacity), 3);
    make("segmentEnd", new Float32Array(3 * this.capacity), 3);
    make("segmentWidths", new Uint16Array(2 * this.capacity), 2);
    make("segmentColour", new Uint8Array(4 * this.capacity), 4, true);
    return true;
  }
}
