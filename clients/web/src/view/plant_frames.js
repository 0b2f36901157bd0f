// Frames of pages that hold a plant: base64 texts of binary glTF files, plain, or packed as frame_packing.py of the Python package does.

const SIZES = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };
const SETTERS = { 5120: "setInt8", 5121: "setUint8", 5122: "setInt16", 5123: "setUint16", 5125: "setUint32", 5126: "setFloat32" };
const COMPONENTS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };
const GLTF = 0x46546c67; // the first four bytes of a .glb file

/** The .glb file (an ArrayBuffer) of a frame. */
export async function readFrame(base64) {
  const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  // gzip begins with these two
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) {
    return bytes.buffer;
  }
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const buffer = await new Response(unpacked).arrayBuffer();
  return buffer.byteLength >= 4 && new DataView(buffer).getUint32(0, true) === GLTF ? buffer : unpackFrame(buffer);
}

/** The .glb file of a packed frame. */
export function unpackFrame(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const packed = new Uint8Array(buffer, 4 + length);
  const text = new TextEncoder().encode(JSON.stringify(gltf));
  const textSize = Math.ceil(text.length / 4) * 4;
  const dataSize = Math.ceil(Math.max(0, ...(gltf.bufferViews ?? []).map((view) => (view.byteOffset ?? 0) + view.byteLength)) / 4) * 4;
  const file = new ArrayBuffer(28 + textSize + dataSize);
  const head = new DataView(file);
  [GLTF, 2, file.byteLength, textSize, 0x4e4f534a].forEach((word, i) => head.setUint32(4 * i, word, true));
  new Uint8Array(file, 20, textSize).fill(32).set(text);
  head.setUint32(20 + textSize, dataSize, true);
  head.setUint32(24 + textSize, 0x004e4942, true);
  const data = new DataView(file, 28 + textSize);
  let at = 0;
  for (const accessor of gltf.accessors ?? []) {
    at = unpackAccessor(gltf.bufferViews[accessor.bufferView], accessor, packed, at, data);
  }
  for (const { bufferView, packedBytes } of (gltf.images ?? []).filter(({ packedBytes: size }) => size !== undefined)) {
    new Uint8Array(file, 28 + textSize + (gltf.bufferViews[bufferView].byteOffset ?? 0)).set(packed.subarray(at, at + packedBytes));
    at += packedBytes;
  }
  return file;
}

// writes the numbers of an accessor to their places, and returns where its packed bytes end
function unpackAccessor(view, { componentType, type, count, byteOffset = 0, packed: { low, step, bytes } }, packed, begin, data) {
  const size = SIZES[componentType];
  const components = COMPONENTS[type];
  const stride = view.byteStride ?? size * components;
  // exact floats are their bits
  const setter = SETTERS[componentType === 5126 && step === undefined ? 5125 : componentType];
  let at = begin;
  for (let component = 0; component < components; ++component) {
    const width = bytes[component];
    let place = (view.byteOffset ?? 0) + byteOffset + component * size;
    let number = 0;
    for (let i = 0; i < count; ++i, place += stride) {
      let folded = 0;
      for (let byte = width - 1; byte >= 0; --byte) {
        folded = folded * 256 + packed[at + byte * count + i];
      }
      number += folded % 2 === 0 ? folded / 2 : -(folded + 1) / 2;
      data[setter](place, step === undefined ? number : low[component] + number * step, true);
    }
    at += width * count;
  }
  return at;
}
