"""The chapters of the gallery: what the documents that the project began with print is what their models derive."""

import html
import math
import re
import tempfile
import time
import unittest
from pathlib import Path
from typing import Dict, List, Tuple

from support import GALLERY, espalier

Point = Tuple[float, float]


def chapter(name: str) -> str:
    return str(GALLERY / f"chapter-{name}")


def derived(model: str, *arguments: str) -> List[str]:
    """The strings of all steps of a chapter's model."""
    lines = espalier("derive", chapter(model), "--every", "--quiet", *arguments).stdout.splitlines()
    return [line.split("\t")[1] for line in lines]


def rewritten(axiom: str, productions: Dict[str, str], steps: int) -> List[str]:
    """The strings of a context-free L-system of one-character symbols, independently of the program."""
    found = [axiom]
    for _ in range(steps):
        found.append("".join(productions.get(symbol, symbol) for symbol in found[-1]))
    return found


def lines_of(model: str, *arguments: str) -> List[List[Point]]:
    """The lines that a model draws, as the points of its SVG with y upwards; units of the page."""
    with tempfile.TemporaryDirectory() as folder:
        espalier("run", chapter(model), "--quiet", "-o", f"{folder}/a.svg", *arguments)
        text = Path(folder, "a.svg").read_text(encoding="utf-8")
    lines: List[List[Point]] = []
    for path in re.findall(r' d="([^"]+)"', text):
        for piece in path.split("M")[1:]:
            lines.append([(float(x), -float(y)) for x, y in re.findall(r"(-?[\d.]+)[ ,](-?[\d.]+)", piece)])
    return lines


class LsystemViewer(unittest.TestCase):
    def test_the_strings_of_the_curve_of_koch(self) -> None:
        self.assertEqual(derived("lsystem-viewer/koch-curve.lsv"),
                         ["F", "F+F--F+F", "F+F--F+F+F+F--F+F--F+F--F+F+F+F--F+F"])

    def test_contours_without_rules_stay_and_others_grow(self) -> None:
        lengths = {name: [len(text) for text in derived(f"lsystem-viewer/{name}.lsv")]
                   for name in ("triangle", "rectangle", "rhombus", "circle", "koch-island")}
        self.assertEqual(lengths["triangle"], [5, 5])
        self.assertEqual(lengths["rectangle"], [9, 9])
        self.assertEqual(lengths["rhombus"], [9, 9])
        # n steps and n - 1 turns between them, n twice as many each time
        self.assertEqual(lengths["circle"], [2 * 2**k - 1 for k in range(10)])
        self.assertEqual(lengths["koch-island"], [len(text) for text in rewritten("F--F--F", {"F": "F+F--F+F"}, 4)])

    def test_growth_is_printed_and_drawn_as_it_is_kept(self) -> None:
        groups = {"contours": ["triangle", "rectangle", "rhombus", "circle", "koch-island"],
                  "coverings": ["peano", "hilbert", "tiling-triangles", "tiling-rhombs", "tiling-parallelograms"],
                  "plants": ["plant-1", "plant-2", "plant-3", "plant-4"]}
        for group, names in groups.items():
            models = [chapter(f"lsystem-viewer/{name}.lsv") for name in names]
            with tempfile.TemporaryDirectory() as folder:
                done = espalier("growth", *models, "--quiet", "-o", f"{folder}/a.svg")
                picture = Path(folder, "a.svg").read_text(encoding="utf-8")
            kept = GALLERY / "chapter-lsystem-viewer" / f"growth-{group}.svg"
            self.assertEqual(picture, kept.read_text(encoding="utf-8"))
            lengths: Dict[str, List[int]] = {}
            for row in done.stdout.splitlines():
                name, _, length = row.split("\t")
                lengths.setdefault(name, []).append(int(length))
            for name in names:
                self.assertEqual(lengths[f"{name}.lsv"], [len(text) for text in derived(f"lsystem-viewer/{name}.lsv")])

    def test_contours_close(self) -> None:
        for name in ("triangle", "rectangle", "rhombus", "koch-island"):
            (line,) = lines_of(f"lsystem-viewer/{name}.lsv")
            self.assertLess(math.dist(line[0], line[-1]), 0.1, name)

    def test_the_circle_is_round_and_goes_more_than_once_around(self) -> None:
        points = [point for line in lines_of("lsystem-viewer/circle.lsv") for point in line]
        # 512 steps of 1 degree
        xs, ys = [x for x, _ in points], [y for _, y in points]
        centre = ((min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2)
        radii = [math.dist(point, centre) for point in points]
        self.assertLess(max(radii) - min(radii), 0.01 * max(radii))

    def test_the_first_step_is_along_x_and_plus_turns_left(self) -> None:
        (line,) = lines_of("lsystem-viewer/triangle.lsv")
        self.assertGreater(line[1][0], line[0][0])
        self.assertAlmostEqual(line[1][1], line[0][1], places=2)
        self.assertGreater(line[2][1], line[1][1])

    def test_a_bracket_brings_back_the_heading(self) -> None:
        # F[+F]-F from 90 degrees at 45: up, a branch to the upper left, then to the upper right
        lines = lines_of("lsystem-viewer/branch.lsv")
        points = sorted({point for line in lines for point in line})
        self.assertEqual(len(points), 4)
        left, right = points[0], points[-1]
        self.assertAlmostEqual(left[1], right[1], places=1)

    def test_a_scale_of_a_third_keeps_the_size(self) -> None:
        for step in ("0", "1", "3"):
            with tempfile.TemporaryDirectory() as folder:
                espalier("run", chapter("lsystem-viewer/koch-curve.lsv"), "--quiet", "--steps", step, "-o", f"{folder}/a.csv")
                rows = Path(folder, "a.csv").read_text(encoding="utf-8").splitlines()
            last = dict(zip(rows[0].split(","), rows[-1].split(",")))
            self.assertAlmostEqual(float(last["x"]), 90.0)
            self.assertAlmostEqual(float(last["y"]), 0.0)

    def test_every_figure_takes_less_than_a_second(self) -> None:
        for file in sorted((GALLERY / "chapter-lsystem-viewer").glob("*.lsv")):
            with tempfile.TemporaryDirectory() as folder:
                begin = time.monotonic()
                espalier("run", str(file), "--quiet", "-o", f"{folder}/a.svg", "-o", f"{folder}/a.ps")
                self.assertLess(time.monotonic() - begin, 5.0, file.name)
                self.assertTrue(Path(folder, "a.ps").read_text(encoding="utf-8").startswith("%!PS"))


class GraphicalModels(unittest.TestCase):
    def test_substitution_with_the_string_that_is_left_out(self) -> None:
        self.assertEqual(derived("graphical-models/substitution.txt"),
                         ["b", "an", "bab", "anbaan", "babanbabab", "anbaanbabanbaanbaan"])

    def test_islands(self) -> None:
        koch = {"F": "F-F+F+FF-F-F+F"}
        self.assertEqual(derived("graphical-models/koch-island.txt"), rewritten("F-F-F-F", koch, 3))
        archipelago = {"F": "F+f-FF+F+FF+Ff+FF-f+FF-F-FF-Ff-FFF", "f": "ffffff"}
        self.assertEqual(derived("graphical-models/archipelago.txt"), rewritten("F+F+F+F", archipelago, 2))
        archipelago["f"] = "ffff"
        self.assertEqual(derived("graphical-models/archipelago-as-printed.txt"), rewritten("F+F+F+F", archipelago, 2))

    def test_a_step_becomes_a_quarter_and_the_figure_keeps_its_size(self) -> None:
        (first,) = lines_of("graphical-models/koch-island.txt", "--steps", "0")
        self.assertLess(math.dist(first[0], first[-1]), 0.1)

    def test_node_rewriting_gives_the_string_of_the_text(self) -> None:
        steps = derived("graphical-models/node-rewriting.txt")
        self.assertEqual(steps[:2], ["L(4)", "+R(3)F-L(3)FL(3)-FR(3)+"])
        # L_2 by the text, with its `+R0L` read as `+R0F`
        r1, l1 = "-L(2)F+R(2)FR(2)+FL(2)-", "+R(2)F-L(2)FL(2)-FR(2)+"
        self.assertEqual(steps[2], f"+{r1}F-{l1}F{l1}-F{r1}+")
        plain = [re.sub(r"\(\d\)", "", text) for text in steps]
        self.assertEqual(plain, rewritten("L", {"L": "+RF-LFL-FR+", "R": "-LF+RFR+FL-"}, 4))

    def test_the_first_tree(self) -> None:
        steps = derived("graphical-models/tree-1.txt")
        plain = [re.sub(r"\(\d\)", "", text) for text in steps]
        self.assertEqual(plain, rewritten("F", {"F": "F[+F]F[-F]F"}, 4))
        # F_2 of the text, from level 2 down
        f1 = "F(2)[+F(2)]F(2)[-F(2)]F(2)"
        self.assertEqual(steps[2], f"{f1}[+{f1}]{f1}[-{f1}]{f1}")

    def test_the_second_tree_gives_the_strings_of_the_text(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            text = (GALLERY / "chapter-graphical-models" / "tree-2.txt").read_text(encoding="utf-8")
            Path(folder, "tree.txt").write_text(text.replace("n = 5", "n = 2"), encoding="utf-8")
            lines = espalier("derive", f"{folder}/tree.txt", "--every", "--quiet").stdout.splitlines()
        printed = [
            "x_2", "F_2[+x_1]F_2[-x_1]+x_1",
            "F_1F_1[+F_1[+x_0]F_1[-x_0]+x_0]F_1F_1[-F_1[+x_0]F_1[-x_0]+x_0]+F_1[+x_0]F_1[-x_0]+x_0",
            # the last symbol of the text is x_1, which has been replaced already
            "F_0F_0F_0F_0[+F_0F_0[+x_0]F_0F_0[-x_0]+x_0]F_0F_0F_0F_0[-F_0F_0[+x_0]F_0F_0[-x_0]+x_0]"
            "+F_0F_0[+x_0]F_0F_0[-x_0]+x_0"]
        self.assertEqual([line.split("\t")[1] for line in lines], [re.sub(r"_(\d)", r"(\1)", line) for line in printed])

    def test_stochastic_productions_have_their_probabilities(self) -> None:
        successors = ["F[+F]F[-F]F", "F[+F]F", "F[-F]F"]
        first = {derived("graphical-models/stochastic.txt", "--steps", "1", "--seed", str(seed))[1] for seed in range(30)}
        self.assertEqual(first, set(successors))
        # of the second generation every module has its own draw; about a third each
        text = "".join(derived("graphical-models/stochastic.txt", "--steps", "7", "--seed", "5")[-1:])
        self.assertGreater(text.count("F"), 1000)

    def test_a_signal_climbs_and_ignores_turns(self) -> None:
        steps = derived("graphical-models/context.txt")
        self.assertEqual(steps[1], "F_b[+F_a]F_a[-F_a]F_a[+F_a]F_a")
        self.assertEqual(steps[2], "F_b[+F_b]F_b[-F_a]F_a[+F_a]F_a")
        self.assertEqual(steps[3], "F_b[+F_b]F_b[-F_b]F_b[+F_a]F_a")


class OpenLsystems(unittest.TestCase):
    def test_algae(self) -> None:
        self.assertEqual(derived("open-l-systems/algae.txt"), ["a", "ab", "aba", "abaab", "abaababa", "abaababaabaab"])

    def test_tables_of_branching(self) -> None:
        self.assertEqual(derived("open-l-systems/monopodial.txt")[:4],
                         ["0", "1[0]0", "1[1[0]0]1[0]0", "1[1[1[0]0]1[0]0]1[1[0]0]1[0]0"])
        self.assertEqual(derived("open-l-systems/dichotomous.txt")[:4],
                         ["0", "1[0][0]", "1[1[0][0]][1[0][0]]",
                          "1[1[1[0][0]][1[0][0]]][1[1[0][0]][1[0][0]]]"])

    def test_each_axiom_of_a_set_has_its_own_derivation(self) -> None:
        curves = {"hilbert": {"L": "+RF-LFL-FR+", "R": "-LF+RFR+FL-"}, "dragon": {"X": "X+YF+", "Y": "-FX-Y"},
                  "sierpinski": {"X": "YF+XF+Y", "Y": "XF-YF-X"}}
        for name, productions in curves.items():
            for axiom in productions:
                steps = derived(f"open-l-systems/{name}.txt:{axiom}", "--steps", "4")
                self.assertEqual(steps, rewritten(axiom, productions, 4))
        note = espalier("derive", chapter("open-l-systems/hilbert.txt"), "--steps", "0").stderr
        self.assertIn("the file holds 2 models and the first is used: L, R", note)

    def test_signals_go_up_and_down(self) -> None:
        # Prusinkiewicz & Lindenmayer 1990, figure 1.30, without its turns being of consequence
        self.assertEqual(derived("open-l-systems/signal-up.txt"),
                         ["B[+A]A[-A]A[+A]A", "B[+B]B[-A]A[+A]A", "B[+B]B[-B]B[+A]A", "B[+B]B[-B]B[+B]B"])
        self.assertEqual(derived("open-l-systems/signal-down.txt"),
                         ["A[+A]A[-A]A[+A]B", "A[+A]A[-A]B[+A]B", "A[+A]B[-A]B[+A]B", "B[+A]B[-A]B[+A]B"])

    def test_several_symbols_of_context(self) -> None:
        self.assertEqual(derived("open-l-systems/context.txt"), ["ZAXYACDEF", "ZAXYAAACDEF"])

    def test_the_four_outcomes_of_the_stochastic_parametric_example(self) -> None:
        counts: Dict[str, int] = {}
        program = chapter("open-l-systems/stochastic-parametric.txt")
        with tempfile.TemporaryDirectory() as folder:
            espalier("run", program, "--quiet", "--variants", "1000", "-o", f"{folder}/%d.string", "--seed", "1")
            for file in Path(folder).iterdir():
                text = file.read_text(encoding="utf-8").strip()
                counts[text] = counts.get(text, 0) + 1
        expected = {"A(2)B(6)[A(3)]A(6)": 0.16, "A(2)B(6)[A(3)]B(4)": 0.24, "B(0)B(6)[A(3)]A(6)": 0.24,
                    "B(0)B(6)[A(3)]B(4)": 0.36}
        self.assertEqual(set(counts), set(expected))
        for text, probability in expected.items():
            # four standard deviations of a share of 1000
            margin = 4 * math.sqrt(probability * (1 - probability) / 1000)
            self.assertLess(abs(counts[text] / 1000 - probability), margin, text)

    def test_the_flower_of_a(self) -> None:
        self.assertEqual(derived("open-l-systems/flower.txt"),
                         ["A(0)", "FA(1)", "F[-L]FA(2)", "F[-L]F[+L]FA(3)", "F[-L]F[+L]FB"])
        warnings = espalier("check", chapter("open-l-systems/flower.txt")).stderr
        self.assertEqual(warnings.count("'<=' is read as '<'"), 2)

    def test_the_bushes(self) -> None:
        self.assertEqual(derived("open-l-systems/bush.txt"), rewritten("F", {"F": "F[-F]F[+F][F]"}, 4))
        self.assertEqual(derived("open-l-systems/fork.txt"), rewritten("F", {"F": "F[+F][-F]F"}, 4))

    def test_plus_turns_right_where_the_slide_does(self) -> None:
        lines = lines_of("open-l-systems/branch-right.txt")
        trunk = max(lines, key=lambda line: line[-1][1])
        branch = [point for line in lines for point in line if point not in trunk]
        self.assertTrue(all(x > trunk[0][0] for x, _ in branch))


    def test_lines_are_coloured_in_the_order_of_drawing(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            espalier("run", chapter("open-l-systems/hilbert.txt:L"), "--quiet", "--rainbow", "-o", f"{folder}/a.svg")
            text = Path(folder, "a.svg").read_text(encoding="utf-8")
        colours = re.findall(r'stroke="(#[0-9a-f]{6})"', text)
        # red at both ends, blue two thirds on; the last lines join the first, which have their colour
        self.assertEqual(colours[0], "#dc1e1e")
        self.assertEqual(colours[-1][:4], "#da1")
        blue = colours[len(colours) * 2 // 3]
        self.assertGreater(int(blue[5:7], 16), 180)
        self.assertGreater(len(set(colours)), 200)


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
        self.assertTrue(all("o" not in text for text in steps[:-1]))
        self.assertIn("o", steps[-1])
        # two branches of r/sqrt 2 have together the section of the one below
        self.assertAlmostEqual(2 * (1 / math.sqrt(2)) ** 2, 1.0)

    def test_quadrants_stay_balanced(self) -> None:
        last = derived("turtle-painter/balanced.txt", "--seed", "2")[-1]
        apices = [[float(number) for number in text.split(",")] for text in re.findall(r"A\(([^)]+)\)", last)]
        self.assertGreater(len(apices), 20)
        for _, _, left, right, upper, lower in apices:
            # what one quadrant loses the opposite one gains
            self.assertEqual((left + right, upper + lower), (100, 100))
            self.assertTrue(0 <= min(left, right, upper, lower) + 30)

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


class Conversion(unittest.TestCase):
    def test_a_converted_model_draws_the_same(self) -> None:
        for model in ("lsystem-viewer/koch-island.lsv", "fractint/curves.l:Weed", "open-l-systems/bush.txt"):
            with tempfile.TemporaryDirectory() as folder:
                text = espalier("convert", chapter(model), "--to", "cpfg", "--quiet").stdout
                self.assertTrue(text.startswith("Lsystem: 1\n"))
                Path(folder, "m.l").write_text(text, encoding="utf-8")
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
        self.assertIn("is written as L-System Viewer: format lays out cpfg models", done.stderr)

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


class Chapters(unittest.TestCase):
    def test_pages_show_the_description_beside_the_picture(self) -> None:
        pictures = (GALLERY / "pictures.txt").read_text(encoding="utf-8").splitlines()
        for name in (line.split(" ")[0] for line in pictures):
            if not name.startswith("chapter-") or "." not in name:
                continue
            file, _, entry = name.partition(":")
            picture = Path(file).stem + (f"-{entry}" if entry else "") + ".png"
            page = (GALLERY / file).parent.joinpath("README.md").read_text(encoding="utf-8")
            row = next((row for row in page.split("<tr>") if f'src="{picture}"' in row), "")
            with self.subTest(name):
                shown = re.search(r"<pre>(.*?)</pre>", row, re.DOTALL)
                self.assertIsNotNone(shown, "there is no description in the row of its picture")
                lines = html.unescape(shown.group(1)).splitlines() if shown else []
                model = [line.rstrip() for line in (GALLERY / file).read_text(encoding="utf-8").splitlines()]
                # what is shown is what the file says, all that a file of one model says
                self.assertTrue(lines and all(line in model for line in lines))
                if Path(file).name not in ("species.txt", "curves.l"):
                    says = [line for line in model if line and not re.match(r"# |//|/\*", line)]
                    self.assertEqual([line for line in lines if not line.startswith("#")],
                                     [line for line in says if not line.startswith("#")])

    def test_pages_show_the_strings_that_are_derived(self) -> None:
        for model in ("graphical-models/koch-island.txt", "graphical-models/context.txt", "open-l-systems/algae.txt",
                      "open-l-systems/monopodial.txt", "open-l-systems/dichotomous.txt", "open-l-systems/flower.txt",
                      "open-l-systems/signal-up.txt", "open-l-systems/signal-down.txt"):
            page = Path(chapter(model)).parent.joinpath("README.md").read_text(encoding="utf-8")
            for text in derived(model)[:2]:
                self.assertRegex(page, rf"(?m)^\d: {re.escape(text)}$")

    def test_every_model_is_without_errors_and_on_its_page(self) -> None:
        listed = (GALLERY / "README.md").read_text(encoding="utf-8")
        for folder in sorted(GALLERY.glob("chapter-*")):
            page = (folder / "README.md").read_text(encoding="utf-8")
            self.assertIn(f"({folder.name}/README.md)", listed)
            for file in sorted(folder.iterdir()):
                if file.suffix in (".lsv", ".txt", ".l"):
                    with self.subTest(file.name):
                        espalier("check", str(file))
                        self.assertIn(file.name, page)


if __name__ == "__main__":
    unittest.main()
