"""`espalier validate`: all benchmarks, those that take longer too."""

import os
import unittest
from pathlib import Path

from support import REPOSITORY, espalier

# published tables, which the repository does not hold
PUBLISHED = Path(os.environ.get("ESPALIER_VALIDATION", str(REPOSITORY.parent / "shared" / "validation")))


class LongValidation(unittest.TestCase):
    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes long: ./dev test --all long")
    def test_long_all_benchmarks_meet_their_tolerances(self) -> None:
        names = [line.split("\t")[0] for line in espalier("validate", "--list").stdout.splitlines() if "\tlong\t" in line]
        self.assertTrue(names)
        for name in names:
            with self.subTest(name):
                data = ["--data", str(PUBLISHED)] if PUBLISHED.is_dir() else []
                self.assertNotIn("NOT MET", espalier("validate", name, *data).stdout)


if __name__ == "__main__":
    unittest.main()
