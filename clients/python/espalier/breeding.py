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
    """A grown plant that waits for its fitness. Lengths are in the model's unit, y is up, the base is at the origin.

    `segments` holds for each drawn line x, y, z of its start, x, y, z of its end, both diameters and the index of the
    line that it grows from (-1: none): nine numbers. `measures` are those that the command line has names for.
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
        """Of its highest point above the base."""
        return self.measures["height"]

    @property
    def light(self) -> float:
        """The ground that it shades from light straight above, in square units."""
        return self.measures["light"]

    @property
    def symmetry(self) -> float:
        """Bilateral, from 0 (nothing has its mirror image) to 1."""
        return self.measures["symmetry"]


def serve_fitness(
    fitness: Callable[[BredPlant], float], source: TextIO = sys.stdin, target: TextIO = sys.stdout
) -> None:
    """Answers for every plant on standard input with `fitness(plant)`, until the input ends.

    The fitness must be a finite number, greater is better; the same plant must get the same. What the function prints
    goes to standard error. An exception ends the breeding: its traceback is printed, and `evolve --resume` goes on
    after it was mended.

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
            except Exception as error:  # whatever the user's function does
                traceback.print_exc(file=sys.stderr)
                answer = {"error": f"{type(error).__name__}: {error}"}
            target.write(json.dumps(answer) + "\n")
            target.flush()
    finally:
        sys.stdout = printed
