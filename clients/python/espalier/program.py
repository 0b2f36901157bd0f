"""Where the program `espalier` is on this machine."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from .errors import ServerFailed

PROGRAM_VARIABLE = "ESPALIER_PROGRAM"
# in a wheel that has the program inside
PACKAGED = Path(__file__).resolve().parent / "bin" / "espalier"


def find_program() -> str:
    """The program `espalier`: the value of ESPALIER_PROGRAM, the program inside this package, the program on the PATH, or the
    release build of the source tree around the working folder or this package. Raises ServerFailed when none of them exists."""
    named = os.environ.get(PROGRAM_VARIABLE)
    if named:
        return named
    if os.access(PACKAGED, os.X_OK):
        return str(PACKAGED)
    on_path = shutil.which("espalier")
    if on_path:
        return on_path
    for start in (Path.cwd(), Path(__file__).resolve().parent):
        for folder in (start, *start.parents):
            built = folder / "build" / "release" / "bin" / "espalier"
            if os.access(built, os.X_OK):
                return str(built)
    raise ServerFailed("There is no program 'espalier'. Build it with './dev build' in the source tree, then put it on the PATH "
                       f"or name it in the variable {PROGRAM_VARIABLE}.")


def main() -> None:
    """The command `espalier` of a wheel with the program inside."""
    os.execv(str(PACKAGED), ["espalier", *sys.argv[1:]])
