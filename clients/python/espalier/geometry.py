"""The shape of plants, for environments that need `geometry`: segments and organ triangles as arrays."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, fields
from typing import Any, Dict, List, Mapping, Optional, Tuple

from .blocks import Blocks, numpy
from .errors import ProtocolError

# in a run's first number: the next new rows
NEW_ROWS = 0xFFFFFFFF
KINDS = ("cylinder", "polygon", "surface", "patch", "ball")

# name on the wire, name here, kind (I: whole numbers, d: numbers), numbers in a row
_SEGMENTS = (("segmentPlant", "segment_plant", "I", 1), ("segmentModule", "segment_module", "I", 1),
             ("segmentSymbol", "segment_symbol", "I", 1), ("segmentColour", "segment_colour", "I", 1),
             ("segmentOrder", "segment_order", "I", 1), ("segmentStart", "segment_start", "d", 3),
             ("segmentEnd", "segment_end", "d", 3), ("segmentStartWidth", "segment_start_width", "d", 1),
             ("segmentEndWidth", "segment_end_width", "d", 1))
_ORGANS = (("organPlant", "organ_plant", "I", 1), ("organModule", "organ_module", "I", 1),
           ("organSymbol", "organ_symbol", "I", 1), ("organColour", "organ_colour", "I", 1),
           ("organOrder", "organ_order", "I", 1), ("organKind", "organ_kind", "I", 1))
_MESHES = (("organVertices", "I", 1), ("organTriangles", "I", 1), ("vertices", "d", 3), ("triangles", "I", 3))
_RUNS = (("segmentRuns", "I", 3), ("organRuns", "I", 3))
NAMES = frozenset([entry[0] for entry in (*_SEGMENTS, *_ORGANS, *_MESHES, *_RUNS)])


@dataclass(frozen=True, repr=False)
class Geometry:
    """The shape of all plants at their queries: s segments (the lines) and o organs (everything else) of v vertices and t
    triangles. NumPy arrays when NumPy is installed, else memoryviews. The organ behind a communication module has the
    module index of its query plus one.

    >>> with client.create(gallery="classic-weed").stream("geometry", arrays=True, columns=True) as stream:
    ...     stream.read().geometry
    <Geometry: 1 segments, 0 organs, 0 vertices, 0 triangles>
    """

    symbols: Tuple[str, ...]  # names that segment_symbol and organ_symbol refer to
    are_widths_pixels: bool  # the widths are pixels of a picture and have no size in the world
    segment_plant: Any  # (s)
    segment_module: Any  # index in the plant's string (s)
    segment_symbol: Any  # (s)
    segment_colour: Any  # colour index of the model, 0 to 255 (s)
    segment_order: Any  # branch order (s)
    segment_start: Any  # (s, 3)
    segment_end: Any  # (s, 3)
    segment_start_width: Any  # diameters (s)
    segment_end_width: Any  # (s)
    organ_plant: Any  # (o)
    organ_module: Any  # (o)
    organ_symbol: Any  # (o)
    organ_colour: Any  # (o)
    organ_order: Any  # (o)
    organ_kind: Any  # index in KINDS (o)
    vertex_offset: Any  # where each organ's vertices begin, and the end (o + 1)
    triangle_offset: Any  # where each organ's triangles begin, and the end (o + 1)
    vertices: Any  # (v, 3)
    triangles: Any  # indices of vertices (t, 3)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Geometry) and all(
            _listed(getattr(self, one.name)) == _listed(getattr(other, one.name)) for one in fields(self))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return (f"<Geometry: {len(self.segment_plant)} segments, {len(self.organ_plant)} organs, {len(self.vertices)} vertices, "
                f"{len(self.triangles)} triangles>")


def _listed(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def form() -> str:
    """The form of geometry to request. Only with NumPy can this package assemble differences."""
    return "whole" if numpy is None else "difference"


def _column(name: str, kind: str, width: int, shape: Mapping[str, Any], blocks: Blocks) -> Any:
    """One column: from the blocks when there are any, else of the JSON."""
    if blocks:
        found = blocks.get(name)
        if found is None:
            raise ProtocolError(f"bin.{name}: the block is missing.")
        extents = tuple(found.shape)
        if len(found) > 0 and (extents[1:] != (() if width == 1 else (width,))):
            raise ProtocolError(f"bin.{name}: expected rows of {width}, found the shape {list(extents)}.")
        return found
    path = f"params.geometry.{name}"
    listed = shape.get(name)
    if not isinstance(listed, list):
        raise ProtocolError(f"{path}: expected a list.")
    flat: List[Any] = []
    for index, row in enumerate(listed):
        values = [row] if width == 1 else row
        if not isinstance(values, list) or len(values) != width or any(
                isinstance(value, bool) or not isinstance(value, (int, float)) for value in values):
            raise ProtocolError(f"{path}[{index}]: expected {'a number' if width == 1 else f'{width} numbers'}.")
        flat.extend(values)
    if numpy is not None:
        made = numpy.array(flat, dtype={"d": "<f8", "I": "<u4"}[kind])
        return made.reshape(-1, width) if width > 1 else made
    view = memoryview(array(kind, flat))
    return view.cast("B").cast(kind, [len(flat) // width, width]) if width > 1 and flat else view


def _offsets(counts: Any) -> Any:
    if numpy is not None:
        return numpy.concatenate([[0], numpy.cumsum(counts, dtype="i8")])
    total = 0
    found = array("q", [0])
    for count in counts.tolist():
        total += count
        found.append(total)
    return memoryview(found)


def _absolute(triangles: Any, vertex_offset: Any, triangle_counts: Any) -> Any:
    """Indices among all vertices, of indices among each organ's own."""
    if numpy is not None:
        return triangles + numpy.repeat(vertex_offset[:-1], triangle_counts).astype("<u4").reshape(-1, 1)
    flat = array("I")
    rows = iter(triangles.tolist())
    for first, count in zip(vertex_offset.tolist(), triangle_counts.tolist()):
        for _ in range(count):
            flat.extend(corner + first for corner in next(rows))
    view = memoryview(flat)
    return view.cast("B").cast("I", [len(flat) // 3, 3]) if flat else view


def _rows_of(runs: Any, before: int, added: int, name: str) -> Tuple[Any, Any]:
    """For each row its row among the old and the new rows, and the offset of its module index."""
    rows = []
    shifts = []
    next_row = before
    for first, count, shift in runs.reshape(-1, 3).tolist():
        is_new = first == NEW_ROWS
        start = next_row if is_new else first
        end = start + count
        next_row += count if is_new else 0
        if end > (before + added if is_new else before):
            raise ProtocolError(f"params.geometry: a run of {name} goes beyond the rows there are.")
        rows.append(numpy.arange(start, end))
        shifts.append(numpy.full(count, 0 if is_new else shift, dtype="<u4"))
    if next_row != before + added:
        raise ProtocolError(f"params.geometry: the runs do not take all new {name}.")
    empty = numpy.zeros(0, dtype="i8")
    return numpy.concatenate([empty, *rows]), numpy.concatenate([empty.astype("<u4"), *shifts])


def _pieces(rows: Any, begin: Any, count: Any) -> Any:
    """The elements of the chosen rows, one after the other: row r has `count[r]` elements from `begin[r]` on."""
    chosen = count[rows]
    starts = numpy.cumsum(chosen) - chosen
    return numpy.arange(int(chosen.sum())) + numpy.repeat(begin[rows] - starts, chosen)


def _continued(before: Geometry, rows: "Dict[str, Any]", runs: "Dict[str, Any]") -> "Dict[str, Any]":
    """The columns after a difference."""
    made: Dict[str, Any] = {}
    for name, table in (("segment", _SEGMENTS), ("organ", _ORGANS)):
        old = len(getattr(before, f"{name}_plant"))
        taken, shift = _rows_of(runs[f"{name}Runs"], old, len(rows[f"{name}_plant"]), f"{name}s")
        for _, field, _, _ in table:
            made[field] = numpy.concatenate([getattr(before, field), rows[field]])[taken]
        made[f"{name}_module"] = made[f"{name}_module"] + shift
    # the meshes of the organs, each with the indices of its own vertices
    counts = {kind: numpy.concatenate([numpy.diff(getattr(before, f"{kind}_offset")), numpy.diff(rows[f"{kind}_offset"])])
              for kind in ("vertex", "triangle")}
    begins = {kind: numpy.cumsum(count) - count for kind, count in counts.items()}
    vertices = numpy.concatenate([before.vertices.reshape(-1, 3), rows["vertices"].reshape(-1, 3)])
    made["vertices"] = vertices[_pieces(taken, begins["vertex"], counts["vertex"])]
    all_vertices_before = len(before.vertices)
    corners = numpy.concatenate([before.triangles.reshape(-1, 3).astype("i8"),
                                 rows["triangles"].reshape(-1, 3).astype("i8") + all_vertices_before])
    own = corners - numpy.repeat(begins["vertex"], counts["triangle"]).reshape(-1, 1)
    made["vertex_offset"] = _offsets(counts["vertex"][taken])
    made["triangle_offset"] = _offsets(counts["triangle"][taken])
    chosen = own[_pieces(taken, begins["triangle"], counts["triangle"])].astype("<u4")
    made["triangles"] = _absolute(chosen, made["vertex_offset"], counts["triangle"][taken])
    return made


def read_geometry(shape: Any, blocks: Blocks, before: Optional[Geometry]) -> Geometry:
    """The geometry of the params of `environment.step`. `before` is the previous geometry, for a difference."""
    if not isinstance(shape, dict) or shape.get("form") not in ("whole", "difference"):
        raise ProtocolError("params.geometry.form: expected whole or difference.")
    names = shape.get("symbols")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ProtocolError("params.geometry.symbols: expected a list of texts.")
    rows = {field: _column(name, kind, width, shape, blocks) for name, field, kind, width in (*_SEGMENTS, *_ORGANS)}
    meshes = {name: _column(name, kind, width, shape, blocks) for name, kind, width in _MESHES}
    rows["vertex_offset"] = _offsets(meshes["organVertices"])
    rows["triangle_offset"] = _offsets(meshes["organTriangles"])
    rows["vertices"] = meshes["vertices"]
    rows["triangles"] = _absolute(meshes["triangles"], rows["vertex_offset"], meshes["organTriangles"])
    symbols = tuple(names)
    if shape["form"] == "difference":
        if before is None or numpy is None:
            raise ProtocolError("params.geometry: a difference, but no geometry came before it; send the whole geometry.")
        # the names before keep their numbers
        symbols = before.symbols + tuple(name for name in dict.fromkeys(names) if name not in before.symbols)
        if symbols != tuple(names):
            number = {name: index for index, name in reversed(list(enumerate(symbols)))}
            renamed = numpy.array([number[name] for name in names] or [0], dtype="<u4")
            for field in ("segment_symbol", "organ_symbol"):
                rows[field] = renamed[rows[field]]
        rows = _continued(before, rows, {name: _column(name, kind, width, shape, blocks) for name, kind, width in _RUNS})
    return Geometry(symbols=symbols, are_widths_pixels=shape.get("widths") == "pixels", **rows)
