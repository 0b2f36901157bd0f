"""The grids of BMI variables: which node is nearest to a place. BMI lists axes from the slowest to the fastest: z, y, x, or y, x."""

from __future__ import annotations

from typing import Any, Callable, List, Sequence

from ..errors import EspalierError

Places = Any  # numpy.ndarray of float64: a row for each query, a column for each axis of the world that the grid follows
Nodes = Any  # numpy.ndarray of int64
AT_ONCE = 4_000_000  # distances that are in memory together


class BmiError(EspalierError):
    """A call that the interface cannot answer: one sentence."""


def grid_of(model: Any, name: str, axes: Sequence[str]) -> Callable[[Places], Nodes]:
    """The function from places to the numbers of their nearest nodes; at the border for places outside."""
    grid = model.get_var_grid(name)
    kind = model.get_grid_type(grid)
    makers = {"uniform_rectilinear": _uniform, "rectilinear": _rectilinear, "scalar": _scalar,
              "points": _points, "unstructured": _points, "structured_quadrilateral": _points}
    if kind not in makers:
        raise BmiError(f"'{name}' is on a grid of the type {kind}: an environment needs one of {', '.join(makers)}.")
    rank = 0 if kind == "scalar" else int(model.get_grid_rank(grid))
    if kind != "scalar" and rank not in (1, 2, 3):
        raise BmiError(f"'{name}' has {rank} dimensions: an environment needs one to three.")
    if len(axes) < rank:
        raise BmiError(f"'{name}' has {rank} dimensions: name as many axes.")
    place = getattr(model, "get_var_location", lambda _: "node")
    try:
        where = place(name)
    except NotImplementedError:
        where = "node"  # a model without this function
    if kind in ("unstructured", "structured_quadrilateral") and where != "node":
        raise BmiError(f"the values of '{name}' are at each {where}: an environment needs values at nodes.")
    try:
        nearest = makers[kind](model, name, grid, rank)
    except (AttributeError, NotImplementedError) as error:
        raise BmiError(f"the model does not describe the grid of '{name}', which is {kind} ({error or 'not implemented'}).") from None

    def checked(places: Places) -> Nodes:
        import numpy

        if numpy.isnan(places).any():
            raise BmiError("the place of a query is no number")
        with numpy.errstate(over="ignore"):  # of places that are very far
            return nearest(places)
    return checked


def values_of(model: Any, name: str) -> int:
    """The number of values of a variable."""
    size, each = int(model.get_var_nbytes(name)), int(model.get_var_itemsize(name))
    if each <= 0 or size < each:
        raise BmiError(f"'{name}' has {size} bytes, and a value has {each}.")
    return size // each


def _require(model: Any, name: str, nodes: int) -> None:
    count = values_of(model, name)
    if count != nodes:
        raise BmiError(f"'{name}' has {count} values, and its grid has {nodes} nodes.")


def _finite(values: Any, name: str, what: str) -> Any:
    import numpy

    if not numpy.isfinite(values).all():
        raise BmiError(f"the grid of '{name}' has {what} that are no finite numbers.")
    return values


def _shape(model: Any, grid: int, rank: int) -> List[int]:
    import numpy

    return [int(number) for number in model.get_grid_shape(grid, numpy.empty(rank, dtype=int))]


def _coordinates(model: Any, name: str, grid: int, axis: str, count: int) -> Any:
    import numpy

    return _finite(numpy.array(getattr(model, f"get_grid_{axis}")(grid, numpy.empty(count)), dtype=float), name, "coordinates")


def _scalar(model: Any, name: str, grid: int, rank: int) -> Callable[[Places], Nodes]:
    import numpy

    _require(model, name, 1)
    return lambda places: numpy.zeros(len(places), dtype=numpy.int64)


def _joined(shape: Sequence[int], along: Sequence[Nodes]) -> Nodes:
    """The number of a node from its numbers along the axes; both begin with the fastest axis."""
    found = along[-1]
    for count, place in zip(reversed(shape[:-1]), reversed(along[:-1])):
        found = found * count + place
    return found


def _uniform(model: Any, name: str, grid: int, rank: int) -> Callable[[Places], Nodes]:
    import numpy

    shape = _shape(model, grid, rank)[::-1]
    spacing = _finite(model.get_grid_spacing(grid, numpy.empty(rank)), name, "spacings")[::-1]
    origin = _finite(model.get_grid_origin(grid, numpy.empty(rank)), name, "origins")[::-1]
    if min(shape) < 1 or not numpy.all(spacing != 0):
        raise BmiError(f"the grid of '{name}' has {shape[::-1]} nodes {list(spacing[::-1])} apart: there are no places.")
    _require(model, name, int(numpy.prod(shape)))

    def nearest(places: Places) -> Nodes:
        along = [numpy.clip(numpy.rint((places[:, axis] - origin[axis]) / spacing[axis]), 0, shape[axis] - 1).astype(numpy.int64)
                 for axis in range(rank)]
        return _joined(shape, along)
    return nearest


def _rectilinear(model: Any, name: str, grid: int, rank: int) -> Callable[[Places], Nodes]:
    import numpy

    shape = _shape(model, grid, rank)[::-1]
    if min(shape) < 1:
        raise BmiError(f"the grid of '{name}' has {shape[::-1]} nodes.")
    _require(model, name, int(numpy.prod(shape)))
    lines = [_coordinates(model, name, grid, axis, count) for axis, count in zip("xyz", shape)]
    for line, axis in zip(lines, "xyz"):
        steps = numpy.diff(line)
        if not (numpy.all(steps > 0) or numpy.all(steps < 0)):
            raise BmiError(f"the coordinates {axis} of the grid of '{name}' neither rise nor fall everywhere.")

    def along(line: Any, values: Any) -> Nodes:
        rising = line if len(line) < 2 or line[0] < line[1] else line[::-1]
        # half-way between two nodes the first counts
        found = numpy.searchsorted((rising[:-1] + rising[1:]) / 2, values)
        return found if rising is line else len(line) - 1 - found

    return lambda places: _joined(shape, [along(lines[axis], places[:, axis]) for axis in range(rank)])


def _points(model: Any, name: str, grid: int, rank: int) -> Callable[[Places], Nodes]:
    """Nodes anywhere: of points, of an unstructured grid, of a curved one. A query costs a look at all of them."""
    import numpy

    shape = _shape(model, grid, rank) if model.get_grid_type(grid) == "structured_quadrilateral" else []
    count = int(numpy.prod(shape)) if shape else int(model.get_grid_node_count(grid))
    if count < 1:
        raise BmiError(f"the grid of '{name}' has {count} nodes.")
    _require(model, name, count)
    nodes = [_coordinates(model, name, grid, axis, count) for axis in "xyz"[:rank]]

    def nearest(places: Places) -> Nodes:
        found = numpy.empty(len(places), dtype=numpy.int64)
        many = max(1, AT_ONCE // count)
        for first in range(0, len(places), many):
            part = places[first:first + many]
            squares = sum((part[:, axis, None] - nodes[axis][None, :]) ** 2 for axis in range(rank))
            found[first:first + many] = numpy.argmin(squares, axis=1)
        return found
    return nearest
