"""The list of mutants (tests/mutation) fits the sources, so that a mutation pass can begin at any time."""

import collections
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "mutation"))

import mutate  # noqa: E402


class Mutants(unittest.TestCase):
    def test_each_stands_once_in_its_file_and_changes_it(self) -> None:
        mutants = mutate.mutants()
        self.assertEqual([problem for problem in map(mutate.problem_of, mutants) if problem], [])
        self.assertEqual([mutant for mutant in mutants if mutant["text"] == mutant["with"]], [])
        # the rule sees a text that is not there
        self.assertIn("has 0 times", str(mutate.problem_of({**mutants[0], "text": "no such line"})))

    def test_each_library_has_ten(self) -> None:
        counted = collections.Counter(mutant["library"] for mutant in mutate.mutants())
        libraries = ("core", "language", "derivation", "turtle", "environment", "protocol", "server")
        self.assertEqual({name: counted[name] >= 10 for name in libraries}, {name: True for name in libraries})


class Switches(unittest.TestCase):
    """A mutant beside the text that it replaces, in one program."""

    def test_conditions_declarations_and_statements(self) -> None:
        for text, other, made in (
                ("if (a < b) {", "if (a > b) {", "if (espalierMutant() == 7 ? bool(a > b) : bool(a < b)) {"),
                ("if (const auto c = f(); c && d) {", "if (const auto c = f(); c) {",
                 "if (const auto c = f(); espalierMutant() == 7 ? bool(c) : bool(c && d)) {"),
                ("if (a) {\n  return;", "if (b) {\n  return;", "if (espalierMutant() == 7 ? bool(b) : bool(a)) {\n  return;"),
                ("const double x = a;", "const double x = b;", "const double x = espalierMutant() == 7 ? (b) : (a);"),
                ("x = a;", "x = b;", "if (espalierMutant() == 7) { x = b; } else { x = a; }"),
                ("return a;", "return b;", "if (espalierMutant() == 7) { return b; } else { return a; }"),
                ("if (a) {\n  y = b;", "if (a) {", "if (a) {\nif (espalierMutant() == 7) {  } else { y = b; }"),
                ("x = a ||\n    b;", "x = a;", "if (espalierMutant() == 7) { x = a; } else { x = a ||\n    b; }")):
            self.assertEqual(mutate.switched(text, other, 7, "{\n  f();\n  // why\n  "), made)

    def test_a_part_of_an_expression_is_none(self) -> None:
        for text, other, before in (("a <= b ?", "a < b ?", "{\n  "), ("a == b);", "a <= b);", "f(c &&\n  "),
                                    ("if (const auto c = f(); c) {", "if (const auto c = g(); c) {", "{\n  ")):
            self.assertIsNone(mutate.switched(text, other, 7, before))

    def test_most_mutants_can_be_chosen_when_the_program_runs(self) -> None:
        known = mutate.mutants()
        self.assertGreater(sum(map(mutate.is_switchable, known)), 0.9 * len(known))


if __name__ == "__main__":
    unittest.main()
