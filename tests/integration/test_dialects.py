"""Files of other programs as people have them: strings, shapes, entries, contact sheets, and messages about wrong files."""

import csv
import math
import struct
import tempfile
import unittest
from pathlib import Path
from typing import List, Tuple

from support import GALLERY, espalier

Point = Tuple[float, float, float]
CURVES = str(GALLERY / "chapter-fractint" / "curves.l")


class Dialects(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def file(self, text: str, name: str = "model.txt") -> str:
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return str(path)

    def string(self, text: str, name: str = "model.txt", *arguments: str) -> str:
        return espalier("derive", self.file(text, name), "--quiet", *arguments).stdout.strip()

    def points(self, text: str, name: str = "model.ls") -> List[Point]:
        """Where the turtle is after each module that moves it."""
        table = self.folder / "points.csv"
        espalier("run", self.file(text, name), "-o", str(table), "--quiet", "--seed", "1")
        with table.open(encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        return [(float(row["x"]), float(row["y"]), float(row["z"])) for row in rows if row["symbol"] in "FfZz"]

    def assert_points(self, found: List[Point], expected: List[Point]) -> None:
        self.assertEqual(len(found), len(expected))
        for a, b in zip(found, expected):
            for x, y in zip(a, b):
                self.assertAlmostEqual(x, y, places=9)

    # ---- Lparser: models of known shapes; its z axis is Espalier's y axis

    def test_lparser_draws_a_square(self) -> None:
        # left turns of 90 degrees, and back at the start
        self.assert_points(self.points("# a square\n1\n90 degrees\n10\nF+F+F+F\nX=X\n@\n"),
                           [(0, 1, 0), (-1, 1, 0), (-1, 0, 0), (0, 0, 0)])

    def test_lparser_draws_a_snowflake_that_closes(self) -> None:
        text = "recursion 3\nangle 60\nthickness 5\naxiom F--F--F\nrule F = F+F--F+F\n"
        found = self.points(text)
        self.assertEqual(len(found), 3 * 4 ** 3)
        self.assert_points(found[-1:], [(0, 0, 0)])
        # each side is 3^3 steps long
        self.assertAlmostEqual(math.dist(found[63], (0, 0, 0)), 27, places=9)

    def test_lparser_turns_in_space(self) -> None:
        # up, pitched down to the back, then left
        self.assert_points(self.points("1\n90\n10\nF&F+F\nX=X\n@\n"), [(0, 1, 0), (0, 1, -1), (-1, 1, -1)])
        # rolls: a pitch behind a roll to the left goes to the left
        self.assert_points(self.points("1\n90\n10\n<F&F\nX=X\n@\n"), [(0, 1, 0), (-1, 1, 0)])
        self.assert_points(self.points("1\n90\n10\n%F+F\nX=X\n@\n"), [(0, 1, 0), (1, 1, 0)])

    def test_lparser_changes_length_and_angle(self) -> None:
        # 1, then twice as long; half steps
        self.assert_points(self.points("1\n45\n10\nF\"(2)F'(0.5)Z\nX=X\n@\n"), [(0, 1, 0), (0, 3, 0), (0, 3.5, 0)])
        # the angle of 45 degrees twice, and back behind the bracket
        half = math.sqrt(0.5)
        self.assert_points(self.points("1\n45\n10\n[;(2)+F]+F\nX=X\n@\n"), [(-1, 0, 0), (-half, half, 0)])

    def test_lparser_bends_down(self) -> None:
        # a horizontal branch: 0.2 radians below the horizon; a vertical one stays
        self.assert_points(self.points("1\n90\n10\n[tF]+tF\nX=X\n@\n"),
                           [(0, 1, 0), (-math.cos(0.2), -math.sin(0.2), 0)])

    def test_lparser_grows_a_binary_tree(self) -> None:
        text = "recursion 4\nangle 30\nthickness 10\naxiom A\nrule A = F[+A][-A]\n"
        found = self.points(text)
        self.assertEqual(len(found), 2 ** 4 - 1)
        # the tree is as wide to the left as to the right
        self.assertAlmostEqual(min(x for x, _, _ in found), -max(x for x, _, _ in found), places=9)

    # ---- L-Py: strings

    def test_lpy_strings(self) -> None:
        text = ("from math import *\nN = 2\nr = 0.5\nmodule Apex(age), Leaf\ncount = 0\n"
                "def StartEach():\n    global count\n    count += 1\n"
                "Axiom: Apex(0, 1)\nderivation length: N + 1\nproduction:\n"
                "Apex(age, l) :\n    l2 = l * r\n    if age < N:\n        nproduce F(l, 0.1)\n"
                "        for i in range(2):\n            nproduce [+(i * 180 - 90) Leaf]\n"
                "        produce Apex(age + 1, l2)\n    else:\n        produce Leaf(count)\n"
                "Leaf --> Leaf(pi // 1)\ninterpretation:\nLeaf(s) --> @O(s)\nendlsystem\n")
        self.assertEqual(espalier("derive", self.file(text, "m.lpy"), "--every", "--quiet").stdout.splitlines(), [
            "0\tApex(0,1)",
            "1\tF(1,0.1)[+(-90)Leaf][+(90)Leaf]Apex(1,0.5)",
            "2\tF(1,0.1)[+(-90)Leaf(3)][+(90)Leaf(3)]F(0.5,0.1)[+(-90)Leaf][+(90)Leaf]Apex(2,0.25)",
            "3\tF(1,0.1)[+(-90)Leaf(3)][+(90)Leaf(3)]F(0.5,0.1)[+(-90)Leaf(3)][+(90)Leaf(3)]Leaf(3)"])

    # ---- textbook words

    def test_textbook_words_give_one_string(self) -> None:
        for text in ("axiom: F\nF -> F+F--F+F\nangle: 60\nn: 2\n", "axiom = F\nF -> F+F--F+F\nangle = 60\nn = 2\n",
                     "n=2, δ=60°\nω: F\np1: F → F+F−−F+F\n", "#define maxgen 2\nSTART : F\np1: F → F+F--F+F\n",
                     "start : F\nrules : (F → F+F−−F+F)\nangle : 60°\niterations: 2\n"):
            self.assertEqual(self.string(text), "F+F--F+F+F+F--F+F--F+F--F+F+F+F--F+F", text)

    def test_texts_of_pages_and_programs_give_one_string(self) -> None:
        for text in ("* axiom: F\n* F -> F+F--F+F\n* angle: 60\n", "1. axiom: F\n2. F -> F+F--F+F\n3. angle: 60\n",
                     "axiom: F\nF => F+F--F+F\nangle: 60\n", 'axiom: "F"\n"F" -> "F+F--F+F"\nangle: 60\n',
                     "axiom: “F”\nF → “F+F--F+F”\nangle: 60\n",
                     'axiom: F\nrules:\n  F: "F+F--F+F"\nangle: 60\n', "axiom: 'F'\n'F' -> 'F+F--F+F'\nangle: 60\n",
                     "start : F {starting character string}\nrules : (F → F+F−−F+F)\nangle : 60°\n",
                     "Initial state: F\nProduction rules: F -> F+F--F+F\nTurning angle: 60\n"):
            self.assertEqual(self.string(text, "model.txt", "--steps", "2"), "F+F--F+F+F+F--F+F--F+F--F+F+F+F--F+F", text)
        # signs among modules stay
        self.assertEqual(self.string("ω: A\np1: A → [’’A]’\nδ = 60°\n", "model.txt", "--steps", "1"), "[''A]'")
        self.assertEqual(self.string("axiom: AB\nA -> AB\nB -> (eliminated at each iteration)\n", "m.txt", "--steps", "2"),
                         "AB")

    def test_alternatives_between_bars_are_a_warning(self) -> None:
        done = espalier("check", self.file("axiom: F\nF -> F[+F] | F[-F]\nangle: 60\n"))
        self.assertIn(":2:12: warning: '|' turns the turtle around here", done.stderr)

    def test_models_inside_of_programs_are_named(self) -> None:
        for text, name in (("Premise: A\nRule 1: A=F[+A][-A]\n", "this is an L-system of Houdini"),
                           ("premise A(0)\nrule1 A(h):h>3=B(h):0.5\n", "this is an L-system of Houdini"),
                           ('let axiom = "F";\nlet rules = { "F": "FF" };\n', "this is a program with an L-system in it"),
                           ('var axiom = "A";\nvar rules = [];\nrules[0] = { a: "A", b: "AB" };\n',
                            "this is a program with an L-system in it"),
                           ("axiom = 'X'\nrules = {\n    'X': 'F[X]',\n}\n", "this is a program with an L-system in it")):
            self.assertIn(f"error: {name}", espalier("derive", self.file(text), status=1).stderr, text)

    # ---- entries

    def test_check_reads_every_model_of_a_file(self) -> None:
        done = espalier("check", CURVES)
        names = [line.split(":")[-1] for line in espalier("check", CURVES, "--list").stdout.splitlines()]
        self.assertGreater(len(names), 5)
        self.assertEqual(done.stdout, f"{CURVES}: {len(names)} models, no errors\n")
        broken = self.file("A { angle 4\naxiom f\n}\nB { angle 4\naxiom f[\n}\n")
        done = espalier("check", broken, status=1)
        self.assertEqual(done.stdout, f"{broken}: 2 models, 1 with errors: B\n")
        self.assertIn(":5:8: error: the bracket '[' is never closed", done.stderr)

    def test_all_models_of_a_file_make_a_contact_sheet(self) -> None:
        sheet = self.folder / "sheet.png"
        text = "A { angle 4\naxiom f\n}\nB { angle 4\naxiom f[\n}\nC { angle 3\naxiom f+f+f\n}\n"
        done = espalier("run", self.file(text), "--all", "-o", str(sheet), "--size", "100x80", status=1)
        self.assertIn("the model 'B' failed", done.stderr)
        width, height = struct.unpack(">II", sheet.read_bytes()[16:24])
        self.assertEqual((width, height), (2 * 104 + 4, 2 * 102 + 4))
        self.assertIn("cannot hold a contact sheet",
                      espalier("run", self.file(text), "--all", "-o", str(self.folder / "a.glb"), status=2).stderr)
        self.assertIn("does not hold several models",
                      espalier("run", self.file("axiom: F\nF -> FF\n"), "--all", "-o", str(sheet), status=1).stderr)

    # ---- messages

    def test_a_macro_that_the_model_does_not_name_is_an_error(self) -> None:
        text = "#define length 2\n#ifdef TALL\n#define length 3\n#endif\nLsystem: 1\nAxiom: F(length)\nF --> F\nendlsystem\n"
        path = self.file(text, "model.l")
        espalier("derive", path, "--define", "length=4", "--define", "TALL=1")
        done = espalier("derive", path, "--define", "lenght=4", status=1)
        self.assertIn("the model does not use the macro 'lenght', so its value has no effect", done.stderr)
        self.assertIn("Did you mean 'length'? Available: length, TALL.", done.stderr)

    def test_a_picture_is_no_model(self) -> None:
        picture = str(GALLERY / "chapter-fractint" / "curves-Tree.png")
        done = espalier("check", picture, status=1)
        self.assertIn("error: this is a PNG picture, not a model", done.stderr)
        self.assertLess(len(done.stderr), 400)

    def test_messages_fit_a_terminal(self) -> None:
        line = "F --> " + "F" * 5000 + "\x1b[31m\x07" + "(" + "é" * 3000
        path = self.folder / "long.l"
        path.write_bytes(("Lsystem: 1\nAxiom: F\n" + line + "\nendlsystem\n").encode("latin-1"))
        done = espalier("check", str(path), status=1)
        for shown in done.stderr.splitlines():
            self.assertLessEqual(len(shown), 200)
            self.assertTrue(all(character.isprintable() or character == "\t" for character in shown), repr(shown))


if __name__ == "__main__":
    unittest.main()
