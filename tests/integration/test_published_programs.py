"""The compatible processes against a second implementation of the published programs (tests/support/published_programs.py)
on random inputs: several steps, each with the answers of the one before. More cases: ESPALIER_PUBLISHED_CASES=200."""

import importlib.util
import os
import random
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, Callable, Dict, List, Sequence, Tuple

from support import REPOSITORY, espalier

sys.path.insert(0, str(REPOSITORY / "tests" / "support"))

CASES = int(os.environ.get("ESPALIER_PUBLISHED_CASES", "3"))
STEPS = 3
ENVIRONMENT = """executable: {program} -e model.e model.spec
turtle position: P: %.4f %.4f %.4f
turtle heading: H: %.4f %.4f %.4f
"""
LSYSTEM = "Lsystem: 1\nderivation length: {steps}\nAxiom: {axiom}\ne --> e\nendlsystem\n"

Draw = random.Random
Places = List[Tuple[Sequence[float], Sequence[float], List[float]]]


def decimal(draw: Draw, low: float, high: float, digits: int = 1) -> float:
    """A place on a decimal lattice, where single precision decides."""
    return round(draw.uniform(low, high), digits)


@unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
class PublishedPrograms(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def answered(self, program: str, specification: str, queries: Places) -> List[List[List[float]]]:
        """The parameters of every query after each step, as Espalier answers them."""
        modules = []
        for place, heading, sent in queries:
            modules.append(f"@R({','.join(map(str, heading))})@M({','.join(map(str, place))})?E({','.join(map(str, sent))})")
        (self.folder / "model.l").write_text(LSYSTEM.format(steps=STEPS, axiom="".join(modules)), encoding="utf-8")
        (self.folder / "model.e").write_text(ENVIRONMENT.format(program=program), encoding="utf-8")
        (self.folder / "model.spec").write_text(specification, encoding="utf-8")
        lines = espalier("derive", str(self.folder / "model.l"), "--compat", "cpfg", "--every", "--answered",
                         "--quiet").stdout.splitlines()
        return [[[float(number) for number in part.split(")")[0].split(",")] for part in line.split("?E(")[1:]]
                for line in lines[:STEPS]]

    def compare(self, program: str, make: Callable[[Draw], Tuple[str, Any, Places]]) -> None:
        from published_programs import F, Query
        for number in range(CASES):
            draw = random.Random(f"{program} {number}")
            specification, second, queries = make(draw)
            sent = [list(one[2]) for one in queries]
            found = self.answered(program, specification, queries)
            for step in range(STEPS):
                asked = [Query([float(F(f"{x:.4f}")) for x in place], [float(F(f"{float(F(x)):.4f}")) for x in heading],
                               [float(F(f"{F(x):g}")) for x in values])
                         for (place, heading, _), values in zip(queries, sent)]
                for values, answer in zip(sent, second.answers(asked)):
                    for k, value in answer.items():
                        values[k] = float(F(f"{value:g}"))
                for index, (expected, actual) in enumerate(zip(sent, found[step])):
                    self.assertEqual(len(expected), len(actual))
                    for a, b in zip(expected, actual):
                        self.assertLessEqual(abs(a - b), 2e-5 * max(abs(a), abs(b)) + 3e-6,
                                             f"{program} case {number}, step {step}, query {index} {queries[index]}: "
                                             f"expected {expected}, found {actual}\n{specification}")

    @staticmethod
    def tips(draw: Draw, count: int, reach: float) -> Places:
        return [([decimal(draw, -reach, reach) for _ in range(3)], (0, 1, 0),
                 [float(draw.randint(1, 3)), float(draw.randint(0, 1))][:draw.randint(1, 2)]) for _ in range(count)]

    def test_honda81(self) -> None:
        from published_programs import Honda81

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            radius, space = decimal(draw, 0.1, 0.9), draw.random() < 0.5
            text = f"radius: {radius}m\n" + ("3d case: on\n" if space else "3d case: yes\n")
            return text, Honda81(radius, space), self.tips(draw, 40, 2)
        self.compare("honda81", make)

    def test_ecosystem(self) -> None:
        from published_programs import Ecosystem

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            vigor, space = draw.random() < 0.5, draw.random() < 0.5
            text = ("vigor: on\n" if vigor else "") + ("3d case: yes\n" if space else "")
            places = [(place, heading, [decimal(draw, 0.1, 0.6), *sent[1:]])
                      for place, heading, sent in self.tips(draw, 40, 2)]
            return text, Ecosystem(vigor, space), places
        self.compare("ecosystem", make)

    def raster(self, draw: Draw) -> Tuple[str, Any]:
        from published_programs import Raster
        cells = [draw.randint(2, 23), draw.randint(2, 23)]
        size, corner = [decimal(draw, 1, 9), decimal(draw, 1, 9)], [decimal(draw, -4, 1), decimal(draw, -4, 1)]
        up = draw.random() < 0.5
        pixels: List[List[Tuple[int, int]]] = []
        text = (f"grid size: {cells[0]}x{cells[1]}\ngrid range: {size[0]}x{size[1]}\n"
                f"grid position: {corner[0]} {corner[1]}\n" + ("" if up else "z is up: no\n"))
        if draw.random() < 0.5:
            width, height = draw.randint(1, 9), draw.randint(1, 9)
            pixels = [[(draw.randint(0, 255), draw.randint(0, 255)) for _ in range(width)] for _ in range(height)]
            rows = " ".join(f"{red} {green} 0" for row in pixels for green, red in row)
            (self.folder / "light.pnm").write_text(f"P3 {width} {height} 255\n{rows}\n", encoding="ascii")
            text += "input image: light.pnm\n"
        return text, Raster(cells, size, corner, pixels, up)

    def test_clover(self) -> None:
        from published_programs import Clover

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            text, raster = self.raster(draw)
            t = draw.choice([0, 0.3, 0.85])
            places: Places = [([decimal(draw, -5, 9) for _ in range(3)], (0, 1, 0),
                               draw.choice([[0.0, 0.0], [1.0, decimal(draw, 0, 9)], [2.0, decimal(draw, 0, 3)], [7.0]]))
                              for _ in range(60)]
            return f"{text}transmittance: {t}\n", Clover(raster, t), places
        self.compare("clover", make)

    def test_ornament(self) -> None:
        from published_programs import Ornament

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            text, raster = self.raster(draw)
            places: Places = [([decimal(draw, -5, 9) for _ in range(3)], (0, 1, 0),
                               [0.0, decimal(draw, 0, 0.9), 0.0][:draw.choice([1, 2, 2, 2, 3])]) for _ in range(60)]
            return text, Ornament(raster), places
        self.compare("ornament", make)

    def test_chiba(self) -> None:
        from published_programs import Chiba

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            values: Dict[str, Any] = {"transmittance": draw.choice([0.2, 0.6]), "radius": decimal(draw, 0.2, 2),
                                      "area": draw.random() < 0.4, "beam": draw.choice([0, 0, 0.5])}
            cells = [draw.randint(1, 9) for _ in range(draw.choice([0, 2, 3]))]
            text = (f"transmittance: {values['transmittance']}\nradius: {values['radius']}\n"
                    f"beam radius: {values['beam']}\n" + ("estimate intersection area: on\n" if values["area"] else "")
                    + (f"grid size: {' '.join(map(str, cells))}\n" if cells else ""))
            sources: List[List[float]] = []
            if draw.random() < 0.6:
                sources = [[decimal(draw, -1, 1, 2), decimal(draw, 0.1, 1, 2), decimal(draw, -1, 1, 2), draw.randint(1, 4)]
                           for _ in range(draw.randint(1, 4))]
                text += "".join(f"source direction: {' '.join(map(str, s))}\n" for s in sources) + "source direction: 1 2\n"
            else:
                values.update(samples=draw.choice([8, 30]), ratio=draw.choice([0, 0.5]), overcast=draw.random() < 0.4)
                text += (f"number of samples: {values['samples']}\nlower to upper ratio: {values['ratio']}\n"
                         + ("use CIE formula: yes\n" if values["overcast"] else ""))
            aside = decimal(draw, -20, 20)
            places: Places = [([aside + decimal(draw, 0, 6), decimal(draw, 0, 6), decimal(draw, -3, 3)], (0, 1, 0),
                               [draw.choice([0.0, 0.3, 0.7, 1.1]), 0.0, 0.0, 0.0, 9.0][:draw.choice([1, 1, 2, 3, 4, 5])])
                              for _ in range(14)]
            return text, Chiba([*cells, 1, 1, 1][:3], sources, **values), places
        self.compare("chiba", make)

    def test_takenaka(self) -> None:
        from published_programs import Takenaka

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            values = {"s": decimal(draw, 1, 2), "transmittance": decimal(draw, 0, 0.9), "beam": draw.choice([0, 0.5])}
            cells = [draw.randint(1, 9) for _ in range(3)]
            text = (f"parameter s: {values['s']}\ntransmittance: {values['transmittance']}\n"
                    f"beam radius: {values['beam']}\ngrid size: {cells[0]}x{cells[1]}x{cells[2]}\n")
            sources: List[List[float]] = []
            disk = [decimal(draw, 1, 5), 0, decimal(draw, 1, 6), 0] if draw.random() < 0.4 else None
            if disk:
                text += f"disk source: {' '.join(map(str, disk))}\n"
            elif draw.random() < 0.6:
                sources = [[draw.randint(-90, 90), draw.randint(20, 90), draw.randint(-90, 90), draw.randint(1, 3)]
                           for _ in range(draw.randint(1, 3))]
                text += "".join(f"source: {' '.join(map(str, s))}\n" for s in sources)
            places: Places = [([decimal(draw, -6, 6), decimal(draw, 0, 6), decimal(draw, -3, 3)], (0, 1, 0),
                               [decimal(draw, 0.2, 6), 0.0, 5.0][:draw.choice([1, 2, 2, 3])]) for _ in range(20)]
            return text, Takenaka(cells, sources, disk, **values), places
        self.compare("takenaka", make)

    def test_soil(self) -> None:
        from published_programs import Soil

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            nx, ny, nz = draw.randint(1, 5), draw.randint(1, 4), draw.choice([1, 1, 3])
            box, corner = [decimal(draw, 1, 6) for _ in range(3)], [decimal(draw, -3, 0) for _ in range(3)]
            values = [[[decimal(draw, -0.2, 2.3) for _ in range(nx)] for _ in range(ny)] for _ in range(nz)]
            more: Dict[str, Any] = {"kinds": draw.random() < 0.5, "depletes": draw.random() < 0.7,
                                    "omega": draw.choice([0.3, 0.5, 1, 1.3])}
            text = (f"domain size: {' '.join(map(str, box))}\nposition: {' '.join(map(str, corner))}\n"
                    f"relaxation factor: {more['omega']}\n" + ("" if more["depletes"] else "depletion: off\n")
                    + ("obstacles and sources: on\n" if more["kinds"] else "") + f"array: {nx} {ny} {nz} 0 2\n")
            text += "".join(" ".join(map(str, row)) + "\n" for part in values for row in reversed(part))
            if draw.random() < 0.7:
                more["sweeps"] = draw.choice([-1, 0, 1, 2, 4])
                more["tolerance"] = 0.05
                text += f"diffusion: {more['sweeps']} 0.05\n"
            if draw.random() < 0.6:
                more["layers"] = [decimal(draw, 0.2, 2) for _ in range(draw.randint(1, 3))]
                more["angles"] = [draw.randint(-60, 60) for _ in range(draw.randint(0, 3))]
                text += (f"layer thicknesses: {'+'.join(map(str, more['layers']))}\n"
                         f"geotropic angles: {' '.join(map(str, more['angles']))}\n")
            places: Places = []
            for _ in range(25):
                heading = draw.choice([(1, 0, 0), (0, -1, 0), (0.6, -0.8, 0), (0, 0.6, -0.8)])
                place = [corner[c] + decimal(draw, -0.3, box[c] + 0.3, 2) for c in range(3)]
                places.append((place, heading, [decimal(draw, 0, 1), 0.5, 2.0, 0.0][:draw.randint(1, 4)]))
            return text, Soil(box, corner, values, (0, 2), **more), places
        self.compare("soil", make)

    def test_shadowpyramid(self) -> None:
        from published_programs import ShadowPyramid

        def make(draw: Draw) -> Tuple[str, Any, Places]:
            n, span = draw.randint(4, 13), draw.choice([3, 5, 7.5])
            more: Dict[str, Any] = {"spread": draw.choice([0.5, 1, 1.5]), "depth": draw.randint(1, 5),
                                    "c1": draw.choice([0.58, 1.4]), "c2": draw.choice([0.8, 2, 6.9]), "randomness": draw.choice([0, 0.25]),
                                    "bias": draw.choice([0, 0.5]), "radius": draw.choice([0.5, 1.6])}
            text = (f"grid size: {n}\ngrid span: {span}\nshadow spread: {more['spread']}\nshadow depth: {more['depth']}\n"
                    f"shadow weight: {more['c1']}\nshadow dissipation: {more['c2']}\nlight randomness: {more['randomness']}\n"
                    f"light vertical bias: {more['bias']}\nsample radius: {more['radius']}\n")
            places: Places = [([decimal(draw, -span - 1, span + 1, 2), decimal(draw, -1, 2 * span + 1, 2),
                                decimal(draw, -span - 1, span + 1, 2)], (0, 1, 0),
                               [float(draw.randint(0, 1)), 0.0, 0.0, 0.0, 7.0][:draw.randint(1, 5)]) for _ in range(25)]
            return text, ShadowPyramid(n, span, **more), places
        self.compare("shadowpyramid", make)


if __name__ == "__main__":
    unittest.main()
