"""Meshes of plants as `espalier run -o plant.vtp` writes them, and polygons as VTK writes them; OBJ out."""

from __future__ import annotations

import math
import os
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

from .arrays import TYPES, Arrays, SurveyError as SurveyError

Point = Tuple[float, float, float]
MOST_BYTES = 1_000_000_000


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


def _whole_numbers(array: "xml.Element", file: Arrays) -> List[int]:
    numbers = file.numbers(array)
    if not all(isinstance(number, int) for number in numbers):
        raise SurveyError(f"the numbers of '{array.get('Name')}' are not whole: get a complete copy.")
    return [int(number) for number in numbers]


def _piece(piece: "xml.Element", file: Arrays, mesh: VtpMesh) -> None:
    def arrays(part: str) -> Dict[str, "xml.Element"]:
        return {array.get("Name", ""): array for holder in piece.findall(part) for array in holder.findall("DataArray")}

    first = len(mesh.points)
    places = [file.numbers(array) for array in arrays("Points").values()]
    if len(places) != 1 or len(places[0]) % 3 or not all(abs(number) < 1e15 for number in places[0]):
        raise SurveyError("a piece has no points of three numbers below 1e15: get a complete copy.")
    mesh.points.extend(zip(places[0][0::3], places[0][1::3], places[0][2::3]))
    polygons = arrays("Polys")
    if not {"connectivity", "offsets"} <= set(polygons):
        raise SurveyError("a piece has no polygons: give a .vtp file of a mesh.")
    corners, ends = (_whole_numbers(polygons[name], file) for name in ("connectivity", "offsets"))
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
            values = file.numbers(array)
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
    """Reads a .vtp file. Raises SurveyError."""
    require_file(path)
    try:
        if Path(path).stat().st_size > MOST_BYTES:
            raise SurveyError(f"it has more than {MOST_BYTES} bytes: write it with a smaller --detail.")
        file = Arrays(Path(path).read_bytes(), "PolyData")
        mesh = VtpMesh([], [], {})
        for piece in file.top.iter("Piece"):
            _piece(piece, file, mesh)
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
