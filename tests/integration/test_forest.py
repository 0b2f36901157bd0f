"""espalier forest: many trees of several species as one scene, as text and from text."""

import json
import math
import re
import struct
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

from support import GALLERY, program


class Forest(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def forest(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run([program(), "forest", *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=250)

    def gltf(self, name: str) -> "dict[str, list[dict[str, Any]]]":
        data = (self.folder / name).read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        read: "dict[str, list[dict[str, Any]]]" = json.loads(data[20:20 + length])
        return read

    def test_a_few_grown_trees_are_a_forest_with_shared_meshes(self) -> None:
        made = self.forest("--number", "60", "--distinct", "9", "--seed", "3", "-o", "a.glb", "-o", "a.png", "--size",
                           "200x150")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertIn("60 trees, 9 of them distinct", made.stderr)
        scene = self.gltf("a.glb")
        self.assertGreaterEqual(len(scene["nodes"]), 61)
        self.assertLess(len(scene["meshes"]), 61)
        again = self.forest("--number", "60", "--distinct", "9", "--seed", "3", "-o", "b.glb", "--threads", "1")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.folder / "a.glb").read_bytes(), (self.folder / "b.glb").read_bytes())
        self.forest("--number", "60", "--distinct", "9", "--seed", "4", "-o", "b.glb")
        self.assertNotEqual((self.folder / "a.glb").read_bytes(), (self.folder / "b.glb").read_bytes())

    def test_trees_go_through_text(self) -> None:
        made = self.forest("--number", "12", "--distinct", "12", "--trees", "trees")
        self.assertEqual(made.returncode, 0, made.stderr)
        files = sorted((self.folder / "trees").glob("*.txt"))
        self.assertEqual(len(files), 12)
        for file in files:
            lines = file.read_text().splitlines()
            self.assertEqual(len(lines) % 2, 0)
            self.assertTrue(all(re.fullmatch(r"\S+ \S+ \S+ \d+ \d+", line) for line in lines))
            self.assertIn(" 0 ", " ".join(line.split()[3] + " " for line in lines))
        shown = self.forest("--from", "trees", "--show", "5", "--seed", "1", "-o", "one.png", "--size", "120x90")
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertIn("5 trees, 5 of them distinct", shown.stderr)
        other = self.forest("--from", "trees", "--show", "5", "--seed", "2", "-o", "two.png", "--size", "120x90")
        self.assertEqual(other.returncode, 0, other.stderr)
        self.assertNotEqual((self.folder / "one.png").read_bytes(), (self.folder / "two.png").read_bytes())
        turned = self.forest("--from", "trees", "--show", "4", "--turntable", "3", "-o", "turn.png", "--size", "80x60")
        self.assertEqual(turned.returncode, 0, turned.stderr)
        frames = [(self.folder / f"turn-000{i}.png").read_bytes() for i in range(3)]
        self.assertEqual(len(set(frames)), 3)

    def trees(self, *arguments: str) -> "list[list[list[float]]]":
        made = self.forest("--number", "21", "--distinct", "21", "--trees", "t", "--quiet", *arguments)
        self.assertEqual(made.returncode, 0, made.stderr)
        return [[[float(word) for word in line.split()] for line in file.read_text().splitlines()]
                for file in sorted((self.folder / "t").iterdir())]

    def test_the_turn_at_each_branch_makes_trees_of_space(self) -> None:
        for arguments, is_flat in (((), False), (("--flat",), True), (("--turn", "0"), True), (("--turn", "45"), False)):
            with self.subTest(arguments):
                for tree in self.trees(*arguments):
                    depth = max(abs(point[2]) for point in tree)
                    self.assertEqual(depth < 1e-9, is_flat, depth)
        # 30 degrees are what the species say
        self.assertEqual(self.trees("--turn", "30"), self.trees())
        self.assertNotEqual(self.trees("--turn", "45"), self.trees())

    def test_the_number_of_generations_is_drawn_for_each_tree(self) -> None:
        species = str(GALLERY / "chapter-forest" / "species.txt")
        for name, sizes in (("0", {5 ** 4, 5 ** 5}), ("6", {3 ** 5, 3 ** 6})):
            lines = {len(tree) // 2 for tree in self.trees("--model", f"{species}:{name}")}
            self.assertEqual(lines, sizes)

    def test_a_forest_of_a_thousand_is_a_small_file_soon(self) -> None:
        begin = time.monotonic()
        made = self.forest("--number", "1000", "--seed", "7", "-o", "a.glb", "-o", "a.png")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertIn("1000 trees, 200 of them distinct", made.stderr)
        # about two seconds; busy machines have more time
        self.assertLess(time.monotonic() - begin, 60.0)
        self.assertLess((self.folder / "a.glb").stat().st_size, 60_000_000)
        self.assertEqual(len(self.gltf("a.glb")["meshes"]), 201)

    def test_own_models_have_their_shares(self) -> None:
        (self.folder / "a.l").write_text("Lsystem: 1\nderivation length: 1\nAxiom: F(1)\nA --> A\nendlsystem\n")
        (self.folder / "b.l").write_text("Lsystem: 1\nderivation length: 1\nAxiom: F(1)F(1)\nA --> A\nendlsystem\n")
        made = self.forest("--model", "a.l=3", "--model", "b.l", "--number", "400", "--distinct", "400", "--spacing",
                           "poisson", "--distance", "2", "--trees", "trees", "--quiet")
        self.assertEqual(made.returncode, 0, made.stderr)
        points = [len(file.read_text().splitlines()) for file in (self.folder / "trees").iterdir()]
        # 400 draws of probability 3/4: 300, standard deviation 8.7; four of them
        self.assertAlmostEqual(points.count(2), 300, delta=35)
        self.assertEqual(points.count(2) + points.count(4), 400)

    def test_roots_stand_apart_in_every_spacing(self) -> None:
        (self.folder / "a.l").write_text("Lsystem: 1\nderivation length: 1\nAxiom: F[+F]F\nA --> A\nendlsystem\n")
        nearest = {}
        for spacing in ("grid", "jittered", "poisson", "competition"):
            made = self.forest("--model", "a.l", "--number", "60", "--distinct", "2", "--spacing", spacing, "--distance",
                               "2", "--seed", "5", "-o", "a.glb", "--no-ground")
            self.assertEqual(made.returncode, 0, made.stderr)
            nodes = [node for node in self.gltf("a.glb")["nodes"] if "translation" in node or "mesh" in node]
            self.assertEqual(len(nodes), 60, spacing)
            places = [node.get("translation", [0.0, 0.0, 0.0]) for node in nodes]
            nearest[spacing] = min(math.dist(p, q) for i, p in enumerate(places) for q in places[:i])
            # far ones are first
            depths = [place[2] for place in places]
            self.assertEqual(depths, sorted(depths))
            sizes = {node.get("scale", [1.0])[0] for node in nodes}
            self.assertEqual(len(sizes) > 1, spacing == "competition")
        self.assertAlmostEqual(nearest["grid"], 2.0, places=5)
        self.assertGreater(nearest["poisson"], 2.0 - 1e-5)
        # a fifth of a cell stays between roots that were moved off the grid
        self.assertGreater(nearest["jittered"], 0.4 - 1e-5)
        self.assertGreater(nearest["competition"], 0.01)

    def test_what_cannot_be_is_said(self) -> None:
        (self.folder / "a.l").write_text("Lsystem: 1\nderivation length: 1\nAxiom: F\nA --> A\nendlsystem\n")
        (self.folder / "bad").mkdir()
        (self.folder / "bad" / "x.txt").write_text("0 0 0 1\n")
        cases = {
            ("--model", "a.l=0", "-o", "a.png"): "the sum of the shares of the species is zero",
            ("--model", "a.l=-1", "-o", "a.png"): "the share of a species is a number of at least 0",
            ("--model", "a.l", "--distance", "0", "-o", "a.png"):
                "--distance: '0' is not possible: give a distance in the models' unit, above 0",
            ("--from", "nothing", "-o", "a.png"): "the folder 'nothing' holds no trees (*.txt)",
            ("--from", "bad", "-o", "a.png"): "x.txt: line 1: a point is five numbers",
            ("-o", "a.svg"): "'a.svg' cannot hold several plants side by side",
            ("--number", "3"): "-o FILE or --trees FOLDER",
        }
        for arguments, message in cases.items():
            made = self.forest(*arguments)
            self.assertNotEqual(made.returncode, 0, arguments)
            self.assertIn(message, made.stderr)


if __name__ == "__main__":
    unittest.main()
