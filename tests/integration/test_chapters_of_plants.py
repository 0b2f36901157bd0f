"""The chapters of the gallery whose plants are random or in space, Fractint, and what becomes of models elsewhere."""

import math
import re
import tempfile
import unittest
from pathlib import Path
from typing import List

from chapters import chapter, derived, lines_of, rewritten, rows_of, vector
from support import GALLERY, espalier


class TurtlePainter(unittest.TestCase):
    def test_the_first_example(self) -> None:
        self.assertEqual(derived("turtle-painter/words.txt"), ["A", "B", "AB", "BAB", "ABBAB", "BABABBAB"])

    def test_the_dragon_of_heighway_starts_along_x(self) -> None:
        self.assertEqual(derived("turtle-painter/dragon.txt", "--steps", "3"),
                         rewritten("FX", {"X": "X+YF+", "Y": "-FX-Y"}, 3))
        (line,) = lines_of("turtle-painter/dragon.txt", "--steps", "2")
        self.assertGreater(line[1][0], line[0][0])
        self.assertAlmostEqual(line[1][1], line[0][1], places=2)

    def test_the_bracketed_and_the_spatial_example(self) -> None:
        self.assertEqual(derived("turtle-painter/plant.txt"), rewritten("F", {"F": "FF[-F+F+F][+F-F-F]"}, 4))
        leafy = "F//[/////-p][-Fp]F//[/////-p][-Fp][F]"
        self.assertEqual(derived("turtle-painter/leafy.txt", "--steps", "2"), rewritten("F", {"F": leafy}, 2))

    def test_the_production_with_a_condition(self) -> None:
        # A(6) gives D(3,4); the text prints D(3,5)
        self.assertEqual(derived("turtle-painter/parametric.txt")[1], "B(7)CD(3,4)A(5)")

    def test_a_production_needs_as_many_parameters_as_its_predecessor(self) -> None:
        # the text says its successor: B(t + 1)CD(t * 0.5, t - 2) has three
        with tempfile.TemporaryDirectory() as folder:
            text = (GALLERY / "chapter-turtle-painter" / "parametric.txt").read_text(encoding="utf-8")
            Path(folder, "m.txt").write_text(text.replace("A(6)A(5)", "A(6)A(6,7,8)A"), encoding="utf-8")
            self.assertEqual(espalier("derive", f"{folder}/m.txt", "--quiet").stdout.strip(), "B(7)CD(3,4)A(6,7,8)A")

    def test_time_and_random_numbers(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            model = Path(folder, "m.txt")
            model.write_text("// Turtle Painter\nω = A(7)B\nn = 3\nA(t) → A(t)\nB : t >= 2 → C(t)\nC(x) → C(x)\n",
                             encoding="utf-8")
            lines = espalier("derive", str(model), "--every", "--quiet").stdout.splitlines()
            self.assertEqual([line.split("\t")[1] for line in lines], ["A(7)B", "A(7)B", "A(7)C(2)", "A(7)C(2)"])
            model.write_text("// Turtle Painter\nω = " + 400 * "A" + "\nA : 30 > % → B\nA → +(10,20)\n", encoding="utf-8")
            text = espalier("derive", str(model), "--quiet", "--seed", "3").stdout
            # 30 % of 400, four standard deviations
            self.assertLess(abs(text.count("B") - 120), 4 * math.sqrt(400 * 0.3 * 0.7))
            angles = [float(angle) for angle in re.findall(r"\+\(([^)]+)\)", text)]
            self.assertTrue(angles and all(10 <= angle < 20 for angle in angles))

    def test_the_apple_tree_has_its_phases_and_leonardos_thickness(self) -> None:
        steps = derived("turtle-painter/apple-tree.txt", "--seed", "4")
        organs = [{symbol for symbol in "po" if symbol in text} for text in steps]
        # the structure, then thinner branches with leaves, at last fruits
        self.assertEqual(organs, 6 * [set()] + 2 * [{"p"}] + [{"p", "o"}])
        # the two branches of a stem have together its section, up to the digits of 0.707
        below: List[float] = []
        forks: List[List[float]] = []
        for token in re.findall(r"\[|\]|F\([^)]*\)", steps[5]):
            if token == "[":
                below.append(below[-1])
                forks.append([below[-2]])
            elif token == "]":
                thickness = below.pop()
                forks[-1].append(thickness)
            else:
                thickness = float(token[2:-1].split(",")[1])
                if below:
                    self.assertAlmostEqual(2 * thickness**2, below[-1] ** 2, delta=0.002 * below[-1] ** 2)
                    below[-1] = thickness
                else:
                    below.append(thickness)
        self.assertEqual(len(forks), 2 + 4 + 8 + 16 + 32)

    def test_quadrants_stay_balanced(self) -> None:
        last = derived("turtle-painter/balanced.txt", "--seed", "2")[-1]
        apices = [[float(number) for number in text.split(",")] for text in re.findall(r"A\(([^)]+)\)", last)]
        self.assertGreater(len(apices), 20)
        for _, _, left, right, upper, lower in apices:
            # what one quadrant loses the opposite one gains
            self.assertEqual((left + right, upper + lower), (100, 100))
            # a quadrant starts at 50 and loses 30 only while it is above 0
            self.assertLessEqual({left, right, upper, lower}, {-10, 20, 50, 80, 110})

    def test_branches_of_opposite_quadrants_are_in_balance(self) -> None:
        for seed in range(1, 21):
            text = derived("turtle-painter/balanced.txt", "--seed", str(seed))[-1]
            # of each axis the branches in the quadrants 0 to 90, 90 to 180, ... degrees about it
            axes = [[0, 0, 0, 0]]
            for bracket, angle in re.findall(r"(\[|\])(?:/\(([^)]+)\))?", text):
                if bracket == "]":
                    counts = axes.pop()
                    self.assertLessEqual(abs(counts[0] - counts[2]), 2)
                    self.assertLessEqual(abs(counts[1] - counts[3]), 2)
                else:
                    axes[-1][int(float(angle) // 90)] += 1
                    axes.append([0, 0, 0, 0])
            self.assertEqual(len(axes), 1)
            self.assertGreater(sum(axes[0]), 1)

    def test_other_first_values_move_the_centre_of_gravity(self) -> None:
        text = (GALLERY / "chapter-turtle-painter" / "balanced.txt").read_text(encoding="utf-8")
        sums = []
        for values in ("50,50,50,50", "20,80,50,50", "80,20,50,50"):
            with tempfile.TemporaryDirectory() as folder:
                Path(folder, "m.txt").write_text(text.replace("50,50,50,50", values).replace("n = 9", "n = 6"),
                                                 encoding="utf-8")
                espalier("run", f"{folder}/m.txt", "--quiet", "--variants", "20", "--seed", "1", "-o", f"{folder}/%d.string")
                strings = [file.read_text(encoding="utf-8") for file in Path(folder).glob("*.string")]
            self.assertEqual(len(strings), 20)
            angles = [float(angle) for string in strings for angle in re.findall(r"\[/\(([^)]+)\)", string)]
            # p stands for 0 to 90 degrees, l for 180 to 270
            sums.append(sum(angle < 90 for angle in angles) / sum(180 <= angle < 270 for angle in angles))
        self.assertGreater(sums[1], 1.3 * sums[0])
        self.assertLess(sums[2], sums[0] / 1.3)

    def test_an_object_of_ones_own_is_an_obj_or_a_glb_file(self) -> None:
        def extent(model: Path) -> List[float]:
            espalier("run", str(model), "--quiet", "-o", f"{model}.obj")
            points = [[float(number) for number in line.split()[1:4]]
                      for line in Path(f"{model}.obj").read_text(encoding="utf-8").splitlines() if line.startswith("v ")]
            return [max(point[k] for point in points) - min(point[k] for point in points) for k in range(3)]

        with tempfile.TemporaryDirectory() as folder:
            leaf = Path(folder, "leaf.obj")
            leaf.write_bytes((GALLERY / "chapter-turtle-painter" / "leaf.obj").read_bytes())
            model = Path(folder, "m.txt")
            text = "// Turtle Painter\nω = {}\nn = 0\nF → F\nobject p: {}\n"
            model.write_text(text.format("p", "leaf.obj"), encoding="utf-8")
            once = extent(model)
            self.assertAlmostEqual(once[1], 1.0, places=4)
            espalier("run", str(model), "--quiet", "-o", f"{folder}/leaf.glb")
            # p(3) is three times as large, and what the file says multiplies it
            model.write_text(text.format("p(3)", "leaf.glb 0.5"), encoding="utf-8")
            for size, unit in zip(extent(model), once):
                self.assertAlmostEqual(size, 1.5 * unit, places=4)

    def test_the_constant_vector_moves_what_is_drawn(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "m.txt").write_text("// Turtle Painter\nω = FFFF\nn = 0\nvector: 0.5, -0.25, 0\n",
                                             encoding="utf-8")
            espalier("run", f"{folder}/m.txt", "--quiet", "-o", f"{folder}/a.csv")
            rows = Path(folder, "a.csv").read_text(encoding="utf-8").splitlines()
        header = rows[0].split(",")
        end = dict(zip(header, rows[-1].split(",")))
        self.assertAlmostEqual(float(end["x"]), 2.0)
        self.assertAlmostEqual(float(end["y"]), 3.0)


class Forest(unittest.TestCase):
    def test_the_strings_of_the_table_of_species_6(self) -> None:
        rules = ["F[+F]F", "F[-F]F"]
        found = set()
        for seed in range(60):
            steps = derived("forest/species.txt:6", "--steps", "3", "--seed", str(seed))
            drawn = []
            for before, after in zip(steps, steps[1:]):
                fitting = [k for k, rule in enumerate(rules) if before.replace("F", rule) == after]
                # one rule is drawn for the whole string
                self.assertEqual(len(fitting), 1)
                drawn.append(fitting[0])
            found.add(tuple(drawn))
            if drawn == [0, 1, 0]:
                # the third string of the table lacks its last `]F`
                self.assertEqual(steps[1:3], ["F[+F]F", "F[-F]F[+F[-F]F]F[-F]F"])
                self.assertEqual(
                    steps[3],
                    "F[+F]F[-F[+F]F]F[+F]F[+F[+F]F[-F[+F]F]F[+F]F]F[+F]F[-F[+F]F]F[+F]F")
        self.assertEqual(len(found), 8)

    def test_species_that_begin_with_x_grow(self) -> None:
        for species in ("3", "4", "5"):
            steps = derived(f"forest/species.txt:{species}", "--seed", "1")
            self.assertEqual(steps[0], "X")
            self.assertGreater(len(steps[-1]), 100)

    def test_rules_can_be_drawn_by_module(self) -> None:
        text = (GALLERY / "chapter-forest" / "species.txt").read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "s.txt").write_text(text.replace("Sorteio: geração", "Sorteio: módulo"), encoding="utf-8")
            last = espalier("derive", f"{folder}/s.txt:6", "--quiet", "--steps", "4", "--seed", "1").stdout
        self.assertIn("F[+F]F", last)
        self.assertIn("F[-F]F", last)

    def test_plus_turns_with_the_clock(self) -> None:
        for seed in ("1", "2"):
            steps = derived("forest/species.txt:6", "--steps", "1", "--seed", seed)
            lines = lines_of("forest/species.txt:6", "--steps", "1", "--seed", seed)
            xs = [x for line in lines for x, _ in line]
            trunk = max((line for line in lines), key=lambda line: line[-1][1])[0][0]
            aside = max(xs, key=lambda x: abs(x - trunk)) - trunk
            self.assertEqual(aside > 0, "+" in steps[1])


class Fractint(unittest.TestCase):
    def test_strings_are_in_capitals_and_case_does_not_count(self) -> None:
        self.assertEqual(derived("fractint/curves.l:koch6"), rewritten("F--F--F", {"F": "F+F--F+F"}, 2))
        self.assertEqual(derived("fractint/curves.l:DRAGON", "--steps", "3"),
                         rewritten("FX", {"F": "", "Y": "+FX--FY+", "X": "-FX++FY-"}, 3))

    def test_the_plant_grows_upwards(self) -> None:
        points = [point for line in lines_of("fractint/curves.l:Weed") for point in line]
        self.assertGreater(max(y for _, y in points) - min(y for _, y in points),
                           max(x for x, _ in points) - min(x for x, _ in points))

    def test_d_has_a_heading_of_its_own(self) -> None:
        # a ring of 24 sides that + turns, and rays that \\ turns, straight away from its centre
        rows = rows_of(chapter("fractint/curves.l:Sun"), "--steps", "24")
        ring = [vector(row, "x y") for row in rows if row["symbol"] == "F"]
        self.assertEqual(len(ring), 24)
        self.assertLess(math.dist(ring[-1], (0.0, 0.0)), 1e-9)
        centre = (sum(x for x, _ in ring) / 24, sum(y for _, y in ring) / 24)
        tips = [vector(row, "x y") for row, after in zip(rows, rows[1:]) if row["symbol"] == "D" and after["symbol"] == "]"]
        self.assertEqual(len(tips), 24)
        for foot, tip in zip(ring, tips):
            self.assertAlmostEqual(math.dist(tip, centre) - math.dist(foot, centre), 2.0)

    def test_two_headings_cannot_be_converted(self) -> None:
        done = espalier("convert", chapter("fractint/curves.l:Sun"), "--to", "cpfg", status=1)
        self.assertIn("which has no second heading, which D and M have beside that of F and G", done.stderr)


class Conversion(unittest.TestCase):
    def test_a_converted_model_draws_the_same(self) -> None:
        for model in ("lsystem-viewer/koch-island.lsv", "fractint/curves.l:Weed", "open-l-systems/bush.txt"):
            with tempfile.TemporaryDirectory() as folder:
                text = espalier("convert", chapter(model), "--to", "cpfg", "--quiet").stdout
                self.assertTrue(text.startswith("Lsystem: 1\n"))
                Path(folder, "m.l").write_text(text, encoding="utf-8")
                # no turn is written that the model does not have: its production would never match
                self.assertNotRegex(espalier("check", f"{folder}/m.l").stderr, r"'[-+&^/\\]' never matches")
                espalier("run", f"{folder}/m.l", "--quiet", "-o", f"{folder}/a.obj")
                espalier("run", chapter(model), "--quiet", "-o", f"{folder}/b.obj")
                points = [sorted(tuple(round(float(number), 6) for number in line.split()[1:4])
                                 for line in Path(folder, name).read_text(encoding="utf-8").splitlines()
                                 if line.startswith("v ")) for name in ("a.obj", "b.obj")]
            self.assertTrue(points[0])
            self.assertEqual(len(points[0]), len(points[1]))
            self.assertLess(max(math.dist(p, q) for p, q in zip(*points)), 1e-3)

    def test_a_converted_model_derives_the_same_string(self) -> None:
        models = ["lsystem-viewer/koch-curve.lsv", "lsystem-viewer/plant-4.lsv", "fractint/curves.l:Dragon",
                  "graphical-models/koch-island.txt", "graphical-models/tree-2.txt", "graphical-models/stochastic.txt",
                  "turtle-painter/plant.txt", "turtle-painter/parametric.txt", "turtle-painter/balanced.txt",
                  "open-l-systems/algae.txt", "open-l-systems/flower.txt", "open-l-systems/context.txt",
                  "open-l-systems/stochastic-parametric.txt", "forest/species.txt:5", "forest/species.txt:6"]
        for model in models:
            with self.subTest(model), tempfile.TemporaryDirectory() as folder:
                text = espalier("convert", chapter(model), "--to", "cpfg", "--quiet").stdout
                Path(folder, "m.l").write_text(text, encoding="utf-8")
                converted = espalier("derive", f"{folder}/m.l", "--quiet", "--seed", "5").stdout.strip()
                original = espalier("derive", chapter(model), "--quiet", "--seed", "5").stdout.strip()
                # the start of the turtle stands before the axiom
                self.assertTrue(converted.endswith(original), converted[:200] + "\n" + original[:200])
                self.assertLess(len(converted) - len(original), 40)

    def test_what_cpfg_cannot_say_is_explained(self) -> None:
        done = espalier("convert", chapter("graphical-models/context.txt"), "--to", "cpfg", status=1)
        self.assertIn("cannot be written for cpfg, which has no symbols of more than one character: F_a, F_b", done.stderr)
        self.assertEqual(done.stdout, "")


    def test_only_cpfg_models_are_formatted(self) -> None:
        done = espalier("format", chapter("lsystem-viewer/koch-curve.lsv"), status=1)
        self.assertIn("is written as L-System Viewer: `espalier format` lays out cpfg models only", done.stderr)

    def test_a_run_goes_on_from_a_snapshot_of_a_foreign_model(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            model = chapter("fractint/curves.l:Weed")
            espalier("run", model, "--quiet", "--steps", "1", "-o", f"{folder}/a.snapshot")
            espalier("run", "--resume", f"{folder}/a.snapshot", "--quiet", "--steps", "2", "-o", f"{folder}/a.svg")
            espalier("run", model, "--quiet", "--steps", "2", "-o", f"{folder}/b.svg")
            self.assertEqual(Path(folder, "a.svg").read_text(encoding="utf-8"),
                             Path(folder, "b.svg").read_text(encoding="utf-8"))

    def test_the_dialect_and_the_entry_can_be_named(self) -> None:
        text = espalier("derive", chapter("fractint/curves.l:nowhere"), status=1).stderr
        self.assertIn("the file has no entry 'nowhere'", text)
        self.assertIn("Koch6, Dragon", text)
        wrong = espalier("check", chapter("open-l-systems/bush.txt"), "--dialect", "lsv", status=1).stderr
        self.assertIn("bush.txt:1:1: error: unknown command 'w'", wrong)


if __name__ == "__main__":
    unittest.main()
