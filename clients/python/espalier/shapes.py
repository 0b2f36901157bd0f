"""What a server's answers and frames hold, as Python values."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Mapping, Optional, Sequence, Tuple

from .blocks import Blocks
from .errors import ProtocolError
from .geometry import Geometry

Vector = Tuple[float, float, float]


@dataclass(frozen=True)
class StepResult:
    """What a call of step made."""

    step: int  # completed steps
    finished: bool  # the derivation length is reached or the model stopped itself
    truncated: bool  # fewer steps than requested, although the model is not finished
    saved: bool  # the state is on the server's disk
    statistics: Mapping[str, Any]


@dataclass(frozen=True)
class CompiledModel:
    """A model that the server has compiled, or its errors."""

    model: str  # identifier; empty when the model was only checked
    valid: bool
    derivation_length: int
    diagnostics: Sequence[Mapping[str, Any]]

    def __str__(self) -> str:
        return "\n".join(str(diagnostic.get("text", "")) for diagnostic in self.diagnostics)


@dataclass(frozen=True)
class TurtleRecord:
    """One module of a string and the turtle's state after it."""

    index: int  # among all records of the frame; `parent` is such an index
    plant: int
    module: int  # index in the plant's string
    symbol: str
    parameters: Tuple[float, ...]
    position: Vector
    heading: Vector
    left: Vector
    up: Vector
    width: float
    colour: int
    branch_order: int
    parent: Optional[int]  # None: a root


@dataclass(frozen=True)
class Frame:
    """What a stream says about one step."""

    step: int
    sequence: int
    missed: int  # frames left out since the one before, because this reader was slow
    finished: bool  # the simulation will make no further step
    records: Sequence[TurtleRecord] = ()
    string: str = ""
    statistics: Mapping[str, Any] = field(default_factory=dict)
    count: int = 0  # of records
    # with stream(arrays=True) instead of records: plant, module, symbol (an index in `symbols`), position (count, 3),
    # heading, left, up, width, colour, branchOrder, parent (2^32 - 1: none), parameters and parameterOffset (count + 1)
    columns: Blocks = field(default_factory=dict)
    symbols: Tuple[str, ...] = ()
    # of a stream of queries: the queries and answers of the last step, as in environment.step
    queries: Sequence[Mapping[str, Any]] = ()
    replies: Sequence[Mapping[str, Any]] = ()
    # of a stream of geometry with columns=True: the plants as environments see them
    geometry: Optional[Geometry] = None
    key: bool = True  # it came whole; else as a difference, and was put together


def _vector(value: Any) -> Vector:
    x, y, z = value
    return (float(x), float(y), float(z))


def read_record(shape: Mapping[str, Any], index: int) -> TurtleRecord:
    """The record of its JSON shape; the index is the place in the list unless the record says another."""
    return TurtleRecord(
        index=int(shape.get("index", index)), plant=int(shape["plant"]), module=int(shape["module"]),
        symbol=str(shape["symbol"]), parameters=tuple(float(value) for value in shape["parameters"]),
        position=_vector(shape["position"]), heading=_vector(shape["heading"]), left=_vector(shape["left"]),
        up=_vector(shape["up"]), width=float(shape["width"]), colour=int(shape["colour"]),
        branch_order=int(shape["branchOrder"]), parent=shape["parent"])


def read_frame(shape: Mapping[str, Any], blocks: Blocks = MappingProxyType({})) -> Frame:
    """The frame of the params of `stream.data`."""
    try:
        return Frame(
            step=int(shape["step"]), sequence=int(shape["sequence"]), missed=int(shape.get("missed", 0)),
            finished=bool(shape.get("finished", False)),
            records=[read_record(record, index) for index, record in enumerate(shape.get("records", []))],
            string=str(shape.get("string", "")), statistics=shape.get("statistics", {}),
            count=int(shape.get("count", len(shape.get("records", [])))), symbols=tuple(shape.get("symbols", ())),
            columns=blocks, queries=shape.get("queries", ()), replies=shape.get("replies", ()),
            key=bool(shape.get("key", True)))
    except (KeyError, TypeError, ValueError) as error:
        raise ProtocolError(f"stream.data: a frame without or with a wrong {error}.") from None


def read_step(shape: Mapping[str, Any]) -> StepResult:
    """What the answer to simulation.step or simulation.run says."""
    return StepResult(int(shape["step"]), bool(shape["finished"]), bool(shape["truncated"]),
                      bool(shape.get("saved", False)), shape["statistics"])


def step_of(frame: Frame) -> StepResult:
    """The result of one step from a statistics frame."""
    return StepResult(frame.step, frame.finished, False, False, frame.statistics)


def read_model(shape: Mapping[str, Any]) -> CompiledModel:
    """What the answer to model.check or model.load says."""
    return CompiledModel(str(shape.get("model", "")), bool(shape["valid"]), int(shape.get("derivationLength", 0)),
                 shape.get("diagnostics", []))
