"""Assembles complete frames of streams from differences."""

from __future__ import annotations

from array import array
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from .blocks import Blocks, numpy
from .errors import ProtocolError
from .geometry import read_geometry
from .shapes import Frame, TurtleRecord, read_frame, read_record

NO_PARENT = 0xFFFFFFFF
# columns that count records or modules: a run of kept rows has an offset for their numbers
_SHIFTED = ("module", "parent", "index")


class _Segment(NamedTuple):
    """Consecutive rows of a frame: kept from the frame before, or new."""

    kept: bool
    begin: int  # first row where they come from
    end: int
    shifts: Tuple[int, int, int]  # of module, parent and index


def read_next(previous: Optional[Frame], shape: Mapping[str, Any], blocks: Blocks = MappingProxyType({})) -> Frame:
    """The complete frame of the params of `stream.data`; `previous` is the frame before on the stream."""
    if "geometry" in shape:
        before = previous.geometry if previous is not None else None
        return replace(read_frame(shape), geometry=read_geometry(shape["geometry"], blocks, before))
    if shape.get("key", True):
        return read_frame(shape, blocks)
    if previous is None:
        raise ProtocolError("stream.data: a difference without a frame before it.")
    try:
        if "pieces" in shape:
            text = "".join(piece if isinstance(piece, str) else previous.string[piece[0]:piece[0] + piece[1]]
                           for piece in shape["pieces"])
            return replace(read_frame({**shape, "string": text}), records=(), columns={})
        if "kept" in blocks:
            return replace(read_frame(shape), columns=_columns(previous.columns, int(shape["count"]), blocks))
        records = _records(previous.records, int(shape["count"]), shape)
        return replace(read_frame({**shape, "records": []}), records=records)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise ProtocolError(f"stream.data: a difference that does not fit the frame before: {error}.") from None


def _segments(runs: Sequence[Sequence[int]], count: int, fresh: int) -> Iterator[_Segment]:
    row = used = 0
    for run in runs:
        to, begin, rows, module, parent = (int(number) for number in run[:5])
        if to > row:
            yield _Segment(False, used, used + to - row, (0, 0, 0))
            used += to - row
        yield _Segment(True, begin, begin + rows, (module, parent, int(run[5]) if len(run) > 5 else 0))
        row = to + rows
    if row < count:
        yield _Segment(False, used, used + count - row, (0, 0, 0))
        used += count - row
    if used != fresh:
        raise ValueError(f"{fresh} new rows where {used} are missing")


def _records(before: Sequence[TurtleRecord], count: int, shape: Mapping[str, Any]) -> List[TurtleRecord]:
    fresh = shape["records"]
    records: List[TurtleRecord] = []
    for segment in _segments(shape["kept"], count, len(fresh)):
        if not segment.kept:
            for record in fresh[segment.begin:segment.end]:
                records.append(read_record(record, len(records)))
            continue
        module, parent, index = segment.shifts
        has_index = len(shape["kept"][0]) > 5
        for kept in before[segment.begin:segment.end]:
            moved = index if has_index else len(records) - kept.index
            records.append(kept if module == parent == moved == 0 else replace(
                kept, module=kept.module + module, index=kept.index + moved,
                parent=None if kept.parent is None else kept.parent + parent))
    return records


def _columns(before: Blocks, count: int, blocks: Blocks) -> Dict[str, Any]:
    segments = list(_segments(_rows_of(blocks["kept"], 6), count, len(blocks["plant"])))
    columns: Dict[str, Any] = {}
    for name, fresh in blocks.items():
        if name not in ("kept", "parameterOffset", "parameters"):
            columns[name] = _joined(before[name], fresh, [(segment.kept, segment.begin, segment.end) for segment in segments])
    for place, name in enumerate(_SHIFTED):
        if name in columns:
            _shift(columns[name], [(segment.end - segment.begin, segment.shifts[place]) for segment in segments],
                   name == "parent")
    offsets = (blocks["parameterOffset"], before["parameterOffset"])  # by whether the rows are kept
    columns["parameters"] = _joined(before["parameters"], blocks["parameters"], [
        (segment.kept, int(offsets[segment.kept][segment.begin]), int(offsets[segment.kept][segment.end]))
        for segment in segments])
    columns["parameterOffset"] = _offsets(offsets, segments)
    return columns


def _rows_of(block: Any, width: int) -> List[Sequence[int]]:
    numbers: List[Any] = block.tolist()
    return numbers if not numbers or isinstance(numbers[0], list) else [
        numbers[at:at + width] for at in range(0, len(numbers), width)]


def _joined(before: Any, fresh: Any, pieces: Sequence[Tuple[bool, int, int]]) -> Any:
    """Rows of both columns, one piece after the other."""
    if numpy is not None:
        return numpy.concatenate([(before if kept else fresh)[begin:end] for kept, begin, end in pieces] or [fresh])
    # an empty one has lost how wide its rows are
    rows = fresh if fresh.nbytes else before
    width = rows.itemsize
    for extent in rows.shape[1:]:
        width *= extent
    sides = (fresh.cast("B") if fresh.nbytes else b"", before.cast("B") if before.nbytes else b"")
    joined = bytearray().join(sides[kept][begin * width:end * width] for kept, begin, end in pieces)
    view = memoryview(joined)
    return view.cast(rows.format, [len(joined) // width, *rows.shape[1:]]) if joined else view.cast(rows.format)


def _shift(column: Any, runs: Sequence[Tuple[int, int]], skips_none: bool) -> None:
    """Adds an offset to the numbers of each run, modulo 2^32; a row without a parent stays without."""
    row = 0
    for rows, shift in runs:
        if shift != 0 and numpy is not None:
            part = column[row:row + rows]
            numpy.add(part, numpy.uint32(shift & NO_PARENT), out=part, where=part != NO_PARENT if skips_none else True)
        elif shift != 0:
            for at in range(row, row + rows):
                if not skips_none or column[at] != NO_PARENT:
                    column[at] = (column[at] + shift) & NO_PARENT
        row += rows


def _offsets(offsets: Tuple[Any, Any], segments: Sequence[_Segment]) -> Any:
    """Where each row's parameters begin, from the offsets of new rows and of those before."""
    if numpy is not None:
        counts = [numpy.diff(offsets[segment.kept][segment.begin:segment.end + 1]) for segment in segments]
        return numpy.concatenate([numpy.zeros(1, numpy.uint32), numpy.cumsum(numpy.concatenate(counts), dtype=numpy.uint32)]
                                 if counts else [numpy.zeros(1, numpy.uint32)])
    result = array("I", [0])
    for segment in segments:
        side = offsets[segment.kept]
        for row in range(segment.begin, segment.end):
            result.append(result[-1] + side[row + 1] - side[row])
    return memoryview(result)
