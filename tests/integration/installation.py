"""The build under test, installed into a temporary folder, and projects outside the tree that use it."""

import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import ClassVar

from support import SECONDS, program


def run(*command: str) -> str:
    """Runs a command, which must succeed; returns its standard output."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(command)}\nended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


@unittest.skipUnless(shutil.which("cmake"), "there is no cmake")
class Installed(unittest.TestCase):
    """Tests that use an installed Espalier: `prefix` is where it is, `folder` is for files of the tests."""

    temporary: "ClassVar[tempfile.TemporaryDirectory[str]]"
    folder: ClassVar[Path]
    prefix: ClassVar[Path]

    @classmethod
    def setUpClass(cls) -> None:
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = Path(cls.temporary.name)
        cls.prefix = cls.folder / "prefix"
        build = Path(program()).resolve().parents[1]
        run("cmake", "--install", str(build), "--prefix", str(cls.prefix))

    def build_project(self, project: Path, *arguments: str) -> Path:
        """Configures and builds a project against the installed package; returns the folder with its programs."""
        out = project / "build"
        run("cmake", "-S", str(project), "-B", str(out), "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.prefix}", *arguments)
        run("cmake", "--build", str(out))
        return out
