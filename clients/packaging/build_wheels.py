"""Builds wheels: `build_wheels.py PROGRAM FOLDER` writes a pure one for clients, and one with the program inside.

The second needs nothing else: the program, the shared libraries that it uses (all but those of the C library), the gallery and the
conformance suite are in the package. Its tag names the oldest C library that has every symbol that these files use.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "clients" / "python" / "build_backend"))

import espalier_build  # noqa: E402

# parts of the C library, which every system has in its own version
OF_THE_SYSTEM = re.compile(r"^(?:linux-vdso|ld-linux|lib(?:c|m|dl|rt|pthread|resolv|util)\.so)")
# loaded when a user names a file that needs it, and not missed without it
OPTIONAL = {b"libgeotiff.so.5"}
ENTRY_POINTS = "[console_scripts]\nespalier = espalier.program:main\n"


def said(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def linked(file: Path) -> dict[str, Path]:
    """The shared libraries that the loader finds for a file, without those of the system."""
    found = re.findall(r"^\s*(\S+) => (\S+)", said("ldd", str(file)), re.MULTILINE)
    return {name: Path(path) for name, path in found if not OF_THE_SYSTEM.match(name)}


def loaded_later(program: Path) -> list[str]:
    """The names of the libraries that a program loads when it needs them (environment/base/loaded_library.h)."""
    names = set(re.findall(rb"\0(lib[\w.+-]+\.so\.\d+)(?=\0)", program.read_bytes())) - OPTIONAL
    return sorted(name.decode() for name in names if name.decode() not in said("readelf", "--dynamic", str(program)))


def libraries(program: Path) -> list[Path]:
    """The shared libraries of a program that do not belong to the system, and those that they need."""
    found = linked(program)
    folders = sorted({path.parent for path in found.values()})
    for name in loaded_later(program):
        path = next((folder / name for folder in folders if (folder / name).exists()), None)
        if path is None:
            sys.exit(f"{name}, which {program} loads, is in none of {', '.join(map(str, folders))}. Install its package.")
        found |= {name: path, **linked(path)}
    return list(found.values())


def needed_c_library(files: list[Path]) -> tuple[int, int]:
    """The newest version among the symbols of the C library that the files use."""
    versions = [(int(major), int(minor)) for file in files
                for major, minor in re.findall(r"\bGLIBC_(\d+)\.(\d+)", said("objdump", "-T", str(file)))]
    return max(versions)


def with_own_libraries(source: Path, target: Path, origin: str) -> None:
    """A copy that finds its libraries beside it."""
    shutil.copy(source, target)
    target.chmod(0o755)
    subprocess.run(["strip", "--strip-unneeded", str(target)], check=True)
    subprocess.run(["patchelf", "--set-rpath", origin, str(target)], check=True)


def data_files() -> list[tuple[str, bytes]]:
    found = []
    for folder, name in ((ROOT / "clients" / "gallery", "gallery"), (ROOT / "tests" / "conformance" / "cases", "conformance")):
        found += [(f"espalier/share/espalier/{name}/{path.relative_to(folder).as_posix()}", path.read_bytes())
                  for path in sorted(folder.rglob("*")) if path.is_file()]
    return found


def platform_wheel(program: Path, folder: Path) -> str:
    shared = libraries(program)
    with tempfile.TemporaryDirectory() as work:
        files: list[tuple[str, bytes]] = []
        for source, name, origin in [(program, "espalier/bin/espalier", "$ORIGIN/lib"),
                                     *((path, f"espalier/bin/lib/{path.name}", "$ORIGIN") for path in shared)]:
            copy = Path(work) / Path(name).name
            with_own_libraries(source.resolve(), copy, origin)
            files.append((name, copy.read_bytes()))
        major, minor = needed_c_library([program, *shared])
    pure = [(path.relative_to(espalier_build.ROOT).as_posix(), path.read_bytes()) for path in espalier_build.package_files()]
    information = f"espalier-{espalier_build.version()}.dist-info"
    tag = f"py3-none-manylinux_{major}_{minor}_{said('uname', '-m').strip()}"
    return espalier_build.write_wheel(folder, [*pure, *espalier_build.viewer(), *files, *data_files(),
                                               (f"{information}/entry_points.txt", ENTRY_POINTS.encode())],
                                      tag, programs=[name for name, _ in files])


def main() -> None:
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    print(folder / espalier_build.build_wheel(str(folder)))
    print(folder / platform_wheel(program, folder))


if __name__ == "__main__":
    main()
