"""Maps of fields as GeoTIFF (OGC 19-008r4): one band of 64-bit reals in one strip per row, north up, cells as areas."""

from __future__ import annotations

import math
import os
import struct
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from ..fields import Fields
from .las import require_place
from .vtp import SurveyError


class Map(NamedTuple):
    """Values in equal cells; the first row is the northern one."""
    rows: List[List[float]]
    west: float  # edge of the first cell
    north: float
    step: Tuple[float, float]  # to the east, to the south


def _plane(fields: Fields, name: str, over: str) -> Map:
    grid = fields.grid
    columns, layers, depths = grid.cells
    raw = fields.quantities[name][1]
    values = struct.unpack(f"<{len(raw) // 8}d", raw)
    ways: Dict[str, Callable[[Sequence[float]], float]] = {"mean": lambda some: math.fsum(some) / len(some), "sum": math.fsum,
                                                           "least": min, "most": max}
    reduce = ways.get(over)
    if reduce is None:
        raise SurveyError(f"'{over}' is no way from a column of cells to a number: give mean, sum, least or most.")
    # z is south, so the first row has the smallest
    rows = [[reduce([values[x + columns * (y + layers * z)] for y in range(layers)]) for x in range(columns)] for z in range(depths)]
    return Map(rows, grid.position[0], -grid.position[2], (grid.spacing[0], grid.spacing[2]))


def heights_of(fields: Fields, name: Optional[str] = None, over: str = "mean", isMap: Optional[bool] = None) -> Map:
    """A map of a quantity, seen from above: y is up, and a column of cells becomes its mean, sum, least or greatest value. With
    `isMap` the field has one layer in z and is a map already, with y to the north; so is `height` of one layer, as `espalier field
    hill.tif --field` writes it."""
    names = list(fields.quantities)
    if name is None and len(names) > 1:
        raise SurveyError(f"the file has the quantities {', '.join(names)}: choose one with --quantity.")
    chosen = names[0] if name is None else name
    if chosen not in fields.quantities:
        raise SurveyError(f"there is no quantity '{chosen}'. Quantities: {', '.join(names)}.")
    grid = fields.grid
    if not (chosen == "height" and grid.cells[2] == 1 if isMap is None else isMap):
        return _plane(fields, chosen, over)
    if grid.cells[2] != 1:
        raise SurveyError(f"the field has {grid.cells[2]} layers in z, and a map has one.")
    columns, rows = grid.cells[:2]
    raw = fields.quantities[chosen][1]
    values = struct.unpack(f"<{len(raw) // 8}d", raw)
    return Map([list(values[columns * row:columns * (row + 1)]) for row in reversed(range(rows))], grid.position[0],
               grid.position[1] + rows * grid.spacing[1], (grid.spacing[0], grid.spacing[1]))


def write_geotiff(content: Map, path: "str | os.PathLike[str]", epsg: Optional[int] = None, origin: Sequence[float] = (0.0, 0.0),
                  unit: str = "") -> None:
    """Writes a map. `epsg` is the number of a projection in metres; without it the file has places and no projection."""
    require_place(origin)
    rows, columns = len(content.rows), len(content.rows[0])
    line = 8 * columns
    if 8 + rows * line > 2**32 - 2**20:
        raise SurveyError(f"the map has {rows} rows of {columns} cells, more than a TIFF file holds: write a coarser field.")
    # a projected system in metres, cells are areas, and its number or 'user-defined'
    keys = [(1024, 1), (1025, 1), (3072, 32767 if epsg is None else epsg), (3076, 9001)]
    if not all(0 < value < 65536 for _, value in keys):
        raise SurveyError(f"the number {epsg} of a projection is not from 1 to 65535.")
    entries: List[Tuple[int, str, Sequence[float]]] = [  # tag, kind, values
        (256, "I", [columns]), (257, "I", [rows]), (258, "H", [64]), (259, "H", [1]), (262, "H", [1]),
        (273, "I", [8 + line * row for row in range(rows)]), (277, "H", [1]), (278, "I", [1]), (279, "I", [line] * rows), (339, "H", [3]),
        (33550, "d", [*content.step, 0.0]), (33922, "d", [0, 0, 0, origin[0] + content.west, origin[1] + content.north, 0]),
        (34735, "H", [1, 1, 0, len(keys), *(number for key, value in keys for number in (key, 0, 1, value))])]
    packed = [(tag, kind, len(values), struct.pack(f"<{len(values)}{kind}", *values)) for tag, kind, values in entries]
    if unit:
        text = f'<GDALMetadata><Item name="UNITTYPE" sample="0" role="unittype">{unit}</Item></GDALMetadata>'.encode("utf-8") + b"\0"
        packed.append((42112, "s", len(text), text))
    start = 8 + rows * line
    behind = start + 2 + 12 * len(packed) + 4
    directory, more = struct.pack("<H", len(packed)), b""
    for tag, kind, count, raw in packed:
        directory += struct.pack("<HHI", tag, {"s": 2, "H": 3, "I": 4, "d": 12}[kind], count)
        if len(raw) <= 4:
            directory += raw.ljust(4, b"\0")
        else:
            directory += struct.pack("<I", behind + len(more))
            more += raw + b"\0" * (len(raw) % 2)
    with open(path, "wb") as file:
        file.write(struct.pack("<2sHI", b"II", 42, start))
        for row in content.rows:
            file.write(struct.pack(f"<{columns}d", *row))
        file.write(directory + bytes(4) + more)
