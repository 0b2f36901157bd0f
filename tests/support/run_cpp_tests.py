"""Runs the GoogleTest programs of a build, shows what fails, and writes `passed failed` and the time of each test.

A process runs a few tests of one suite, and several processes run side by side: one process a test would spend most of the
time on its start. When a test ends its process, or does not end in time, it has failed, and a new process runs the rest.
"""

import argparse
import concurrent.futures
import pathlib
import re
import subprocess
import sys
import typing

AT_A_TIME = 8  # tests of a process
OUTCOME = re.compile(r"\[ +(OK|FAILED|SKIPPED) +\] (\S+?)(?:,.*)? \((\d+) ms\)")


class Part(typing.NamedTuple):
    program: pathlib.Path
    tests: list[str]  # with their suite


class Result(typing.NamedTuple):
    test: str
    outcome: str  # OK, FAILED or SKIPPED
    seconds: float
    output: str


def tests_of(program: pathlib.Path) -> typing.Iterator[str]:
    listed = subprocess.run([program, "--gtest_list_tests"], capture_output=True, text=True, check=True, timeout=60).stdout
    suite = ""
    for line in listed.splitlines():
        name = line.split("#")[0].rstrip()
        if not line.startswith(" "):
            suite = name
        elif "DISABLED_" not in suite + name:
            yield suite + name.strip()


def parts_of(program: pathlib.Path, pattern: str, is_long: bool) -> typing.Iterator[Part]:
    suites: dict[str, list[str]] = {}
    for test in tests_of(program):
        if re.search(pattern, test) and (is_long or not re.search(r"(^|/)Long", test)):
            suites.setdefault(test.partition(".")[0], []).append(test)
    number = 1 if is_long else AT_A_TIME
    for tests in suites.values():
        for first in range(0, len(tests), number):
            yield Part(program, tests[first:first + number])


def run(part: Part, folder: pathlib.Path, seconds: float) -> list[Result]:
    results: list[Result] = []
    remaining = part.tests
    while remaining:
        reason = ""
        try:
            ended = subprocess.run([part.program, "--gtest_color=no", "--gtest_filter=" + ":".join(remaining)], cwd=folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=seconds, check=False)
            output = ended.stdout
            if ended.returncode != 0:
                reason = f"its process ended with {ended.returncode}"
        except subprocess.TimeoutExpired as late:
            output = late.stdout or b""
            reason = f"not finished after {seconds} s"
        text = output.decode(errors="replace")
        begun = []
        # the text between the beginnings of two tests
        for said in text.split("[ RUN      ] ")[1:]:
            test = said.split(maxsplit=1)[0]
            if test not in remaining:
                continue
            outcome = OUTCOME.search(said)
            begun.append(Result(test, outcome[1], int(outcome[3]) / 1000, said) if outcome else
                         Result(test, "FAILED", 0.0, f"{said}\n{test}: {reason or 'no outcome'}\n"))
            remaining = [other for other in remaining if other != test]
        results += begun
        if not begun or (reason and not any(result.outcome == "FAILED" for result in begun)):
            # no test began, or the process failed behind the last one, as when it lost memory
            failed = remaining or [begun[-1].test]
            results = [result for result in results if result.test not in failed]
            results += [Result(test, "FAILED", 0.0, f"{text}\n{test}: {reason or 'did not run'}\n") for test in failed]
            remaining = []
    return results


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path, help="build folder; its programs are bin/test_*")
    parser.add_argument("--figures", required=True, help="file that receives the two numbers, then the time of each test")
    parser.add_argument("--program", default="test_*", help="only this test program")
    parser.add_argument("--pattern", default="", help="regular expression that a test's name must match")
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    parser.add_argument("--long", action="store_true", help="with the tests named Long…; a process each")
    options = parser.parse_args()

    folder = options.build.resolve()
    parts = [part for program in sorted(folder.glob("bin/" + options.program))
             for part in parts_of(program, options.pattern, options.long)]
    results: list[Result] = []
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        for some in pool.map(lambda part: run(part, folder, 3600 if options.long else 600), parts):
            results += some
            for result in some:
                if result.outcome == "FAILED":
                    print(result.output, flush=True)
    passed = sum(result.outcome == "OK" for result in results)
    failed = sum(result.outcome == "FAILED" for result in results)
    with open(options.figures, "w", encoding="utf-8") as figures:
        figures.write(f"{passed} {failed}\n")
        for result in sorted(results, key=lambda result: -result.seconds):
            figures.write(f"{result.seconds:8.1f} s  {result.test}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
