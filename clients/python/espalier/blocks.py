"""Arrays that follow a message as raw little-endian numbers.

With NumPy an array is a view of the received bytes; without it a memoryview of the same shape. Nothing is copied.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from .errors import ProtocolError

# the module, or None
numpy: Any
try:
    numpy = importlib.import_module("numpy")
except ImportError:
    numpy = None

# by name: NumPy arrays, memoryviews, or (to be sent) anything else with the buffer protocol
Blocks = Mapping[str, Any]

_FORMATS = {"<f8": "d", "<f4": "f", "<u4": "I"}
_TYPES = {"d": "<f8", "f": "<f4", "I": "<u4"}
_BYTES = {"<f8": 8, "<f4": 4, "<u4": 4}
_ALIGNMENT = 8


def _extents(value: Any, path: str) -> List[int]:
    if not isinstance(value, list) or not all(type(item) is int and item >= 0 for item in value):
        raise ProtocolError(f"{path}: expected a list of whole numbers.")
    return list(value)


def read_blocks(table: Any, raw: bytearray) -> Dict[str, Any]:
    """The arrays of a message by name, as views of its raw bytes."""
    if sys.byteorder != "little":
        raise ProtocolError("Binary blocks are little-endian; this machine is not. Leave out the capability bin.")
    if not isinstance(table, list):
        raise ProtocolError("bin: expected a list.")
    found: Dict[str, Any] = {}
    view = memoryview(raw)
    for index, entry in enumerate(table):
        path = f"bin[{index}]"
        if not isinstance(entry, dict) or not isinstance(entry.get("name"), str):
            raise ProtocolError(f"{path}: expected an object with a name.")
        kind = entry.get("dtype")
        if kind not in _FORMATS:
            raise ProtocolError(f"{path}.dtype: expected one of <f8, <f4, <u4, found {kind!r}.")
        shape = _extents(entry.get("shape"), f"{path}.shape")
        offset, size = _extents([entry.get("offset"), entry.get("bytes")], f"{path}.offset and bytes")
        expected = _BYTES[kind]
        for extent in shape:
            expected *= extent
        if size != expected:
            raise ProtocolError(f"{path}.bytes: shape and dtype make {expected} bytes, found {size}.")
        if offset % _ALIGNMENT != 0 or offset + size > len(raw):
            raise ProtocolError(f"{path}.offset: expected a multiple of 8 within binBytes={len(raw)}, found {offset}.")
        if entry["name"] in found:
            raise ProtocolError(f"{path}.name: '{entry['name']}' occurs twice.")
        piece = view[offset:offset + size]
        if numpy is not None:
            found[entry["name"]] = numpy.frombuffer(piece, dtype=kind).reshape(shape)
        elif size == 0:
            found[entry["name"]] = piece.cast(_FORMATS[kind])
        else:
            found[entry["name"]] = piece.cast(_FORMATS[kind], shape)
    return found


def pack(blocks: Blocks) -> Tuple[List[Dict[str, Any]], List[Any], int]:
    """The table of the arrays of a message, their bytes with padding, and the number of bytes."""
    table: List[Dict[str, Any]] = []
    pieces: List[Any] = []
    offset = 0
    for name, array in blocks.items():
        view = memoryview(array)
        kind = _TYPES.get(view.format.lstrip("<=@"))
        if view.format.lstrip("<=@") == "L" and view.itemsize == 4:
            kind = "<u4"
        if kind is None:
            raise ProtocolError(f"The array '{name}' has the format '{view.format}'; d, f and I can be sent.")
        if not view.c_contiguous:
            view = memoryview(view.tobytes()).cast(_FORMATS[kind], list(view.shape or ()))
        size = view.nbytes
        table.append({"name": name, "dtype": kind, "shape": list(view.shape or ()), "offset": offset, "bytes": size})
        padding = -size % _ALIGNMENT
        pieces.append(view.cast("B") if size else b"")
        if padding:
            pieces.append(bytes(padding))
        offset += size + padding
    return table, pieces, offset


def offsets_of(counts: Sequence[int]) -> List[int]:
    """Where each row begins among concatenated rows, and the end of the last."""
    result = [0]
    for count in counts:
        result.append(result[-1] + count)
    return result
