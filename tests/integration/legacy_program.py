#!/usr/bin/env python3
"""A test program like the published environment programs of the 1990s: text records on pipes, answers in chunks.

    legacy_program.py -e FILE.e MODE

MODE: `height` answers the height of the point as the second value and leaves the first unset; `chunks` the same, three answers a
chunk; `eager` answers as soon as a record is in; `count` remembers and answers how many steps it has seen; `quit`, `silent`,
`garbage` and `ill` misbehave in the second step.
"""

import re
import sys
import time

RECORD = re.compile(r"(\d+) (\S+?)\(([^)]*)\)(.*)")
READY = "\x01"


def main() -> int:
    assert sys.argv[1] == "-e" and sys.argv[2].endswith(".e"), sys.argv
    mode = sys.argv[3]
    answers_per_chunk = 3 if mode == "chunks" else 10**9
    sys.stdout.write(READY)
    sys.stdout.flush()
    steps = 0
    while True:
        # a step: chunks of records until one says that it is the last
        pending, flags = [], 0
        first = True
        while not flags & 4:
            for line in sys.stdin:
                if line.startswith("Control:"):
                    flags, step = map(int, line.split()[1:])
                    break
                match = RECORD.match(line)
                assert match, line
                identifier, name, parameters, following = match.groups()
                assert name == "E", line
                x, y, z = (float(word) for word in sys.stdin.readline().split()[1:])
                pending.append((identifier, y, following, parameters))
                if mode == "eager":
                    print(f"{identifier} E(,{y:g})")
            else:
                return 0
            if flags & 8:
                sys.stdout.write(READY)
                sys.stdout.flush()
                return 0
            assert bool(flags & 1) == first, flags
            first = False
            if not flags & 4:
                print("Control: 0", flush=True)
        steps += 1
        if steps == 2:
            if mode == "quit":
                return 3
            if mode == "silent":
                time.sleep(60)
            if mode == "garbage":
                print("hello there", flush=True)
            if mode == "ill":
                print("0 E(nan)", flush=True)
        if mode == "eager":
            pending = []
        while pending:
            for identifier, y, following, parameters in pending[:answers_per_chunk]:
                value = float(steps) if mode == "count" else y
                print(f"{identifier} E(,{value:g})")
            pending = pending[answers_per_chunk:]
            if pending:
                print("Control: 0", flush=True)
                assert sys.stdin.readline().startswith("Control:")
        print("Control: 4", flush=True)


if __name__ == "__main__":
    sys.exit(main())
