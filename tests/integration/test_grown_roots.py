"""`xylem` on root systems that our own models grow, against an independent solver (tests/support/root_solver.py)."""

import json
import math
import re
import sys
import tempfile
import unittest
from pathlib import Path
from typing import List, Tuple

from support import REPOSITORY, espalier

sys.path.insert(0, str(REPOSITORY / "tests" / "support"))
from root_solver import Segment, heads_and_uptakes  # noqa: E402

# a tap root with laterals of two orders, drawn downwards; each segment is followed by its query, with age and order
ROOTS = """Lsystem: 1
derivation length: 9
Axiom: -(180)A(0,1)
A(t,o) : t < 4 && o < 4 --> F(1.5+ran(1))?E(t,o,0,0,0,0,0,0,0,0)[+(50+ran(20))A(o,o+1)]A(t+0.5,o)
endlsystem
"""
RADIUS, SOIL, COLLAR = 0.05, -300.0, -4000.0
# rows of order, age and value; from an age on
KR = [[1, 0, 2e-4], [1, 1, 1e-4], [2, 0, 3e-4], [3, 0, 4e-4]]
KX = [[1, 0, 0.05], [2, 0, 0.004], [3, 0, 0.002]]


def value(table: "List[List[float]]", order: float, age: float) -> float:
    """Linear between the ages of an order, as the page of the process says."""
    rows = [(row[1], row[2]) for row in table if row[0] == order]
    if age <= rows[0][0]:
        return rows[0][1]
    for (a, x), (b, y) in zip(rows, rows[1:]):
        if age <= b:
            return x + (y - x) * (age - a) / (b - a)
    return rows[-1][1]


def drawn(string: str) -> "Tuple[List[Segment], List[List[float]]]":
    """The segments of a string, and the parameters of the query behind each. Its turtle draws in a plane, upwards at first."""
    segments: List[Segment] = []
    answers: List[List[float]] = []
    angle, last = 90.0, -1
    stack: "List[Tuple[float, int]]" = []
    for name, given in re.findall(r"(\?E|[F+\-\[\]])(?:\(([^)]*)\))?", string):
        numbers = [float(number) for number in given.split(",")] if given else []
        if name == "F":
            rise = numbers[0] * math.sin(math.radians(angle))
            segments.append(Segment(last, numbers[0], rise, RADIUS, 0.0, 0.0))
            last = len(segments) - 1
        elif name == "?E":
            answers.append(numbers)
            segments[last].kr = value(KR, numbers[1], numbers[0])
            segments[last].kx = value(KX, numbers[1], numbers[0])
        elif name in "+-":
            angle += numbers[0] if name == "+" else -numbers[0]
        elif name == "[":
            stack.append((angle, last))
        else:
            angle, last = stack.pop()
    return segments, answers


class GrownRoots(unittest.TestCase):
    def test_heads_and_uptakes_are_those_of_finite_differences(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "roots.l").write_text(ROOTS, encoding="utf-8")
            (folder / "world.json").write_text('{"lengthUnit": "cm"}', encoding="utf-8")
            (folder / "xylem.json").write_text(json.dumps(
                {"type": "xylem", "collar": "head", "collarHead": COLLAR, "soilHead": SOIL, "radius": RADIUS, "krTable": KR, "kxTable": KX,
                 "groundHeight": 1000}), encoding="utf-8")
            for seed in (1, 2):
                string = espalier("derive", str(folder / "roots.l"), "--environment", str(folder / "xylem.json"), "--world",
                                  str(folder / "world.json"), "--seed", str(seed), "--steps", "8", "--quiet", "--every", "--answered").stdout.splitlines()[-1].split("\t")[1]
                segments, answers = drawn(string)
                self.assertGreater(len(segments), 30)
                self.assertEqual(len(segments), len(answers))
                heads, uptakes = heads_and_uptakes(segments, SOIL, COLLAR)
                for number, answer in enumerate(answers):
                    self.assertAlmostEqual(answer[3] / heads[number], 1.0, delta=1e-4)
                    self.assertAlmostEqual(answer[4], uptakes[number], delta=1e-4 * max(uptakes))
                self.assertAlmostEqual(answers[0][6] / sum(uptakes), 1.0, delta=1e-4)


if __name__ == "__main__":
    unittest.main()
