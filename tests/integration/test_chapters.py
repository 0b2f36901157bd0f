"""The chapters of the gallery: what the documents that the project began with print is what their models derive."""

import html
import math
import re
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List, Tuple

from chapters import chapter, derived, edges_of, lattice, lines_of, rewritten, rows_of, vector
from support import GALLERY, espalier


class LsystemViewer(unittest.TestCase):
    def test_regular_polygons_are_n_times_f_and_turns_between(self) -> None:
        # the paper's recipe: the angle is 360/n, the axiom n F with n - 1 + between them
        for sides in (3, 4, 5, 6, 8, 12):
            with self.subTest(sides), tempfile.TemporaryDirectory() as folder:
                model = Path(folder, "n.lsv")
                model.write_text(f"generations 1\nstep 10\nangle 360/{sides}\naxiom {'+'.join(sides * 'F')}\n",
                                 encoding="utf-8")
                corners = [vector(row, "x y") for row in rows_of(str(model)) if row["symbol"] == "F"]
                self.assertEqual(len({lattice(corner, 1e-3) for corner in corners}), sides)
                self.assertLess(math.dist(corners[-1], (0.0, 0.0)), 1e-9)
                centre = (sum(x for x, _ in corners) / sides, sum(y for _, y in corners) / sides)
                for corner in corners:
                    # the radius of a polygon with sides of 10
                    self.assertAlmostEqual(math.dist(corner, centre), 5 / math.sin(math.pi / sides))

    def test_polygons_that_are_not_regular(self) -> None:
        corners = [end for _, end in edges_of("lsystem-viewer/rectangle.lsv")]
        self.assertEqual(sorted({corner[:2] for corner in map(lambda c: lattice(c, 60), corners)}),
                         [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)])
        rhombus = [end for _, end in edges_of("lsystem-viewer/rhombus.lsv")]
        self.assertEqual(len(rhombus), 4)
        # equal sides, diagonals of 80 and 80 times the root of 3
        self.assertAlmostEqual(math.dist(rhombus[1], rhombus[3]), 80.0)
        self.assertAlmostEqual(math.dist(rhombus[0], rhombus[2]), 80.0 * math.sqrt(3))

    def test_peano_and_hilbert_cover_their_squares(self) -> None:
        # Hilbert: 32 by 32 points, each once; with scale 1/2 a step is 200/2^5
        edges = edges_of("lsystem-viewer/hilbert.lsv")
        points = {lattice(point, 200 / 2**5) for edge in edges for point in edge}
        self.assertEqual((len(edges), len(points)), (4**5 - 1, 4**5))
        self.assertEqual(max(x for x, _, _ in points) - min(x for x, _, _ in points), 31)
        self.assertEqual(max(y for _, y, _ in points) - min(y for _, y, _ in points), 31)
        # Peano: every line of a turned square lattice once, 27 squares of a step on the diagonal
        edges = edges_of("lsystem-viewer/peano.lsv")
        half = 200 / 3**3 / math.sqrt(2)
        lines = {tuple(sorted(lattice(point, half) for point in edge)) for edge in edges}
        self.assertEqual((len(edges), len(lines)), (9**3, 9**3))
        ends = {point for line in lines for point in line}
        self.assertEqual({max(c[k] for c in ends) - min(c[k] for c in ends) for k in (0, 1)}, {27})

    def test_tilings_repeat_one_figure(self) -> None:
        # all steps are sides of one lattice, and what each figure is made of is there
        unit = (10.0, 10.0 * math.sqrt(3))
        for name, steps in (("triangles", 3), ("rhombs", 4), ("parallelograms", 6)):
            with self.subTest(name):
                edges = edges_of(f"lsystem-viewer/tiling-{name}.lsv")
                sides = set()
                for start, end in edges:
                    self.assertAlmostEqual(math.dist(start, end), 20.0)
                    for x, y, _ in (start, end):
                        self.assertAlmostEqual(x / unit[0], round(x / unit[0]), places=6)
                        self.assertAlmostEqual(y / unit[1], round(y / unit[1]), places=6)
                    sides.add(tuple(sorted((round(x / unit[0]), round(y / unit[1])) for x, y, _ in (start, end))))
                # neighbours share sides: fewer than the figures have
                self.assertLess(len(sides), len(edges))
                directions = {(b[0] - a[0], b[1] - a[1]) for a, b in sides}
                self.assertEqual(len(directions), 2 if name == "parallelograms" else 3)
                self.assertGreater(len(edges), 3 * steps)

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
            # contours without rules stay as long in every generation: nine are shown of each
            steps = ["--steps", "9"] if group == "contours" else []
            models = [chapter(f"lsystem-viewer/{name}.lsv") for name in names]
            with tempfile.TemporaryDirectory() as folder:
                done = espalier("growth", *models, *steps, "--quiet", "-o", f"{folder}/a.svg")
                picture = Path(folder, "a.svg").read_text(encoding="utf-8")
            kept = GALLERY / "chapter-lsystem-viewer" / f"growth-{group}.svg"
            self.assertEqual(picture, kept.read_text(encoding="utf-8"))
            lengths: Dict[str, List[int]] = {}
            for row in done.stdout.splitlines():
                name, _, length = row.split("\t")
                lengths.setdefault(name, []).append(int(length))
            for name in names:
                self.assertEqual(lengths[f"{name}.lsv"], [len(text) for text in derived(f"lsystem-viewer/{name}.lsv", *steps)])

    def test_a_rule_may_keep_the_length(self) -> None:
        # the paper says that each generation is at least twice as long unless rules are trivial
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "m.lsv").write_text("generations 3\nangle 60\nstep 1\naxiom F+F\nprule F -> f\nprule f -> F\n",
                                             encoding="utf-8")
            lines = espalier("derive", f"{folder}/m.lsv", "--every", "--quiet").stdout.splitlines()
        self.assertEqual([line.split("\t")[1] for line in lines], ["F+F", "f+f", "F+F", "f+f"])

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

    def test_every_figure_is_drawn(self) -> None:
        files = sorted((GALLERY / "chapter-lsystem-viewer").glob("*.lsv"))
        self.assertGreater(len(files), 5)
        for file in files:
            with tempfile.TemporaryDirectory() as folder:
                espalier("run", str(file), "--quiet", "-o", f"{folder}/a.svg", "-o", f"{folder}/a.ps")
                self.assertTrue(Path(folder, "a.ps").read_text(encoding="utf-8").startswith("%!PS"), file.name)
                self.assertIn("<path", Path(folder, "a.svg").read_text(encoding="utf-8"), file.name)


class GraphicalModels(unittest.TestCase):
    def test_substitution_with_the_string_that_is_left_out(self) -> None:
        self.assertEqual(derived("graphical-models/substitution.txt"),
                         ["b", "an", "bab", "anbaan", "babanbabab", "anbaanbabanbaanbaan"])

    def test_the_inference_problem_has_the_answers_of_the_page(self) -> None:
        page = (GALLERY / "chapter-graphical-models" / "README.md").read_text(encoding="utf-8")
        strings = derived("graphical-models/substitution.txt")
        with tempfile.TemporaryDirectory() as folder:
            def infer(steps: List[str], status: int = 0) -> Tuple[str, str]:
                Path(folder, "steps.txt").write_text("\n".join(steps) + "\n", encoding="utf-8")
                done = espalier("infer", f"{folder}/steps.txt", status=status)
                return done.stdout.strip(), done.stderr.strip()

            self.assertIn(f"\n{infer(strings)[0]}\n", page)
            self.assertIn(f"\n{infer(strings[:3])[1]}\n", page)
            # the text leaves the string an out
            self.assertIn(f"\n{infer(strings[:1] + strings[2:], 1)[1]}\n", page)

    def test_islands(self) -> None:
        koch = {"F": "F-F+F+FF-F-F+F"}
        self.assertEqual(derived("graphical-models/koch-island.txt"), rewritten("F-F-F-F", koch, 3))
        archipelago = {"F": "F+f-FF+F+FF+Ff+FF-f+FF-F-FF-Ff-FFF", "f": "ffffff"}
        self.assertEqual(derived("graphical-models/archipelago.txt"), rewritten("F+F+F+F", archipelago, 2))
        archipelago["f"] = "ffff"
        self.assertEqual(derived("graphical-models/archipelago-as-printed.txt"), rewritten("F+F+F+F", archipelago, 2))

    def test_the_snowflake_grows_from_its_initiator_and_generator(self) -> None:
        self.assertEqual(derived("graphical-models/snowflake.txt"), rewritten("F--F--F", {"F": "F+F--F+F"}, 4))
        for step in range(5):
            edges = edges_of("graphical-models/snowflake.txt", "--steps", str(step))
            self.assertEqual(len(edges), 3 * 4**step)
            self.assertLess(math.dist(edges[-1][1], (0.0, 0.0, 0.0)), 1e-9)
            # each side becomes a third
            self.assertAlmostEqual(math.dist(*edges[0]), 1 / 3**step)

    def test_what_the_bracketed_string_results_in(self) -> None:
        # F[+F][-F[-F]F]F[+F][-F]: two lines up; at the first joint a line to the left and a branch of two to the right
        # with one more to the right between them, at the second joint a line to each side
        edges = edges_of("graphical-models/bracketed.txt")
        self.assertEqual(len(edges), 8)
        half = math.sqrt(0.5)
        ends = sorted((round(x, 6), round(y, 6)) for _, (x, y, _) in edges)
        self.assertEqual(ends, sorted((round(x, 6), round(y, 6)) for x, y in [
            (0, 1), (-half, 1 + half), (half, 1 + half), (half + 1, 1 + half), (2 * half, 1 + 2 * half), (0, 2),
            (-half, 2 + half), (half, 2 + half)]))

    def test_symbols_of_space_turn_by_the_matrices_of_the_text(self) -> None:
        # (H', L', U')^T = R (H, L, U)^T with U = H x L; ^ and / by -alpha, \ and / by R_H
        angle = math.radians(22.5)
        cosine, sine = math.cos(angle), math.sin(angle)
        rotations: Dict[str, List[List[float]]] = {
            "+": [[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]],
            "-": [[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]],
            "&": [[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]],
            "^": [[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]],
            "\\": [[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]],
            "/": [[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]],
            "|": [[-1, 0, 0], [0, -1, 0], [0, 0, 1]],
        }
        turns = "+&\\^-/&|/+^^\\-"
        with tempfile.TemporaryDirectory() as folder:
            model = Path(folder, "m.txt")
            model.write_text(f"ω: {''.join(turn + 'F' for turn in turns)}\nδ = 22,5°\nn = 0\nF → F\n", encoding="utf-8")
            drawn = [row for row in rows_of(str(model)) if row["symbol"] == "F"]
        self.assertEqual(len(drawn), len(turns))
        frame = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        for turn, row in zip(turns, drawn):
            frame = [[sum(rotations[turn][i][k] * frame[k][axis] for k in range(3)) for axis in range(3)]
                     for i in range(3)]
            for i, names in enumerate(("hx hy hz", "lx ly lz")):
                for expected, found in zip(frame[i], vector(row, names)):
                    self.assertAlmostEqual(expected, found, places=9, msg=turn)

    def test_the_invention_is_in_space_with_thickness_and_colours(self) -> None:
        rows = [row for row in rows_of(chapter("graphical-models/space.txt")) if row["symbol"] in "FS"]
        self.assertGreater(max(float(row["z"]) for row in rows) - min(float(row["z"]) for row in rows), 3.0)
        self.assertGreater(len({row["colour"] for row in rows}), 3)
        self.assertEqual({float(row["width"]) for row in rows}, {5.0})

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
        # every module has a draw of its own: of 900 a third each, four standard deviations
        with tempfile.TemporaryDirectory() as folder:
            text = (GALLERY / "chapter-graphical-models" / "stochastic.txt").read_text(encoding="utf-8")
            Path(folder, "m.txt").write_text(text.replace("ω: F\n", "ω: " + 900 * "AF" + "\n"), encoding="utf-8")
            after = espalier("derive", f"{folder}/m.txt", "--steps", "1", "--seed", "5", "--quiet").stdout.strip()
        drawn = after.split("A")[1:]
        self.assertEqual(len(drawn), 900)
        for successor in successors:
            self.assertLess(abs(drawn.count(successor) - 300), 4 * math.sqrt(900 * 2 / 9))

    def test_the_first_printed_outcome_cannot_be_derived_and_the_others_can(self) -> None:
        one = r"(?:F\[\+F\]F\[-F\]F|F\[\+F\]F|F\[-F\]F)"
        two = re.compile(rf"{one}\[\+{one}\]{one}\[-{one}\]{one}|{one}\[\+{one}\]{one}|{one}\[-{one}\]{one}")
        printed = ["F[+F]F[-F]F[+F[+F]F[-F]F]F[+F]F[-F]F[-F[+F]F[-F]F]F[+F]F[-F]F[-F]F",
                   "F[+F]F[+F[-F]F]F[+F]F[-F[+F]F]F[+F]F",
                   "F[+F]F[-F]F[+F[+F]F[-F]F]F[+F]F[-F]F"]
        self.assertEqual([two.fullmatch(text) is not None for text in printed], [False, True, True])
        for seed in range(20):
            self.assertIsNotNone(two.fullmatch(derived("graphical-models/stochastic.txt", "--seed", str(seed))[2]))

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

    def test_branching_is_drawn_by_the_substitution_of_shapes(self) -> None:
        # level 5 of the tables; every 1 and every 0 is a line of one step
        for name, rule, straight in (("monopodial", "1[0]0", True), ("dichotomous", "1[0][0]", False)):
            text = rewritten("0", {"0": rule}, 4)[-1]
            rows = [row for row in rows_of(chapter(f"open-l-systems/{name}.txt")) if row["symbol"] in "01"]
            self.assertEqual(len(rows), text.count("0") + text.count("1"))
            ends = {(round(float(row["x"]), 6), round(float(row["y"]), 6)) for row in rows}
            # one axis goes on straight where branching is monopodial, none where it is dichotomous
            on_axis = max(y for x, y in ends if x == 0.0)
            self.assertEqual((0.0, 2.0) in ends, straight)
            self.assertEqual(on_axis == 5.0, straight)
            mirrored = {(0.0 - x, y) for x, y in ends}
            self.assertEqual(mirrored == ends, not straight)

    def test_each_axiom_of_a_set_has_its_own_derivation(self) -> None:
        curves = {"hilbert": {"L": "+RF-LFL-FR+", "R": "-LF+RFR+FL-"}, "dragon": {"X": "X+YF+", "Y": "-FX-Y"},
                  "sierpinski": {"X": "YF+XF+Y", "Y": "XF-YF-X"}}
        for name, productions in curves.items():
            for axiom in productions:
                steps = derived(f"open-l-systems/{name}.txt:{axiom}", "--steps", "4")
                self.assertEqual(steps, rewritten(axiom, productions, 4))
        note = espalier("derive", chapter("open-l-systems/hilbert.txt"), "--steps", "0").stderr
        self.assertIn("the file holds 2 models; the first is used: L, R", note)

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

    def test_the_open_example_after_its_answers(self) -> None:
        # as the slide prints them, with ?E(2) for its last ?E(3)
        self.assertEqual(derived("open-l-systems/open.txt", "--answered"),
                         ["F(0,0)A?E(0)", "F(0,0)F(0,1)A?E(1)", "F(0,0)F(0,1)F(0,2)A?E(2)", "F(0,0)F(0,1)F(0,2)?E(2)"])
        # F(x,y) is a line to the point (x,y)
        rows = [row for row in rows_of(chapter("open-l-systems/open.txt")) if row["symbol"] == "F"]
        self.assertEqual([vector(row, "x y z") for row in rows], [(0.0, float(k), 0.0) for k in range(3)])

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
        for curve in ("hilbert.txt:L", "dragon.txt:X", "sierpinski.txt:Y"):
            with self.subTest(curve), tempfile.TemporaryDirectory() as folder:
                espalier("run", chapter(f"open-l-systems/{curve}"), "--quiet", "--rainbow", "-o", f"{folder}/a.svg")
                text = Path(folder, "a.svg").read_text(encoding="utf-8")
                colours = re.findall(r'stroke="(#[0-9a-f]{6})"', text)
                # red at both ends, blue two thirds on; the last lines join the first, which have their colour
                self.assertEqual(colours[0], "#dc1e1e")
                self.assertEqual(colours[-1][:3], "#da")
                blue = colours[len(colours) * 2 // 3]
                self.assertGreater(int(blue[5:7], 16), 180)
                self.assertGreater(len(set(colours)), 200)


class Chapters(unittest.TestCase):
    def test_pages_show_the_description_beside_the_picture(self) -> None:
        pictures = (GALLERY / "pictures.txt").read_text(encoding="utf-8").splitlines()
        for name in (line.split(" ")[0] for line in pictures):
            if not name.startswith("chapter-") or "." not in name:
                continue
            # FILE:ENTRY, and behind @ a word that tells pictures of one model apart
            model_name, _, word = name.partition("@")
            file, _, entry = model_name.partition(":")
            picture = "-".join(part for part in (Path(file).stem, entry, word) if part) + ".png"
            page = (GALLERY / file).parent.joinpath("README.md").read_text(encoding="utf-8")
            if word:
                self.assertIn(f'src="{picture}"', page)
                continue
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
