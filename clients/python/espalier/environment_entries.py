"""The `environment` of create(), as the list of entries that the protocol has."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Type, Union

from .environment_process import EnvironmentProcess
from .errors import EspalierError

# one process with its configuration, as in {"type": "honda", "radius": 0.5}
Process = Mapping[str, Any]
# a name, a configuration, a class or an object of this program, or a list of them
OneEnvironment = Union[str, Process, Type[EnvironmentProcess], EnvironmentProcess]
Environments = Union[OneEnvironment, Sequence[OneEnvironment]]
Attach = Callable[[Any], Mapping[str, Any]]


def entries(environment: Optional[Environments], attach: Optional[Attach] = None) -> Optional[List[Dict[str, Any]]]:
    """The list of entries; None: the model decides. `attach` runs an environment of this program and returns its entry."""
    if environment is None:
        return None
    listed: Sequence[Any] = environment if isinstance(environment, (list, tuple)) else [environment]
    made: List[Dict[str, Any]] = []
    for one in listed:
        made += _entry(one, attach)
    return made


def _entry(one: OneEnvironment, attach: Optional[Attach]) -> List[Dict[str, Any]]:
    if isinstance(one, Mapping):
        return [dict(one)]
    if isinstance(one, EnvironmentProcess) or (isinstance(one, type) and issubclass(one, EnvironmentProcess)):
        if attach is None:
            name = one.name()
            raise EspalierError(f"Only espalier.local() runs the environment '{name}' of this program. Here start it with "
                                f"--offer ADDRESS, and name it: {{'type': 'offered', 'name': '{name}'}}.")
        return [dict(attach(one))]
    if not isinstance(one, str):
        raise EspalierError(f"{one!r} is no environment. Give a name ('honda'), a configuration ({{'type': 'honda', 'radius': "
                            "0.5}), a class or an object of Environment, or a list of them.")
    return _named(one)


def _named(text: str) -> List[Dict[str, Any]]:
    """The entries of a text: a file, an address, or the name of a built-in process."""
    if text.endswith((".json", ".e")):
        path = Path(text)
        if not path.is_file():
            raise EspalierError(f"There is no environment file '{text}' (the working folder is {Path.cwd()}).")
        if text.endswith(".json"):
            try:
                read = json.loads(path.read_text(encoding="utf-8"))
            except json.JSONDecodeError as error:
                raise EspalierError(f"{text}:{error.lineno}:{error.colno}: the environment is not valid JSON: {error.msg}.") from None
            return [dict(entry) for entry in (read if isinstance(read, list) else [read])]
        # with the files that it names
        content = path.read_text(encoding="utf-8", errors="replace")
        files = {path.name: content}
        for other in path.parent.iterdir():
            if other.is_file() and other != path and other.name in content:
                files[other.name] = other.read_text(encoding="utf-8", errors="replace")
        return [{"type": "field", "main": path.name, "files": files}]
    for prefix, kind, member in (("tcp://", "tcp", "address"), ("stdio:", "stdio", "command"),
                                 ("offered:", "offered", "name")):
        if text.startswith(prefix):
            return [{"type": kind, member: text[len(prefix):]}]
    starter = "python3 " if text.endswith(".py") else "Rscript " if text.endswith(".R") else ""
    if starter or " " in text:
        starter = "" if " " in text else starter
        own = " Or give its class." if text.endswith(".py") else ""
        raise EspalierError(f"'{text}' is a program, not the name of an environment: 'stdio:{starter}{text}' lets the server start it.{own}")
    return [{"type": text}]
