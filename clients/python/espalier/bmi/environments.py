"""A model of the Basic Model Interface as an environment that plants ask."""

from __future__ import annotations

import weakref
from typing import Any, Callable, Dict, Mapping, Optional, Sequence, Type

from ..environment import Environment
from ..queries import Answer, Query, Variable
from .grids import BmiError, grid_of, values_of


def _described(model: Any, name: str) -> Variable:
    try:
        unit = str(model.get_var_units(name)).strip()
    except (AttributeError, NotImplementedError):
        unit = ""  # a model without this function
    return Variable(name.replace(" ", "_"), unit if unit not in ("", "-") else "1")


def environment_of(model: Callable[[], Any], config_file: str, output: str, demand: Optional[str] = None,
                   axes: Sequence[str] = ("x", "y", "z")) -> Type[Environment]:
    """An Environment that a BMI model answers. In each step the model gets the sum of the queries' first parameters of each node in
    its variable `demand`, makes one update, and a query is answered the value of `output` at its place. `axes` are those of the
    world that the axes of the grid follow, from the fastest on: ("x", "y") for a map seen from the side. Each simulation has
    a model of its own, finalized when it starts over or is closed, or the connection ends. One more model is initialized and
    finalized at once: it says the units. BMI has no way to save a state: after a lost model the simulation must be reset.

        environment_of(Heat, "heat.yaml", "plate_surface__temperature", axes=("x", "z")).serve()
    """
    if not set(axes) <= {"x", "y", "z"}:
        raise BmiError(f"the axes {list(axes)} are not of x, y and z.")
    first = model()
    first.initialize(config_file)
    try:
        grid_of(first, output, axes)
        if demand is not None and values_of(first, demand) != values_of(first, output):
            raise BmiError(f"'{demand}' has {values_of(first, demand)} values and '{output}' {values_of(first, output)}: both need the same grid.")
        described = [_described(first, name) for name in (output, demand) if name is not None]
    finally:
        first.finalize()

    class Bmi(Environment):
        needs = ("position", "parameters")
        inputs = described[1:]
        outputs = described[:1]
        is_stateful = True

        @classmethod
        def description(cls) -> Dict[str, Any]:
            return {**super().description(), "checkpoint": False}

        def opened(self) -> None:
            self.model = model()
            self.model.initialize(config_file)
            # at the latest when this object goes: a simulation that starts over has a new one, and a lost connection closes none
            self.end = weakref.finalize(self, self.model.finalize)
            self.nearest = grid_of(self.model, output, axes)
            self.last_step = -1

        def closed(self) -> None:
            self.end()

        def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
            import numpy

            # the same step may be asked again
            if self.completed_steps - self.last_step not in (0, 1):
                raise BmiError(f"the BMI model is not at step {self.completed_steps}, and its state is never saved: reset the simulation")
            self.last_step = self.completed_steps
            nodes = self.nearest(numpy.array([[query.position["xyz".index(axis)] for axis in axes] for query in queries]).reshape(-1, len(axes)))
            places = [int(node) for node in nodes]
            if demand is not None:
                asked = numpy.zeros(values_of(self.model, demand))
                for place, query in zip(places, queries):
                    asked[place] += query.parameters[0] if query.parameters else 0.0
                self.model.set_value(demand, asked)
            self.model.update()
            values = self.model.get_value(output, numpy.empty(values_of(self.model, output), dtype=self.model.get_var_type(output)))
            return [[float(values[place])] for place in places]

        def save(self) -> Mapping[str, Any]:
            raise BmiError("a BMI model has no way to save its state: run it in one piece.")

    return Bmi
