"""BMI models on all kinds of grids as environments: the nearest node against a search by hand, mistakes as sentences."""

import importlib.util
import math
import random
import unittest
from typing import Any, Dict, List, Sequence

from support import program

import espalier
from espalier import bmi


class Numbers:
    """A BMI model on any grid, that answers the number of the node. It has the functions of its grid only, so that others are not called."""

    grid: Dict[str, Any] = {}

    def initialize(self, config_file: str) -> None:
        self.demand: List[float] = []

    def update(self) -> None: ...

    def finalize(self) -> None: ...

    def get_var_units(self, name: str) -> str:
        return "1"

    def get_var_grid(self, name: str) -> int:
        return 0

    def get_var_type(self, name: str) -> str:
        return "float64"

    def get_var_itemsize(self, name: str) -> int:
        return 8

    def get_var_nbytes(self, name: str) -> int:
        return 8 * int(self.grid[f"count of {name}"] if f"count of {name}" in self.grid else self.grid["count"])

    def get_value(self, name: str, dest: Any) -> Any:
        dest[:] = range(len(dest))
        return dest

    def set_value(self, name: str, src: Any) -> None:
        self.demand = list(src)

    def __getattr__(self, name: str) -> Any:
        if name not in type(self).grid:
            raise AttributeError(name)
        given = type(self).grid[name]

        def answer(_: Any, dest: Any = None) -> Any:
            if dest is None:
                return given
            dest[:] = given
            return dest
        return answer


def model(kind: str, count: int, **members: Any) -> Any:
    return type("Numbers", (Numbers,), {"grid": {"get_grid_type": kind, "count": count, **members}})


def corners(*lines: Sequence[float]) -> List[List[float]]:
    """The nodes of a grid of lines x, y, z: the first is the fastest."""
    nodes: List[List[float]] = [[]]
    for line in reversed(lines):
        nodes = [[place, *node] for node in nodes for place in line]
    return nodes


X, Y, Z = [0.0, 0.5, 2.0, 7.0], [3.0, 1.0, -4.0], [0.0, 10.0]
CURVED = [[math.cos(angle) * radius, math.sin(angle) * radius] for radius in (1.0, 2.0) for angle in (0.0, 0.7, 1.4)]
ANYWHERE = [[random.Random(number).uniform(-3, 3) for number in (3 * node, 3 * node + 1, 3 * node + 2)] for node in range(50)]
GRIDS = {
    "a line": (model("uniform_rectilinear", 4, get_grid_rank=1, get_grid_shape=[4], get_grid_spacing=[2.0], get_grid_origin=[-3.0]),
               [[-3.0], [-1.0], [1.0], [3.0]]),
    "equal cells": (model("uniform_rectilinear", 24, get_grid_rank=3, get_grid_shape=[2, 3, 4], get_grid_spacing=[3.0, 2.0, 1.0],
                          get_grid_origin=[0.0, -2.0, 1.0]), corners([1.0, 2.0, 3.0, 4.0], [-2.0, 0.0, 2.0], [0.0, 3.0])),
    "lines": (model("rectilinear", 24, get_grid_rank=3, get_grid_shape=[2, 3, 4], get_grid_x=X, get_grid_y=Y, get_grid_z=Z), corners(X, Y, Z)),
    "one column": (model("rectilinear", 3, get_grid_rank=2, get_grid_shape=[3, 1], get_grid_x=[4.0], get_grid_y=Y), corners([4.0], Y)),
    "curved": (model("structured_quadrilateral", 6, get_grid_rank=2, get_grid_shape=[2, 3], get_grid_x=[x for x, _ in CURVED],
                     get_grid_y=[y for _, y in CURVED]), CURVED),
    "unstructured": (model("unstructured", 50, get_grid_rank=3, get_grid_node_count=50, get_var_location="node", get_grid_x=[x for x, _, _ in ANYWHERE],
                           get_grid_y=[y for _, y, _ in ANYWHERE], get_grid_z=[z for _, _, z in ANYWHERE]), ANYWHERE),
    "points": (model("points", 6, get_grid_rank=2, get_grid_node_count=6, get_grid_x=[x for x, _ in CURVED], get_grid_y=[y for _, y in CURVED]), CURVED),
}


@unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
class Grids(unittest.TestCase):
    def test_each_place_has_the_nearest_node(self) -> None:
        import numpy
        from espalier.bmi import grids

        draw = random.Random(11)
        places = [[draw.uniform(-8, 12) for _ in range(3)] for _ in range(500)] + [[1e300, -1e300, 0.0]]
        for name, (kind, nodes) in GRIDS.items():
            with self.subTest(name):
                rank = len(nodes[0])
                found = grids.grid_of(kind(), "number", "xyz"[:rank])(numpy.array(places))
                for place, node in zip(places[:500], found):
                    self.assertEqual(math.dist(place[:rank], nodes[node]), min(math.dist(place[:rank], other) for other in nodes))

    def test_plants_ask_and_their_demands_are_added_up(self) -> None:
        plant = "Lsystem: 1\nderivation length: 1\nAxiom: [@M(0.4,0,3.2)?E(4)][@M(0.6,0,2.9)?E(5)][@M(6,0,-9)?E(7)]\nendlsystem\n"
        with espalier.local(program()) as client:
            for name, (kind, expected) in {"lines": (model("rectilinear", 12, get_grid_rank=2, get_grid_shape=[3, 4], get_grid_x=X, get_grid_y=Y), [1, 1, 11]),
                                           "one number": (model("scalar", 1), [0, 0, 0])}.items():
                with self.subTest(name):
                    made: List[Any] = []
                    asked = client.attach(bmi.environment_of(lambda kind=kind: made.append(kind()) or made[-1], "none", "number",  # type: ignore[misc, func-returns-value]
                                                             demand="taken", axes=("x", "z")))
                    grown = client.create(plant, environment=[asked], save=False)
                    grown.step(1)
                    self.assertEqual([record.parameters for record in grown.turtle() if record.symbol == "E"], [(number,) for number in expected])
                    self.assertEqual({node: taken for node, taken in enumerate(made[-1].demand) if taken}, {1: 9.0, 11: 7.0} if name == "lines" else {0: 16.0})

    def test_what_cannot_be_an_environment_is_one_sentence(self) -> None:
        line = {"get_grid_rank": 1, "get_grid_shape": [3], "get_grid_x": [0.0, 1.0, 2.0]}
        cloud = {"get_grid_rank": 1, "get_grid_node_count": 3, "get_grid_x": [0.0, 1.0, 2.0]}
        for kind, said in ((model("vector", 3), "on a grid of the type vector: an environment needs one of uniform_rectilinear, rectilinear"),
                           (model("rectilinear", 3, **{**line, "get_grid_x": [0.0, 2.0, 1.0]}), "the coordinates x .* neither rise nor fall"),
                           (model("rectilinear", 3, **{**line, "get_grid_x": [0.0, 0.0, 1.0]}), "the coordinates x .* neither rise nor fall"),
                           (model("rectilinear", 3, **{**line, "get_grid_x": [0.0, math.nan, 1.0]}), "no finite numbers"),
                           (model("rectilinear", 4, **line), "'number' has 4 values, and its grid has 3 nodes"),
                           (model("rectilinear", 3, **{**line, "get_grid_rank": 4}), "has 4 dimensions"),
                           (model("unstructured", 3, **cloud, get_var_location="face"), "the values of 'number' are at each face"),
                           (model("unstructured", 2, **cloud), "'number' has 2 values, and its grid has 3 nodes"),
                           (model("points", 0, **{**cloud, "get_grid_node_count": 0}), "has 0 nodes"),
                           (model("rectilinear", 3, get_grid_rank=1, get_grid_shape=[3]), "does not describe the grid of 'number', which is rectilinear .*get_grid_x"),
                           (model("scalar", 3), "'number' has 3 values, and its grid has 1 nodes"),
                           (model("uniform_rectilinear", 3, get_grid_rank=1, get_grid_shape=[3], get_grid_spacing=[0.0], get_grid_origin=[0.0]), "there are no places"),
                           (model("rectilinear", 3, **line, **{"count of taken": 2}), "'taken' has 2 values and 'number' 3")):
            with self.assertRaisesRegex(bmi.BmiError, said):
                bmi.environment_of(kind, "none", "number", demand="taken", axes=("x", "y", "z"))


if __name__ == "__main__":
    unittest.main()
