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


if __name__ == "__main__":
    unittest.main()
