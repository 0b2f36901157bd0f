"""Every gallery model derives, and those with exact answers give them."""

import re
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List, Set, Tuple

from support import GALLERY, espalier, model, strings

Cell = Tuple[int, ...]


def ulam_warburton(dimensions: int, generations: int) -> List[int]:
    """Cells after each generation by the automaton itself: a cell is born where exactly one neighbour lives."""
    directions = [tuple(sign if axis == along else 0 for axis in range(dimensions))
                  for along in range(dimensions) for sign in (-1, 1)]
    living: Set[Cell] = {(0,) * dimensions}
    counts = [1]
    for _ in range(generations):
        neighbours: Dict[Cell, int] = {}
        for cell in living:
            for direction in directions:
                place = tuple(a + b for a, b in zip(cell, direction))
                if place not in living:
                    neighbours[place] = neighbours.get(place, 0) + 1
        living |= {place for place, count in neighbours.items() if count == 1}
        counts.append(len(living))
    return counts


def rewrite(axiom: str, productions: Dict[str, str], steps: int) -> List[str]:
    """The strings of a context-free L-system of one-character symbols, independently of the program."""
    found = [axiom]
    for _ in range(steps):
        found.append("".join(productions.get(symbol, symbol) for symbol in found[-1]))
    return found


class Gallery(unittest.TestCase):
    def test_growth_to_a_height_gives_its_four_strings(self) -> None:
        expected = ["F(0,0)A?E(0)", "F(0,0)F(0,1)A?E(0)", "F(0,0)F(0,1)F(0,2)A?E(1)", "F(0,0)F(0,1)F(0,2)?E(2)"]
        self.assertEqual(strings("growth-to-a-height"), expected)
        lines = (GALLERY / "growth-to-a-height" / "expected.txt").read_text(encoding="utf-8").splitlines()
        self.assertEqual(lines, [f"{step}\t{string}" for step, string in enumerate(expected)])

    def test_the_automaton_gives_the_published_numbers(self) -> None:
        self.assertEqual(ulam_warburton(2, 7), [1, 5, 9, 21, 25, 37, 49, 85])
        self.assertEqual(ulam_warburton(3, 3), [1, 7, 13, 43])

    def test_ulam_warburton_2d_for_40_generations(self) -> None:
        cells = [string.count("C") for string in strings("ulam-warburton-2d", "--steps", "40")]
        self.assertEqual(cells, ulam_warburton(2, 40))

    def test_ulam_warburton_3d_for_10_generations(self) -> None:
        cells = [string.count("C") for string in strings("ulam-warburton-3d", "--steps", "10")]
        self.assertEqual(cells, ulam_warburton(3, 10))

    def test_a_losing_tip_must_stay_as_an_occupant(self) -> None:
        # the counter-example of the model's README: without the places of losing tips the seventh number is 57
        source = (GALLERY / "ulam-warburton-2d" / "ulam-warburton-2d.l").read_text(encoding="utf-8")
        forgetting, replaced = re.subn(r"^A > \?E\(v\) : v <= 0 --> B$", "A?E(v) : v <= 0 --> B", source, flags=re.MULTILINE)
        self.assertEqual(replaced, 1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = Path(folder.name) / "forgetting.l"
        path.write_text(forgetting, encoding="utf-8")
        beside = str(GALLERY / "ulam-warburton-2d" / "ulam-warburton-2d")
        lines = espalier("derive", str(path), "--every", "--quiet", "--steps", "7", "--view", f"{beside}.v",
                         "--environment", f"{beside}.e").stdout.splitlines()
        self.assertEqual([line.count("C") for line in lines][:7], [1, 5, 9, 21, 25, 37, 57])

    def test_branch_tiers_are_symmetric_and_fewer_than_alone(self) -> None:
        derived = strings("branch-tiers")
        alone = strings("branch-tiers-alone")
        for step, string in enumerate(derived):
            # the second tier is the first turned by half a turn: equal strings after the placement
            parts = re.split(r"@M\([-0-9.,]*\)", string)
            self.assertEqual(len(parts), 3)
            self.assertEqual(parts[1].rsplit("]", 1)[0], parts[2].rsplit("]", 1)[0], f"step {step}")
        clusters = [string.count("K") for string in derived]
        self.assertEqual([string.count("K") for string in alone], [10 * (2 ** (step + 1) - 1) for step in range(9)])
        # nothing meets in the first step: five branches a tier fork freely
        self.assertEqual(clusters[:2], [10, 30])
        self.assertTrue(all(few < many for few, many in zip(clusters[2:], [string.count("K") for string in alone][2:])))

    def test_classics_agree_with_plain_rewriting(self) -> None:
        hilbert = {"L": "+RF-LFL-FR+", "R": "-LF+RFR+FL-"}
        classics: List[Tuple[str, str, Dict[str, str]]] = [
            ("hilbert", "L", hilbert),
            ("peano", "F", {"F": "F+F-F-F-F+F+F+F-F"}),
            ("dragon", "FX", {"X": "X+YF+", "Y": "-FX-Y"}),
            ("sierpinski", "YF", {"X": "YF+XF+Y", "Y": "XF-YF-X"}),
            ("koch-curve", "F", {"F": "F+F--F+F"}),
            ("koch-snowflake", "F--F--F", {"F": "F+F--F+F"}),
            ("koch-island", "F-F-F-F", {"F": "F-F+F+FF-F-F+F"}),
            ("koch-archipelago", "F+F+F+F", {"F": "F+f-FF+F+FF+Ff+FF-f+FF-F-FF-Ff-FFF", "f": "ffffff"}),
            ("weed", "F", {"F": "FF-[-F+F+F]+[+F-F-F]"}),
            ("herb", "X", {"X": "F[+X]F[-X]+X", "F": "FF"}),
            ("algae", "a", {"a": "ab", "b": "a"}),
        ]
        for name, axiom, productions in classics:
            with self.subTest(name):
                derived = strings(f"classic-{name}")
                self.assertEqual(derived, rewrite(axiom, productions, len(derived) - 1))
        self.assertEqual({f"classic-{name}" for name, _, _ in classics} | {"classic-monopodial", "classic-dichotomous"},
                         {folder.name for folder in GALLERY.glob("classic-*")})

    def test_branching_patterns_without_their_turns_are_those_of_the_lecture(self) -> None:
        for name, branch in (("monopodial", "1[0]0"), ("dichotomous", "1[0][0]")):
            derived = strings(f"classic-{name}")
            plain = [re.sub(r"/\(180\)|[-+]", "", string) for string in derived]
            self.assertEqual(plain, rewrite("0", {"0": branch}, len(derived) - 1))

    def test_the_stochastic_bush_repeats_with_its_seed(self) -> None:
        first = strings("stochastic-bush", "--seed", "3")
        self.assertEqual(first, strings("stochastic-bush", "--seed", "3"))
        self.assertNotEqual(first, strings("stochastic-bush", "--seed", "4"))

    def test_shadows_leave_buds_behind(self) -> None:
        last = strings("shadow-trees")[-1]
        self.assertGreater(last.count("L"), 0)
        self.assertGreater(last.count("A("), 0)

    def test_model_folders_run_as_their_specifications_say(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            lilac = espalier("run", str(GALLERY / "lilac"), "-o", f"{folder}/lilac.svg")
            # the last frame of lilac.a, in the colours of lilac.map, and nothing to remark
            self.assertRegex(lilac.stderr, r"\Awrote \S+lilac.svg \(step 22, \d+ modules\)\n\Z")
            picture = Path(folder, "lilac.svg").read_text(encoding="utf-8")
            self.assertIn('<rect width="100%" height="100%" fill="#f7f4fa"/>', picture)

            espalier("run", str(GALLERY / "shaded-maple"), "--quiet", "--steps", "4", "-o", f"{folder}/maple.obj")
            materials = Path(folder, "maple.mtl").read_text(encoding="utf-8")
            self.assertIn("newmtl bark\nKd 0.4392 0.3608 0.3059\n", materials)
            # the environment of its specifications puts buds in the shade
            self.assertIn("S(", espalier("derive", str(GALLERY / "shaded-maple"), "--quiet").stdout)
            self.assertIn("V(5)", espalier("derive", str(GALLERY / "shaded-maple"), "--object", "leaf").stdout)

    def test_every_model_is_complete_and_without_errors(self) -> None:
        listed = (GALLERY / "README.md").read_text(encoding="utf-8")
        folders = sorted(path for path in GALLERY.iterdir() if path.is_dir() and not path.name.startswith("chapter-"))
        self.assertTrue(folders)
        for folder in folders:
            with self.subTest(folder.name):
                self.assertTrue((folder / "README.md").is_file())
                self.assertIn(f"| `{folder.name}` |", listed)
                espalier("check", model(folder.name))
                espalier("derive", model(folder.name), "--steps", "2", "--quiet")


if __name__ == "__main__":
    unittest.main()
