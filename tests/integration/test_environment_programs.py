"""Every built-in process as a program of its own, on standard input and output and over TCP, grows bit by bit the plant of
the process inside. The tips of the model take every answer into their parameters."""

import json
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List

from support import REPOSITORY, Process, espalier, program, python, stdio

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

# the members "plants" of tests/environment/processes/NAME.json: a configuration, the number of parameters of a query, and
# the first value that a query sends unless that is 1
CASES: Dict[str, List[Case]] = {
    file.stem: json.loads(file.read_text(encoding="utf-8"))["plants"]
    for file in sorted((REPOSITORY / "tests" / "environment" / "processes").glob("*.json"))
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
                    inside.write_text(json.dumps({"type": name, **case["configuration"]}), encoding="utf-8")
                    model = self.model(case["parameters"], case.get("first", "1"))
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

    def test_what_an_environment_notes_is_a_warning_once(self) -> None:
        model = self.model(1)
        box = self.folder / "box.json"
        box.write_text('{"type":"light-voxels","position":[100,100,100],"gridSize":[4,4,4]}', encoding="utf-8")
        inside = espalier("derive", model, "--environment", str(box)).stderr
        self.assertEqual(inside.count("no query of the step lies in its box"), 1, inside)
        command = [program(), "environment", "light-voxels", "--configuration", str(box), "--stdio"]
        self.assertEqual(espalier("derive", model, "--environment", stdio(command)).stderr, inside)
        # of another's program: one line that a terminal can show
        for answers in ("def answer(self, query):\n        self.note('')\n        self.note('the well is dry')\n        return [1]",
                        "def answer(self, query):\n        self.note('the\\nwell\\x1bis dry')\n        return [1]",
                        "def step_columns(self, queries):\n        self.note('the well is dry')\n"
                        "        return [1] * queries.count"):
            script = self.folder / "well.py"
            script.write_text("from espalier import Environment\n\n\nclass Well(Environment):\n    " + answers +
                              "\n\n\nWell.serve()\n", encoding="utf-8")
            said = espalier("derive", model, "--environment", stdio(python(script))).stderr
            self.assertEqual(said.splitlines(), ["warning: the well is dry"])

    def test_the_environment_has_a_say_in_it(self) -> None:
        """Otherwise the comparison above would prove nothing."""
        silent = self.folder / "silent.json"
        silent.write_text('{"type":"constant","values":[]}', encoding="utf-8")
        for name, cases in CASES.items():
            with self.subTest(name):
                inside = self.folder / f"{name}.json"
                inside.write_text(json.dumps({"type": name, **cases[0]["configuration"]}), encoding="utf-8")
                model = self.model(cases[0]["parameters"], cases[0].get("first", "1"))
                grown = [espalier("derive", model, "--quiet", "--environment", str(file)).stdout
                         for file in (inside, silent)]
                self.assertNotEqual(*grown)


if __name__ == "__main__":
    unittest.main()
