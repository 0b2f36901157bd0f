"""espalier evolve: what it breeds, that it depends on the seed alone, and that it goes on where it was stopped."""

import csv
import math
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from support import GALLERY, PACKAGE, program

NUMBERS = """#define ANGLE 30
#define RATIO 0.7
Lsystem: 1
derivation length: 6
Axiom: A(1)
A(s) --> F(s)[+(ANGLE)A(s*RATIO)][-(ANGLE)A(s*RATIO)]
endlsystem
"""
WEED = """Lsystem: 1
derivation length: 4
Axiom: X
X --> F[+X]F[-X]+X
F --> FF
endlsystem
"""
CONTEXT = "Lsystem: 1\nderivation length: 2\nAxiom: AB\nA < B --> A\nendlsystem\n"


class Evolving(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "tree.l").write_text(NUMBERS)
        (self.folder / "weed.l").write_text(WEED)
        (self.folder / "context.l").write_text(CONTEXT)

    def evolve(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [program(), "evolve", *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120,
            env={**os.environ, "PYTHONPATH": str(PACKAGE)})

    def table(self, name: str) -> "list[dict[str, str]]":
        with open(self.folder / name / "generations.csv", newline="") as file:
            return list(csv.DictReader(file))

    def test_numbers_are_bred_and_the_best_plant_is_a_model(self) -> None:
        made = self.evolve("tree.l", "--gene", "ANGLE=5:85", "--gene", "RATIO=0.3:0.9", "--fitness", "height",
                           "--population", "16", "--generations", "20", "-o", "bred")
        self.assertEqual(made.returncode, 0, made.stderr)
        rows = self.table("bred")
        self.assertEqual([row["generation"] for row in rows], [str(i) for i in range(21)])
        best = [float(row["best"]) for row in rows]
        self.assertEqual(best, sorted(best))
        # a plant of these is the higher the more upright it is and the greater the ratio
        self.assertLess(float(rows[-1]["ANGLE"]), 15)
        self.assertGreater(float(rows[-1]["RATIO"]), 0.85)
        self.assertTrue((self.folder / "bred" / "best-0020.png").exists())
        again = subprocess.run([program(), "run", "bred/best.l", "-o", "best.svg"], cwd=self.folder,
                               capture_output=True, text=True)
        self.assertEqual(again.returncode, 0, again.stderr)

    def test_what_is_bred_by_default_is_a_symmetric_plant_of_its_size(self) -> None:
        # F[-F]F[+F][F] leans; its kin with as many branches on both sides are fitter
        bush = str(GALLERY / "chapter-open-l-systems" / "bush.txt")
        made = self.evolve(bush, "--productions", "--seed", "2", "--population", "24", "--generations", "12", "-o", "bred")
        self.assertEqual(made.returncode, 0, made.stderr)
        rows = self.table("bred")
        self.assertGreater(float(rows[-1]["best"]), 1.5 * float(rows[0]["best"]))
        self.assertGreater(float(rows[-1]["symmetry"]), 0.9)
        # neither a line alone nor the largest plant that there can be
        self.assertGreater(float(rows[-1]["branching"]), 0.0)
        self.assertLess(int(rows[-1]["modules"]), 20_000)
        # the angle of the slides goes on into the plants that are bred
        self.assertIn("angle increment: 25\n", (self.folder / "bred" / "best.v").read_text())
        subprocess.run([program(), "run", "bred/best.l", "--quiet", "--steps", "1", "-o", "one.csv"], cwd=self.folder, check=True)
        with open(self.folder / "one.csv", newline="") as file:
            headings = {round(math.degrees(math.atan2(float(row["hx"]), float(row["hy"])))) for row in csv.DictReader(file)}
        self.assertTrue(headings > {0} and all(degrees % 25 == 0 for degrees in headings), headings)

    def test_plants_of_a_dialect_keep_their_steps_and_colours(self) -> None:
        plant = str(GALLERY / "chapter-lsystem-viewer" / "plant-1.lsv")
        made = self.evolve(plant, "--productions", "--seed", "2", "--population", "6", "--generations", "1", "-o", "bred")
        self.assertEqual(made.returncode, 0, made.stderr)
        best = (self.folder / "bred" / "best.l").read_text()
        self.assertIn("derivation length: 4\nAxiom: F\nF --> ", best)
        self.assertTrue(best.endswith("homomorphism no warnings\nF --> F(5)\nf --> f(5)\nendlsystem\n"), best)
        subprocess.run([program(), "run", "bred/best.l", "--quiet", "-o", "best.svg"], cwd=self.folder, check=True)
        self.assertIn("#006400", (self.folder / "best.svg").read_text())

    def test_threads_change_nothing_and_a_run_goes_on_where_it_stopped(self) -> None:
        common = ["weed.l", "--productions", "--fitness", "symmetry=2,light", "--population", "10", "--seed", "3",
                  "--limit", "modules=20000"]
        for name, threads in (("one", "1"), ("two", "2")):
            made = self.evolve(*common, "--generations", "5", "--threads", threads, "-o", name)
            self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(self.evolve(*common, "--generations", "2", "-o", "parts").returncode, 0)
        self.assertEqual(self.evolve(*common, "--generations", "5", "-o", "parts", "--resume").returncode, 0)
        for file in ("generations.csv", "evolution.json", "best.l", "best-0005.png"):
            whole = (self.folder / "one" / file).read_bytes()
            self.assertEqual(whole, (self.folder / "two" / file).read_bytes(), file)
            self.assertEqual(whole, (self.folder / "parts" / file).read_bytes(), file)
        self.assertIn("X -->", (self.folder / "one" / "best.l").read_text())

    def test_a_python_function_is_a_fitness(self) -> None:
        (self.folder / "fitness.py").write_text(
            "import espalier\n\n"
            "def fitness(plant):\n"
            "    assert len(plant.segments) == 63 and plant.measures['length'] > 0\n"
            "    return -abs(plant.parameters['ANGLE'] - 40)\n\n"
            "espalier.serve_fitness(fitness)\n")
        made = self.evolve("tree.l", "--gene", "ANGLE=5:85", "--fitness", "stdio:python3 fitness.py", "--population",
                           "10", "--generations", "6", "-o", "bred")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertAlmostEqual(float(self.table("bred")[-1]["ANGLE"]), 40, delta=3)

    def test_a_fitness_that_fails_shows_its_traceback_and_the_run_can_go_on(self) -> None:
        (self.folder / "fitness.py").write_text(
            "import espalier\nespalier.serve_fitness(lambda plant: 1 / 0)\n")
        common = ["tree.l", "--gene", "ANGLE=5:85", "--fitness", "stdio:python3 fitness.py", "--population", "4",
                  "--generations", "1", "-o", "bred"]
        made = self.evolve(*common)
        self.assertEqual(made.returncode, 1)
        self.assertIn("Traceback", made.stderr)
        self.assertIn("error: generation 0: the fitness program says: ZeroDivisionError: division by zero", made.stderr)
        (self.folder / "fitness.py").write_text(
            "import sys\nsys.stdin.readline()\nprint('hello', flush=True)\nsys.stdin.read()\n")
        self.assertIn("answered 'hello', not {\"fitness\": NUMBER}", self.evolve(*common).stderr)
        (self.folder / "fitness.py").write_text("import sys; sys.exit(3)\n")
        self.assertIn("the fitness program ended with status 3 instead of answering", self.evolve(*common).stderr)

    def test_what_cannot_be_bred_is_said(self) -> None:
        cases = {
            ("tree.l", "--gene", "ANGEL=1:2"): "the model has no line '#define ANGEL NUMBER'. Did you mean 'ANGLE'?",
            ("tree.l", "--productions"): "has a predecessor with parameters",
            ("context.l", "--productions"): "context.l:4: 'A < B --> A' has a context",
            ("tree.l", "--gene", "ANGLE=9:1"): "'ANGLE=9:1' is not a gene: give NAME=LOW:HIGH with LOW < HIGH",
            ("tree.l", "--gene", "ANGLE=1:9", "--fitness", "beauty"): "there is no measure 'beauty'",
            ("tree.l",): "--gene NAME=LOW:HIGH or --productions",
            ("tree.l", "--gene", "ANGLE=1:9", "--resume"): "there is no earlier run in 'bred/evolution.json'",
            ("weed.l", "--productions", "--limit", "modules=2"): "no plant of generation 0 grew to its end",
        }
        for arguments, message in cases.items():
            made = self.evolve(*arguments, "-o", "bred", "--population", "4")
            self.assertNotEqual(made.returncode, 0, arguments)
            self.assertIn(message, made.stderr)
        common = ["tree.l", "--gene", "ANGLE=1:9", "--population", "4", "--generations", "0", "-o", "bred"]
        self.assertEqual(self.evolve(*common).returncode, 0)
        self.assertIn("continue it with --resume", self.evolve(*common).stderr)
        self.assertIn("it was made with another seed: 1, now 2",
                      self.evolve(*common, "--seed", "2", "--resume").stderr)


if __name__ == "__main__":
    unittest.main()
