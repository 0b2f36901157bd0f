"""The client for asyncio: the methods of client.py as coroutines. Many calls and streams may be active at once.

    async with AsyncClient("127.0.0.1:4321") as client:
        simulation = await client.create(gallery="branch-tiers", seed=7)
        async with await simulation.stream(arrays=True) as stream:
            running = asyncio.ensure_future(simulation.run())
            async for frame in stream:
                print(frame.step, frame.count)
            await running
"""

from __future__ import annotations

import asyncio
from types import TracebackType
from typing import Any, AsyncIterator, Callable, Dict, List, Mapping, Optional, Sequence, Type, TypeVar, Union

from . import async_channel, client as blocking, requests, wire
from .environment_entries import Environments, entries
from .errors import ConnectionLost, EspalierError, warn_about, warn_of_run
from .hosting import CLIENT_ROLES, hello_parameters, require_server
from .model_folder import ModelSource
from .requests import Inbox, NewModule, Request, Result, result_of
from .shapes import CompiledModel, Frame, StepResult, TurtleRecord, Vector, step_of

Function = TypeVar("Function", bound=Callable[..., Any])


def _as(described: Callable[..., Any]) -> Callable[[Function], Function]:
    """Takes over the description, without its example, of the blocking method that does the same."""

    def describe(function: Function) -> Function:
        function.__doc__ = (described.__doc__ or "").split(">>>")[0].rstrip()
        return function

    return describe


class AsyncClient:
    """A connection to a server, for the tasks of one event loop.

    A task that is cancelled while it waits for an answer cancels the request on the server: a simulation then stays at its
    last completed step.

    >>> async def grow(address, **more):
    ...     async with espalier.AsyncClient(address, **more) as client:
    ...         algae = await client.create(gallery="classic-algae")
    ...         return (await algae.step(4)).step
    >>> import asyncio
    >>> asyncio.run(grow(client.address, token=getattr(client, "token", None)))
    4
    """

    def __init__(self, address: str, *, name: str = "python", token: Optional[str] = None,
                 timeout: Optional[float] = None, connect_timeout: float = 10.0) -> None:
        """Connects when it is entered with `async with`, or by connect(). Addresses and times as for Client."""
        self._address = address
        self._name = name
        self._token = token
        self._timeout = timeout
        self._connect_timeout = connect_timeout
        self._channel: Optional[async_channel.AsyncChannel] = None
        self._reading: Optional["asyncio.Task[None]"] = None
        self._next_id = 1
        self._waiting: Dict[int, "asyncio.Future[Any]"] = {}  # for the answers, by request
        self._opening: Dict[int, Callable[[Any], None]] = {}  # done with the result before anything else is read
        self._readers: List["asyncio.Future[None]"] = []  # of streams: woken by every message
        self._inbox = Inbox()
        self._lost: Optional[EspalierError] = None
        self.server: Mapping[str, Any] = {}

    async def connect(self) -> "AsyncClient":
        """Connects and says hello; returns itself."""
        if self._channel is not None:
            return self
        try:
            self._channel = await asyncio.wait_for(async_channel.connect(self._address), self._connect_timeout)
            self._lost = None
            self._reading = asyncio.ensure_future(self._read(self._channel))
            self.server = await asyncio.wait_for(
                self._call("hello", hello_parameters(self._name, CLIENT_ROLES, self._token), self._channel.agree),
                self._connect_timeout)
            require_server(self.server, self._address)
        except asyncio.TimeoutError:
            await self.close()
            raise ConnectionLost(f"{self._address} did not answer within {self._connect_timeout:g} seconds. "
                                 "Is it an Espalier server?") from None
        except BaseException:
            await self.close()
            raise
        return self

    def __repr__(self) -> str:
        return f"<AsyncClient: {self._address}>"

    async def __aenter__(self) -> "AsyncClient":
        return await self.connect()

    async def __aexit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                        trace: Optional[TracebackType]) -> None:
        await self.close()

    async def close(self) -> None:
        """Ends the connection. Simulations stay on the server."""
        channel, self._channel = self._channel, None
        if self._reading is not None:
            self._reading.cancel()
            await asyncio.wait([self._reading])
            self._reading = None
        self._end(ConnectionLost("The client was closed."))
        if channel is not None:
            await channel.close()

    # ---- any method --------------------------------------------------------------------------------------------

    async def call(self, method: str, parameters: Optional[Mapping[str, Any]] = None, *,
                   seconds: Optional[float] = None) -> Any:
        """Sends a request of protocol/README.md and returns its result. After `seconds` (None: never) the client asks the
        server to cancel it: ServerError 1010, and the simulation stays at its last completed step."""
        return await self._call(method, parameters or {}, None, seconds)

    async def notify(self, method: str, parameters: Mapping[str, Any]) -> None:
        """Sends a notification: nothing is answered."""
        await self._connected().send(wire.notification(method, dict(parameters)))

    async def _do(self, request: Request[Result], at_once: Optional[Callable[[Any], None]] = None) -> Result:
        return request.read(await self._call(request.method, request.parameters, at_once))

    async def _call(self, method: str, parameters: Mapping[str, Any], at_once: Optional[Callable[[Any], None]],
                    seconds: Optional[float] = None) -> Any:
        """The result of a request; `at_once` is called with it before the next message is read. After `seconds` it is
        cancelled."""
        channel = self._connected()
        identifier = self._next_id
        self._next_id += 1
        answer: "asyncio.Future[Any]" = asyncio.get_running_loop().create_future()
        self._waiting[identifier] = answer
        if at_once is not None:
            self._opening[identifier] = at_once
        cancelling = None if seconds is None else asyncio.ensure_future(self._cancel_after(seconds, identifier))
        try:
            await channel.send(wire.request(identifier, method, dict(parameters)))
            return await asyncio.wait_for(answer, self._timeout)
        except asyncio.TimeoutError:
            self._abandon(identifier)
            raise ConnectionLost(f"{channel.peer} did not answer {method} within {self._timeout:g} seconds.") from None
        except asyncio.CancelledError:
            self._abandon(identifier)
            raise
        finally:
            if cancelling is not None:
                cancelling.cancel()
            self._waiting.pop(identifier, None)
            self._opening.pop(identifier, None)

    async def _cancel_after(self, seconds: float, identifier: int) -> None:
        await asyncio.sleep(seconds)
        await self.notify("$/cancel", {"id": identifier})

    def _abandon(self, identifier: int) -> None:
        """Tells the server that the client no longer waits for an answer."""
        if self._channel is not None and self._lost is None:
            self._channel.post(wire.notification("$/cancel", {"id": identifier}))

    def _connected(self) -> async_channel.AsyncChannel:
        if self._lost is not None:
            raise self._lost
        if self._channel is None:
            raise EspalierError("The client is not connected. Use `async with AsyncClient(…) as client`, or await connect().")
        return self._channel

    async def _read(self, channel: async_channel.AsyncChannel) -> None:
        """Distributes messages until the connection ends."""
        try:
            while True:
                message = await channel.receive()
                if message is None:
                    raise ConnectionLost(f"{channel.peer} closed the connection.")
                if "method" not in message and message.get("id") is not None:
                    self._answered(message)
                else:
                    self._inbox.take(message)
                    self._wake_readers()
        except EspalierError as error:
            self._end(error)

    def _answered(self, message: wire.Received) -> None:
        identifier = message["id"]
        waiting = self._waiting.get(identifier) if isinstance(identifier, int) else None
        if waiting is None or waiting.done():
            return
        try:
            result = result_of(message)
            at_once = self._opening.get(identifier)
            if at_once is not None:
                at_once(result)
        except EspalierError as error:
            waiting.set_exception(error)
        else:
            waiting.set_result(result)

    def _wake_readers(self) -> None:
        for reader in self._readers:
            if not reader.done():
                reader.set_result(None)
        self._readers.clear()

    def _end(self, error: EspalierError) -> None:
        """Ends every waiting call and every reader with the error."""
        if self._lost is None:
            self._lost = error
        for answer in list(self._waiting.values()):
            if not answer.done():
                answer.set_exception(error)
        self._wake_readers()

    # ---- models and simulations --------------------------------------------------------------------------------

    @_as(blocking.Client.check)
    async def check(self, source: str) -> CompiledModel:
        return await self._do(requests.check(source))

    @_as(blocking.Client.load)
    async def load(self, source: Optional[ModelSource] = None, *, gallery: Optional[str] = None,
                   files: Optional[Mapping[str, str]] = None, main: Optional[str] = None) -> CompiledModel:
        return await self._do(requests.load(source, gallery, files, main))

    @_as(blocking.Client.create)
    async def create(self, source: Optional[ModelSource] = None, *, gallery: Optional[str] = None, loaded: Optional[str] = None,
                     files: Optional[Mapping[str, str]] = None, main: Optional[str] = None, seed: Optional[int] = None,
                     environment: Optional[Environments] = None, name: Optional[str] = None,
                     derivation_length: Optional[int] = None, plants: Optional[Sequence[Vector]] = None,
                     parameters: Optional[Mapping[str, Any]] = None, limits: Optional[Mapping[str, int]] = None,
                     save: bool = True, world: Optional[Mapping[str, Any]] = None,
                     simulation: Optional[str] = None) -> "AsyncSimulation":
        created = await self._do(requests.create(
            source, gallery=gallery, loaded=loaded, files=files, main=main, environment=entries(environment), plants=plants,
            save=save,
            seed=seed, name=name, derivationLength=derivation_length, parameters=parameters, limits=limits,
            world=world, simulation=simulation))
        warn_about(created)
        return AsyncSimulation(self, str(created["simulation"]), created)

    @_as(blocking.Client.create_forest)
    async def create_forest(self, models: Sequence[Mapping[str, Any]], plants: Sequence[Mapping[str, Any]], *,
                            seeds: Optional[Mapping[str, Any]] = None, environment: Optional[Environments] = None,
                            seed: Optional[int] = None, name: Optional[str] = None,
                            derivation_length: Optional[int] = None,
                            world: Optional[Mapping[str, Any]] = None) -> "AsyncSimulation":
        created = await self._do(requests.create_forest(models, plants, seeds=seeds, environment=entries(environment), seed=seed,
                                                        name=name, derivationLength=derivation_length, world=world))
        warn_about(created)
        return AsyncSimulation(self, str(created["simulation"]), created)

    @_as(blocking.Client.simulation)
    async def simulation(self, identifier: str) -> "AsyncSimulation":
        return AsyncSimulation(self, identifier, await self._do(requests.information(identifier)))

    @_as(blocking.Client.gallery)
    async def gallery(self) -> List[str]:
        return await self._do(requests.gallery())

    @_as(blocking.Client.simulations)
    async def simulations(self) -> List[Mapping[str, Any]]:
        return await self._do(requests.simulations())

    @_as(blocking.Client.environments)
    async def environments(self) -> List[Mapping[str, Any]]:
        return await self._do(requests.environments())

    @_as(blocking.Client.status)
    async def status(self) -> Mapping[str, Any]:
        return await self._do(requests.status())


class AsyncSimulation:
    """One simulation on the server, with the methods of Simulation as coroutines.

    >>> async def string_of(address, **more):
    ...     async with espalier.AsyncClient(address, **more) as client:
    ...         algae = await client.create(gallery="classic-algae")
    ...         await algae.step(2)
    ...         return await algae.string()
    >>> import asyncio
    >>> asyncio.run(string_of(client.address, token=getattr(client, "token", None)))
    'aba'
    """

    def __repr__(self) -> str:
        return f"<AsyncSimulation {self.identifier}>"

    def __init__(self, client: AsyncClient, identifier: str, created: Mapping[str, Any]) -> None:
        self._client = client
        self.identifier = identifier
        self.created = created  # the answer of the server when the simulation was created or found
        self.history: List[StepResult] = []  # results of step() and run(), in order

    async def _do(self, request: Request[Result]) -> Result:
        return await self._client._do(request)

    @_as(blocking.Simulation.step)
    async def step(self, steps: int = 1, *, until: Optional[int] = None) -> StepResult:
        made = await self._do(requests.step(self.identifier, steps, until))
        self.history.append(made)
        warn_of_run(made.warnings)
        return made

    @_as(blocking.Simulation.steps)
    async def steps(self) -> AsyncIterator[StepResult]:
        while True:
            made = await self.step()
            yield made
            if made.finished or made.truncated:
                return

    @_as(blocking.Simulation.run)
    async def run(self, progress: Optional[Callable[[Frame], None]] = None) -> StepResult:
        if progress is None:
            made = await self._do(requests.run(self.identifier))
            self.history.append(made)
            warn_of_run(made.warnings)
            return made
        async with await self.stream("statistics", credits=None) as stream:
            first = await stream.read()
            progress(first)
            shown = first.step
            running = asyncio.ensure_future(self._do(requests.run(self.identifier)))
            reading = asyncio.ensure_future(stream.read())
            try:
                while not running.done() or shown < running.result().step:
                    await asyncio.wait([running, reading] if not running.done() else [reading],
                                       return_when=asyncio.FIRST_COMPLETED)
                    if reading.done():
                        frame = reading.result()
                        reading = asyncio.ensure_future(stream.read())
                        progress(frame)
                        self.history.append(step_of(frame))
                        shown = frame.step
                made = running.result()
                warn_of_run(made.warnings)
                return made
            finally:
                # an exception of `progress` or a cancelled task ends the run too
                for task in (running, reading):
                    task.cancel()
                await asyncio.wait([running, reading])

    @_as(blocking.Simulation.pause)
    async def pause(self) -> int:
        return await self._do(requests.pause(self.identifier))

    @_as(blocking.Simulation.get)
    async def get(self, what: str, **parameters: Any) -> Mapping[str, Any]:
        return await self._do(requests.get(self.identifier, what, parameters))

    @_as(blocking.Simulation.string)
    async def string(self, plant: int = 0) -> str:
        return await self._do(requests.string(self.identifier, plant))

    @_as(blocking.Simulation.turtle)
    async def turtle(self) -> List[TurtleRecord]:
        return await self._do(requests.turtle(self.identifier))

    @_as(blocking.Simulation.set)
    async def set(self, parameters: Mapping[str, Union[float, str]]) -> None:
        await self._do(requests.set_parameters(self.identifier, parameters))

    @_as(blocking.Simulation.prune)
    async def prune(self, module: int, plant: int = 0) -> None:
        await self._do(requests.edit(self.identifier, "prune", module, (), plant))

    @_as(blocking.Simulation.insert)
    async def insert(self, module: int, modules: Sequence[NewModule], plant: int = 0) -> None:
        await self._do(requests.edit(self.identifier, "insert", module, modules, plant))

    @_as(blocking.Simulation.replace)
    async def replace(self, module: int, modules: Sequence[NewModule], plant: int = 0) -> None:
        await self._do(requests.edit(self.identifier, "replace", module, modules, plant))

    @_as(blocking.Simulation.save)
    async def save(self) -> bytes:
        return await self._do(requests.save(self.identifier))

    @_as(blocking.Simulation.checkpoint)
    async def checkpoint(self, name: str) -> None:
        await self._do(requests.save_checkpoint(self.identifier, name))

    @_as(blocking.Simulation.checkpoints)
    async def checkpoints(self) -> List[Mapping[str, Any]]:
        return await self._do(requests.checkpoints(self.identifier))

    @_as(blocking.Simulation.restore)
    async def restore(self, snapshot: Optional[bytes] = None, *, checkpoint: Optional[str] = None) -> None:
        await self._do(requests.restore(self.identifier, snapshot, checkpoint))

    @_as(blocking.Simulation.reset)
    async def reset(self, seed: Optional[int] = None) -> None:
        await self._do(requests.reset(self.identifier, seed))

    @_as(blocking.Simulation.fork)
    async def fork(self, name: Optional[str] = None) -> "AsyncSimulation":
        created = await self._do(requests.fork(self.identifier, name))
        return AsyncSimulation(self._client, str(created["simulation"]), created)

    @_as(blocking.Simulation.delete)
    async def delete(self) -> None:
        await self._do(requests.delete(self.identifier))

    @_as(blocking.Simulation.geometry)
    async def geometry(self) -> bytes:
        async with await self.stream("geometry", arrays=True, credits=1) as stream:
            return bytes((await stream.read()).columns["glb"])

    @_as(blocking.Simulation.stream)
    async def stream(self, what: str = "turtle", *, every: int = 1, symbols: Optional[Sequence[str]] = None,
                     credits: Optional[int] = 8, arrays: bool = False, single: bool = False, delta: bool = True,
                     max_hz: Optional[float] = None, columns: bool = False) -> "AsyncStream":
        # the first frame may come right behind the answer
        opened = await self._client._do(
            requests.open_stream(self.identifier, what, every, symbols, credits, arrays, single, delta, max_hz, columns),
            lambda result: self._client._inbox.open(str(result["stream"])))
        return AsyncStream(self._client, opened)


class AsyncStream:
    """Frames of a simulation, one for every step: `async for frame in stream`, or read one at a time.

    >>> async def first(address, **more):
    ...     async with espalier.AsyncClient(address, **more) as client:
    ...         algae = await client.create(gallery="classic-algae")
    ...         async with await algae.stream("string") as stream:
    ...             return (await stream.read()).string
    >>> import asyncio
    >>> asyncio.run(first(client.address, token=getattr(client, "token", None)))
    'a'
    """

    def __repr__(self) -> str:
        return f"<AsyncStream {self.identifier}>"

    def __init__(self, client: AsyncClient, identifier: str) -> None:
        self._client = client
        self.identifier = identifier
        self._is_open = True

    async def read(self, timeout: Optional[float] = None) -> Frame:
        """The next frame; waits for it at most `timeout` seconds (None: as long as it takes), then raises ConnectionLost.
        It is acknowledged, which lets the server send another."""
        try:
            return await asyncio.wait_for(self._next(), timeout)
        except asyncio.TimeoutError:
            raise ConnectionLost(f"No frame came within {timeout:g} seconds.") from None

    async def _next(self) -> Frame:
        frame = self.poll()
        while frame is None:
            self._client._connected()
            arrived: "asyncio.Future[None]" = asyncio.get_running_loop().create_future()
            self._client._readers.append(arrived)
            await arrived
            frame = self.poll()
        return frame

    def poll(self) -> Optional[Frame]:
        """The next frame if one has come, without waiting for one."""
        frame = self._client._inbox.next(self.identifier)
        if frame is not None and self._client._channel is not None and self._client._lost is None:
            self._client._channel.post(wire.notification(*requests.acknowledgement(self.identifier, frame)))
        return frame

    async def __aiter__(self) -> AsyncIterator[Frame]:
        """Frames until the simulation is finished."""
        while True:
            frame = await self.read()
            yield frame
            if frame.finished:
                return

    async def close(self) -> None:
        """Ends the stream; frames that were not read are dropped."""
        if self._is_open:
            self._is_open = False
            try:
                await self._client._do(requests.close_stream(self.identifier))
            finally:
                self._client._inbox.close(self.identifier)
                self._client._wake_readers()

    async def __aenter__(self) -> "AsyncStream":
        return self

    async def __aexit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                        trace: Optional[TracebackType]) -> None:
        # a connection that is lost has no stream to close; the first error is the one to see
        if error is None or not isinstance(error, ConnectionLost):
            await self.close()

