"""The files of a model on this machine, as the server takes them: a model file, a folder, or a text."""

from __future__ import annotations

import base64
import os
from pathlib import Path
from typing import Any, Dict, List, Optional, Union

from .errors import EspalierError

# a model as create() and load() take it: a file, a folder, or a source text
ModelSource = Union[str, "os.PathLike[str]"]

COMPANIONS = (".v", ".e", ".json", ".a", ".map", ".mat")
MOST_BYTES = 32_000_000


def reference(model: ModelSource) -> Dict[str, Any]:
    """The member `model` of a request: `{"source": TEXT}`, or the files of a file or folder."""
    if isinstance(model, str) and "\n" in model:
        return {"source": model}
    path = Path(model)
    if path.is_dir():
        return _files(path, None)
    if path.is_file():
        return _files(path.parent, path.name)
    if isinstance(model, str) and ":" in model and not model.endswith(".l"):
        return {"source": model}
    raise EspalierError(f"There is no model file or folder '{model}' (the working folder is {Path.cwd()}). A model of the "
                        "gallery is create(gallery=…), a source text has several lines.")


def _names(folder: Path) -> List[str]:
    """The files of a folder and of its subfolders, relative to it; not those of a folder that is no model's."""
    found = [path.name for path in folder.iterdir() if path.is_file()]
    for inner in folder.iterdir():
        if inner.is_dir() and not inner.name.startswith("."):
            found += [f"{inner.name}/{path.name}" for path in inner.iterdir() if path.is_file()]
    return sorted(name for name in found if not name.startswith("."))


def _files(folder: Path, main: Optional[str]) -> Dict[str, Any]:
    """The model with the files that it names, directly or through other files."""
    names = _names(folder)
    if main is not None:
        wanted = [main] + [str(Path(main).with_suffix(suffix)) for suffix in COMPANIONS]
    elif "specifications" in names:
        wanted = ["specifications"]
    else:
        wanted = [name for name in names if "/" not in name and Path(name).suffix in (".l", *COMPANIONS)]
    contents: Dict[str, bytes] = {}
    total = 0
    while wanted:
        name = wanted.pop()
        if name in contents or name not in names:
            continue
        contents[name] = (folder / name).read_bytes()
        total += len(contents[name])
        if total > MOST_BYTES:
            raise EspalierError(f"The model '{folder}' has more than {MOST_BYTES // 1_000_000} MB of files, and a message cannot "
                                "hold them. Name the file of the model, or put the model into a folder of its own.")
        text = contents[name].decode("utf-8", "replace")
        wanted += [other for other in names if other not in contents and os.path.basename(other) in text]
    texts: Dict[str, str] = {}
    binary: Dict[str, str] = {}
    for name, content in contents.items():
        try:
            if b"\0" in content:
                raise ValueError
            texts[name] = content.decode("utf-8")
        except ValueError:
            binary[name] = base64.b64encode(content).decode("ascii")
    made: Dict[str, Any] = {"files": texts}
    if binary:
        made["binaryFiles"] = binary
    if main is not None:
        made["main"] = main
    return made
