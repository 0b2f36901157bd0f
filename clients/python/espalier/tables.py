"""Turtle records (shapes.TurtleRecord) as tables: one row each, with plain columns that every tool for tables reads."""

from __future__ import annotations

from typing import Any, Dict, Iterator, List, Sequence

from .blocks import numpy
from .errors import EspalierError

_AXES = "xyz"
_VECTORS = ("heading", "left", "up")
_NUMBERS = ("width", "colour", "branch_order")


def names(parameters: int) -> List[str]:
    """The columns of a table whose modules have up to so many parameters."""
    return (["plant", "module", "symbol", "x", "y", "z"] + [f"{name}_{axis}" for name in _VECTORS for axis in _AXES]
            + list(_NUMBERS) + ["parent"] + [f"parameter_{i + 1}" for i in range(parameters)])


def row(record: Any, parameters: int) -> Dict[str, Any]:
    """One record; a parameter that a module does not have is NaN, and a root has the parent -1."""
    values: List[Any] = [record.plant, record.module, record.symbol, *record.position, *record.heading, *record.left,
                         *record.up, record.width, record.colour, record.branch_order,
                         -1 if record.parent is None else record.parent, *record.parameters]
    values += [float("nan")] * (parameters - len(record.parameters))
    return dict(zip(names(parameters), values))


def rows(records: Sequence[Any]) -> Iterator[Dict[str, Any]]:
    parameters = max((len(record.parameters) for record in records), default=0)
    return (row(record, parameters) for record in records)


def to_columns(records: Sequence[Any]) -> Dict[str, List[Any]]:
    parameters = max((len(record.parameters) for record in records), default=0)
    made: Dict[str, List[Any]] = {name: [] for name in names(parameters)}
    for record in records:
        for name, value in row(record, parameters).items():
            made[name].append(value)
    return made


def to_numpy(records: Sequence[Any]) -> Any:
    """A structured array: table["x"], table[table["symbol"] == "F"]. Needs NumPy."""
    if numpy is None:
        raise EspalierError("to_numpy() needs NumPy (Debian: python3-numpy). The records are in `records`.")
    columns = to_columns(records)
    whole = ("plant", "module", "colour", "branch_order", "parent")
    longest = max((len(symbol) for symbol in columns["symbol"]), default=1)
    table = numpy.zeros(len(records), dtype=[
        (name, "i8" if name in whole else f"U{longest}" if name == "symbol" else "f8") for name in columns])
    for name, values in columns.items():
        table[name] = values
    return table


def to_pandas(records: Sequence[Any]) -> Any:
    """A DataFrame. Needs pandas."""
    try:
        import pandas  # type: ignore[import]
    except ImportError:
        raise EspalierError("to_pandas() needs pandas (Debian: python3-pandas). to_numpy() gives the same columns.") from None
    return pandas.DataFrame(to_columns(records))
