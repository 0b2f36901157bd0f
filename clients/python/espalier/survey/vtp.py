"""Meshes of plants as `espalier run -o plant.vtp` writes them, and as VTK writes polygons inline; OBJ out."""

from __future__ import annotations

import base64
import binascii
import math
import os
import struct
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

Point = Tuple[float, float, float]
TYPES = {"Float32": "f", "Float64": "d", "Int8": "b", "UInt8": "B", "Int16": "h", "UInt16": "H", "Int32": "i", "UInt32": "I", "Int64": "q", "UInt64": "Q"}
MOST_BYTES = 1_000_000_000


class SurveyError(Exception):
    """A file that cannot be read or written: one sentence, with what to do."""


class VtpMesh(NamedTuple):
    """Polygons with what their cells know."""
    points: List[Point]
    polygons: List[Tuple[int, ...]]  # places in points
    cells: Dict[str, List[float]]  # by name: a value for each polygon; of arrays with one component

    def triangles(self) -> Iterator[Tuple[int, Point, Point, Point]]:
        """The polygons as fans, each with its number."""
        for number, polygon in enumerate(self.polygons):
            for second, third in zip(polygon[1:], polygon[2:]):
                yield number, self.points[polygon[0]], self.points[second], self.points[third]


def _numbers(array: "xml.Element", header: str) -> Tuple[float, ...]:
    kind = TYPES.get(array.get("type", ""))
    name = array.get("Name", "?")
    if kind is None:
        raise SurveyError(f"the array '{name}' has the type {array.get('type')}, which has no numbers.")
    text = array.text or ""
    try:
        if array.get("format") == "ascii":
            return tuple(float(word) if kind in "fd" else int(word) for word in text.split())
        if array.get("format") != "binary":
            raise SurveyError(f"the array '{name}' is {array.get('format')}: write the file with SetDataModeToBinary and without a compressor.")
        raw = base64.b64decode("".join(text.split()), validate=True)
        (size,) = struct.unpack_from(header, raw)
        begin = struct.calcsize(header)
        if size != len(raw) - begin or size % struct.calcsize(kind):
            raise SurveyError(f"the array '{name}' has {len(raw) - begin} bytes and claims {size}: get a complete copy.")
        return struct.unpack_from(f"<{size // struct.calcsize(kind)}{kind}", raw, begin)
    except (ValueError, binascii.Error, struct.error):
        raise SurveyError(f"the array '{name}' is damaged: get a complete copy.") from None


def _whole_numbers(array: "xml.Element", header: str) -> List[int]:
    numbers = _numbers(array, header)
    if not all(isinstance(number, int) for number in numbers):
        raise SurveyError(f"the numbers of '{array.get('Name')}' are not whole: get a complete copy.")
    return [int(number) for number in numbers]


def _piece(piece: "xml.Element", header: str, mesh: VtpMesh) -> None:
    def arrays(part: str) -> Dict[str, "xml.Element"]:
        return {array.get("Name", ""): array for holder in piece.findall(part) for array in holder.findall("DataArray")}

    first = len(mesh.points)
    places = [_numbers(array, header) for array in arrays("Points").values()]
    if len(places) != 1 or len(places[0]) % 3 or not all(abs(number) < 1e15 for number in places[0]):
        raise SurveyError("a piece has no points of three numbers below 1e15: get a complete copy.")
    mesh.points.extend(zip(places[0][0::3], places[0][1::3], places[0][2::3]))
    polygons = arrays("Polys")
    if not {"connectivity", "offsets"} <= set(polygons):
        raise SurveyError("a piece has no polygons: give a .vtp file of a mesh.")
    corners, ends = (_whole_numbers(polygons[name], header) for name in ("connectivity", "offsets"))
    begin = 0
    if not all(0 <= corner < len(places[0]) // 3 for corner in corners):
        raise SurveyError("a polygon has a point that is not there: get a complete copy.")
    count = 0
    for end in ends:
        if not begin + 3 <= end <= len(corners):
            raise SurveyError("a polygon has less than three points: get a complete copy.")
        mesh.polygons.append(tuple(first + corner for corner in corners[begin:end]))
        begin, count = end, count + 1
    for name, array in arrays("CellData").items():
        if array.get("NumberOfComponents", "1") == "1" and array.get("type") in TYPES:
            values = _numbers(array, header)
            if len(values) != count:
                raise SurveyError(f"the array '{name}' has {len(values)} values for {count} polygons: get a complete copy.")
            _fill(mesh.cells.setdefault(name, []), len(mesh.polygons) - count)
            mesh.cells[name].extend(values)


def _fill(values: List[float], count: int) -> None:
    """A name that is not in all pieces has no number in the others."""
    values.extend([math.nan] * (count - len(values)))


def require_file(path: "str | os.PathLike[str]") -> None:
    """Raises SurveyError for what is no file: a pipe would have no end. What is not there is left to the reader."""
    if Path(path).exists() and not Path(path).is_file():
        raise SurveyError(f"{path} is no file: give the name of a file, no pipe, device or folder.")


def read_vtp(path: "str | os.PathLike[str]") -> VtpMesh:
    """Reads a .vtp file with inline arrays that are not compressed. Raises SurveyError."""
    require_file(path)
    try:
        if Path(path).stat().st_size > MOST_BYTES:
            raise SurveyError(f"it has more than {MOST_BYTES} bytes: write it with a smaller --detail.")
        text = Path(path).read_text(encoding="utf-8")
        if "<!" in text:  # entities could grow without bound
            raise SurveyError("it has declarations, which a .vtp file has not: write the file again.")
        top = xml.fromstring(text)
        if top.get("type") != "PolyData" or top.get("byte_order", "LittleEndian") != "LittleEndian" or top.get("compressor"):
            raise SurveyError("it is no little-endian PolyData without a compressor: write it with Espalier, or with SetCompressorTypeToNone.")
        mesh = VtpMesh([], [], {})
        for piece in top.iter("Piece"):
            _piece(piece, "<Q" if top.get("header_type") == "UInt64" else "<I", mesh)
        for values in mesh.cells.values():
            _fill(values, len(mesh.polygons))
    except SurveyError as error:
        raise SurveyError(f"{path}: {error}") from None
    except (OSError, UnicodeDecodeError, xml.ParseError) as error:
        raise SurveyError(f"{path} cannot be read ({error}): give a .vtp file that is complete.") from None
    return mesh


def write_obj(mesh: VtpMesh, path: "str | os.PathLike[str]") -> None:
    """Writes a mesh in the coordinates of the world, as `"meshFile"` of an environment takes it. Raises SurveyError for no polygons."""
    if not mesh.polygons:
        raise SurveyError("there are no polygons: give a mesh with at least one.")

    def line(polygon: Sequence[int]) -> str:
        return "f " + " ".join(str(point + 1) for point in polygon) + "\n"

    with open(path, "w", encoding="ascii") as file:
        file.writelines("v " + " ".join(repr(number) for number in point) + "\n" for point in mesh.points)
        file.writelines(line(polygon) for polygon in mesh.polygons)
