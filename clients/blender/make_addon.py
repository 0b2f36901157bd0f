#!/usr/bin/env python3
"""Writes the add-on for Blender as a file that Blender installs: make_addon.py espalier-blender.zip"""

import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
# the add-on, and inside of it the package that it connects with: Blender takes each folder at the top for an add-on
FOLDERS = ((HERE / "espalier_blender", Path("espalier_blender")),
           (HERE.parent / "python" / "espalier", Path("espalier_blender", "packages", "espalier")))


def make(target: Path) -> None:
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for folder, place in FOLDERS:
            for file in sorted(folder.rglob("*")):
                if file.is_file() and "__pycache__" not in file.parts:
                    # one date for all, so that equal files make an equal archive
                    entry = zipfile.ZipInfo(str(place / file.relative_to(folder)), (1980, 1, 1, 0, 0, 0))
                    entry.compress_type = zipfile.ZIP_DEFLATED
                    archive.writestr(entry, file.read_bytes())


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: make_addon.py FILE.zip")
    make(Path(sys.argv[1]))
