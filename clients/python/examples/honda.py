"""The process `honda` in Python: collisions of branch tips with clusters of one radius (Honda, Tomlinson & Fisher 1981).

    espalier derive clients/gallery/branch-tiers/branch-tiers.l \
        --environment 'stdio:python3 clients/python/examples/honda.py --radius 0.5'
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from math import floor
from typing import DefaultDict, List, Sequence, Tuple

from espalier import Answer, Environment, Query, Variable

Cell = Tuple[int, ...]


class Honda(Environment):
    """Answers 0 when a point of the same group with at least the same vigor is within the radius, else 1."""

    needs = ("position", "parameters")
    inputs = (Variable("vigor"), Variable("group"))
    outputs = (Variable("free"),)
    # the settings of the command line; a simulation's configuration wins
    radius = 0.0
    axes: Sequence[int] = (0, 2)

    def opened(self) -> None:
        self.radius = float(self.opening.configuration.get("radius", self.radius))

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        # squares as wide as the radius: colliding tips are in the same or a neighbouring square
        width = self.radius if self.radius > 0 else 1.0
        cells: DefaultDict[Cell, List[int]] = defaultdict(list)
        points = [tuple(query.position[axis] for axis in self.axes) for query in queries]
        for index, point in enumerate(points):
            cells[tuple(floor(value / width) for value in point)].append(index)

        answers: List[Answer] = []
        for index, query in enumerate(queries):
            vigor, group = self._vigor_and_group(query)
            home = tuple(floor(value / width) for value in points[index])
            is_free = True
            for cell in _neighbours(home):
                for other in cells.get(cell, ()):
                    other_vigor, other_group = self._vigor_and_group(queries[other])
                    if other == index or other_group != group or other_vigor < vigor:
                        continue
                    if _squared_distance(points[index], points[other]) <= self.radius * self.radius:
                        is_free = False
            answers.append([1 if is_free else 0])
        return answers

    @staticmethod
    def _vigor_and_group(query: Query) -> Tuple[float, float]:
        values = (*query.parameters, 0.0, 0.0)
        return values[0], values[len(query.parameters)] if len(query.parameters) < 2 else values[1]


def _neighbours(cell: Cell) -> List[Cell]:
    found: List[Cell] = [()]
    for value in cell:
        found = [(*start, value + offset) for start in found for offset in (-1, 0, 1)]
    return found


def _squared_distance(a: Tuple[float, ...], b: Tuple[float, ...]) -> float:
    return sum((p - q) * (p - q) for p, q in zip(a, b))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--radius", type=float, default=0.0)
    parser.add_argument("--3d", dest="is_spatial", action="store_true")
    own, rest = parser.parse_known_args()
    Honda.radius = own.radius
    Honda.axes = (0, 1, 2) if own.is_spatial else (0, 2)
    sys.argv[1:] = rest
    Honda.serve()
