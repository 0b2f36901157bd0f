"""A simulation as a model of the Basic Model Interface that others step.

    model = EspalierBmi()
    model.initialize("tree-bmi.json")        # {"model": "tree.l", "environment": [{"type": "shadow"}], "seed": 7, "inputs": ["ENOUGH"],
    model.update_until(12.0)                 #  "parameters": {"ENOUGH": 1}, "outputs": ["modules", "height", "count:A", "sum:F:1"]}
    print(model.get_value("height", numpy.empty(1)))
    model.finalize()                         # ends its server

All values are scalars of the whole simulation. Needs NumPy. `espalier run tree.l` would take tree.json as the environment.
"""

from __future__ import annotations

import json
import math
from fractions import Fraction
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Optional, Tuple, TypeVar

from ..client import Simulation
from ..errors import EspalierError
from ..local_server import Local
from ..model_folder import reference, step_days, world
from .grids import BmiError

Array = Any  # numpy.ndarray
Value = TypeVar("Value")


# the keys of a configuration, and what each of them is
_KEYS: Dict[str, Tuple[Tuple[type, ...], str]] = {
    "model": ((str,), "the name of a file or folder beside the configuration"), "gallery": ((str,), "the name of a model of the gallery"),
    "environment": ((str, dict, list), "a name, an object, or a list of them"), "seed": ((int,), "a whole number"),
    "derivationLength": ((int,), "a whole number"), "stepDurationDays": ((int, float), "a number above 0"),
    "inputs": ((list,), "a list of names"), "outputs": ((list,), "a list of names"), "program": ((str,), "the path of the program espalier"),
    "parameters": ((dict,), "an object with a value for each name"),
}


def _configuration(path: Path) -> Dict[str, Any]:
    try:
        read = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BmiError(f"{path} cannot be read as JSON ({error}): initialize takes the name of a configuration file.") from None
    if not isinstance(read, dict):
        raise BmiError(f"{path} is no JSON object.")
    unknown = sorted(set(read) - set(_KEYS))
    if unknown:
        raise BmiError(f"{path}: '{unknown[0]}' is not known. Keys: {', '.join(sorted(_KEYS))}.")
    read = {key: value for key, value in read.items() if value is not None}
    for key, value in read.items():
        kinds, what = _KEYS[key]
        is_kind = isinstance(value, kinds) and not isinstance(value, bool)
        if (not is_kind or (kinds == (list,) and not all(isinstance(name, str) for name in value))
                or (key == "stepDurationDays" and not 0.0 < value < math.inf)):
            raise BmiError(f"{path}: '{key}' is {what}, not {json.dumps(value)}.")
    if ("model" in read) == ("gallery" in read):
        raise BmiError(f"{path} needs either 'model', a file or folder beside it, or 'gallery', a name.")
    read.setdefault("outputs", ["modules", "height"])
    parameters = read.setdefault("parameters", {})
    for name in read.setdefault("inputs", []):
        if not isinstance(value := parameters.get(name), (int, float)) or not math.isfinite(value):
            raise BmiError(f"{path}: the input '{name}' needs a value at the start, in 'parameters': a number.")
    return read


def _of_variable(answer: Callable[[str, Array], Value]) -> Callable[["EspalierBmi", str], Value]:
    def get(self: "EspalierBmi", name: str) -> Value:
        return answer(name, self._value(name))
    return get


def _of_grid(answer: Value) -> Callable[["EspalierBmi", int], Value]:
    def get(self: "EspalierBmi", grid: int) -> Value:
        if grid != 0:
            raise BmiError(f"there is no grid {grid}: all variables are on grid 0.")
        return answer
    return get


class EspalierBmi:
    """A simulation on a server of its own, as a BMI model. Time is in days; a step of the model is one time step."""

    def __init__(self) -> None:
        self._server: Optional[Local] = None
        self._simulation: Optional[Simulation] = None
        self._inputs: Dict[str, Array] = {}
        self._outputs: Dict[str, Array] = {}
        self._step, self._last, self._days = 0, 0, Fraction(1)

    # ---- control -----------------------------------------------------------------------------------------------

    def initialize(self, config_file: str) -> None:
        """Starts the simulation of a configuration file on a new server. The model before it is finalized."""
        import numpy
        self.finalize()
        path = Path(config_file)
        settings = _configuration(path)
        self._inputs = {name: numpy.array([float(settings["parameters"][name])]) for name in settings["inputs"]}
        self._outputs = {name: numpy.zeros(1) for name in settings["outputs"]}
        try:
            self._begin(path, settings)
        except BaseException as error:
            # no server stays behind a model that could not begin
            self.finalize()
            if isinstance(error, (EspalierError, OSError, TypeError, ValueError)) and not isinstance(error, BmiError):
                raise BmiError(f"{path}: the model cannot start. Correct this and initialize it again: {error}") from error
            raise

    def _begin(self, path: Path, settings: Mapping[str, Any]) -> None:
        sent = None if "gallery" in settings else self._files(path, settings["model"])
        self._server = server = Local(settings.get("program"))
        loaded = None if sent is None else str(server.call("model.load", {"model": sent})["model"])
        files = sent or server.call("model.read", {"gallery": settings["gallery"]})
        made = world({} if sent and "main" in sent else files["files"], settings.get("stepDurationDays"))
        self._simulation = server.create(gallery=settings.get("gallery"), loaded=loaded, environment=settings.get("environment"),
                                         seed=settings.get("seed", 1), derivation_length=settings.get("derivationLength"),
                                         parameters=settings["parameters"] or None, save=False,
                                         world=made)
        self._days = step_days(made)
        self._last = int(self._simulation.created["derivationLength"])
        self._read()

    @staticmethod
    def _files(path: Path, name: str) -> Dict[str, Any]:
        """The model beside a configuration with the files that it names."""
        model = path.parent / name
        if not model.exists():
            raise BmiError(f"{path}: there is no file or folder '{model}': 'model' names one beside the configuration.")
        sent = reference(model)
        # a configuration with the name of the model would be its environment
        folder = model if model.is_dir() else model.parent
        sent["files"] = {file: text for file, text in sent["files"].items() if (folder / file).resolve() != path.resolve()}
        return sent

    def update(self) -> None:
        simulation = self._running()
        if self._step >= self._last:
            raise BmiError(f"the model ends after {self._last} steps: initialize it with a larger 'derivationLength'.")
        if self._inputs:
            # a pointer may have changed them
            simulation.set({name: self._finite(name, value[0]) for name, value in self._inputs.items()})
        simulation.step(1)
        self._step += 1
        self._read()

    def update_until(self, time: float) -> None:
        """Makes all steps that end at this time or before it."""
        now = self.get_current_time()
        if not math.isfinite(time):
            raise BmiError(f"the time {time} is not finite: give a number of days from {now} on.")
        # a half of a step's rounding error
        until = time + abs(time) * 1e-12
        if until < now:
            raise BmiError(f"the time {time} is before {now}: a model does not go back. Initialize it again.")
        while float((self._step + 1) * self._days) <= until:
            self.update()

    def finalize(self) -> None:
        """Ends the server. Until the next initialize nothing can be asked."""
        server = self._server
        self._server = self._simulation = None
        self._inputs, self._outputs = {}, {}
        self._step = self._last = 0
        if server is not None:
            server.close()

    def _running(self) -> Simulation:
        if self._simulation is None:
            raise BmiError("the model is not initialized: call initialize(config_file) first.")
        return self._simulation

    def _known(self, value: Value) -> Value:
        self._running()
        return value

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

    # ---- what there is, and the time ---------------------------------------------------------------------------

    def get_component_name(self) -> str:
        return "Espalier"

    def get_input_item_count(self) -> int:
        return self._known(len(self._inputs))

    def get_output_item_count(self) -> int:
        return self._known(len(self._outputs))

    def get_input_var_names(self) -> Tuple[str, ...]:
        return self._known(tuple(self._inputs))

    def get_output_var_names(self) -> Tuple[str, ...]:
        return self._known(tuple(self._outputs))

    def _value(self, name: str) -> Array:
        value = self._known(self._inputs.get(name, self._outputs.get(name)))
        if value is None:
            raise BmiError(f"there is no variable '{name}'. Variables: {', '.join([*self._inputs, *self._outputs])}.")
        return value

    get_var_grid = _of_variable(lambda name, value: 0)
    get_var_type = _of_variable(lambda name, value: str(value.dtype))
    get_var_units = _of_variable(lambda name, value: "m" if name == "height" else "1")
    get_var_itemsize = _of_variable(lambda name, value: int(value.itemsize))
    get_var_nbytes = _of_variable(lambda name, value: int(value.nbytes))
    get_var_location = _of_variable(lambda name, value: "node")

    def get_current_time(self) -> float:
        return self._known(float(self._step * self._days))

    def get_start_time(self) -> float:
        return 0.0

    def get_end_time(self) -> float:
        return self._known(float(self._last * self._days))

    def get_time_units(self) -> str:
        return "d"

    def get_time_step(self) -> float:
        return self._known(float(self._days))

    # ---- values ------------------------------------------------------------------------------------------------

    def get_value(self, name: str, dest: Array) -> Array:
        dest[:] = self._value(name)
        return dest

    def get_value_ptr(self, name: str) -> Array:
        return self._value(name)

    def get_value_at_indices(self, name: str, dest: Array, inds: Array) -> Array:
        dest[:] = self._at(name, inds).take(inds)
        return dest

    def set_value(self, name: str, src: Array) -> None:
        import numpy

        value = self._value(name)
        if name not in self._inputs:
            raise BmiError(f"'{name}' is no input. Inputs: {', '.join(self._inputs) or 'none'}.")
        try:
            (number,) = numpy.asarray(src, dtype=float).ravel()
        except (TypeError, ValueError):
            raise BmiError(f"'{name}' takes one number, not {src!r}.") from None
        value[0] = self._finite(name, number)

    @staticmethod
    def _finite(name: str, value: float) -> float:
        if not math.isfinite(value):
            raise BmiError(f"the input '{name}' cannot be {float(value)}: set it to a finite number.")
        return float(value)

    def set_value_at_indices(self, name: str, inds: Array, src: Array) -> None:
        self._at(name, inds)
        if len(inds) > 0:
            self.set_value(name, src)

    def _at(self, name: str, inds: Array) -> Array:
        value = self._value(name)
        if any(index != 0 for index in inds):
            raise BmiError(f"'{name}' has the index 0 only.")
        return value

    # ---- the grid: one number ----------------------------------------------------------------------------------

    get_grid_type = _of_grid("scalar")
    get_grid_size = get_grid_node_count = _of_grid(1)
    get_grid_rank = get_grid_edge_count = get_grid_face_count = _of_grid(0)

    def _no_grid(self, grid: int, *_: Array) -> Array:
        self.get_grid_type(grid)
        raise BmiError("a scalar has no points, edges or faces.")

    get_grid_shape = get_grid_spacing = get_grid_origin = get_grid_x = get_grid_y = get_grid_z = _no_grid
    get_grid_edge_nodes = get_grid_face_edges = get_grid_face_nodes = get_grid_nodes_per_face = _no_grid
