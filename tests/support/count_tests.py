"""Prints `passed failed` of a JUnit report. Skipped tests count as neither."""

import sys
import xml.etree.ElementTree as ElementTree


def count(report: str) -> tuple[int, int]:
    passed = failed = 0
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        status = case.get("status", "run")
        if case.find("failure") is not None or case.find("error") is not None or status == "fail":
            failed += 1
        elif case.find("skipped") is None and status == "run":
            passed += 1
    return passed, failed


if __name__ == "__main__":
    print(*count(sys.argv[1]))
