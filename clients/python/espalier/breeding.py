"""Judging plants that `espalier evolve --fitness 'stdio:COMMAND'` breeds."""

from __future__ import annotations

import json
import math
import sys
import traceback
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, TextIO


@dataclass(frozen=True)
class BredPlant:
    """A grown plant without a fitness. Lengths are in the unit of the model, y is up, the base is at the origin.

    `segments` holds for each drawn line x, y, z of its start, x, y, z of its end, both diameters and the index of the
    line that it grows from (-1: none): nine numbers. `measures` has the measures of the command line by name.

    >>> espalier.BredPlant(generation=0, individual=1, modules=3, parameters={}, productions={}, segments=[], string="F",
    ...                    measures={"height": 2.0}).height
    2.0
    """

    generation: int
    individual: int
    modules: int
    parameters: Dict[str, float]
    productions: Dict[str, str]
    measures: Dict[str, float]
    segments: List[List[float]]
    string: str

    @property
    def height(self) -> float:
        """Height of the highest point above the base."""
        return self.measures["height"]

    @property
    def light(self) -> float:
        """The ground shaded from light straight above, in square units."""
        return self.measures["light"]

    @property
    def symmetry(self) -> float:
        """Bilateral symmetry, from 0 (no part has its mirror image) to 1."""
        return self.measures["symmetry"]


def serve_fitness(
    fitness: Callable[[BredPlant], float], source: TextIO = sys.stdin, target: TextIO = sys.stdout
) -> None:
    """Answers for every plant on standard input with `fitness(plant)`, until the input ends.

    The fitness must be a finite number; greater is better. Equal plants must get equal numbers. The output of the function
    goes to standard error. An exception ends the breeding and prints its traceback. `evolve --resume` continues after
    the correction.

    >>> import io
    >>> plant = dict(generation=0, individual=1, modules=3, parameters={}, productions={}, segments=[], string="F",
    ...              measures={"height": 2.0})
    >>> answers = io.StringIO()
    >>> serve_fitness(lambda plant: plant.height ** 2, io.StringIO(json.dumps(plant)), answers)
    >>> answers.getvalue()
    '{"fitness": 4.0}\\n'
    """
    printed = sys.stdout
    if target is printed:
        sys.stdout = sys.stderr
    try:
        for line in source:
            answer: Dict[str, Any]
            try:
                value = float(fitness(BredPlant(**json.loads(line))))
                answer = {"fitness": value}
                if not math.isfinite(value):
                    answer = {"error": f"the fitness is {value}, not a finite number"}
            except Exception as error:  # the function may raise anything
                traceback.print_exc(file=sys.stderr)
                answer = {"error": f"{type(error).__name__}: {error}"}
            target.write(json.dumps(answer) + "\n")
            target.flush()
    finally:
        sys.stdout = printed
