"""`espalier validate`: all benchmarks, those that take longer too."""

import os
import subprocess
import unittest
from pathlib import Path

from support import REPOSITORY, espalier, program

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
                # forests of 398 crowns take a quarter of an hour of one core
                done = subprocess.run([program(), "validate", name, *data], capture_output=True, text=True, timeout=3600,
                                      stdin=subprocess.DEVNULL)
                lines = [line.split("\t") for line in done.stdout.splitlines()]
                table = [dict(zip(lines[0], line)) for line in lines[1:]]
                self.assertTrue(table, done.stderr)
                # what a machine with other work takes is no mistake
                wrong = [row for row in table if row["result"] == "NOT MET" and not row["what"].startswith("time of ")]
                self.assertEqual(wrong, [], done.stdout)


if __name__ == "__main__":
    unittest.main()
