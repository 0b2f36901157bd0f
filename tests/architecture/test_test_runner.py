"""The runner of the C++ tests: no test is lost when its process ends."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# a test program that crashes in a test, leaks at its end, or ends before its first test
PROGRAM = r"""#!/bin/bash
if [[ "$*" == *list* ]]; then printf 'A.\n  Right\n  Crash\n  Later\nB.\n  Leak\nC.\n  Never\n'; exit; fi
tests="$*"; tests="${tests##*--gtest_filter=}"
for test in ${tests//:/ }; do
  [[ $test == C.Never ]] && exit 5
  echo "[ RUN      ] $test"
  [[ $test == A.Crash ]] && kill -SEGV $$
  echo "[       OK ] $test (1 ms)"
done
[[ $tests == B.Leak ]] && exit 1
exit 0
"""


class TestRunner(unittest.TestCase):
    def test_a_process_that_ends_is_a_failure_and_the_rest_runs(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "bin" / "test_a"
            program.parent.mkdir()
            program.write_text(PROGRAM, encoding="utf-8")
            os.chmod(program, 0o755)
            done = subprocess.run([sys.executable, str(ROOT / "tests/support/run_cpp_tests.py"), folder, "--figures", f"{folder}/figures"],
                                  capture_output=True, text=True, timeout=60, check=False)
            figures = Path(folder, "figures").read_text(encoding="utf-8")
        self.assertEqual((done.returncode, figures.splitlines()[0]), (1, "2 3"))
        for test in ("A.Crash", "B.Leak", "C.Never"):
            self.assertIn(f"{test}: its process ended with", done.stdout)


if __name__ == "__main__":
    unittest.main()
