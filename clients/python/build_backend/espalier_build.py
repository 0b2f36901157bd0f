"""Builds the package with the standard library alone (PEP 517 and PEP 660).

A pure Python wheel is a zip archive with three small text files beside the sources, so an in-tree backend of one page
replaces a download: `pip install` works on a machine without a network.
"""

from __future__ import annotations

import base64
import hashlib
import io
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "espalier"
PURE = "py3-none-any"
# archives hold this date so that equal sources give equal files
ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)

Settings = Optional[Dict[str, Any]]


def get_requires_for_build_wheel(config_settings: Settings = None) -> List[str]:
    return []


def get_requires_for_build_editable(config_settings: Settings = None) -> List[str]:
    return []


def get_requires_for_build_sdist(config_settings: Settings = None) -> List[str]:
    return []


def build_wheel(wheel_directory: str, config_settings: Settings = None,
                metadata_directory: Optional[str] = None) -> str:
    """Writes a wheel that holds the sources; returns its file name."""
    files = [(path.relative_to(ROOT).as_posix(), path.read_bytes()) for path in package_files()] + viewer()
    return write_wheel(Path(wheel_directory), files)


def build_editable(wheel_directory: str, config_settings: Settings = None,
                   metadata_directory: Optional[str] = None) -> str:
    """Writes a wheel that only points at this folder, so that changes of the sources are seen at once."""
    return write_wheel(Path(wheel_directory), [(f"{PACKAGE}_editable.pth", f"{ROOT}\n".encode())])


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: Settings = None) -> str:
    """Writes the metadata folder of the wheel; returns its name."""
    folder = f"{PACKAGE}-{version()}.dist-info"
    target = Path(metadata_directory) / folder
    target.mkdir(parents=True, exist_ok=True)
    for name, content in metadata_files():
        (target / name).write_bytes(content)
    return folder


def prepare_metadata_for_build_editable(metadata_directory: str, config_settings: Settings = None) -> str:
    return prepare_metadata_for_build_wheel(metadata_directory, config_settings)


def build_sdist(sdist_directory: str, config_settings: Settings = None) -> str:
    """Writes the source archive; returns its file name."""
    base = f"{PACKAGE}-{version()}"
    name = f"{base}.tar.gz"
    files = [(path.relative_to(ROOT).as_posix(), path.read_bytes()) for path in source_files()]
    files += viewer() + [("PKG-INFO", metadata())]
    with tarfile.open(Path(sdist_directory) / name, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for relative, content in files:
            entry = tarfile.TarInfo(f"{base}/{relative}")
            entry.size = len(content)
            entry.mode = 0o644
            archive.addfile(entry, io.BytesIO(content))
    return name


def project_value(key: str) -> str:
    """A string of pyproject.toml's [project] table. Python reads TOML itself only from 3.11 on; one line is enough here."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    found = re.search(rf'^{re.escape(key)}\s*=\s*"([^"]*)"', text, re.MULTILINE)
    if found is None:
        raise RuntimeError(f"pyproject.toml has no {key} = \"...\"")
    return found.group(1)


def version() -> str:
    return project_value("version")


def package_files() -> List[Path]:
    return sorted(path for path in (ROOT / PACKAGE).rglob("*")
                  if path.is_file() and (path.suffix in (".py", ".js") or path.name == "py.typed"))


def viewer() -> List[Tuple[str, bytes]]:
    """The script of the pages that show plants, of clients/web. A source archive has it in the package already."""
    web = ROOT.parent / "web"
    script = web / "espalier.js"
    sources = [web / "build.js", *(web / "src").rglob("*.[jt]s")]
    if not script.is_file() or any(script.stat().st_mtime < path.stat().st_mtime for path in sources if path.is_file()):
        bundle(web)
    if script.is_file():
        return [(f"{PACKAGE}/viewer/espalier.js", script.read_bytes())]
    if not (ROOT / PACKAGE / "viewer").is_dir():
        print("The package is built without its viewer: Simulation.view() cannot show plants. Install Node.js 18 or newer "
              "with npm (Debian: apt-get install nodejs npm), then install the package again.", file=sys.stderr)
    return []


def bundle(web: Path) -> None:
    """Makes the script from its sources where Node.js is there, as the build of the program does."""
    node = shutil.which("node")
    if node is not None and shutil.which("npm") is not None and (web / "build.js").is_file():
        subprocess.run([node, "build.js"], cwd=web, stdout=sys.__stderr__, stdin=subprocess.DEVNULL, check=False)


def source_files() -> List[Path]:
    folders = ("build_backend", "examples", "tests")
    others = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    return package_files() + sorted(others) + [ROOT / "pyproject.toml", ROOT / "README.md"]


def metadata() -> bytes:
    lines = [
        "Metadata-Version: 2.1",
        f"Name: {project_value('name')}",
        f"Version: {version()}",
        f"Summary: {project_value('description')}",
        f"Requires-Python: {project_value('requires-python')}",
        "License: Apache-2.0",
        "Description-Content-Type: text/markdown",
        "",
        (ROOT / "README.md").read_text(encoding="utf-8"),
    ]
    return "\n".join(lines).encode()


def metadata_files(tag: str = PURE) -> List[Tuple[str, bytes]]:
    is_pure = "true" if tag == PURE else "false"
    wheel = f"Wheel-Version: 1.0\nGenerator: espalier_build\nRoot-Is-Purelib: {is_pure}\nTag: {tag}\n"
    return [("METADATA", metadata()), ("WHEEL", wheel.encode())]


def write_wheel(directory: Path, files: List[Tuple[str, bytes]], tag: str = PURE, programs: Sequence[str] = ()) -> str:
    """Writes a wheel of the files plus metadata and the record of hashes that installers check. `programs` are those of the
    files that can be run."""
    info = f"{PACKAGE}-{version()}.dist-info"
    name = f"{PACKAGE}-{version()}-{tag}.whl"
    entries = files + [(f"{info}/{relative}", content) for relative, content in metadata_files(tag)]
    record = ""
    for relative, content in entries:
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{relative},sha256={digest},{len(content)}\n"
    record += f"{info}/RECORD,,\n"
    entries.append((f"{info}/RECORD", record.encode()))
    with zipfile.ZipFile(directory / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for relative, content in entries:
            entry = zipfile.ZipInfo(relative, ARCHIVE_DATE)
            entry.external_attr = (0o100755 if relative in programs else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return name
