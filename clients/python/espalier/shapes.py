"""The contents of a server's answers and frames, as Python values."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Iterator, List, Mapping, Optional, Sequence, Tuple

from . import tables
from .blocks import Blocks
from .errors import ProtocolError
from .geometry import Geometry

Vector = Tuple[float, float, float]


@dataclass(frozen=True)
class StepResult:
    """The result of a call of step.

    >>> client.create(gallery="classic-algae").step(2).statistics["modules"]
    3
    """

    step: int  # completed steps
    finished: bool  # the derivation length is reached or the model stopped itself
    truncated: bool  # fewer steps than requested, although the model is not finished
    saved: bool  # the state is on the server's disk
    statistics: Mapping[str, Any]
    warnings: Sequence[str] = ()  # of the model and its environments in these steps; each is said once in a simulation
    printed: str = ""  # by the model (`printf`) since the last answer, at most 64,000 bytes


@dataclass(frozen=True)
class CompiledModel:
    """A model that the server has compiled, or its errors.

    >>> wrong = client.check("Lsystem: 1\\nAxiom: A(\\nendlsystem\\n")
    >>> wrong.valid, str(wrong).startswith("model.l:")
    (False, True)
    """

    model: str  # identifier; empty when the model was only checked
    valid: bool
    derivation_length: int
    diagnostics: Sequence[Mapping[str, Any]]

    def __str__(self) -> str:
        return "\n".join(str(diagnostic.get("text", "")) for diagnostic in self.diagnostics)


@dataclass(frozen=True)
class TurtleRecord:
    """One module of a string and the turtle's state after it.

    >>> [(record.symbol, record.position) for record in client.create(gallery="classic-weed").turtle()]
    [('F', (0.0, 1.0, 0.0))]
    """

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


@dataclass(frozen=True, repr=False)
class Frame:
    """The data of a stream about one step. A frame with turtle records is a table: iterate over its rows, or convert it.

    >>> with client.create(gallery="classic-weed").stream() as stream:
    ...     frame = stream.read()
    >>> frame
    <Frame: step 0, 1 records>
    >>> [(row["symbol"], row["x"], row["y"]) for row in frame]
    [('F', 0.0, 1.0)]
    """

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

    def to_numpy(self) -> Any:
        """The turtle records as a structured array with the columns plant, module, symbol, x, y, z, heading_x, …, width,
        colour, branch_order, parent (-1: a root), parameter_1, …. Needs NumPy.

        >>> weed = client.create(gallery="classic-weed")
        >>> with weed.stream() as stream:
        ...     table = stream.read().to_numpy()
        >>> table["symbol"].tolist(), table["y"].tolist()
        (['F'], [1.0])
        """
        return tables.to_numpy(_records_of(self))

    def to_pandas(self) -> Any:
        """The same columns as a DataFrame. `pandas.DataFrame(frame)` is the same. Needs pandas."""
        return tables.to_pandas(_records_of(self))

    def __iter__(self) -> Iterator[Mapping[str, Any]]:
        """The rows of the table, one mapping from column to value for each turtle record."""
        return tables.rows(_records_of(self))

    def __len__(self) -> int:
        return self.count

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        parts = [f"step {self.step}"]
        parts += [f"{self.count} records"] if self.count else []
        parts += [f"a string of {len(self.string)} characters"] if self.string else []
        parts += [f"{name} {value}" for name, value in list(self.statistics.items())[:3]]
        parts += [repr(self.geometry)] if self.geometry is not None else []
        parts += [f"{len(self.queries)} queries"] if self.queries else []
        parts += [f"{self.missed} missed"] if self.missed else []
        return f"<Frame: {', '.join(parts)}{', finished' if self.finished else ''}>"


def _listed(column: Any) -> List[Any]:
    listed: List[Any] = column.tolist()
    return listed


def _records_of(frame: Frame) -> Sequence[TurtleRecord]:
    """The records of a frame, also of one that came as arrays."""
    if not frame.columns or "position" not in frame.columns:
        return frame.records
    columns: Mapping[str, Any] = {name: _listed(block) for name, block in frame.columns.items()}
    offsets = columns["parameterOffset"]

    def vector(name: str, index: int) -> Tuple[float, float, float]:
        x, y, z = columns[name][index]
        return (x, y, z)

    return [TurtleRecord(
        index=i, plant=columns["plant"][i], module=columns["module"][i], symbol=frame.symbols[columns["symbol"][i]],
        parameters=tuple(columns["parameters"][offsets[i]:offsets[i + 1]]), position=vector("position", i),
        heading=vector("heading", i), left=vector("left", i), up=vector("up", i), width=columns["width"][i],
        colour=columns["colour"][i], branch_order=columns["branchOrder"][i],
        parent=None if columns["parent"][i] == 0xFFFFFFFF else columns["parent"][i]) for i in range(frame.count)]


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
    """The result in the answer to simulation.step or simulation.run."""
    return StepResult(int(shape["step"]), bool(shape["finished"]), bool(shape["truncated"]),
                      bool(shape.get("saved", False)), shape["statistics"], tuple(shape.get("warnings", ())),
                      str(shape.get("printed", "")))


def step_of(frame: Frame) -> StepResult:
    """The result of one step from a statistics frame."""
    return StepResult(frame.step, frame.finished, False, False, frame.statistics)


def read_model(shape: Mapping[str, Any]) -> CompiledModel:
    """The compiled model in the answer to model.check or model.load."""
    return CompiledModel(str(shape.get("model", "")), bool(shape["valid"]), int(shape.get("derivationLength", 0)),
                 shape.get("diagnostics", []))
