"""The hashes of states and drawings in hashes.txt: computed again, compared, recorded.

    python3 tests/bits/hashes.py --programs build/release/bin                  # compare, all lines
    python3 tests/bits/hashes.py --programs build/release/bin --record         # write hashes.txt anew
"""

import argparse
import hashlib
import os
import shlex
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path
from typing import Dict, List, Optional

REPOSITORY = Path(__file__).resolve().parents[2]
GALLERY = REPOSITORY / "clients" / "gallery"
FILE = Path(__file__).with_name("hashes.txt")

# the C library's masks: no fused multiply-add; no AVX2 either. Each makes it choose other routines
MASKS = ("glibc.cpu.hwcaps=-FMA", "glibc.cpu.hwcaps=-FMA,-AVX2,-AVX")

MODELS_IN_BLOCK = 100


def content(file: bytes) -> bytes:
    """The bytes of a file; of a PNG its rows, because zlib may pack them otherwise in another version."""
    if not file.startswith(b"\x89PNG"):
        return file
    rows, place = b"", 8
    while place < len(file):
        size = int.from_bytes(file[place:place + 4], "big")
        rows += file[place + 8:place + 8 + size] if file[place + 4:place + 8] == b"IDAT" else b""
        place += size + 12
    return zlib.decompress(rows)


class Programs:
    """The two programs of a build, called through `launcher` and with a mask of the processor."""

    def __init__(self, folder: str, mask: Optional[str] = None, threads: int = 1, launcher: str = "") -> None:
        self.folder = Path(folder).resolve()
        self.threads = threads
        self.launcher = shlex.split(launcher)
        self.variables = {**os.environ, **({"GLIBC_TUNABLES": mask} if mask else {})}

    def run(self, program: str, arguments: List[str]) -> str:
        done = subprocess.run([*self.launcher, str(self.folder / program), *arguments], capture_output=True, text=True,
                              check=False, env=self.variables, stdin=subprocess.DEVNULL, cwd=REPOSITORY)
        if done.returncode != 0:
            raise AssertionError(f"{program} {' '.join(arguments)} ended with {done.returncode}:\n{done.stderr}")
        return done.stdout

    def random(self, first: int, count: int) -> Dict[str, str]:
        lines = self.run("espalier_bits", ["random", str(first), str(count), str(self.threads)]).splitlines()
        return {" ".join(line.split()[:2]): line.split()[2] for line in lines}

    def gallery(self, name: str) -> str:
        return self.run("espalier_bits", ["gallery", str(GALLERY), str(self.threads), name]).split()[2]

    def state(self, arguments: List[str]) -> str:
        return self.run("espalier", ["derive", *arguments, "--hash", "--quiet", "--threads", str(self.threads)]).strip()

    def drawing(self, name: str, arguments: List[str]) -> str:
        with tempfile.TemporaryDirectory() as folder:
            file = f"{folder}/{name}"
            self.run("espalier", ["run", *arguments, "--quiet", "--threads", str(self.threads), "-o", file])
            return hashlib.sha256(content(Path(file).read_bytes())).hexdigest()[:16]

    def again(self, names: List[str]) -> Dict[str, str]:
        """The hashes of these lines."""
        found: Dict[str, str] = {}
        blocks = [int(name.split()[1]) for name in names if name.startswith("random ")]
        if blocks:
            found.update(self.random(blocks[0], blocks[-1] + MODELS_IN_BLOCK - blocks[0]))
        for name in names:
            kind, *words = shlex.split(name)
            if kind == "gallery":
                found[name] = self.gallery(words[0])
            elif kind == "state":
                found[name] = self.state(words)
            elif kind == "drawing":
                found[name] = self.drawing(words[0], words[1:])
        return found


def recorded() -> Dict[str, str]:
    """The lines of hashes.txt: what is hashed, and its hash."""
    lines = [line for line in FILE.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return {line.rsplit(" ", 1)[0]: line.rsplit(" ", 1)[1] for line in lines}


def differences(wanted: Dict[str, str], found: Dict[str, str]) -> List[str]:
    return [f"{name}: {found.get(name, 'nothing')} instead of {value}" for name, value in wanted.items()
            if found.get(name) != value]


def record(programs: Programs) -> None:
    """Writes hashes.txt anew; its lines stay."""
    found = programs.again(list(recorded()))
    lines = []
    for line in FILE.read_text(encoding="utf-8").splitlines():
        name = line.rsplit(" ", 1)[0]
        lines.append(f"{name} {found[name]}" if name in found else line)
    FILE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", required=True, help="folder of espalier and espalier_bits")
    parser.add_argument("--mask", help="GLIBC_TUNABLES")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--launcher", default="", help="a program before the programs, such as qemu-x86_64 -cpu Nehalem")
    parser.add_argument("--kinds", default="gallery,state,drawing,random", help="kinds of lines, with commas between them")
    parser.add_argument("--random", type=int, default=10_000, help="how many models at random")
    parser.add_argument("--record", action="store_true")
    given = parser.parse_args()
    programs = Programs(given.programs, given.mask, given.threads, given.launcher)
    if given.record:
        record(programs)
        return 0
    wanted = {name: value for name, value in recorded().items()
              if name.split()[0] in given.kinds.split(",") and not (name.startswith("random ") and int(name.split()[1]) >= given.random)}
    wrong = differences(wanted, programs.again(list(wanted)))
    print("\n".join(wrong) if wrong else f"{len(wanted)} hashes are equal")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
