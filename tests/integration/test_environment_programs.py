"""Every built-in process as a program of its own, on standard input and output and over TCP: bit by bit the plant of the
process inside, from a model whose tips take every answer into their parameters."""

import json
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List

from support import Process, espalier, program, stdio

# Tips fork and move on; each answer goes into the place of the next tip, so that one different bit changes the plant.
MODEL = """Lsystem: 1
derivation length: 7
Axiom: A?E({first}{rest})
A > ?E({names}) --> f(0.3+(v0-floor(v0))*0.1)F(0.4)[+(31+(v1-floor(v1)))A?E({again})L(0.2)]/(94)&(12)A?E({again})L(0.2)
homomorphism
L(s) --> {{.f(s)-(90)f(s)}}
endlsystem
"""

Case = Dict[str, Any]

# configuration, number of parameters, and what a query sends first unless that is 1
CASES: Dict[str, List[Case]] = {
    "arvo": [{"of": {"spheres": [[0, -1, 0, 1]], "planes": [[0, -2, 0, 0, 1, 0]], "maxSurfaceDistance": 3}, "n": 7}],
    "attractors": [{"of": {"points": [[1, 2, 3, 4], [-1, 5, 0, -2]]}, "n": 4}],
    "chiba": [{"of": {"radius": 0.3, "sampleCount": 8}, "n": 4}, {"of": {"radius": 0.3, "compatible": True}, "n": 4}],
    "clover": [{"of": {"gridSize": [64, 64], "range": [10, 10], "position": [-5, -5],
                       "lightMap": [[0, 200], [100, 30]]}, "n": 2, "first": "0"}],
    "colonization": [{"of": {"markerCount": 3000, "markerBox": [-3, 0, -3, 3, 5, 3], "occupancyRadius": 0.3}, "n": 5}],
    "constant": [{"of": {"values": [0.25, 0.75]}, "n": 2}],
    "crowding": [{"of": {"samples": 30}, "n": 3}],
    "density": [{"of": {}, "n": 3}, {"of": {"onePointValue": True, "returnVector": True}, "n": 3}],
    "density3d": [{"of": {"range": [9, 9, 9], "position": [-4, -1, -4], "gridSize": [9, 9, 9]}, "n": 2}],
    "ecosystem": [{"of": {"threeDimensional": True}, "n": 2}],
    "emission": [{"of": {"gridSize": [9, 9, 9], "position": [-4, -1, -4], "diffusivity": 0.2}, "n": 4}],
    "gravity": [{"of": {"direction": [0.3, -1, 0.2]}, "n": 3}],
    "height": [{"of": {}, "n": 2}],
    "honda": [{"of": {"radius": 0.3, "threeDimensional": True}, "n": 2}],
    "light": [{"of": {"directions": 32, "sun": "direction", "sunDirection": [1, 2, 0]}, "n": 4}],
    "light-voxels": [{"of": {"gridSize": [9, 9, 9], "position": [-4, -1, -4], "voxelSize": 1}, "n": 5}],
    "meadow": [{"of": {"gridSize": [64, 64], "range": [10, 10], "position": [-5, -5],
                       "lightMap": [[0, 200], [100, 30]]}, "n": 6}],
    "multiple": [{"of": {"fields": [{"type": "density3d", "range": [9, 9, 9]}, {"type": "height"}]}, "n": 3}],
    "obstacles": [{"of": {"spheres": [[1, 3, 0, 1]], "plants": "remembered"}, "n": 9}],
    "ornament": [{"of": {"gridSize": [64, 64], "range": [10, 10], "position": [-5, -5]}, "n": 2}],
    "shadow": [{"of": {"gridSize": 41, "gridSpan": 5}, "n": 4}],
    "soil": [{"of": {"domainSize": [9, 9, 9], "position": [-4, -1, -4], "gridSize": [9, 9, 9], "depletion": True,
                     "diffusionSteps": 3}, "n": 7}],
    "soil-water": [{"of": {"gridSize": [3, 9, 3], "cellSize": [2, 0.5, 2], "position": [-3, -1, -3]}, "n": 7}],
    "takenaka": [{"of": {"sources": [[0, 100, 0, 1], [50, 80, 3, 0.5]]}, "n": 2}],
    "wind": [{"of": {"profile": "power"}, "n": 3}],
}


class Programs(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def model(self, count: int, first: str = "1") -> str:
        zeros = ",0.4" * (count - 1)
        names = ",".join(f"v{k}" for k in range(count))
        path = self.folder / f"model{count}.l"
        text = MODEL.format(first=first, rest=zeros, names=names, again=first + zeros)
        path.write_text(text if count > 1 else text.replace("v1", "v0"), encoding="utf-8")
        return str(path)

    def test_every_process_is_here(self) -> None:
        names = [line.split()[0] for line in espalier("environment", "--list").stdout.splitlines()]
        self.assertEqual(sorted(names), sorted(CASES))

    def test_a_program_of_its_own_grows_the_same_plant_bit_by_bit(self) -> None:
        for name, cases in CASES.items():
            for number, case in enumerate(cases):
                with self.subTest(name, case=number):
                    inside = self.folder / f"{name}{number}.json"
                    inside.write_text(json.dumps({"type": name, **case["of"]}), encoding="utf-8")
                    model = self.model(case["n"], case.get("first", "1"))
                    expected = espalier("derive", model, "--every", "--quiet", "--environment", str(inside)).stdout
                    self.assertGreater(len(expected), 5000)
                    command = [program(), "environment", name, "--configuration", str(inside)]
                    spawned = espalier("derive", model, "--every", "--quiet", "--environment",
                                       stdio([*command, "--stdio"])).stdout
                    self.assertTrue(spawned == expected, f"{name} on standard input and output grows another plant")
                    served = Process([*command, "--listen", "127.0.0.1:0"])
                    self.addCleanup(served.stop)
                    dialled = espalier("derive", model, "--every", "--quiet", "--environment",
                                       f"tcp://{served.address}").stdout
                    self.assertTrue(dialled == expected, f"{name} over TCP grows another plant")

    def test_the_environment_has_a_say_in_it(self) -> None:
        """Otherwise the comparison above would prove nothing."""
        silent = self.folder / "silent.json"
        silent.write_text('{"type":"constant","values":[]}', encoding="utf-8")
        for name, cases in CASES.items():
            with self.subTest(name):
                inside = self.folder / f"{name}.json"
                inside.write_text(json.dumps({"type": name, **cases[0]["of"]}), encoding="utf-8")
                model = self.model(cases[0]["n"], cases[0].get("first", "1"))
                grown = [espalier("derive", model, "--quiet", "--environment", str(file)).stdout
                         for file in (inside, silent)]
                self.assertNotEqual(*grown)


if __name__ == "__main__":
    unittest.main()
