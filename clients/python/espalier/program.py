"""Where the program `espalier` is on this machine."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Optional

from .errors import EspalierError, ServerFailed

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
    raise ServerFailed("There is no program 'espalier'. Install its Debian package or the wheel that has it (docs/install.md), or build it with "
                       f"'./dev build' in the source tree; then put it on the PATH or name it in the variable {PROGRAM_VARIABLE}.")


def drawn_by(program: str, snapshot: bytes, suffix: str, *options: str, seconds: Optional[float] = None) -> bytes:
    """The file of that suffix which `espalier export` makes of a snapshot. `seconds` bound its time (None: no bound)."""
    with tempfile.TemporaryDirectory(prefix="espalier-") as folder:
        state, picture = Path(folder) / "plant.snapshot", Path(folder) / f"plant{suffix}"
        state.write_bytes(snapshot)
        command = [program, "export", str(state), "-o", str(picture), "--quiet", *options]
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=seconds,
                                  check=False)
        except subprocess.TimeoutExpired:
            raise EspalierError(f"The picture takes more than {seconds:g} seconds: ask for a smaller one.") from None
        if done.returncode != 0:
            raise EspalierError(f"The plant cannot be drawn: {done.stderr.strip() or 'espalier export failed'}")
        return picture.read_bytes()


def main() -> None:
    """The command `espalier` of a wheel with the program inside."""
    os.execv(str(PACKAGED), ["espalier", *sys.argv[1:]])
