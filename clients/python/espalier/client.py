"""A controller and viewer of a running server with blocking calls. asynchronous.py has the same for asyncio.

    with Client("127.0.0.1:4321") as client:
        simulation = client.create(gallery="branch-tiers", seed=7)
        with simulation.stream() as stream:
            while not simulation.step().finished:
                print(len(stream.read().records), "turtle records")

The tests run the examples below. There `client` is the result of `espalier.local()`.
"""

from __future__ import annotations

import itertools
import threading
from pathlib import Path
from types import TracebackType
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Set, Type, Union

from . import requests, tables, wire
from .environment_entries import Environments, entries
from .model_folder import ModelSource
from .connecting import connect
from .errors import ConnectionLost, EspalierError, warn_about, warn_of_run
from .hosting import CLIENT_ROLES, hello_parameters, require_server
from .plotting import plotted
from .requests import Inbox, NewModule, Request, Result, result_of
from .shapes import CompiledModel, Frame, StepResult, TurtleRecord, Vector, step_of
from .viewing import View, geometry_of, refuse_drawing


class Client:
    """A connection to a server. Use it as a context manager. Several threads may use one client: calls of different threads
    run at the same time, so that one thread can pause what another one runs.

    >>> client                                             # doctest: +ELLIPSIS
    <Local: ...>

    A refused request raises ServerError with `code`, `message` and `data`. A lost connection, or no answer in time, raises
    ConnectionLost. An interrupt (Ctrl-C, or the stop button of a notebook) during a call cancels the call on the server:
    the simulation stays at its last completed step.
    """

    def __init__(self, address: str, *, name: str = "python", token: Optional[str] = None,
                 timeout: Optional[float] = None, connect_timeout: float = 10.0) -> None:
        """Connects to HOST:PORT, tls://HOST:PORT, unix:PATH, ws://HOST:PORT or wss://HOST:PORT and says hello. `timeout`
        (seconds, None: none) bounds the wait for each answer."""
        self._attach(connect(address, connect_timeout), name, token, timeout)

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
        self._ids = itertools.count(1)
        self._inbox = Inbox()
        self._sending = threading.Lock()
        # one waiting thread receives for all of them
        self._arrived = threading.Condition()
        self._is_receiving = False
        self._answers: Dict[int, wire.Message] = {}  # that other threads wait for
        self._waiting: Set[int] = set()
        try:
            self.server: Mapping[str, Any] = self.call("hello", hello_parameters(name, CLIENT_ROLES, token))
            require_server(self.server, channel.peer)
            channel.agree(self.server)
        except BaseException:
            channel.close()
            raise

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self._channel.peer}>"

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection. Simulations stay on the server."""
        self._channel.close()

    # ---- any method --------------------------------------------------------------------------------------------

    def call(self, method: str, parameters: Optional[Mapping[str, Any]] = None, *,
             seconds: Optional[float] = None) -> Any:
        """Sends a request of protocol/README.md and returns its result. After `seconds` (None: never) the client asks the
        server to cancel it: ServerError 1010, and the simulation stays at its last completed step.

        >>> client.call("server.status")["protocol"]
        1
        """
        identifier = self._start(method, parameters or {})
        if seconds is None:
            return self._wait_for(identifier, method)
        timer = threading.Timer(seconds, self.notify, ("$/cancel", {"id": identifier}))
        timer.start()
        try:
            return self._wait_for(identifier, method)
        finally:
            timer.cancel()

    def notify(self, method: str, parameters: Mapping[str, Any]) -> None:
        """Sends a notification: nothing is answered."""
        with self._sending:
            self._channel.send(wire.notification(method, dict(parameters)))

    def _do(self, request: Request[Result]) -> Result:
        return request.read(self.call(request.method, request.parameters))

    def _start(self, method: str, parameters: Mapping[str, Any]) -> int:
        """Sends a request; the number by which its answer is known."""
        identifier = next(self._ids)
        self._waiting.add(identifier)
        with self._sending:
            self._channel.send(wire.request(identifier, method, dict(parameters)))
        return identifier

    def _wait_for(self, identifier: int, method: str, meanwhile: Callable[[], None] = lambda: None) -> Any:
        """The result of a request that was sent; `meanwhile` is called before each message."""
        try:
            while identifier not in self._answers:
                meanwhile()
                self._receive(self._timeout, method, lambda: identifier in self._answers)
        except EspalierError:
            raise
        except BaseException:
            # an interrupt or an exception of `meanwhile`: the client no longer waits
            self.notify("$/cancel", {"id": identifier})
            raise
        finally:
            self._waiting.discard(identifier)
        return result_of(self._answers.pop(identifier))

    def _receive(self, timeout: Optional[float], what: str, is_there: Callable[[], bool] = lambda: False) -> None:
        """Waits until a message has arrived, here or in another thread, or `is_there`. Keeps answers and frames for those
        that wait for them."""
        with self._arrived:
            if is_there():
                return
            if self._is_receiving:
                if not self._arrived.wait(timeout):
                    raise self._too_late(timeout, what)
                return
            self._is_receiving = True
        try:
            message = self._channel.receive(timeout)
            if message is None:
                raise ConnectionLost(f"{self._channel.peer} closed the connection before it answered {what}.")
            identifier = message.get("id")
            if "method" not in message and identifier in self._waiting:
                self._answers[identifier] = message
            else:
                self._inbox.take(message)
        except TimeoutError:
            raise self._too_late(timeout, what) from None
        finally:
            with self._arrived:
                self._is_receiving = False
                self._arrived.notify_all()

    def _too_late(self, timeout: Optional[float], what: str) -> ConnectionLost:
        return ConnectionLost(f"{self._channel.peer} did not answer {what} within {timeout or 0:g} seconds.")

    # ---- models ------------------------------------------------------------------------------------------------

    def check(self, source: str) -> CompiledModel:
        """Compiles a model without keeping it. The diagnostics name every error with its place.

        >>> wrong = client.check("Lsystem: 1")
        >>> wrong.valid, len(wrong.diagnostics) > 0
        (False, True)
        """
        return self._do(requests.check(source))

    def load(self, source: Optional[ModelSource] = None, *, gallery: Optional[str] = None,
             files: Optional[Mapping[str, str]] = None, main: Optional[str] = None) -> CompiledModel:
        """Compiles a model and keeps it on the server, for many simulations: `create(loaded=model.model)`.

        >>> client.load(gallery="classic-algae").valid
        True
        """
        return self._do(requests.load(source, gallery, files, main))

    # ---- simulations -------------------------------------------------------------------------------------------

    def create(self, source: Optional[ModelSource] = None, *, gallery: Optional[str] = None, loaded: Optional[str] = None,
               files: Optional[Mapping[str, str]] = None, main: Optional[str] = None, seed: Optional[int] = None,
               environment: Optional[Environments] = None, name: Optional[str] = None,
               derivation_length: Optional[int] = None, plants: Optional[Sequence[Vector]] = None,
               parameters: Optional[Mapping[str, Any]] = None, limits: Optional[Mapping[str, int]] = None,
               save: bool = True, world: Optional[Mapping[str, Any]] = None,
               simulation: Optional[str] = None) -> "Simulation":
        """Creates a simulation of a model. The model is a file ("tree.l"), a folder, a source text, a model of the gallery,
        `files` by name with `main`, or a result of load(). Files go to the server with the files that they name.

        `environment` is a name ("honda"), a configuration ({"type": "honda", "radius": 0.5}), a class or an object of
        Environment (of a client that local() made), a file (.json, .e), or a list of them. `parameters` override #define.
        `plants` are positions (x, y, z) in the unit of the model, with a plant at each. A model with errors raises ServerError with all `diagnostics`.

        `world` has `lengthUnit`, `up`, `north`, `stepDuration` (days, or a text such as "1 h"), `latitude`, `longitude`,
        `start`, `baseTemperature` and `weather` (the text of a table).

        `simulation` is the identifier of a simulation whose place the new one takes: its viewers go on with it.

        >>> client.create(gallery="branch-tiers", environment={"type": "honda", "radius": 0.5}, seed=7).step().step
        1
        >>> client.create("Lsystem: 1\\nderivation length: 3\\nAxiom: A\\nA --> AB\\nendlsystem\\n").step(3).statistics["modules"]
        4
        """
        created = self._do(requests.create(
            source, gallery=gallery, loaded=loaded, files=files, main=main,
            environment=entries(environment, getattr(self, "_offer", None)), plants=plants, save=save, seed=seed, name=name,
            derivationLength=derivation_length, parameters=parameters, limits=limits,
            world=world, simulation=simulation))
        warn_about(created)
        return Simulation(self, str(created["simulation"]), created)

    def create_forest(self, models: Sequence[Mapping[str, Any]], plants: Sequence[Mapping[str, Any]], *,
                      seeds: Optional[Mapping[str, Any]] = None, environment: Optional[Environments] = None,
                      seed: Optional[int] = None, name: Optional[str] = None,
                      derivation_length: Optional[int] = None,
                      world: Optional[Mapping[str, Any]] = None) -> "Simulation":
        """Creates a simulation of plants of several models in one environment. A model has a `name` and a `source`,
        `gallery` or `files` with `main`; a plant a `position`, and a `model` by name (the first), `heading`, `turn`.
        `seeds` says where the seeds that plants drop take root: `maximumPlants`, `spacing`, `ground`, `area`.

        >>> stand = client.create_forest([{"name": "algae", "gallery": "classic-algae"}],
        ...                              [{"position": [0, 0, 0]}, {"position": [1, 0, 0]}])
        >>> stand.step(3).statistics["plants"]
        2
        """
        created = self._do(requests.create_forest(models, plants, seeds=seeds,
                                                  environment=entries(environment, getattr(self, "_offer", None)),
                                                  seed=seed, name=name, derivationLength=derivation_length, world=world))
        warn_about(created)
        return Simulation(self, str(created["simulation"]), created)

    def simulation(self, identifier: str) -> "Simulation":
        """An existing simulation of the server. ServerError with the code 1011: the simulation does not exist."""
        return Simulation(self, identifier, self._do(requests.information(identifier)))

    def gallery(self) -> List[str]:
        """The names of the models in the server's gallery.

        >>> "light-tree" in client.gallery()
        True
        """
        return self._do(requests.gallery())

    def simulations(self) -> List[Mapping[str, Any]]:
        """A description of each simulation of the server."""
        return self._do(requests.simulations())

    def environments(self) -> List[Mapping[str, Any]]:
        """The built-in and the offered environment processes of the server.

        >>> "honda" in [process["name"] for process in client.environments()]
        True
        """
        return self._do(requests.environments())

    def status(self) -> Mapping[str, Any]:
        """The load and the contents of the server."""
        return self._do(requests.status())


class Simulation:
    """One simulation on the server. Its methods return when the server has finished the request. A failed call changes
    nothing; of several steps, those before the failure remain.

    >>> algae = client.create(gallery="classic-algae")
    >>> algae.step(4).step, algae.string()
    (4, 'abaababa')
    """

    def __init__(self, client: Client, identifier: str, created: Mapping[str, Any]) -> None:
        self._client = client
        self.identifier = identifier
        self.created = created  # the answer of the server when the simulation was created or found
        self.history: List[StepResult] = []  # results of step() and run(), in order

    def __repr__(self) -> str:
        step = self.history[-1].step if self.history else self.created.get("step", 0)
        name = self.created.get("name")
        return f"<{type(self).__name__} {self.identifier}{f' {name!r}' if name else ''}: step {step} when last seen>"

    def _do(self, request: Request[Result]) -> Result:
        return self._client._do(request)

    def step(self, steps: int = 1, *, until: Optional[int] = None) -> StepResult:
        """Makes `steps` steps, or all steps up to step `until`. A failure of the environment raises ServerError, and the
        simulation stays at its last completed step. The same call continues when the environment works again."""
        made = self._do(requests.step(self.identifier, steps, until))
        self.history.append(made)
        warn_of_run(made.warnings)
        return made

    def steps(self) -> Iterator[StepResult]:
        """Makes one step after the other until the model is finished.

        >>> [made.step for made in client.create(gallery="growth-to-a-height", environment=[{"type": "height"}]).steps()]
        [1, 2, 3]
        """
        while True:
            made = self.step()
            yield made
            if made.finished or made.truncated:
                return

    def run(self, progress: Optional[Callable[[Frame], None]] = None) -> StepResult:
        """Makes all steps until the model is finished. `progress` receives a statistics frame (`step`, `statistics`) of the
        state now and of each step; a slow function misses frames. An exception of `progress` ends the run between two
        steps and is raised here. With `progress` the `history` has every step, else one entry for the whole run.

        >>> algae = client.create(gallery="classic-algae", derivation_length=5)
        >>> algae.run(lambda frame: None).step
        5
        """
        request = requests.run(self.identifier)
        if progress is None:
            made = self._do(request)
            self.history.append(made)
            warn_of_run(made.warnings)
            return made
        report = progress
        with self.stream("statistics", credits=None) as stream:
            first = stream.read()
            report(first)
            shown = first.step

            def show() -> None:
                nonlocal shown
                frame = stream.poll()
                while frame is not None:
                    report(frame)
                    self.history.append(step_of(frame))
                    shown = frame.step
                    frame = stream.poll()

            started = self._client._start(request.method, request.parameters)
            made = request.read(self._client._wait_for(started, request.method, show))
            show()
            while shown < made.step:
                self._client._receive(self._client._timeout, "stream.data")
                show()
        warn_of_run(made.warnings)
        return made

    def pause(self) -> int:
        """Ends all calls that step the simulation (also of other clients) between two steps. Returns the number of calls."""
        return self._do(requests.pause(self.identifier))

    def get(self, what: str, **parameters: Any) -> Mapping[str, Any]:
        """One part of the state as in the protocol: string, statistics, state-hash, turtle, model, information, checkpoints.

        >>> client.create(gallery="classic-algae").get("statistics")["statistics"]["modules"]
        1
        """
        return self._do(requests.get(self.identifier, what, parameters))

    def string(self, plant: int = 0) -> str:
        """The derived string of a plant."""
        return self._do(requests.string(self.identifier, plant))

    def turtle(self) -> List[TurtleRecord]:
        """The turtle's state at every module, now. stream(arrays=True) gives the same as arrays, for big plants."""
        return self._do(requests.turtle(self.identifier))

    def set(self, parameters: Mapping[str, Union[float, str]]) -> None:
        """Sets variables of the model, or names from #define, for the next steps. One call sets either variables or names.

        >>> tiers = client.create(gallery="branch-tiers", environment=[{"type": "honda", "radius": 0.5}])
        >>> tiers.set({"ALPHA2": 30})
        """
        self._do(requests.set_parameters(self.identifier, parameters))

    def prune(self, module: int, plant: int = 0) -> None:
        """Removes a module and everything that it carries. `module` is the index in the string, as TurtleRecord.module.

        >>> algae = client.create(gallery="classic-algae")
        >>> algae.step(3).step, algae.string()
        (3, 'abaab')
        >>> algae.prune(2)
        >>> algae.string()
        'ab'
        """
        self._do(requests.edit(self.identifier, "prune", module, (), plant))

    def insert(self, module: int, modules: Sequence[NewModule], plant: int = 0) -> None:
        """Inserts modules before a module: a rotation there bends the shoot. Each is a symbol or (symbol, parameter…) of a
        type that the model has.

        >>> weed = client.create(gallery="classic-weed")
        >>> weed.insert(0, ["[", "+", "F", "]"])
        >>> weed.string()
        '[+F]F'
        """
        self._do(requests.edit(self.identifier, "insert", module, modules, plant))

    def replace(self, module: int, modules: Sequence[NewModule], plant: int = 0) -> None:
        """Replaces one module by modules."""
        self._do(requests.edit(self.identifier, "replace", module, modules, plant))

    def save(self) -> bytes:
        """The complete state as the bytes of a snapshot. `espalier run --resume` reads it too."""
        return self._do(requests.save(self.identifier))

    def save_to(self, path: Union[str, Path]) -> None:
        """Writes a snapshot file, `NAME.snapshot`. The name of a picture, a mesh or a page is a ValueError that says what
        writes one."""
        refuse_drawing(Path(path))
        Path(path).write_bytes(self.save())

    def checkpoint(self, name: str) -> None:
        """Keeps the complete state on the server's disk under a name. Needs a server with a data folder (--data)."""
        self._do(requests.save_checkpoint(self.identifier, name))

    def checkpoints(self) -> List[Mapping[str, Any]]:
        """The checkpoints of the simulation, each with `checkpoint` (the name), `step` and `bytes`."""
        return self._do(requests.checkpoints(self.identifier))

    def restore(self, snapshot: Optional[bytes] = None, *, checkpoint: Optional[str] = None) -> None:
        """Restores the state of a snapshot of the same model, or of a checkpoint of the server.

        >>> algae = client.create(gallery="classic-algae")
        >>> start = algae.save()
        >>> algae.step(5).step
        5
        >>> algae.restore(start)
        >>> algae.string()
        'a'
        """
        self._do(requests.restore(self.identifier, snapshot, checkpoint))

    def reset(self, seed: Optional[int] = None) -> None:
        """Goes back to step 0, with another seed if given."""
        self._do(requests.reset(self.identifier, seed))

    def fork(self, name: Optional[str] = None) -> "Simulation":
        """A second, independent simulation in the same state.

        >>> algae = client.create(gallery="classic-algae")
        >>> other = algae.fork()
        >>> other.step(2).step, algae.string()
        (2, 'a')
        """
        created = self._do(requests.fork(self.identifier, name))
        return Simulation(self._client, str(created["simulation"]), created)

    def delete(self) -> None:
        """Removes the simulation from the server."""
        self._do(requests.delete(self.identifier))

    def view(self, snapshots: Optional[Sequence[bytes]] = None, *, height: int = 480) -> View:
        """The plant in a page, for a notebook or a file: the present state, or one frame for each of `snapshots` (results of
        save()), which the program `espalier` on this machine draws. `height` of the notebook cell is in pixels."""
        frames = [self.geometry()] if snapshots is None else geometry_of(snapshots)
        return View(frames, str(self.created.get("name", "Espalier")), height)

    def geometry(self) -> bytes:
        """The present drawing of the plants with the materials of the model: a binary glTF file (.glb).

        >>> client.create(gallery="classic-weed").geometry()[:4]
        b'glTF'
        """
        with self.stream("geometry", arrays=True, credits=1) as stream:
            return bytes(stream.read().columns["glb"])

    def plot(self, *names: str, by: Optional[str] = None) -> Any:
        """Plots columns and returns the axes (needs matplotlib). A statistic (`modules` by default, `queries`, `bytes`, …)
        is plotted over the steps in `history`, or over the statistic `by`. A column of the turtle records (`x`, `y`, `z`,
        `width`, `branch_order`, `parameter_1`, …) is plotted for the plant as it is now, over `module` or the column `by`.
        """
        return plotted(self.history, lambda: tables.to_columns(self.turtle()), names or ("modules",), by)

    def stream(self, what: str = "turtle", *, every: int = 1, symbols: Optional[Sequence[str]] = None,
               credits: Optional[int] = 8, arrays: bool = False, single: bool = False, delta: bool = True,
               max_hz: Optional[float] = None, columns: bool = False) -> "Stream":
        """Opens a stream of frames: turtle, string, statistics, geometry or queries. The first frame is the state now. The
        server sends at most `credits` frames that are not acknowledged (None: no limit). A slow reader misses frames and
        never slows the simulation.

        With `arrays` the turtle records come as columns (Frame.columns: NumPy arrays when NumPy is installed), in single
        precision when `single`. Geometry needs `arrays`: a binary glTF file in columns["glb"], unsigned (bytes / 4); or with
        `columns` it comes as Frame.geometry, the segments and triangles that an environment sees.

        With `delta` the server sends only changes since the previous frame; every Frame is complete all the same. With
        `max_hz` the server sends at most so many frames per second, and always the last frame.

        >>> algae = client.create(gallery="classic-algae")
        >>> with algae.stream("string") as stream:
        ...     now = stream.read().string
        ...     made = algae.step()
        ...     now, stream.read().string
        ('a', 'ab')
        """
        opened = self._do(requests.open_stream(
            self.identifier, what, every, symbols, credits, arrays, single, delta, max_hz, columns))
        return Stream(self._client, opened)


class Stream:
    """Frames of a simulation, one for every step. Iterate over it, or read one at a time.

    >>> with client.create(gallery="classic-algae").stream("string") as stream:
    ...     stream.read().string
    'a'
    """

    def __init__(self, client: Client, identifier: str) -> None:
        self._client = client
        self.identifier = identifier
        client._inbox.open(identifier)
        self._is_open = True

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.identifier}: {'open' if self._is_open else 'closed'}>"

    def read(self, timeout: Optional[float] = None) -> Frame:
        """The next frame; waits at most `timeout` seconds (None: no limit). Acknowledges the frame, so that the server sends
        another."""
        frame = self.poll()
        while frame is None:
            self._client._receive(timeout, "stream.data", lambda: self._client._inbox.has(self.identifier))
            frame = self.poll()
        return frame

    def poll(self) -> Optional[Frame]:
        """The next frame if it has arrived, without waiting."""
        frame = self._client._inbox.next(self.identifier)
        if frame is not None:
            self._client.notify(*requests.acknowledgement(self.identifier, frame))
        return frame

    def __iter__(self) -> Iterator[Frame]:
        """Frames until the simulation is finished."""
        while True:
            frame = self.read()
            yield frame
            if frame.finished:
                return

    def close(self) -> None:
        """Ends the stream and drops unread frames."""
        if self._is_open:
            self._is_open = False
            try:
                self._client._do(requests.close_stream(self.identifier))
            finally:
                self._client._inbox.close(self.identifier)

    def __enter__(self) -> "Stream":
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        # a lost connection has no stream to close; the first error is the useful one
        if error is None or not isinstance(error, ConnectionLost):
            self.close()
