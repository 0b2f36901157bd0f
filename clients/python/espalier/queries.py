"""The queries and openings that an environment receives, and how they are read from the protocol."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

from .blocks import Blocks, numpy, offsets_of
from .errors import ProtocolError

Vector = Tuple[float, float, float]
# the new values of the parameters of a module, in order; None keeps a value
Answer = Optional[Sequence[Optional[float]]]


@dataclass(frozen=True)
class Following:
    """The module after a communication module in the string.

    >>> espalier.Following("F", (1.5,)).parameters
    (1.5,)
    """

    symbol: str
    parameters: Tuple[float, ...] = ()


@dataclass(frozen=True)
class Query:
    """One communication module `?E(…)` and the state of the turtle there. Only the needs of the environment are filled.

    Lengths are in the world's unit (`opening.world["lengthUnit"]`, as "m"), directions are unit vectors.

    >>> espalier.Query(id=0, position=(0.0, 2.0, 0.0)).position[1]     # in a test of answer()
    2.0
    """

    id: int
    plant: int = 0
    module: int = 0  # index of the module in its plant's string
    is_transient: bool = False  # made by a homomorphism: takes part, its answer is discarded
    symbol: str = "E"
    parameters: Tuple[float, ...] = ()
    position: Vector = (0.0, 0.0, 0.0)  # lengths
    heading: Vector = (0.0, 1.0, 0.0)
    left: Vector = (-1.0, 0.0, 0.0)
    up: Vector = (0.0, 0.0, -1.0)
    width: float = 1.0  # of the turtle's line, a length
    scale: float = 1.0  # factor of lengths that the turtle applies
    following: Optional[Following] = None  # the module after it in the string, if any


@dataclass(frozen=True, repr=False)
class Columns:
    """All queries of one step as arrays, row after row: NumPy arrays when NumPy is installed, else memoryviews. They are
    views of the received bytes. Arrays outside the needs of the environment are None.

    >>> class Heights(espalier.Environment):
    ...     def step_columns(self, queries):
    ...         return [row[1] for row in queries.position.tolist()]
    >>> client.create(gallery="growth-to-a-height", environment=Heights).step().statistics["answers"]
    1
    """

    count: int  # queries
    plant: Any  # (count)
    module: Any  # index of each module in its plant's string (count), or None
    is_transient: Any  # (count), or None: none is
    symbol: Any  # index in `symbols` (count)
    symbols: Tuple[str, ...]
    parameters: Any  # (count, parameters) when all queries have as many, else all of them one after the other
    parameter_offset: Any  # where each query's begin, and the end (count + 1), or None: as many in each row
    position: Any = None  # (count, 3)
    heading: Any = None  # (count, 3)
    left: Any = None  # (count, 3)
    up: Any = None  # (count, 3)
    width: Any = None  # (count)
    scale: Any = None  # (count)
    following: Any = None  # index in `symbols` of the next module (count), 2^32 - 1: none
    following_parameters: Any = None  # as parameters
    following_offset: Any = None

    def __repr__(self) -> str:
        given = [name for name in ("position", "heading", "left", "up", "width", "scale", "following")
                 if getattr(self, name) is not None]
        return f"<Columns: {self.count} queries, with {', '.join(['parameters', *given])}>"

    def queries(self) -> "List[Query]":
        """The same as one object for each query."""
        parameters = _rows(self.parameters, self.parameter_offset, self.count)
        following = _rows(self.following_parameters, self.following_offset, self.count)
        given: Dict[str, Any] = {}
        for name in ("position", "heading", "left", "up"):
            column = getattr(self, name)
            if column is not None:
                given[name] = [tuple(row) for row in column.tolist()]
        for name in ("width", "scale", "module", "plant", "symbol", "is_transient"):
            column = getattr(self, name)
            if column is not None:
                given[name] = column.tolist()
        next_symbols = None if self.following is None else self.following.tolist()
        found = []
        for row in range(self.count):
            values: Dict[str, Any] = {name: column[row] for name, column in given.items()}
            values["symbol"] = self.symbols[values["symbol"]]
            values["is_transient"] = bool(values.get("is_transient"))
            if next_symbols is not None and next_symbols[row] != NO_SYMBOL:
                values["following"] = Following(self.symbols[next_symbols[row]], following[row])
            found.append(Query(id=row, parameters=parameters[row], **values))
        return found


# in Columns.following: no module follows
NO_SYMBOL = 0xFFFFFFFF


@dataclass(frozen=True)
class Opening:
    """The information that an environment gets when a simulation opens it.

    >>> class Ceiling(espalier.Environment):
    ...     def opened(self):
    ...         self.height = self.opening.configuration.get("height", 3)
    ...     def answer(self, query):
    ...         return [1 if query.position[1] < self.height else 0]
    >>> espalier.Opening("sim-1", configuration={"height": 2}).configuration["height"]
    2
    """

    simulation: str  # its identifier on the server
    plants: int = 1
    symbols: Tuple[str, ...] = ()  # of the model's modules
    configuration: Mapping[str, Any] = field(default_factory=dict)  # the member `configuration` of its entry in create()
    seed: int = 0
    # lengthUnit ("m"), up and north (unit vectors), stepDuration (days)
    world: Mapping[str, Any] = field(default_factory=dict)
    bounds: Optional[Any] = None  # of the space that the plants may fill, if the server knows them


@dataclass(frozen=True)
class Variable:
    """A value of a query or an answer with its unit ("1": no unit).

    >>> class Light(espalier.Environment):
    ...     outputs = (espalier.Variable("light", "umol m-2 s-1"),)
    >>> Light.description()["outputs"]
    [{'name': 'light', 'unit': 'umol m-2 s-1'}]
    """

    name: str
    unit: str = "1"

    def as_json(self) -> Dict[str, str]:
        """As the protocol has it."""
        return {"name": self.name, "unit": self.unit}


# ---- reading the protocol's shapes --------------------------------------------------------------------------------


def _number(value: Any, path: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ProtocolError(f"{path}: expected a number, found {_kind(value)}.")
    return float(value)


def _count(value: Any, path: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ProtocolError(f"{path}: expected a whole number from 0 on, found {_kind(value)}.")
    return value


def _text(value: Any, path: str) -> str:
    if not isinstance(value, str):
        raise ProtocolError(f"{path}: expected a text, found {_kind(value)}.")
    return value


def _list(value: Any, path: str) -> List[Any]:
    if not isinstance(value, list):
        raise ProtocolError(f"{path}: expected a list, found {_kind(value)}.")
    return value


def _object(value: Any, path: str) -> Dict[str, Any]:
    if not isinstance(value, dict):
        raise ProtocolError(f"{path}: expected an object, found {_kind(value)}.")
    return value


def _kind(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, (int, float)):
        return f"the number {value}"
    if isinstance(value, str):
        return "a text"
    return "a list" if isinstance(value, list) else "an object"


def _numbers(value: Any, path: str) -> Tuple[float, ...]:
    # the common case of a hundred thousand queries a step: all doubles
    if isinstance(value, list) and all(type(item) is float for item in value):
        return tuple(value)
    return tuple(_number(item, f"{path}[{index}]") for index, item in enumerate(_list(value, path)))


def _vector(value: Any, path: str) -> Vector:
    numbers = _numbers(value, path)
    if len(numbers) != 3:
        raise ProtocolError(f"{path}: expected three numbers, found {len(numbers)}.")
    return (numbers[0], numbers[1], numbers[2])


def read_query(value: Any, path: str) -> Query:
    """The query of its JSON shape. What is missing keeps the turtle's initial value."""
    shape = _object(value, path)
    following = None
    if shape.get("following") is not None:
        next_module = _object(shape["following"], f"{path}.following")
        following = Following(_text(next_module.get("symbol"), f"{path}.following.symbol"),
                              _numbers(next_module.get("parameters", []), f"{path}.following.parameters"))
    found: Dict[str, Any] = {"id": _count(shape.get("id"), f"{path}.id"), "following": following}
    if "plant" in shape:
        found["plant"] = _count(shape["plant"], f"{path}.plant")
    if "module" in shape:
        found["module"] = _count(shape["module"], f"{path}.module")
    if shape.get("transient") is True:
        found["is_transient"] = True
    if "symbol" in shape:
        found["symbol"] = _text(shape["symbol"], f"{path}.symbol")
    if "parameters" in shape:
        found["parameters"] = _numbers(shape["parameters"], f"{path}.parameters")
    for name in ("position", "heading", "left", "up"):
        if name in shape:
            found[name] = _vector(shape[name], f"{path}.{name}")
    for name in ("width", "scale"):
        if name in shape:
            found[name] = _number(shape[name], f"{path}.{name}")
    return Query(**found)


def _rows(values: Any, offset: Any, count: int) -> List[Tuple[float, ...]]:
    """The numbers of each query."""
    if values is None:
        return [()] * count
    listed = values.tolist()
    if offset is None:
        return [tuple(row) for row in listed] if listed else [()] * count
    bounds = offset.tolist()
    return [tuple(listed[bounds[row]:bounds[row + 1]]) for row in range(count)]


def read_columns(parameters: Mapping[str, Any], blocks: Blocks) -> Columns:
    """The columns of the params of `environment.step`: its arrays, or made of its list of queries."""
    if not blocks:
        shapes = _list(parameters.get("queries"), "params.queries")
        return _gathered([read_query(shape, f"params.queries[{index}]") for index, shape in enumerate(shapes)], shapes)
    for name in ("plant", "symbol", "parameters"):
        if name not in blocks:
            raise ProtocolError(f"bin.{name}: the block is missing.")
    symbols = _list(parameters.get("symbols"), "params.symbols")
    count = len(blocks["plant"])
    for name, extents in (("symbol", ()), ("module", ()), ("transient", ()), ("position", (3,)), ("heading", (3,)),
                          ("left", (3,)), ("up", (3,)), ("width", ()), ("scale", ()), ("following", ())):
        found = blocks.get(name)
        if found is not None and count > 0 and tuple(found.shape) != (count, *extents):
            raise ProtocolError(f"bin.{name}: expected the shape {[count, *extents]}, found {list(found.shape)}.")
    return Columns(
        count=count, plant=blocks["plant"], module=blocks.get("module"), is_transient=blocks.get("transient"),
        symbol=blocks["symbol"],
        symbols=tuple(_text(symbol, f"params.symbols[{index}]") for index, symbol in enumerate(symbols)),
        parameters=blocks["parameters"], parameter_offset=blocks.get("parameterOffset"), position=blocks.get("position"),
        heading=blocks.get("heading"), left=blocks.get("left"), up=blocks.get("up"), width=blocks.get("width"),
        scale=blocks.get("scale"), following=blocks.get("following"),
        following_parameters=blocks.get("followingParameters"), following_offset=blocks.get("followingOffset"))


def _array(kind: str, values: List[Any], width: int = 0) -> Any:
    """Numbers as an array of the kind that blocks have: d, I; rows of `width` numbers when it is not 0."""
    if numpy is not None:
        made = numpy.array(values, dtype={"d": "<f8", "I": "<u4"}[kind])
        return made.reshape(-1, width) if width else made
    made = memoryview(array(kind, values))
    return made.cast("B").cast(kind, [len(values) // width, width]) if width and values else made


def _gathered(queries: List[Query], shapes: List[Any]) -> Columns:
    names = list(dict.fromkeys([query.symbol for query in queries]
                               + [query.following.symbol for query in queries if query.following is not None]))
    number = {name: index for index, name in enumerate(names)}
    has = {name: any(name in shape for shape in shapes) for name in ("position", "heading", "left", "up", "width", "scale")}

    def vectors(name: str) -> Any:
        return _array("d", [value for query in queries for value in getattr(query, name)], 3) if has[name] else None

    def rows(values: List[Tuple[float, ...]]) -> Tuple[Any, Any]:
        widths = {len(row) for row in values}
        flat = [value for row in values for value in row]
        if len(widths) == 1 and widths != {0}:
            return _array("d", flat, widths.pop()), None
        return _array("d", flat), _array("I", offsets_of([len(row) for row in values]))

    parameters, offset = rows([query.parameters for query in queries])
    following = None
    following_rows: Tuple[Any, Any] = (None, None)
    if any(query.following is not None for query in queries):
        following = _array("I", [NO_SYMBOL if query.following is None else number[query.following.symbol]
                                 for query in queries])
        following_rows = rows([() if query.following is None else query.following.parameters for query in queries])
    return Columns(
        count=len(queries), plant=_array("I", [query.plant for query in queries]),
        module=_array("I", [query.module for query in queries]),
        is_transient=_array("I", [int(query.is_transient) for query in queries])
        if any(query.is_transient for query in queries) else None,
        symbol=_array("I", [number[query.symbol] for query in queries]), symbols=tuple(names), parameters=parameters,
        parameter_offset=offset, position=vectors("position"), heading=vectors("heading"), left=vectors("left"),
        up=vectors("up"), width=_array("d", [query.width for query in queries]) if has["width"] else None,
        scale=_array("d", [query.scale for query in queries]) if has["scale"] else None, following=following,
        following_parameters=following_rows[0], following_offset=following_rows[1])


def read_opening(parameters: Mapping[str, Any]) -> Opening:
    """The opening of the params of `environment.open`."""
    symbols = _list(parameters.get("symbols", []), "params.symbols")
    return Opening(
        simulation=_text(parameters.get("simulation"), "params.simulation"),
        plants=_count(parameters.get("plants", 1), "params.plants"),
        symbols=tuple(_text(symbol, f"params.symbols[{index}]") for index, symbol in enumerate(symbols)),
        configuration=_object(parameters.get("configuration") or {}, "params.configuration"),
        seed=int(parameters.get("seed") or 0),
        world=_object(parameters.get("world") or {}, "params.world"),
        bounds=parameters.get("bounds"),
    )
