#!/usr/bin/env python3
"""A test program like the published environment programs of the 1990s: text records on pipes, answers in chunks.

    legacy_program.py -e FILE.e MODE [LOG]

It reads the number of modules in a chunk and the format of the position from its FILE.e, as programs of the published library do, and
ends when that file names another communication type than pipes. It answers every chunk of the master with one `Control:` line, and
sends its own chunks one after another. A line that it does not expect ends it with status 9. LOG receives all lines, `>` to the
program and `<` from it.

MODE: `height` answers the height of the point as the second value and leaves the first unset; `eager` the same as soon as a record is in;
`count` remembers and answers how many steps it has seen; `discs` answers 0 when another point is within the distance 3 in x and z, else
1, as the first value; `quit`, `silent`, `garbage`, `ill`, `flags` and `flood` misbehave in the second step.
"""

import re
import sys
import time
from typing import List, Optional, TextIO, Tuple

RECORD = re.compile(r"(\d+) (\S+?)\(([^)]*)\)(.*)")
READY = "\x01"

Vector = Tuple[float, float, float]


class Settings:
    """The settings that the program takes from its `.e` file."""

    def __init__(self, name: str) -> None:
        self.chunk = 100
        self.skipped = 0
        with open(name, encoding="utf-8") as file:
            for line in file:
                keyword, _, value = line.rstrip("\n").partition(":")
                if keyword == "communication type":
                    words = value.split()
                    if words[0] != "pipes":
                        sys.exit(7)
                    self.chunk = int(words[1]) if len(words) > 1 else 100
                elif keyword == "turtle position":
                    # the blank behind the colon counts
                    self.skipped = value.index("%")


class Program:
    def __init__(self, settings: Settings, mode: str, log: Optional[TextIO]) -> None:
        self.settings = settings
        self.mode = mode
        self.log = log
        self.steps = 0
        self.pending: List[Tuple[str, Vector]] = []

    def read(self) -> str:
        line = sys.stdin.readline()
        if self.log and line:
            print(">", line, end="", file=self.log, flush=True)
        return line

    def write(self, line: str) -> None:
        if self.log:
            print("<", line, file=self.log, flush=True)
        print(line, flush=True)

    def expect(self, condition: bool) -> None:
        if not condition:
            sys.exit(9)

    def read_record(self, line: str) -> None:
        match = RECORD.match(line)
        self.expect(match is not None and match[2] == "E")
        assert match is not None
        identifier, point = match[1], self.read()[self.settings.skipped:].split()
        self.expect(len(point) == 3)
        place = (float(point[0]), float(point[1]), float(point[2]))
        if self.mode == "eager":
            self.write(f"{identifier} E(,{place[1]:g})")
        else:
            self.pending.append((identifier, place))

    def read_step(self) -> bool:
        """Reads the master's chunks up to the last; False: it says goodbye."""
        flags, count, first = 0, 0, True
        while not flags & 4:
            line = self.read()
            if not line:
                return False
            if not line.startswith("Control:"):
                self.read_record(line)
                count += 1
                continue
            flags, step = map(int, line.split()[1:])
            if flags & 8:
                return False
            # every chunk has modules; the step stands behind the last one only
            self.expect(bool(flags & 1) == first and 0 < count <= self.settings.chunk)
            self.expect(step == (self.steps if flags & 4 else 0))
            first, count = False, 0
            if not flags & 4:
                self.write("Control: 5")
        return True

    def misbehave(self) -> None:
        if self.mode == "quit":
            sys.exit(3)
        if self.mode == "silent":
            time.sleep(60)
        if self.mode == "garbage":
            self.write("hello there")
        if self.mode == "ill":
            self.write("0 E(nan)")
        if self.mode == "flags":
            self.write("Control: done")
        while self.mode == "flood":
            self.write("Control: 0")

    def answer(self, identifier: str, place: Vector) -> str:
        if self.mode == "discs":
            near = [other for _, other in self.pending if other != place
                    and (other[0] - place[0]) ** 2 + (other[2] - place[2]) ** 2 <= 9]
            return f"{identifier} E({0 if near else 1})"
        return f"{identifier} E(,{float(self.steps) if self.mode == 'count' else place[1]:g})"

    def run(self) -> None:
        self.write(READY)
        while self.read_step():
            self.steps += 1
            if self.steps == 2:
                self.misbehave()
            answers = [self.answer(*pending) for pending in self.pending]
            self.pending = []
            size = self.settings.chunk
            for begin in range(0, max(len(answers), 1), size):
                for line in answers[begin:begin + size]:
                    self.write(line)
                self.write(f"Control: {(1 if begin == 0 else 0) | (4 if begin + size >= len(answers) else 0)}")
        self.write(READY)


def main() -> int:
    assert sys.argv[1] == "-e" and sys.argv[2].endswith(".e"), sys.argv
    log = open(sys.argv[4], "w", encoding="utf-8") if len(sys.argv) > 4 else None
    Program(Settings(sys.argv[2]), sys.argv[3], log).run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
