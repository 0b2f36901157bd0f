"""Runs all unittest tests below the given folders, shows what fails, and writes `passed failed` to a file."""

import argparse
import io
import os
import re
import sys
import unittest


def all_tests(suite: unittest.TestSuite):
    for entry in suite:
        if isinstance(entry, unittest.TestSuite):
            yield from all_tests(entry)
        else:
            yield entry


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--figures", required=True, help="file that receives the two numbers")
    parser.add_argument("--pattern", default="", help="regular expression that a test's name must match")
    options = parser.parse_args()

    chosen = unittest.TestSuite()
    for folder in options.folders:
        if os.path.isdir(folder):
            # a loader of its own: the top folder of one discovery must not be that of the next
            for test in all_tests(unittest.TestLoader().discover(folder, pattern="test_*.py")):
                if re.search(options.pattern, test.id()):
                    chosen.addTest(test)

    stream = io.StringIO()
    result = unittest.TextTestRunner(stream=stream, verbosity=0, buffer=True).run(chosen)
    broken = len(result.failures) + len(result.errors) + len(result.unexpectedSuccesses)
    passed = max(0, result.testsRun - broken - len(result.skipped) - len(result.expectedFailures))
    for test, reason in result.skipped:
        print(f"skipped: {test.id()}: {reason}")
    if broken:
        sys.stdout.write(stream.getvalue())
    with open(options.figures, "w", encoding="utf-8") as figures:
        figures.write(f"{passed} {broken}\n")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
