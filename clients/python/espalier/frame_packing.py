"""Binary glTF files made small for a page: numbers as differences, sorted by bytes, then deflated.

`plant_frames.js` of clients/web is the other side. A packed frame is gzip of: the length of a JSON text (4 bytes, little-endian),
the text, and the data. The text is the file's own; each accessor has `packed`, and each image `packedBytes`.
"""

from __future__ import annotations

import gzip
import json
import struct
import sys
from array import array
from typing import Any, Dict, List, Sequence, Tuple

# Bits of a coordinate, as a part of the widest side of the accessor's box: 1/16384 of a plant is less than a pixel. Those of a normal
# turn it by less than half a degree.
COORDINATE_BITS = 14
NORMAL_BITS = 8
FLOAT = 5126
CODES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", FLOAT: "f"}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
ROUNDED = ("POSITION", "NORMAL", "TRANSLATION", "ROTATION", "SCALE")


def pack_frame(frame: bytes) -> bytes:
    """The packed form of a binary glTF file (.glb, version 2, one buffer). Coordinates are rounded to 14 bits of their box, normals to
    8 bits; all other numbers stay as they are. What is not such a file,
    or has sparse accessors, is only deflated."""
    if frame[:4] != b"glTF" or len(frame) < 28:
        return gzip.compress(frame, 9, mtime=0)
    size = struct.unpack_from("<I", frame, 12)[0]
    document = json.loads(frame[20:20 + size])
    if any("bufferView" not in accessor or "sparse" in accessor for accessor in document.get("accessors", [])):
        return gzip.compress(frame, 9, mtime=0)
    data = frame[28 + size:]
    uses = _uses(document)
    parts: List[bytes] = []
    for index, accessor in enumerate(document.get("accessors", [])):
        bits = 0
        if accessor["componentType"] == FLOAT and uses.get(index) in ROUNDED:
            bits = NORMAL_BITS if uses[index] == "NORMAL" else COORDINATE_BITS
        packed, part = _pack_columns(_columns(document, accessor, data), bits)
        accessor["packed"] = packed
        parts.append(part)
    for image in document.get("images", []):
        if "bufferView" in image:
            view = document["bufferViews"][image["bufferView"]]
            start = view.get("byteOffset", 0)
            image["packedBytes"] = view["byteLength"]
            parts.append(data[start:start + view["byteLength"]])
    text = json.dumps(document, separators=(",", ":")).encode("utf-8")
    return gzip.compress(b"".join([struct.pack("<I", len(text)), text, *parts]), 9, mtime=0)


def _uses(document: Dict[str, Any]) -> Dict[int, str]:
    """The use of each accessor."""
    found: Dict[int, str] = {}
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            found.update({index: name for name, index in primitive["attributes"].items()})
    for node in document.get("nodes", []):
        copies = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
        found.update({index: name for name, index in copies.items()})
    return found


def _columns(document: Dict[str, Any], accessor: Dict[str, Any], data: bytes) -> List["array[Any]"]:
    """The numbers of an accessor, component by component; those that are not float32 as they are, float32 as such."""
    view = document["bufferViews"][accessor["bufferView"]]
    code = CODES[accessor["componentType"]]
    width = array(code).itemsize
    count = COMPONENTS[accessor["type"]]
    stride = view.get("byteStride", width * count) // width
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    numbers = array(code)
    numbers.frombytes(data[start:start + width * ((accessor["count"] - 1) * stride + count)] if accessor["count"] else b"")
    if sys.byteorder == "big":
        numbers.byteswap()
    return [numbers[component::stride] for component in range(count)]


def _pack_columns(columns: Sequence["array[Any]"], bits: int) -> Tuple[Dict[str, Any], bytes]:
    """How to unpack them, and their bytes. `bits` of 0: exact."""
    lows = [min(column, default=0.0) for column in columns]
    step = 0.0
    if bits > 0:
        step = max(max(column, default=0.0) - low for column, low in zip(columns, lows)) / ((1 << bits) - 1)
    packed: Dict[str, Any] = {"low": lows, "step": step} if bits > 0 else {}
    widths: List[int] = []
    parts: List[bytes] = []
    for column, low in zip(columns, lows):
        if bits > 0:
            scale = 1 / step if step > 0 else 0.0
            numbers = [int((number - low) * scale + 0.5) for number in column]
        elif column.typecode == "f":
            numbers = array("I", column.tobytes()).tolist()
        else:
            numbers = column.tolist()
        # differences; then their sign moves to the last bit, so that small ones have high bytes of 0
        changes = [now - before for now, before in zip(numbers, [0, *numbers])]
        folded = [2 * change if change >= 0 else -2 * change - 1 for change in changes]
        largest = max(folded, default=0)
        width = 1 if largest < 1 << 8 else 2 if largest < 1 << 16 else 8
        code = {1: "B", 2: "H", 8: "Q"}[width]
        raw = array(code, folded)
        if sys.byteorder == "big":
            raw.byteswap()
        stored = raw.tobytes()
        # a difference of two 32-bit numbers has 33 bits
        kept = 5 if width == 8 else width
        parts.extend(stored[byte::width] for byte in range(kept))
        widths.append(kept)
    packed["bytes"] = widths
    return packed, b"".join(parts)
