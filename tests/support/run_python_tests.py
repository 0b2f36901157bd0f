"""Runs all unittest tests below the given folders, shows what fails, and writes `passed failed` to a file.

Test classes run side by side, `--jobs` of them at a time, each in a process of its own.
"""

import argparse
import concurrent.futures
import io
import multiprocessing
import os
import re
import sys
import time
import typing
import unittest

LONGEST = ("InABrowser",)
PROCESSES = multiprocessing.get_context("fork")


class Outcome(typing.NamedTuple):
    passed: int
    broken: int
    skipped: list[str]
    report: str  # of the failures
    seconds: float = 0.0


def all_tests(suite: unittest.TestSuite):
    for entry in suite:
        if isinstance(entry, unittest.TestSuite):
            yield from all_tests(entry)
        else:
            yield entry


def run(tests: list[unittest.TestCase]) -> Outcome:
    stream = io.StringIO()
    result = unittest.TextTestRunner(stream=stream, verbosity=0, buffer=True).run(unittest.TestSuite(tests))
    broken = len(result.failures) + len(result.errors) + len(result.unexpectedSuccesses)
    return Outcome(passed=max(0, result.testsRun - broken - len(result.skipped) - len(result.expectedFailures)),
                   broken=broken,
                   skipped=[f"{test.id()}: {reason}" for test, reason in result.skipped],
                   report=stream.getvalue())


def in_own_process(tests: list[unittest.TestCase]) -> Outcome:
    """The outcome of run(), also when the process that runs it dies; remains of a test do not reach the next class."""
    began = time.monotonic()
    receiving, sending = PROCESSES.Pipe(duplex=False)
    child = PROCESSES.Process(target=lambda: sending.send(run(tests)))
    child.start()
    sending.close()
    try:
        return receiving.recv()._replace(seconds=time.monotonic() - began)
    except EOFError:
        child.join()
        names = ", ".join(test.id() for test in tests)
        return Outcome(0, len(tests), [], f"the process of {names} ended with {child.exitcode}\n")
    finally:
        child.join()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--figures", required=True, help="file that receives the two numbers, then the time of each class")
    parser.add_argument("--pattern", default="", help="regular expression that a test's name must match")
    parser.add_argument("--jobs", type=int, default=1, help="test classes that run at a time")
    options = parser.parse_args()

    classes: dict[tuple[type, str], list[unittest.TestCase]] = {}
    for folder in options.folders:
        if os.path.isdir(folder):
            # a loader of its own: the top folder of one discovery must not be that of the next
            for test in all_tests(unittest.TestLoader().discover(folder, pattern="test_*.py")):
                if re.search(options.pattern, test.id()):
                    classes.setdefault((type(test), folder), []).append(test)

    # the longest first: one of minutes, then as far as the number of tests tells
    work = sorted(classes.values(), key=lambda tests: (type(tests[0]).__name__ not in LONGEST, -len(tests)))
    passed = broken = 0
    times = []
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        for tests, outcome in zip(work, pool.map(in_own_process, work)):
            times.append((outcome.seconds, tests[0].id().rpartition(".")[0]))
            passed += outcome.passed
            broken += outcome.broken
            for line in outcome.skipped:
                print(f"skipped: {line}")
            if outcome.broken:
                sys.stdout.write(outcome.report)
            sys.stdout.flush()
    with open(options.figures, "w", encoding="utf-8") as figures:
        figures.write(f"{passed} {broken}\n")
        figures.writelines(f"{seconds:8.1f} s  {name}\n" for seconds, name in sorted(times, reverse=True))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
