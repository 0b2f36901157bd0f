"""The requests of a client: method, parameters, and how the answer is read.

The blocking client and the one for asyncio differ only in how they wait, so everything else is here.
"""

from __future__ import annotations

import base64
from collections import deque
from dataclasses import dataclass
from typing import Any, Callable, Deque, Dict, Generic, List, Mapping, Optional, Sequence, Tuple, TypeVar, Union

from . import geometry, wire
from .environment_entries import Process
from .errors import EspalierError, ProtocolError, ServerError
from .frames import read_next
from .model_folder import ModelSource, reference
from .shapes import CompiledModel, Frame, StepResult, TurtleRecord, Vector, read_model, read_record, read_step

Result = TypeVar("Result")
# a module to be put into a string: its symbol and parameters, as in ("F", 1.5)
NewModule = Union[str, Sequence[Any]]


@dataclass(frozen=True)
class Request(Generic[Result]):
    """A request and how its result is read."""

    method: str
    parameters: Dict[str, Any]
    read: Callable[[Any], Result]


def result_of(message: wire.Message) -> Any:
    """The result of a response; an error of the server raises ServerError."""
    if "error" not in message:
        return message.get("result")
    error = message["error"]
    if not isinstance(error, dict):
        raise ProtocolError("error: expected an object.")
    code = error.get("code", 0)
    if not isinstance(code, int):
        raise ProtocolError("error.code: expected a whole number.")
    raise ServerError(code, str(error.get("message", "")), error.get("data"))


class Inbox:
    """Frames of the streams that are open, until they are read."""

    def __init__(self) -> None:
        self.frames: Dict[str, Deque[Frame]] = {}
        self.latest: Dict[str, Frame] = {}  # the base of the next difference of a stream
        self.ended: Dict[str, str] = {}  # why, by stream

    def open(self, stream: str) -> None:
        self.frames.setdefault(stream, deque())

    def close(self, stream: str) -> None:
        self.frames.pop(stream, None)
        self.latest.pop(stream, None)
        self.ended.pop(stream, None)

    def take(self, message: wire.Received) -> None:
        """Keeps a frame for its stream. An error without a request raises ServerError."""
        if message.get("method") == "stream.data":
            parameters = message.get("params")
            if not isinstance(parameters, dict) or not isinstance(parameters.get("stream"), str):
                raise ProtocolError("stream.data: params.stream: expected a text.")
            # frames of a stream that was closed meanwhile are dropped
            frames = self.frames.get(parameters["stream"])
            if frames is not None:
                frame = read_next(self.latest.get(parameters["stream"]), parameters, message.blocks)
                self.latest[parameters["stream"]] = frame
                frames.append(frame)
        elif message.get("method") == "stream.end" and isinstance(message.get("params"), dict):
            ended = message["params"]
            self.ended[str(ended.get("stream"))] = str(ended.get("reason", "the server closed it"))
        elif message.get("id") is None and "error" in message:
            result_of(message)

    def has(self, stream: str) -> bool:
        """Whether next() returns or raises at once."""
        return bool(self.frames.get(stream, True)) or stream in self.ended

    def next(self, stream: str) -> Optional[Frame]:
        """The oldest unread frame, or None. A stream that has ended raises EspalierError."""
        frames = self.frames.get(stream)
        if frames is None:
            raise EspalierError("The stream is closed.")
        if frames:
            return frames.popleft()
        if stream in self.ended:
            raise EspalierError(f"The stream has ended: {self.ended[stream]}")
        return None


# ---- models and the server ------------------------------------------------------------------------------------------


def check(source: str) -> Request[CompiledModel]:
    return Request("model.check", {"source": source}, read_model)


def load(source: Optional[ModelSource], gallery: Optional[str], files: Optional[Mapping[str, str]],
         main: Optional[str]) -> Request[CompiledModel]:
    return Request("model.load", {"model": _reference(source, gallery, files, main, None)}, read_model)


def create(source: Optional[ModelSource], *, gallery: Optional[str], loaded: Optional[str], files: Optional[Mapping[str, str]],
           main: Optional[str], environment: Optional[Sequence[Process]], plants: Optional[Sequence[Vector]], save: bool,
           **optional: Any) -> Request[Mapping[str, Any]]:
    parameters: Dict[str, Any] = {"model": _reference(source, gallery, files, main, loaded)}
    if environment is not None:
        parameters["environment"] = [dict(process) for process in environment]
    if plants is not None:
        parameters["plants"] = [{"position": list(position)} for position in plants]
    if not save:
        parameters["save"] = False
    parameters.update({key: value for key, value in optional.items() if value is not None})
    return Request("simulation.create", parameters, _created)


def create_forest(models: Sequence[Mapping[str, Any]], plants: Sequence[Mapping[str, Any]],
                  **optional: Any) -> Request[Mapping[str, Any]]:
    parameters: Dict[str, Any] = {"models": [dict(model) for model in models], "plants": [dict(plant) for plant in plants]}
    parameters.update({key: value for key, value in optional.items() if value is not None})
    return Request("simulation.create", parameters, _created)


def information(simulation: str) -> Request[Mapping[str, Any]]:
    return Request("simulation.get", {"simulation": simulation, "what": "information"}, _information)


def gallery() -> Request[List[str]]:
    return Request("model.list", {}, lambda result: list(result["gallery"]))


def simulations() -> Request[List[Mapping[str, Any]]]:
    return Request("simulation.list", {}, lambda result: list(result["simulations"]))


def environments() -> Request[List[Mapping[str, Any]]]:
    return Request("environment.list", {}, lambda result: list(result["environments"]))


def status() -> Request[Mapping[str, Any]]:
    return Request("server.status", {}, _as_it_is)


# ---- one simulation -------------------------------------------------------------------------------------------------


def step(simulation: str, steps: int, until: Optional[int]) -> Request[StepResult]:
    wanted = {"steps": steps} if until is None else {"until": until}
    return Request("simulation.step", {"simulation": simulation, **wanted}, read_step)


def run(simulation: str) -> Request[StepResult]:
    return Request("simulation.run", {"simulation": simulation}, read_step)


def pause(simulation: str) -> Request[int]:
    return Request("simulation.pause", {"simulation": simulation}, lambda result: int(result["paused"]))


def get(simulation: str, what: str, parameters: Mapping[str, Any]) -> Request[Mapping[str, Any]]:
    return Request("simulation.get", {"simulation": simulation, "what": what, **parameters}, _as_it_is)


def string(simulation: str, plant: int) -> Request[str]:
    return Request("simulation.get", {"simulation": simulation, "what": "string", "plant": plant},
                   lambda result: str(result["string"]))


def turtle(simulation: str) -> Request[List[TurtleRecord]]:
    return Request("simulation.get", {"simulation": simulation, "what": "turtle"},
                   lambda result: [read_record(record, index) for index, record in enumerate(result["records"])])


def set_parameters(simulation: str, parameters: Mapping[str, Any]) -> Request[None]:
    return Request("simulation.set", {"simulation": simulation, "parameters": dict(parameters)}, _nothing)


def edit(simulation: str, action: str, module: int, modules: Sequence[NewModule], plant: int) -> Request[None]:
    parameters: Dict[str, Any] = {"simulation": simulation, "plant": plant, "module": module, "action": action}
    if action != "prune":
        parameters["modules"] = [_module(item) for item in modules]
    return Request("simulation.edit", parameters, _nothing)


def save(simulation: str) -> Request[bytes]:
    return Request("simulation.save", {"simulation": simulation}, lambda result: base64.b64decode(result["snapshot"]))


def save_checkpoint(simulation: str, name: str) -> Request[None]:
    return Request("simulation.save", {"simulation": simulation, "checkpoint": name}, _nothing)


def checkpoints(simulation: str) -> Request[List[Mapping[str, Any]]]:
    return Request("simulation.get", {"simulation": simulation, "what": "checkpoints"},
                   lambda result: list(result["checkpoints"]))


def restore(simulation: str, snapshot: Optional[bytes], checkpoint: Optional[str]) -> Request[None]:
    if (snapshot is None) == (checkpoint is None):
        raise EspalierError("Give either a snapshot (the result of save()) or checkpoint=… (the name for checkpoint()).")
    where = ({"checkpoint": checkpoint} if snapshot is None else
             {"snapshot": base64.b64encode(snapshot).decode("ascii")})
    return Request("simulation.restore", {"simulation": simulation, **where}, _nothing)


def reset(simulation: str, seed: Optional[int]) -> Request[None]:
    chosen = {} if seed is None else {"seed": seed}
    return Request("simulation.reset", {"simulation": simulation, **chosen}, _nothing)


def fork(simulation: str, name: Optional[str]) -> Request[Mapping[str, Any]]:
    chosen = {} if name is None else {"name": name}
    return Request("simulation.fork", {"simulation": simulation, **chosen}, _created)


def delete(simulation: str) -> Request[None]:
    return Request("simulation.delete", {"simulation": simulation}, _nothing)


def open_stream(simulation: str, what: str, every: int, symbols: Optional[Sequence[str]], credits: Optional[int],
                arrays: bool, single: bool, delta: bool, max_hz: Optional[float], columns: bool) -> Request[str]:
    parameters: Dict[str, Any] = {"simulation": simulation, "what": what, "every": every,
                                  "delta": delta, "precision": "single" if single else "double"}
    if columns:
        parameters["format"] = "columns"
        # NumPy assembles differences
        parameters["delta"] = delta and geometry.form() == "difference"
    if credits is not None:
        parameters["credits"] = credits
    if max_hz is not None:
        parameters["maxHz"] = max_hz
    if symbols is not None:
        parameters["select"] = {"symbols": list(symbols)}
    if arrays:
        parameters["bin"] = True
    return Request("stream.open", parameters, lambda result: str(result["stream"]))


def close_stream(stream: str) -> Request[None]:
    return Request("stream.close", {"stream": stream}, _nothing)


def acknowledgement(stream: str, frame: Frame) -> Tuple[str, Dict[str, Any]]:
    """Method and parameters of the notification that lets the server send another frame."""
    return "stream.ack", {"stream": stream, "sequence": frame.sequence}


# ---- reading and writing shapes -------------------------------------------------------------------------------------


def _nothing(_: Any) -> None:
    return None


def _as_it_is(result: Any) -> Mapping[str, Any]:
    return dict(result)


def _created(result: Any) -> Mapping[str, Any]:
    if not isinstance(result, dict) or not isinstance(result.get("simulation"), str):
        raise ProtocolError("result.simulation: expected a text.")
    return result


def _information(result: Any) -> Mapping[str, Any]:
    return dict(result["information"])


def _module(given: NewModule) -> Dict[str, Any]:
    """A module as the protocol writes it: "A" or ("F", 1.5)."""
    if isinstance(given, str):
        return {"symbol": given, "parameters": []}
    if not isinstance(given, (list, tuple)) or not given or not isinstance(given[0], str):
        raise EspalierError(f"{given!r} is not a module. Write its symbol and then its parameters, as in ('F', 1.5).")
    return {"symbol": given[0], "parameters": [float(value) for value in given[1:]]}


def _reference(source: Optional[ModelSource], gallery: Optional[str], files: Optional[Mapping[str, str]], main: Optional[str],
               loaded: Optional[str]) -> Dict[str, Any]:
    given: Dict[str, Any] = {"gallery": gallery, "loaded": loaded}
    if files is not None:
        given["files"] = dict(files)
        given["main"] = main
    chosen = {key: value for key, value in given.items() if value is not None}
    if len(chosen) - (1 if "main" in chosen else 0) + (0 if source is None else 1) != 1:
        raise EspalierError("Give a model in exactly one way: a file, folder or source text, gallery=…, files=… with main=…, or "
                            "loaded=….")
    return chosen if source is None else reference(source)
