"""The common parts of the integration tests: the program under test, and environments as processes."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Dict, List, Optional, Sequence

REPOSITORY = Path(__file__).resolve().parents[2]
GALLERY = REPOSITORY / "clients" / "gallery"
PACKAGE = REPOSITORY / "clients" / "python"
EXAMPLES = PACKAGE / "examples"
sys.path.insert(0, str(PACKAGE))

SECONDS = 300


def program() -> str:
    """The program under test: ESPALIER_PROGRAM, or the release build."""
    path = os.environ.get("ESPALIER_PROGRAM", str(REPOSITORY / "build" / "release" / "bin" / "espalier"))
    if not os.access(path, os.X_OK):
        raise AssertionError(f"There is no program {path}. Run ./dev build, or set ESPALIER_PROGRAM.")
    return path


def variables(**more: str) -> Dict[str, str]:
    """The variables of a process in which Python finds the package."""
    return {**os.environ, "PYTHONPATH": str(PACKAGE), "PYTHONDONTWRITEBYTECODE": "1", **more}


def espalier(*arguments: str, status: int = 0, **more: str) -> "subprocess.CompletedProcess[str]":
    """Runs the program and checks its exit status."""
    done = subprocess.run([program(), *arguments], capture_output=True, text=True, timeout=SECONDS, check=False,
                          env=variables(**more), stdin=subprocess.DEVNULL)
    if done.returncode != status:
        raise AssertionError(f"espalier {' '.join(arguments)} ended with {done.returncode} instead of {status}:\n"
                             f"{done.stderr}")
    return done


def model(name: str) -> str:
    return str(GALLERY / name / f"{name}.l")


def strings(name: str, *arguments: str) -> List[str]:
    """The derived strings of a gallery model, from step 0 on."""
    lines = espalier("derive", model(name), "--every", "--quiet", *arguments).stdout.splitlines()
    return [line.split("\t")[1] for line in lines]


class Process:
    """A program of a test: started, its first line read from standard output or standard error, ended."""

    def __init__(self, command: Sequence[str], *, speaks_on: str = "stdout", pass_fds: Sequence[int] = (), **more: str) -> None:
        pipes = {speaks_on: subprocess.PIPE}
        self.process: "subprocess.Popen[str]" = subprocess.Popen(
            list(command), stdin=subprocess.DEVNULL, text=True, env=variables(**more),
            stdout=pipes.get("stdout"), stderr=pipes.get("stderr"), pass_fds=pass_fds)
        stream = self.process.stdout if speaks_on == "stdout" else self.process.stderr
        assert stream is not None
        self._stream = stream
        self.first_line = stream.readline().strip()

    @property
    def address(self) -> str:
        """The address of its line `listening on HOST:PORT`."""
        found = re.search(r"listening on (\S+)", self.first_line)
        if found is None:
            raise AssertionError(f"expected 'listening on HOST:PORT', found '{self.first_line}'")
        return found.group(1)

    def wait(self) -> int:
        return self.process.wait(SECONDS)

    def stop(self) -> None:
        if self.process.poll() is None:
            self.process.terminate()
        self.process.wait(SECONDS)
        self._stream.close()


class Server(Process):
    """A server with its HTTP side."""

    def __init__(self, *arguments: str, listen: str = "127.0.0.1:0") -> None:
        gallery = [] if "--gallery" in arguments else ["--gallery", str(GALLERY)]
        super().__init__([program(), "serve", "--listen", listen, "--http", "127.0.0.1:0", "--log-level", "off",
                          *gallery, *arguments])
        found = re.match(r"http on (\S+)$", self._stream.readline().strip())
        assert found is not None
        self.http = found.group(1)


def python(script: Path, *arguments: str) -> List[str]:
    return [sys.executable, str(script), *arguments]


def stdio(command: Sequence[str], directory: Optional[Path] = None) -> str:
    """The --environment argument that spawns a command."""
    return "stdio:" + " ".join("'" + word.replace("'", "'\\''") + "'" for word in command)
