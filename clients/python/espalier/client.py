"""A controller and viewer of a running server.

    with Client("127.0.0.1:4321") as client:
        simulation = client.create(gallery="branch-tiers", seed=7)
        with simulation.stream() as stream:
            while not simulation.step().finished:
                print(len(stream.read().records), "turtle records")
"""

from __future__ import annotations

import base64
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, Deque, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Type, Union

from . import wire
from .blocks import Blocks
from .errors import ConnectionLost, EspalierError, ProtocolError, ServerError
from .hosting import hello_parameters

if TYPE_CHECKING:
    from .viewing import View

Vector = Tuple[float, float, float]
# one process with its configuration, as in {"type": "honda", "radius": 0.5}
Process = Mapping[str, Any]


@dataclass(frozen=True)
class StepResult:
    """What a call of step made."""

    step: int  # completed steps
    finished: bool  # the derivation length is reached or the model stopped itself
    truncated: bool  # fewer steps than asked for were made, although the model is not finished
    saved: bool  # the state is on the server's disk
    statistics: Mapping[str, Any]


@dataclass(frozen=True)
class Model:
    """A model that the server has compiled, or what is wrong with it."""

    model: str  # identifier; empty when the model was only checked
    valid: bool
    derivation_length: int
    diagnostics: Sequence[Mapping[str, Any]]

    def __str__(self) -> str:
        return "\n".join(str(diagnostic.get("text", "")) for diagnostic in self.diagnostics)


@dataclass(frozen=True)
class TurtleRecord:
    """One module of a string and the turtle's state after it."""

    index: int  # among all records of the frame; what `parent` refers to
    plant: int
    module: int  # index in the plant's string
    symbol: str
    parameters: Tuple[float, ...]
    position: Vector
    heading: Vector
    left: Vector
    up: Vector
    width: float
    colour: int
    branch_order: int
    parent: Optional[int]  # None: a root


@dataclass(frozen=True)
class Frame:
    """What a stream says about one step."""

    step: int
    sequence: int
    missed: int  # frames left out since the one before, because this reader was slow
    finished: bool  # the simulation will make no further step
    records: Sequence[TurtleRecord] = ()
    string: str = ""
    statistics: Mapping[str, Any] = field(default_factory=dict)
    count: int = 0  # of records
    # with stream(arrays=True) instead of records: plant, module, symbol (an index in `symbols`), position (count, 3),
    # heading, left, up, width, colour, branchOrder, parent (2^32 - 1: none), parameters and parameterOffset (count + 1)
    columns: Blocks = field(default_factory=dict)
    symbols: Tuple[str, ...] = ()


def _vector(value: Any) -> Vector:
    x, y, z = value
    return (float(x), float(y), float(z))


def read_record(shape: Mapping[str, Any], index: int) -> TurtleRecord:
    """The record of its JSON shape; the index is the place in the list unless the record says another."""
    return TurtleRecord(
        index=int(shape.get("index", index)), plant=int(shape["plant"]), module=int(shape["module"]),
        symbol=str(shape["symbol"]), parameters=tuple(float(value) for value in shape["parameters"]),
        position=_vector(shape["position"]), heading=_vector(shape["heading"]), left=_vector(shape["left"]),
        up=_vector(shape["up"]), width=float(shape["width"]), colour=int(shape["colour"]),
        branch_order=int(shape["branchOrder"]), parent=shape["parent"])


def read_frame(shape: Mapping[str, Any], blocks: Blocks = MappingProxyType({})) -> Frame:
    """The frame of the params of `stream.data`."""
    try:
        return Frame(
            step=int(shape["step"]), sequence=int(shape["sequence"]), missed=int(shape.get("missed", 0)),
            finished=bool(shape.get("finished", False)),
            records=[read_record(record, index) for index, record in enumerate(shape.get("records", []))],
            string=str(shape.get("string", "")), statistics=shape.get("statistics", {}),
            count=int(shape.get("count", len(shape.get("records", [])))), symbols=tuple(shape.get("symbols", ())),
            columns=blocks)
    except (KeyError, TypeError, ValueError) as error:
        raise ProtocolError(f"stream.data: a frame without or with a wrong {error}.") from None


class Client:
    """A connection to a server. Use it as a context manager, from one thread."""

    def __init__(self, address: str, *, name: str = "python", token: Optional[str] = None,
                 timeout: Optional[float] = None, connect_timeout: float = 10.0) -> None:
        """Connects to HOST:PORT, tls://HOST:PORT, unix:PATH, ws://HOST:PORT or wss://HOST:PORT and says hello. `timeout`
        (seconds, None: none) bounds the wait for each answer."""
        self._attach(wire.connect(address, connect_timeout), name, token, timeout)

    @classmethod
    def over(cls, channel: wire.Channel, *, name: str = "python", token: Optional[str] = None,
             timeout: Optional[float] = None) -> "Client":
        """A client on a channel that is connected already."""
        client = cls.__new__(cls)
        client._attach(channel, name, token, timeout)
        return client

    def _attach(self, channel: wire.Channel, name: str, token: Optional[str], timeout: Optional[float]) -> None:
        self._channel = channel
        self._timeout = timeout
        self._next_id = 1
        self._frames: Dict[str, Deque[Frame]] = {}
        self._ended: Dict[str, str] = {}  # why, by stream
        try:
            self.server: Mapping[str, Any] = self.call("hello", hello_parameters(name, "controller", token))
            channel.agree(self.server)
        except BaseException:
            channel.close()
            raise

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection. Simulations stay on the server."""
        self._channel.close()

    # ---- any method --------------------------------------------------------------------------------------------

    def call(self, method: str, parameters: Optional[Mapping[str, Any]] = None) -> Any:
        """Sends a request and returns its result. An error of the server raises ServerError."""
        identifier = self._next_id
        self._next_id += 1
        self._channel.send(wire.request(identifier, method, dict(parameters or {})))
        while True:
            message = self._receive(self._timeout, method)
            if "method" not in message and message.get("id") == identifier:
                return _result_of(message)

    def notify(self, method: str, parameters: Mapping[str, Any]) -> None:
        """Sends a notification: nothing is answered."""
        self._channel.send(wire.notification(method, dict(parameters)))

    def _receive(self, timeout: Optional[float], what: str) -> wire.Received:
        """The next message. A frame is put aside for its stream on the way."""
        try:
            message = self._channel.receive(timeout)
        except TimeoutError:
            raise ConnectionLost(f"{self._channel.peer} did not answer {what} within {timeout:g} seconds.") from None
        if message is None:
            raise ConnectionLost(f"{self._channel.peer} closed the connection while {what} was waited for.")
        if message.get("method") == "stream.data":
            parameters = message.get("params")
            if not isinstance(parameters, dict) or not isinstance(parameters.get("stream"), str):
                raise ProtocolError("stream.data: params.stream: expected a text.")
            # frames of a stream that was closed meanwhile are dropped
            frames = self._frames.get(parameters["stream"])
            if frames is not None:
                frames.append(read_frame(parameters, message.blocks))
        elif message.get("method") == "stream.end" and isinstance(message.get("params"), dict):
            closed = message["params"]
            self._ended[str(closed.get("stream"))] = str(closed.get("reason", "the server closed it"))
        elif message.get("id") is None and "error" in message:
            _result_of(message)
        return message

    # ---- models ------------------------------------------------------------------------------------------------

    def check(self, source: str) -> Model:
        """Compiles a model without keeping it; the diagnostics say what is wrong and where."""
        return _model(self.call("model.check", {"source": source}))

    def load(self, source: Optional[str] = None, *, gallery: Optional[str] = None,
             files: Optional[Mapping[str, str]] = None, main: Optional[str] = None) -> Model:
        """Compiles a model and keeps it on the server, for many simulations."""
        return _model(self.call("model.load", {"model": _reference(source, gallery, files, main, None)}))

    # ---- simulations -------------------------------------------------------------------------------------------

    def create(self, source: Optional[str] = None, *, gallery: Optional[str] = None, loaded: Optional[str] = None,
               files: Optional[Mapping[str, str]] = None, main: Optional[str] = None, seed: Optional[int] = None,
               environment: Optional[Sequence[Process]] = None, name: Optional[str] = None,
               derivation_length: Optional[int] = None, plants: Optional[Sequence[Vector]] = None,
               parameters: Optional[Mapping[str, Any]] = None, limits: Optional[Mapping[str, int]] = None,
               save: bool = True) -> "Simulation":
        """Creates a simulation of a model: its source text, a folder of the gallery, `files` by name with `main`, or what
        load() returned. `environment` lists processes, as in [{"type": "honda", "radius": 0.5}]; one that offered itself
        is {"type": "offered", "name": …}. `parameters` override #define; `plants` are positions."""
        request: Dict[str, Any] = {"model": _reference(source, gallery, files, main, loaded)}
        if environment is not None:
            request["environment"] = [dict(process) for process in environment]
        if plants is not None:
            request["plants"] = [{"position": list(position)} for position in plants]
        if not save:
            request["save"] = False
        optional = {"seed": seed, "name": name, "derivationLength": derivation_length, "parameters": parameters,
                    "limits": limits}
        request.update({key: value for key, value in optional.items() if value is not None})
        created = self.call("simulation.create", request)
        return Simulation(self, str(created["simulation"]), created)

    def simulation(self, identifier: str) -> "Simulation":
        """A simulation that is on the server already."""
        found = self.call("simulation.get", {"simulation": identifier, "what": "information"})
        return Simulation(self, identifier, found["information"])

    def simulations(self) -> List[Mapping[str, Any]]:
        """What the server says about each of its simulations."""
        return list(self.call("simulation.list")["simulations"])

    def environments(self) -> List[Mapping[str, Any]]:
        """The server's built-in processes and those that are offered to it."""
        return list(self.call("environment.list")["environments"])

    def status(self) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self.call("server.status")
        return found


class Simulation:
    """One simulation on the server."""

    def __init__(self, client: Client, identifier: str, created: Mapping[str, Any]) -> None:
        self._client = client
        self.identifier = identifier
        self.created = created  # what the server said when it was created or found
        self.history: List[StepResult] = []  # what the calls of step() made, in order

    def _call(self, method: str, **parameters: Any) -> Any:
        return self._client.call(method, {"simulation": self.identifier, **parameters})

    def step(self, steps: int = 1, *, until: Optional[int] = None) -> StepResult:
        """Makes steps, or as many as are missing to `until` completed steps. When the environment fails, ServerError is
        raised and the simulation stays at its last completed step."""
        made = self._call("simulation.step", **({"steps": steps} if until is None else {"until": until}))
        result = StepResult(int(made["step"]), bool(made["finished"]), bool(made["truncated"]),
                            bool(made.get("saved", False)), made["statistics"])
        self.history.append(result)
        return result

    def steps(self) -> Iterator[StepResult]:
        """Makes one step after the other until the model is finished."""
        while True:
            made = self.step()
            yield made
            if made.finished or made.truncated:
                return

    def get(self, what: str, **parameters: Any) -> Mapping[str, Any]:
        """string, statistics, state-hash, turtle, model or information."""
        found: Mapping[str, Any] = self._call("simulation.get", what=what, **parameters)
        return found

    def string(self, plant: int = 0) -> str:
        """The derived string of a plant."""
        return str(self.get("string", plant=plant)["string"])

    def turtle(self) -> List[TurtleRecord]:
        """The turtle's state at every module, now."""
        return [read_record(record, index) for index, record in enumerate(self.get("turtle")["records"])]

    def save(self) -> bytes:
        """The complete state: the bytes of a snapshot, which `espalier run --resume` reads too."""
        return base64.b64decode(self._call("simulation.save")["snapshot"])

    def save_to(self, path: Union[str, Path]) -> None:
        """Writes a snapshot file."""
        Path(path).write_bytes(self.save())

    def restore(self, snapshot: bytes) -> None:
        """Goes back, or forward, to the state of a snapshot of the same model."""
        self._call("simulation.restore", snapshot=base64.b64encode(snapshot).decode("ascii"))

    def reset(self, seed: Optional[int] = None) -> None:
        """Goes back to step 0, with another seed when one is given."""
        self._call("simulation.reset", **({} if seed is None else {"seed": seed}))

    def delete(self) -> None:
        """Removes the simulation from the server."""
        self._call("simulation.delete")

    def view(self, snapshots: Optional[Sequence[bytes]] = None, *, height: int = 480) -> "View":
        """The plant in a page, which a notebook shows: as it is now, or one frame for each of `snapshots` (what save()
        returned). The program `espalier` on this machine draws it. `height` is that of the notebook's cell, in pixels."""
        from .viewing import View, geometry_of

        states = [self.save()] if snapshots is None else snapshots
        return View(geometry_of(states), str(self.created.get("name", "Espalier")), height)

    def plot(self, *names: str) -> Any:
        """Plots statistics over the steps that step() made (`modules` by default) and returns the axes. Needs matplotlib."""
        try:
            from matplotlib import pyplot  # type: ignore[import]
        except ImportError:
            raise EspalierError("plot() needs matplotlib (Debian: python3-matplotlib). The figures are in `history`.") from None
        axes = pyplot.figure().add_subplot()
        for name in names or ("modules",):
            axes.plot([made.step for made in self.history], [made.statistics[name] for made in self.history], label=name)
        axes.set_xlabel("step")
        axes.legend()
        return axes

    def stream(self, what: str = "turtle", *, every: int = 1, symbols: Optional[Sequence[str]] = None,
               credits: int = 8, arrays: bool = False, single: bool = False) -> "Stream":
        """Opens a stream of frames: turtle, string or statistics. The first frame is the state now. At most `credits`
        frames are under way; a reader that is slower misses frames and never slows the simulation. With `arrays` the turtle's
        records come as columns (Frame.columns: NumPy arrays when NumPy is there), in single precision when `single`."""
        parameters: Dict[str, Any] = {"what": what, "every": every, "credits": credits}
        if symbols is not None:
            parameters["select"] = {"symbols": list(symbols)}
        if arrays:
            parameters.update({"bin": True, "precision": "single" if single else "double"})
        return Stream(self._client, str(self._call("stream.open", **parameters)["stream"]))


class Stream:
    """Frames of a simulation, one for every step. Iterate over it, or read one at a time."""

    def __init__(self, client: Client, identifier: str) -> None:
        self._client = client
        self.identifier = identifier
        self._is_open = True
        client._frames.setdefault(identifier, deque())

    def read(self, timeout: Optional[float] = None) -> Frame:
        """The next frame; waits for it at most `timeout` seconds (None: as long as it takes). It is acknowledged, which
        lets the server send another."""
        if not self._is_open:
            raise EspalierError("The stream is closed.")
        frames = self._client._frames[self.identifier]
        while not frames:
            if self.identifier in self._client._ended:
                raise EspalierError(f"The stream has ended: {self._client._ended[self.identifier]}")
            self._client._receive(timeout, "stream.data")
        frame = frames.popleft()
        self._client.notify("stream.ack", {"stream": self.identifier, "sequence": frame.sequence})
        return frame

    def __iter__(self) -> Iterator[Frame]:
        """Frames until the simulation is finished."""
        while True:
            frame = self.read()
            yield frame
            if frame.finished:
                return

    def close(self) -> None:
        if self._is_open:
            self._is_open = False
            try:
                self._client.call("stream.close", {"stream": self.identifier})
            finally:
                self._client._frames.pop(self.identifier, None)

    def __enter__(self) -> "Stream":
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        # a connection that is lost has no stream to close; the first error is the one to see
        if error is None or not isinstance(error, ConnectionLost):
            self.close()


def _result_of(message: wire.Message) -> Any:
    if "error" not in message:
        return message.get("result")
    error = message["error"]
    if not isinstance(error, dict):
        raise ProtocolError("error: expected an object.")
    raise ServerError(int(error.get("code", 0)), str(error.get("message", "")), error.get("data"))


def _reference(source: Optional[str], gallery: Optional[str], files: Optional[Mapping[str, str]], main: Optional[str],
               loaded: Optional[str]) -> Dict[str, Any]:
    given: Dict[str, Any] = {"source": source, "gallery": gallery, "loaded": loaded}
    if files is not None:
        given["files"] = dict(files)
        given["main"] = main
    chosen = {key: value for key, value in given.items() if value is not None}
    if len(chosen) - (1 if "main" in chosen else 0) != 1:
        raise EspalierError("Give a model in exactly one way: its source text, gallery=…, files=… with main=…, or loaded=….")
    return chosen


def _model(shape: Mapping[str, Any]) -> Model:
    return Model(str(shape.get("model", "")), bool(shape["valid"]), int(shape.get("derivationLength", 0)),
                 shape.get("diagnostics", []))
