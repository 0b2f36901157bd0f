"""Runs an environment as a program: connected to a server, waiting for servers, or on pipes."""

from __future__ import annotations

import argparse
import array as array_module
import base64
import json
import math
import os
import socket
import sys
import threading
import time
import traceback
from types import TracebackType
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Type, Union

from . import wire
from .blocks import Blocks, numpy
from .connecting import connect, token_in
from .environment_process import EnvironmentProcess
from .errors import ConnectionLost, EspalierError, ProtocolError, ServerError
from .geometry import NAMES, Geometry, read_geometry
from .listening import Admission, accepted, is_loopback
from .queries import Answer, Columns, Query, read_columns, read_opening, read_query
from .version import VERSION

PROTOCOL = 1
# numbers of the protocol's own errors that an environment sends
VERSION_UNKNOWN = 1001
LIMIT = 1004
ENVIRONMENT_FAILED = 1006
NON_FINITE = 1008
NOT_FOUND = 1011
SNAPSHOT = 1013
OFFER_TAKEN = 1016
# that a client asks for; the server grants those that its token has
CLIENT_ROLES = ("controller", "viewer")

CONNECT_SECONDS = 10.0
SERVERS = 500  # that a listening environment answers at a time
SIMULATIONS = 10_000  # open at a time on one connection
RECONNECT_SECONDS = 1.0


class _Simulation:
    """The environment's object for one simulation, and the reply of its last step."""

    def __init__(self, environment: EnvironmentProcess) -> None:
        self.environment = environment
        self.last_request: Optional[Tuple[int, int, Any]] = None  # step, iteration, queries
        self.last_reply: "Reply" = Reply({})
        self.geometry: Optional[Geometry] = None  # that came last


class Reply:
    """The result of a request, and the arrays that go with it."""

    def __init__(self, value: Dict[str, Any], blocks: Optional[Blocks] = None) -> None:
        self.value = value
        self.blocks = blocks


class Host:
    """Answers the protocol's requests to an environment. Keeps one object of the class for every simulation. A given
    object serves every simulation itself."""

    def __init__(self, environment: Union[Type[EnvironmentProcess], EnvironmentProcess]) -> None:
        self._given = environment if isinstance(environment, EnvironmentProcess) else None
        self._has_noted_silence = False
        self._class: Type[EnvironmentProcess] = environment if isinstance(environment, type) else type(environment)
        self._simulations: Dict[str, _Simulation] = {}

    def handle(self, message: wire.Message) -> Optional[wire.Message]:
        """The response to a message; None for notifications and responses."""
        return self.answer(wire.Received(message))[0]

    def answer(self, message: wire.Received) -> Tuple[Optional[wire.Message], Optional[Blocks]]:
        """The response to a message with the arrays behind it; None for notifications and responses."""
        method = message.get("method")
        identifier = message.get("id")
        blocks: Optional[Blocks] = None
        if not isinstance(method, str):
            if "result" in message or "error" in message:
                return None, None
            return wire.failure(identifier, wire.INVALID_REQUEST,
                                "method: expected a text. This is not a request."), None
        parameters = message.get("params", {})
        try:
            if not isinstance(parameters, dict):
                raise wire.Refusal(wire.INVALID_PARAMETERS, "params: expected an object.", {"path": "params"})
            reply = self._call(method, parameters, message.blocks)
        except wire.Refusal as refusal:
            response = wire.failure(identifier, refusal.code, str(refusal), refusal.data)
        except ProtocolError as error:
            path = str(error).split(":")[0]
            response = wire.failure(identifier, wire.INVALID_PARAMETERS, str(error), {"path": path})
        except Exception as error:  # a mistake of this package must not end the program either
            traceback.print_exc(file=sys.stderr)
            response = wire.failure(identifier, wire.INTERNAL_ERROR, f"{type(error).__name__} in {method}: {error}.")
        else:
            response = wire.result(identifier, reply.value)
            blocks = reply.blocks
        return (None, None) if identifier is None else (response, blocks)

    def _call(self, method: str, parameters: Dict[str, Any], blocks: Blocks) -> Reply:
        if method == "environment.step":
            return self._step(parameters, blocks)
        if method == "environment.describe":
            return Reply(self._class.description())
        if method == "environment.open":
            return Reply(self._open(parameters))
        if method == "environment.close":
            simulation = self._simulations.pop(str(parameters.get("simulation")), None)
            if simulation is not None:
                self._run("closed()", simulation.environment.closed)
            return Reply({})
        if method == "environment.save":
            simulation = self._find(parameters)
            state = self._run("save()", simulation.environment.save)
            return Reply({"state": pack_state(state)})
        if method == "environment.restore":
            return Reply(self._restore(parameters))
        if method == "hello":
            return Reply(hello_result(self._class.name(), parameters))
        if method == "ping":
            return Reply({})
        raise wire.Refusal(wire.METHOD_NOT_FOUND, f"An environment does not know the method '{method}'. It knows "
                       "environment.describe, open, step, save, restore and close.")

    def _find(self, parameters: Dict[str, Any]) -> _Simulation:
        name = parameters.get("simulation")
        found = self._simulations.get(name) if isinstance(name, str) else None
        if found is None:
            raise wire.Refusal(NOT_FOUND, f"params.simulation: {json.dumps(name)} is not open here. "
                           "Send environment.open first.", {"path": "params.simulation"})
        return found

    def _open(self, parameters: Dict[str, Any]) -> Dict[str, Any]:
        opening = read_opening(parameters)
        # opened again in the middle of a run after a lost connection: an existing object continues
        if parameters.get("resume") is not None and opening.simulation in self._simulations:
            return {}
        if opening.simulation not in self._simulations and len(self._simulations) >= SIMULATIONS:
            raise wire.Refusal(LIMIT, f"the limit 'simulations' is {SIMULATIONS}, and this is one more. Close simulations of this "
                               "connection, or connect again for more.",
                               {"limit": "simulations", "value": SIMULATIONS + 1, "bound": SIMULATIONS})
        simulation = _Simulation(self._given or self._run("__init__()", self._class))
        simulation.environment.opening = opening
        self._run("opened()", simulation.environment.opened)
        self._simulations[opening.simulation] = simulation
        return {}

    def _restore(self, parameters: Dict[str, Any]) -> Dict[str, Any]:
        simulation = self._find(parameters)
        try:
            state = unpack_state(parameters.get("state"))
        except ValueError as error:
            raise wire.Refusal(SNAPSHOT, f"params.state: this is not a state that {self._class.name()} saved ({error}).",
                           {"path": "params.state"}) from None
        self._run("restore()", lambda: simulation.environment.restore(state))
        simulation.last_request = None
        return {}

    def _step(self, parameters: Dict[str, Any], blocks: Blocks) -> Reply:
        simulation = self._find(parameters)
        sent = parameters.get("queries")
        if not blocks and not isinstance(sent, list):
            raise wire.Refusal(wire.INVALID_PARAMETERS, "params.queries: expected a list of queries.",
                           {"path": "params.queries"})
        # arrays are kept only for an environment that must not advance twice
        asked: Any = sent
        if blocks:
            # of the geometry all comes where only the difference came before
            asked = ({name: bytes(array) for name, array in blocks.items() if name not in NAMES}
                     if self._class.is_stateful else object())
        key = (int(parameters.get("step", 0)), int(parameters.get("iteration", 0)), asked)
        # the same step is sent again after a lost connection
        if simulation.last_request == key:
            return simulation.last_reply

        environment = simulation.environment
        environment.completed_steps = key[0]
        environment.days = float(parameters.get("time", 0.0))
        if "geometry" in parameters:
            before, simulation.geometry = simulation.geometry, None
            simulation.geometry = read_geometry(parameters["geometry"], blocks, before)
            environment.geometry = simulation.geometry
        if type(environment).step_columns is not EnvironmentProcess.step_columns:
            reply = self._step_columns(environment, parameters, blocks)
        else:
            queries = (read_columns(parameters, blocks).queries() if blocks else
                       [read_query(shape, f"params.queries[{index}]") for index, shape in enumerate(sent or [])])
            answers: Sequence[Answer] = self._run("step()", lambda: environment.step(queries), key[0])
            reply = Reply({"replies": self._replies(queries, answers, key[0])})
        if notes := vars(environment).pop("_notes_of_step", None):
            reply.value["notes"] = notes
        simulation.last_reply = reply
        simulation.last_request = key
        return reply

    def _step_columns(self, environment: EnvironmentProcess, parameters: Dict[str, Any], blocks: Blocks) -> Reply:
        """A step of an environment that works with whole columns. Answered as it was asked: in arrays or as text."""
        step = environment.completed_steps
        columns = read_columns(parameters, blocks)
        answer = self._run("step_columns()", lambda: environment.step_columns(columns), step)
        if answer is None:
            self._note_silence(columns.count, step)
            return Reply({"replies": []})
        try:
            array, width = _as_column(answer)
        except (TypeError, ValueError) as error:
            raise self._mistake(f"step_columns() returned {_described(answer)}; expected one number for every query, or "
                                f"rows of them, as an array ({error}).", step) from None
        if len(array) != columns.count * width:
            raise self._mistake(f"step_columns() returned {len(array) // max(width, 1)} rows for {columns.count} queries. "
                                "Return one for every query.", step)
        self._require_finite(array, width, step)
        if blocks:
            return Reply({}, {"parameters": _shaped(array, columns.count, width)})
        rows = [list(array[row * width:(row + 1) * width]) for row in range(columns.count)]
        return Reply({"replies": [{"id": row, "parameters": [float(value) for value in values]}
                                  for row, values in enumerate(rows)]})

    def _require_finite(self, array: Any, width: int, step: int) -> None:
        if numpy is not None:
            wrong = numpy.flatnonzero(~numpy.isfinite(array))
            place = int(wrong[0]) if len(wrong) else -1
        else:
            place = next((index for index, value in enumerate(array) if not math.isfinite(value)), -1)
        if place >= 0:
            raise self._not_finite(place // width, array[place], place % width, step)

    def _replies(self, queries: Sequence[Query], answers: Any, step: int) -> List[Dict[str, Any]]:
        try:
            answers = list(answers)
        except TypeError:
            raise self._mistake(f"step() returned {_described(answers)}; expected a list with one answer for every "
                                "query, or None.", step) from None
        if len(answers) != len(queries):
            raise self._mistake(f"step() gave {len(answers)} answers to {len(queries)} queries. Return one answer for "
                                "every query, or None.", step)
        replies = []
        for query, answer in zip(queries, answers):
            if answer is None:
                continue
            values: List[Optional[float]] = []
            try:
                listed = [] if isinstance(answer, (str, bytes)) else list(answer)
            except TypeError:
                listed = []
            if not listed and not _is_empty(answer):
                raise self._mistake(f"query {query.id} was answered with {_described(answer)}; expected a list of the "
                                    "module's values, as in [0.5], or None to keep its values.", step)
            for index, value in enumerate(listed):
                if value is not None:
                    try:
                        value = _number(value)
                    except (TypeError, ValueError):
                        raise self._mistake(f"query {query.id} was answered with {_described(value)} as value "
                                            f"{index + 1}; expected a number or None.", step) from None
                    if not math.isfinite(value):
                        raise self._not_finite(query.id, value, index, step)
                values.append(value)
            if values:
                replies.append({"id": query.id, "parameters": values})
        if not replies:
            self._note_silence(len(queries), step)
        return replies

    def _note_silence(self, count: int, step: int) -> None:
        if count > 0 and not self._has_noted_silence:
            self._has_noted_silence = True
            print(f"{self._class.name()}: step {step}: none of {count} queries was answered, so the modules keep their values. "
                  "Is a 'return' missing? (This is said once.)", file=sys.stderr, flush=True)

    def _mistake(self, what: str, step: int) -> wire.Refusal:
        """A wrong answer of the subclass: prints it here and returns the error for the server."""
        print(f"{self._class.name()}: step {step}: {what}", file=sys.stderr, flush=True)
        return wire.Refusal(ENVIRONMENT_FAILED, f"{self._class.name()}: {what}",
                        {"environment": self._class.name(), "step": step, "retryable": False})

    def _not_finite(self, query: int, value: Any, index: int, step: int) -> wire.Refusal:
        mistake = self._mistake(f"query {query} was answered with {float(value)} as value {index + 1}. Only finite "
                                "numbers can be sent.", step)
        mistake.code = NON_FINITE
        return mistake

    def _run(self, what: str, call: Any, step: Optional[int] = None) -> Any:
        """Calls the subclass. The trace of an exception goes to standard error, a sentence goes to the server."""
        try:
            return call()
        except Exception as error:  # any error of the subclass must reach the user of the simulation
            traceback.print_exception(type(error), error, _own(error.__traceback__), file=sys.stderr)
            frames = traceback.extract_tb(error.__traceback__)
            place = f"{os.path.basename(frames[-1].filename)}:{frames[-1].lineno}" if frames else "unknown place"
            data: Dict[str, Any] = {"environment": self._class.name(), "retryable": False}
            if step is not None:
                data["step"] = step
            raise wire.Refusal(ENVIRONMENT_FAILED, f"{self._class.name()}: {type(error).__name__} in {what} at {place}: "
                           f"{str(error).rstrip('.')}. The environment's standard error has the whole trace.", data) from None


def _own(trace: Optional[TracebackType]) -> Optional[TracebackType]:
    """A traceback without the frames of this package at its beginning; all of it when there are no others."""
    rest = trace
    while rest is not None and os.path.dirname(rest.tb_frame.f_code.co_filename) == os.path.dirname(__file__):
        rest = rest.tb_next
    return rest or trace


def _described(value: Any) -> str:
    """A value as a message shows it."""
    text = repr(value)
    shown = text if len(text) <= 60 else text[:57] + "..."
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"the number {shown}"
    return f"{shown} ({type(value).__name__})"


def _number(value: Any) -> float:
    # float() would read a text
    if isinstance(value, (str, bytes)):
        raise TypeError
    return float(value)


def _is_empty(answer: Any) -> bool:
    return isinstance(answer, (list, tuple)) and not answer


def _as_column(answer: Any) -> Tuple[Any, int]:
    """The numbers of an answer to all queries, one after the other, and how many each row has."""
    if numpy is not None:
        array = numpy.asarray(answer)
        if array.dtype.kind not in "fiub" or array.ndim not in (1, 2):
            raise ValueError(f"an array of {array.dtype} with the shape {list(array.shape)}")
        kept = array if array.dtype.str in ("<f8", "<f4") else array.astype("<f8")
        return numpy.ascontiguousarray(kept).reshape(-1), 1 if array.ndim == 1 else int(array.shape[1])
    rows = list(answer)
    if not rows or not hasattr(rows[0], "__len__"):
        return array_module.array("d", rows), 1
    width = len(rows[0])
    if any(len(row) != width for row in rows):
        raise ValueError("rows of different lengths")
    return array_module.array("d", [value for row in rows for value in row]), width


def _shaped(array: Any, rows: int, width: int) -> Any:
    if numpy is not None:
        return array.reshape(rows, width)
    return memoryview(array).cast("B").cast("d", [rows, width]) if rows and width else memoryview(array)


def pack_state(state: Any) -> str:
    """A state as the protocol carries it: bytes in base 64; here the bytes of its JSON text."""
    try:
        text = json.dumps(state, separators=(",", ":"), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise wire.Refusal(ENVIRONMENT_FAILED, f"save() returned a value that JSON does not have ({error}).",
                       {"retryable": False}) from None
    return base64.b64encode(text.encode("utf-8")).decode("ascii")


def unpack_state(packed: Any) -> Any:
    if not isinstance(packed, str):
        raise ValueError("expected a text")
    return json.loads(base64.b64decode(packed, validate=True).decode("utf-8"))


def hello_parameters(name: str, roles: Sequence[str], token: Optional[str] = None) -> Dict[str, Any]:
    # an environment answers while it waits, so the server may send heartbeats
    capabilities = [*wire.CAPABILITIES, *(["heartbeat"] if "environment" in roles else [])]
    parameters: Dict[str, Any] = {"protocol": [PROTOCOL], "roles": list(roles), "name": name, "version": VERSION,
                                  "capabilities": capabilities, "limits": dict(wire.LIMITS)}
    if token is not None:
        parameters["token"] = token
    return parameters


def require_server(hello: Mapping[str, Any], address: str) -> None:
    """A server grants roles in its answer to hello, an environment none."""
    if not hello.get("roles"):
        raise EspalierError(f"At {address} is an environment, not a server. `espalier serve` starts a server; a model asks this "
                            f"environment by environment='tcp://{address.removeprefix('tcp://')}'.")


def hello_result(name: str, parameters: Dict[str, Any]) -> Dict[str, Any]:
    """The answer of an environment that was connected to."""
    offered = parameters.get("protocol")
    if not isinstance(offered, list) or PROTOCOL not in offered:
        raise wire.Refusal(VERSION_UNKNOWN, f"No common protocol version: the request has {json.dumps(offered)}, "
                       f"this environment speaks [{PROTOCOL}].", {"supported": [PROTOCOL]})
    return {"protocol": PROTOCOL, "session": name, "server": f"{name} {VERSION}",
            "capabilities": list(wire.CAPABILITIES), "limits": dict(wire.LIMITS)}


# ---- the three kinds of connection ---------------------------------------------------------------------------------


def answer_all(host: Host, channel: wire.Channel, first_seconds: Optional[float] = None,
               is_admitted: Callable[[], bool] = lambda: True) -> None:
    """Answers requests until the other side ends, or has sent nothing in the first seconds. `is_admitted` is asked when the first
    message has come, and ends it, too."""
    is_first = True
    while True:
        try:
            message = channel.receive(first_seconds if is_first else None)
        except ProtocolError as error:
            channel.send(wire.failure(None, wire.PARSE_ERROR, str(error)))
            continue
        except TimeoutError:
            return
        if message is None or (is_first and not is_admitted()):
            return
        is_first = False
        response, blocks = host.answer(message)
        if response is not None:
            channel.send(response, blocks)
        if message.get("method") == "hello" and isinstance(message.get("params"), dict):
            channel.agree(message["params"])


def call(channel: wire.Channel, identifier: int, method: str, parameters: Dict[str, Any]) -> Any:
    """Sends a request and waits for its response. Ignores other messages."""
    channel.send(wire.request(identifier, method, parameters))
    while True:
        try:
            message = channel.receive(CONNECT_SECONDS)
        except TimeoutError:
            raise ConnectionLost(f"{channel.peer} did not answer {method} within {CONNECT_SECONDS:g} seconds. "
                                 "Is it an Espalier server?") from None
        if message is None:
            raise ConnectionLost(f"{channel.peer} closed the connection instead of answering {method}.")
        if message.get("id") == identifier and "method" not in message:
            if "error" in message:
                error = message["error"]
                raise ServerError(int(error.get("code", 0)), str(error.get("message", "")), error.get("data"))
            return message.get("result")


def open_offer(name: str, address: str, token: Optional[str] = None) -> wire.Channel:
    """Connects to a server and offers an environment under a name; the server's requests then arrive on the channel."""
    channel = connect(address, CONNECT_SECONDS)
    try:
        channel.agree(call(channel, 1, "hello", hello_parameters(name, ["environment"], token)) or {})
        call(channel, 2, "environment.offer", {"name": name})
    except BaseException:
        channel.close()
        raise
    return channel


def offer(host: Host, name: str, address: str, token: Optional[str] = None) -> None:
    """Connects to a server, offers the environment and answers until the server ends."""
    channel = open_offer(name, address, token)
    try:
        print(f"environment '{name}' is offered to {channel.peer}", file=sys.stderr, flush=True)
        answer_all(host, channel)
    finally:
        channel.close()


def listen(environment: Type[EnvironmentProcess], address: str, insecure: bool = False) -> None:
    """Answers every server that connects, each with simulations of its own. Ends only by an interrupt. `insecure`: the address may be
    reached from other machines, which need no token."""
    host, port = wire.parse_address(address)
    try:
        listener = socket.create_server((host, port))
    except OSError as error:
        raise EspalierError(f"Cannot listen on {address} ({error.strerror or error}). "
                            "Give another port, or 0 for a free one.") from None
    if not insecure and not is_loopback(listener.getsockname()[0]):
        listener.close()
        raise EspalierError(f"'{host}' can be reached from other machines, and an environment does not ask for a token: "
                            "add --insecure if that is acceptable, or listen on 127.0.0.1.")
    admission = Admission(trusted=SERVERS)
    with listener:
        print(f"listening on {host}:{listener.getsockname()[1]}", flush=True)
        while True:
            try:
                connection, peer = accepted(listener, admission)
            except OSError as error:
                print(f"cannot accept a connection: {error.strerror or error}", file=sys.stderr)
                continue
            admission.enter(connection, "" if is_loopback(peer[0]) else peer[0])
            channel = wire.SocketChannel(connection, f"{peer[0]}:{peer[1]}")
            try:
                threading.Thread(target=_serve_connection, args=(environment, channel, admission), daemon=True).start()
            except RuntimeError as error:
                print(f"cannot answer {channel.peer}: {error}", file=sys.stderr)
                admission.leave(connection)
                channel.close()


def _serve_connection(environment: Type[EnvironmentProcess], channel: wire.SocketChannel, admission: Admission) -> None:
    connection = channel.release()
    try:
        # a server that has spoken keeps its place, however long it computes
        answer_all(Host(environment), channel, CONNECT_SECONDS, lambda: admission.trust(connection) and admission.begin(connection))
    except EspalierError as error:
        print(error, file=sys.stderr)
    finally:
        admission.leave(connection)
        channel.close()


def serve_pipes(environment: Type[EnvironmentProcess]) -> None:
    """Answers on standard input and output until the input ends."""
    channel = wire.PipeChannel(sys.stdin.buffer, sys.stdout.buffer, "the server")
    # standard output carries only messages; the output of the subclass goes to standard error
    sys.stdout = sys.stderr
    answer_all(Host(environment), channel)


def main(environment: Type[EnvironmentProcess], arguments: Sequence[str]) -> int:
    """The program of an environment. Returns its exit status: 0 success, 1 failure; wrong usage exits with 2."""
    parser = argparse.ArgumentParser(description=(environment.__doc__ or "").strip() or None)
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--offer", metavar="ADDRESS",
                     help="connect to a server and offer the environment: HOST:PORT, tls://, unix:PATH, ws:// or wss://")
    way.add_argument("--listen", metavar="HOST:PORT", help="wait for servers; port 0 takes a free port")
    parser.add_argument("--insecure", action="store_true", help="with --listen: other machines may connect, without a token")
    parser.add_argument("--name", default=environment.name(), help="name of the offered environment (default: %(default)s)")
    parser.add_argument("--token", default=None, help="token of the server, if the server needs one")
    parser.add_argument("--token-file", metavar="FILE", default=None,
                        help="file with the token in its first line; other users of the machine cannot see it")
    parser.add_argument("--reconnect", action="store_true", help="with --offer: connect again after a lost connection")
    parser.add_argument("--describe", action="store_true", help="print the description as one JSON object and exit")
    options = parser.parse_args(arguments)
    if options.token_file is not None:
        try:
            options.token = token_in(options.token_file)
        except EspalierError as error:
            parser.error(str(error))
    try:
        if options.describe:
            print(json.dumps(environment.description()))
        elif options.listen is not None:
            listen(environment, options.listen, options.insecure)
        elif options.offer is not None:
            _offer_again(Host(environment), options)
        else:
            serve_pipes(environment)
    except KeyboardInterrupt:
        return 0
    except EspalierError as error:
        print(f"{environment.name()}: {error}", file=sys.stderr)
        return 1
    return 0


def _offer_again(host: Host, options: argparse.Namespace) -> None:
    """Offers once, or again with the same objects after a lost connection, so that simulations continue."""
    while True:
        try:
            offer(host, options.name, options.offer, options.token)
        except ConnectionLost as error:
            if not options.reconnect:
                raise
            print(f"{error} Trying again.", file=sys.stderr)
        except ServerError as error:
            # the server has not noticed yet that the connection before is lost
            if not options.reconnect or error.code != OFFER_TAKEN:
                raise
            print(f"{error} Trying again.", file=sys.stderr)
        if not options.reconnect:
            return
        time.sleep(RECONNECT_SECONDS)
