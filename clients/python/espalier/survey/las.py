"""Points of surfaces, and LAS 1.2 files of them (ASPRS, LAS Specification 1.2, point format 0)."""

from __future__ import annotations

import math
import os
import struct
from typing import Iterable, Iterator, List, NamedTuple, Sequence, Tuple

from .vtp import Point, SurveyError, VtpMesh

MOST_POINTS = 100_000_000
HIGH_VEGETATION = 5
_MOST = 2**31 - 1


class LasPoint(NamedTuple):
    place: Point  # in the world
    plant: int  # becomes the point source ID
    organ: int  # becomes the user data


def require_place(origin: Sequence[float]) -> None:
    """Raises SurveyError for an origin that is no place."""
    if not all(abs(number) < 1e15 for number in origin):
        raise SurveyError(f"the origin {','.join(repr(number) for number in origin)} is no place: give finite numbers below 1e15.")


def surface_points(mesh: VtpMesh, spacing: float) -> Iterator[LasPoint]:
    """Points that lie evenly on the triangles: the centres of their equal parts, whose sides are at most `spacing`."""
    if not (spacing > 0 and math.isfinite(spacing)):
        raise SurveyError(f"the spacing {spacing} is no number above 0: give the distance of points.")
    count = 0
    for number, a, b, c in mesh.triangles():
        longest = max(math.dist(a, b), math.dist(b, c), math.dist(c, a))
        parts = max(1, math.ceil(longest / spacing))
        count += parts * parts
        if count > MOST_POINTS:
            raise SurveyError(f"the surface has more than {MOST_POINTS} points: give a larger spacing.")
        # of each row the parts that stand like the triangle, then those upside down
        for row in range(parts):
            for third in range(3 * row + 1, 3 * parts - 1):
                column = third - 3 * row
                if column % 3 == 0:
                    continue
                s, t = (3 * row + (1 if column % 3 == 1 else 2)) / (3 * parts), column / (3 * parts)
                yield LasPoint((a[0] + s * (b[0] - a[0]) + t * (c[0] - a[0]), a[1] + s * (b[1] - a[1]) + t * (c[1] - a[1]),
                                a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2])), _whole(mesh, "plant", number), _whole(mesh, "organ", number))


def _whole(mesh: VtpMesh, name: str, polygon: int) -> int:
    """A number of a polygon; 0 where its piece of the file has none."""
    values = mesh.cells.get(name, [])
    return int(values[polygon]) if polygon < len(values) and abs(values[polygon]) < 1e15 else 0


def write_las(points: Iterable[LasPoint], path: "str | os.PathLike[str]", origin: Sequence[float] = (0.0, 0.0, 0.0), scale: float = 0.001) -> int:
    """Writes the points as high vegetation; a coordinate is a whole multiple of `scale` from the origin. Returns their number."""
    require_place(origin)
    east, north, height = origin
    body, count = bytearray(), 0
    low, high = [_MOST] * 3, [-_MOST] * 3
    for point in points:
        x, y, z = point.place
        whole = [round(x / scale), round(-z / scale), round(y / scale)]
        if not all(-_MOST <= number <= _MOST for number in whole):
            raise SurveyError(f"a point is farther than {_MOST * scale} from the origin: give a larger scale.")
        low = [min(pair) for pair in zip(low, whole)]
        high = [max(pair) for pair in zip(high, whole)]
        # one return of one; the class is that of high vegetation
        body += struct.pack("<3iHBBbBH", *whole, 0, 0b001001, HIGH_VEGETATION, 0, point.organ & 255, point.plant & 65535)
        count += 1
    if count == 0:
        raise SurveyError("there are no points: give a mesh with at least one polygon.")
    offsets = (east, north, height)
    header = bytearray(227)
    struct.pack_into("<4s", header, 0, b"LASF")
    header[24:26] = bytes((1, 2))
    header[26:34], header[58:66] = b"Espalier", b"Espalier"
    struct.pack_into("<HIIBHI5I", header, 94, 227, 227, 0, 0, 20, count, count, 0, 0, 0, 0)
    bounds: List[Tuple[float, float]] = [(top * scale + at, bottom * scale + at) for top, bottom, at in zip(high, low, offsets)]
    struct.pack_into("<12d", header, 131, scale, scale, scale, *offsets, *(number for pair in bounds for number in pair))
    with open(path, "wb") as file:
        file.write(header)
        file.write(body)
    return count
