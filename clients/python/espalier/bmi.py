"""The Basic Model Interface (BMI 2.0, Hutton, Piper & Tucker 2020): a simulation as a model that others step, and a BMI model as an
environment that plants ask.

    model = EspalierBmi()
    model.initialize("tree.json")            # {"model": "tree.l", "environment": [{"type": "shadow"}], "seed": 7, "inputs": ["ENOUGH"],
    model.update_until(12.0)                 #  "outputs": ["modules", "height", "count:A", "sum:F:1"]}
    print(model.get_value("height", numpy.empty(1)))

All values are scalars of the whole simulation. Needs NumPy.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Type

from .client import Simulation
from .environment import Environment
from .errors import EspalierError
from .local_server import Local
from .queries import Answer, Query, Variable

Array = Any  # numpy.ndarray


class BmiError(EspalierError):
    """A call that the interface cannot answer: one sentence."""


_KEYS = {"model", "gallery", "environment", "seed", "derivationLength", "stepDurationDays", "inputs", "outputs", "program", "parameters"}


def _configuration(path: Path) -> Dict[str, Any]:
    try:
        read = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BmiError(f"{path} cannot be read as JSON ({error}): initialize takes the name of a configuration file.") from None
    if not isinstance(read, dict):
        raise BmiError(f"{path} is no JSON object.")
    unknown = sorted(set(read) - _KEYS)
    if unknown:
        raise BmiError(f"{path}: '{unknown[0]}' is not known. Keys: {', '.join(sorted(_KEYS))}.")
    if ("model" in read) == ("gallery" in read):
        raise BmiError(f"{path} needs either 'model', a file beside it, or 'gallery', a name.")
    return read


class EspalierBmi:
    """A simulation on a server of its own, as a BMI model. Time is in days; a step of the model is one time step."""

    def __init__(self) -> None:
        self._server: Optional[Local] = None
        self._simulation: Optional[Simulation] = None
        self._inputs: Dict[str, Array] = {}
        self._outputs: Dict[str, Array] = {}
        self._step = 0
        self._last = 0
        self._days = 1.0

    # ---- control -----------------------------------------------------------------------------------------------

    def initialize(self, config_file: str) -> None:
        import numpy

        path = Path(config_file)
        settings = _configuration(path)
        self._days = float(settings.get("stepDurationDays", 1.0))
        if not 0.0 < self._days < float("inf"):
            raise BmiError(f"{path}: 'stepDurationDays' is a number above 0.")
        parameters = dict(settings.get("parameters", {}))
        missing = [name for name in settings.get("inputs", []) if name not in parameters]
        if missing:
            raise BmiError(f"{path}: the input '{missing[0]}' needs a value at the start, in 'parameters'.")
        self._inputs = {name: numpy.array([float(parameters[name])]) for name in settings.get("inputs", [])}
        names = settings.get("outputs", ["modules", "height"])
        for name in names:
            self._reader(name)
        self._outputs = {name: numpy.zeros(1) for name in names}
        source = (path.parent / settings["model"]).read_text(encoding="utf-8") if "model" in settings else None
        self._server = Local(settings.get("program"))
        try:
            self._begin(source, settings, parameters)
        except BaseException:
            # no server stays behind a model that could not begin
            self.finalize()
            raise

    def _begin(self, source: Optional[str], settings: Mapping[str, Any], parameters: Mapping[str, Any]) -> None:
        assert self._server is not None
        self._simulation = self._server.create(source, gallery=settings.get("gallery"), environment=settings.get("environment"),
                                               seed=settings.get("seed", 1), derivation_length=settings.get("derivationLength"),
                                               parameters=parameters or None, save=False)
        self._step = 0
        length = settings.get("derivationLength")
        self._last = int(length if length is not None else self._server.load(source, gallery=settings.get("gallery")).derivation_length)
        self._read()

    def update(self) -> None:
        if self._step >= self._last:
            raise BmiError(f"the model ends after {self._last} steps: initialize it with a larger 'derivationLength'.")
        simulation = self._running()
        if self._inputs:
            simulation.set({name: float(value[0]) for name, value in self._inputs.items()})
        simulation.step(1)
        self._step += 1
        self._read()

    def update_until(self, time: float) -> None:
        """Makes all steps that end at this time or before it."""
        if time < self.get_current_time():
            raise BmiError(f"the time {time} is before {self.get_current_time()}: a model does not go back. Initialize it again.")
        # a half of a step's rounding error
        while (self._step + 1) * self._days <= time * (1 + 1e-12):
            self.update()

    def finalize(self) -> None:
        if self._server is not None:
            self._server.close()
        self._server = self._simulation = None

    def _running(self) -> Simulation:
        if self._simulation is None:
            raise BmiError("the model is not initialized: call initialize(config_file) first.")
        return self._simulation

    def _read(self) -> None:
        for name, value in self._outputs.items():
            value[0] = self._reader(name)(self._running())

    @staticmethod
    def _reader(name: str) -> Callable[[Simulation], float]:
        words = name.split(":")
        if name == "modules":
            return lambda simulation: float(simulation.get("statistics")["statistics"]["modules"])
        if name == "height":
            return lambda simulation: max((record.position[1] for record in simulation.turtle()), default=0.0)
        if words[0] == "count" and len(words) == 2:
            return lambda simulation: float(sum(record.symbol == words[1] for record in simulation.turtle()))
        if words[0] == "sum" and len(words) == 3 and words[2].isdigit() and int(words[2]) > 0:
            place = int(words[2]) - 1
            return lambda simulation: float(sum(record.parameters[place] for record in simulation.turtle()
                                                if record.symbol == words[1] and len(record.parameters) > place))
        raise BmiError(f"there is no output '{name}'. Outputs: modules, height, count:SYMBOL, sum:SYMBOL:PARAMETER.")

    # ---- what there is -----------------------------------------------------------------------------------------

    def get_component_name(self) -> str:
        return "Espalier"

    def get_input_item_count(self) -> int:
        return len(self._inputs)

    def get_output_item_count(self) -> int:
        return len(self._outputs)

    def get_input_var_names(self) -> Tuple[str, ...]:
        return tuple(self._inputs)

    def get_output_var_names(self) -> Tuple[str, ...]:
        return tuple(self._outputs)

    def _value(self, name: str) -> Array:
        value = self._inputs.get(name, self._outputs.get(name))
        if value is None:
            raise BmiError(f"there is no variable '{name}'. Variables: {', '.join([*self._inputs, *self._outputs])}.")
        return value

    def get_var_grid(self, name: str) -> int:
        self._value(name)
        return 0

    def get_var_type(self, name: str) -> str:
        return str(self._value(name).dtype)

    def get_var_units(self, name: str) -> str:
        self._value(name)
        return "m" if name == "height" else "1"

    def get_var_itemsize(self, name: str) -> int:
        return int(self._value(name).itemsize)

    def get_var_nbytes(self, name: str) -> int:
        return int(self._value(name).nbytes)

    def get_var_location(self, name: str) -> str:
        self._value(name)
        return "node"

    # ---- time --------------------------------------------------------------------------------------------------

    def get_current_time(self) -> float:
        return self._step * self._days

    def get_start_time(self) -> float:
        return 0.0

    def get_end_time(self) -> float:
        return self._last * self._days

    def get_time_units(self) -> str:
        return "d"

    def get_time_step(self) -> float:
        return self._days

    # ---- values ------------------------------------------------------------------------------------------------

    def get_value(self, name: str, dest: Array) -> Array:
        dest[:] = self._value(name)
        return dest

    def get_value_ptr(self, name: str) -> Array:
        return self._value(name)

    def get_value_at_indices(self, name: str, dest: Array, inds: Array) -> Array:
        dest[:] = self._value(name).take(inds)
        return dest

    def set_value(self, name: str, src: Array) -> None:
        if name not in self._inputs:
            raise BmiError(f"'{name}' is no input. Inputs: {', '.join(self._inputs) or 'none'}.")
        self._inputs[name][:] = src

    def set_value_at_indices(self, name: str, inds: Array, src: Array) -> None:
        if list(inds) == [0]:
            self.set_value(name, src)
        elif len(inds) > 0:
            raise BmiError(f"'{name}' has the index 0 only.")

    # ---- the grid: one number ----------------------------------------------------------------------------------

    def _only(self, grid: int) -> None:
        if grid != 0:
            raise BmiError(f"there is no grid {grid}: all variables are on grid 0.")

    def get_grid_type(self, grid: int) -> str:
        self._only(grid)
        return "scalar"

    def get_grid_rank(self, grid: int) -> int:
        self._only(grid)
        return 0

    def get_grid_size(self, grid: int) -> int:
        self._only(grid)
        return 1

    def _no_grid(self, grid: int, *_: Array) -> Array:
        self._only(grid)
        raise BmiError("a scalar has no points, edges or faces.")

    get_grid_shape = get_grid_spacing = get_grid_origin = _no_grid
    get_grid_x = get_grid_y = get_grid_z = _no_grid
    get_grid_edge_nodes = get_grid_face_edges = get_grid_face_nodes = get_grid_nodes_per_face = _no_grid

    def get_grid_node_count(self, grid: int) -> int:
        self._only(grid)
        return 1

    def get_grid_edge_count(self, grid: int) -> int:
        self._only(grid)
        return 0

    def get_grid_face_count(self, grid: int) -> int:
        self._only(grid)
        return 0


class _Raster:
    """The uniform grid of a BMI variable. BMI lists axes from the slowest to the fastest: z, y, x, or y, x."""

    def __init__(self, model: Any, name: str) -> None:
        import numpy

        grid = model.get_var_grid(name)
        if model.get_grid_type(grid) != "uniform_rectilinear":
            raise BmiError(f"'{name}' is on a grid of the type {model.get_grid_type(grid)}: an environment needs uniform_rectilinear.")
        rank = model.get_grid_rank(grid)
        if rank not in (1, 2, 3):
            raise BmiError(f"'{name}' has {rank} dimensions: an environment needs one to three.")
        self.shape: List[int] = [int(number) for number in model.get_grid_shape(grid, numpy.empty(rank, dtype=int))]
        self.spacing = [float(number) for number in model.get_grid_spacing(grid, numpy.empty(rank))]
        self.origin = [float(number) for number in model.get_grid_origin(grid, numpy.empty(rank))]

    def index(self, place: Sequence[float]) -> int:
        """The nearest node, at the border for places outside."""
        found = 0
        for count, spacing, origin, coordinate in zip(self.shape, self.spacing, self.origin, reversed(place[:len(self.shape)])):
            found = found * count + min(max(round((coordinate - origin) / spacing), 0), count - 1)
        return found


def environment_of(model: Callable[[], Any], config_file: str, output: str, demand: Optional[str] = None,
                   axes: Sequence[str] = ("x", "y", "z")) -> Type[Environment]:
    """An Environment that a BMI model answers. In each step the model gets the sum of the queries' first parameters of each node in
    its variable `demand`, makes one update, and a query is answered the value of `output` at its place. `axes` are those of the
    world that the axes of the grid follow, from the fastest on: ("x", "y") for a map seen from the side. Each simulation has
    a model of its own.

        environment_of(Heat, "heat.yaml", "plate_surface__temperature", axes=("x", "z")).serve()
    """
    if not set(axes) <= {"x", "y", "z"}:
        raise BmiError(f"the axes {list(axes)} are not of x, y and z.")

    class BmiEnvironment(Environment):
        needs = ("position", "parameters")
        outputs = (Variable(output.replace(" ", "_")),)
        is_stateful = True

        @classmethod
        def name(cls) -> str:
            return "bmi"

        def opened(self) -> None:
            self.model = model()
            self.model.initialize(config_file)
            self.raster = _Raster(self.model, output)
            if len(axes) < len(self.raster.shape):
                raise BmiError(f"'{output}' has {len(self.raster.shape)} dimensions: name as many axes.")

        def place(self, query: Query) -> Tuple[float, ...]:
            return tuple(query.position["xyz".index(axis)] for axis in axes)

        def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
            import numpy

            places = [self.raster.index(self.place(query)) for query in queries]
            if demand is not None:
                asked = numpy.zeros(self.model.get_var_nbytes(demand) // self.model.get_var_itemsize(demand))
                for place, query in zip(places, queries):
                    asked[place] += query.parameters[0] if query.parameters else 0.0
                self.model.set_value(demand, asked)
            self.model.update()
            size = self.model.get_var_nbytes(output) // self.model.get_var_itemsize(output)
            values = self.model.get_value(output, numpy.empty(size, dtype=self.model.get_var_type(output)))
            return [[float(values[place])] for place in places]

        def save(self) -> Mapping[str, Any]:
            raise BmiError("a BMI model has no way to save its state: run it in one piece.")

    return BmiEnvironment
