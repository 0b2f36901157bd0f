"""The files of a model on this machine, as the server takes them: a model file, a folder, or a text."""

from __future__ import annotations

import base64
import json
import os
from fractions import Fraction
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Union

from .errors import EspalierError

# a model as create() and load() take it: a file, a folder, or a source text
ModelSource = Union[str, "os.PathLike[str]"]

COMPANIONS = (".v", ".e", ".json", ".a", ".map", ".mat")
MOST_BYTES = 32_000_000
# units of a duration, as the server reads them
DAYS_OF = {"s": Fraction(1, 86400), "min": Fraction(1, 1440), "h": Fraction(1, 24), "hour": Fraction(1, 24), "hours": Fraction(1, 24),
           "": Fraction(1), "d": Fraction(1), "day": Fraction(1), "days": Fraction(1), "week": Fraction(7)}


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


def world(files: Mapping[str, str], step_days: Optional[float]) -> Optional[Dict[str, Any]]:
    """The world that the world.json among the files of a whole folder says, with its weather and another step. The server
    refuses what is wrong in it; None: there is neither a file nor a step."""
    text = files.get("world.json")
    try:
        made = {} if text is None else json.loads(text)
    except ValueError as error:
        raise EspalierError(f"'world.json' of the model cannot be read as JSON ({error}): correct it.") from None
    if not isinstance(made, dict):
        raise EspalierError("'world.json' of the model is no JSON object: write one such as {\"stepDuration\": \"1 h\"}.")
    table = made.get("weather")
    if isinstance(table, str) and table:
        if table not in files:
            raise EspalierError(f"'world.json' of the model: there is no table of weather '{table}': check 'weather'.")
        made["weather"] = files[table]
    if step_days is not None:
        made["stepDuration"] = step_days
    return made or None


def step_days(world: Optional[Mapping[str, Any]]) -> Fraction:
    """The days of a step of a world that the server has taken."""
    duration = (world or {}).get("stepDuration", 1)
    if isinstance(duration, str):
        number = duration.rstrip("adehikmnorsuwy ")
        return Fraction(number) * DAYS_OF[duration[len(number):].strip()]
    simple = Fraction(duration).limit_denominator(10_000_000)  # 0.1 stands for 1/10, so that ten steps are a day
    return simple if float(simple) == float(duration) else Fraction(duration)


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
    if main is None and "world.json" in names:
        wanted.append("world.json")
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
