"""`espalier validate`: the benchmarks that take longer, each a part of the stage `long` (ESPALIER_LONG_CASE names it)."""

import os
import subprocess
import unittest
from pathlib import Path

from support import REPOSITORY, espalier, program

# published tables, which the repository does not hold
PUBLISHED = Path(os.environ.get("ESPALIER_VALIDATION", str(REPOSITORY.parent / "shared" / "validation")))


def long_cases() -> "list[str]":
    return [line.split("\t")[0] for line in espalier("validate", "--list").stdout.splitlines() if "\tlong\t" in line]


class LongValidation(unittest.TestCase):
    def test_the_stage_has_a_part_for_each_long_benchmark(self) -> None:
        # the function of the script, with the program of this test in the place of the built one
        script = (REPOSITORY / "dev").read_text(encoding="utf-8")
        listing = next(line for line in script.splitlines() if line.startswith("long_benchmarks()"))
        listing = listing.replace("build/release/bin/espalier", program())
        done = subprocess.run(["bash", "-c", f"{listing}\nlong_benchmarks"], capture_output=True, text=True, check=True, timeout=60)
        self.assertEqual(done.stdout.split(), long_cases())
        self.assertIn("rami-398", done.stdout.split())

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes long: ./dev test --all long")
    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_CASE"), "a part of its own for each benchmark: ESPALIER_LONG_CASE")
    def test_long_a_benchmark_meets_its_tolerances(self) -> None:
        data = ["--data", str(PUBLISHED)] if PUBLISHED.is_dir() else []
        page = ["--page", os.environ["ESPALIER_VALIDATION_PAGE"]] if "ESPALIER_VALIDATION_PAGE" in os.environ else []
        # forests of 398 crowns take a quarter of an hour of one core
        done = subprocess.run([program(), "validate", os.environ["ESPALIER_LONG_CASE"], *data, *page], capture_output=True, text=True,
                              timeout=3600, stdin=subprocess.DEVNULL)
        lines = [line.split("\t") for line in done.stdout.splitlines()]
        table = [dict(zip(lines[0], line)) for line in lines[1:]]
        # no long benchmark needs tables of other authors
        self.assertTrue(table, done.stderr)
        # what a machine with other work takes is no mistake
        wrong = [row for row in table if row["result"] == "NOT MET" and not row["what"].startswith("time of ")]
        self.assertEqual(wrong, [], done.stdout)


if __name__ == "__main__":
    unittest.main()
