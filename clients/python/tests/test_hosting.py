"""Environments: the requests of the protocol against a class, and the three ways to meet a server."""

import contextlib
import io
import json
import os
import resource
import signal
import socket
import subprocess
import sys
import threading
import unittest
from array import array
from pathlib import Path
from typing import Any, Callable, ClassVar, Dict, List, Sequence, Tuple, Type
from unittest import mock

from espalier import (Answer, Columns, ConnectionLost, Environment, ProtocolError, Query, Variable, blocks, hosting,
                      wire)
from espalier import queries

PACKAGE_FOLDER = Path(__file__).resolve().parents[1]


class Doubler(Environment):
    """Answers twice what it is sent."""

    needs = ("parameters",)
    inputs = (Variable("amount", "g"),)
    outputs = (Variable("twice", "g"),)

    def answer(self, query: Query) -> Answer:
        return [2 * value for value in query.parameters]


class Counter(Environment):
    """Answers how many steps it has seen."""

    is_stateful = True
    seen = 0
    closings: ClassVar[List[str]] = []

    def opened(self) -> None:
        self.seen = int(self.opening.configuration.get("start", 0))

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        self.seen += 1
        return [[self.seen, None] for _ in queries]

    def save(self) -> Any:
        return {"seen": self.seen}

    def restore(self, state: Any) -> None:
        self.seen = state["seen"]

    def closed(self) -> None:
        self.closings.append(self.opening.simulation)


class Broken(Environment):
    """Raises."""

    def answer(self, query: Query) -> Answer:
        return [1 / query.parameters[0]]


class Infinite(Environment):
    def answer(self, query: Query) -> Answer:
        return [0.5, float("inf")]


class Short(Environment):
    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        return []


class Careless(Environment):
    """Answers with whatever it is told to."""

    answers: ClassVar[Any] = None

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        return type(self).answers  # type: ignore[no-any-return]


class HeightColumn(Environment):
    """Answers the height of each query, as an array."""

    needs = ("position",)

    def step_columns(self, queries: Columns) -> Any:
        if hasattr(queries.position, "reshape"):
            return queries.position[:, 1]
        return [row[1] for row in queries.position.tolist()]


class WrongColumn(Environment):
    column: ClassVar[Any] = None

    def step_columns(self, queries: Columns) -> Any:
        return type(self).column


def in_blocks(host: hosting.Host, count: int, positions: Sequence[float]) -> Any:
    """A step asked in arrays; the response with its arrays."""
    params = {"simulation": "s", "step": 0, "symbols": ["E", "F"]}
    message = wire.Received(wire.request(2, "environment.step", params))
    table, pieces, total = blocks.pack({
        "plant": array("I", [0] * count), "symbol": array("I", [0] * count),
        "parameters": memoryview(array("d", [0.5] * count)).cast("B").cast("d", [count, 1]),
        "position": memoryview(array("d", positions)).cast("B").cast("d", [count, 3])})
    message.blocks = blocks.read_blocks(table, bytearray(b"".join(bytes(piece) for piece in pieces)))
    assert total == sum(len(bytes(piece)) for piece in pieces)
    return host.answer(message)


def query(identifier: int, *parameters: float) -> Dict[str, Any]:
    return {"id": identifier, "plant": 0, "symbol": "E", "parameters": list(parameters)}


class Requests(unittest.TestCase):
    def ask(self, host: hosting.Host, method: str, **parameters: Any) -> Any:
        response = host.handle(wire.request(1, method, parameters))
        assert response is not None
        # the answer can be sent
        wire.encode(response)
        return response.get("result", response.get("error"))

    def opened(self, environment: type, simulation: str = "s", **more: Any) -> hosting.Host:
        host = hosting.Host(environment)
        self.assertEqual(self.ask(host, "environment.open", simulation=simulation, **more), {})
        return host

    def step(self, host: hosting.Host, step: int, *queries: Dict[str, Any], simulation: str = "s") -> Any:
        return self.ask(host, "environment.step", simulation=simulation, step=step, iteration=0, time=float(step),
                        queries=list(queries))

    def test_describes_itself(self) -> None:
        self.assertEqual(self.ask(hosting.Host(Doubler), "environment.describe"), {
            "name": "doubler", "summary": "Answers twice what it is sent.", "needs": ["parameters"],
            "inputs": [{"name": "amount", "unit": "g"}], "outputs": [{"name": "twice", "unit": "g"}],
            "stateful": False, "checkpoint": False})

    def test_answers_every_query_by_its_id(self) -> None:
        host = self.opened(Doubler)
        self.assertEqual(self.step(host, 0, query(0, 0.1), query(1, 2.0, 3.0)),
                         {"replies": [{"id": 0, "parameters": [0.2]}, {"id": 1, "parameters": [4.0, 6.0]}]})

    def test_simulations_have_objects_of_their_own(self) -> None:
        host = self.opened(Counter, "a", configuration={"start": 10})
        self.ask(host, "environment.open", simulation="b")
        self.step(host, 0, query(0, 0.0), simulation="a")
        self.assertEqual(self.step(host, 1, query(0, 0.0), simulation="a")["replies"][0]["parameters"], [12.0, None])
        self.assertEqual(self.step(host, 0, query(0, 0.0), simulation="b")["replies"][0]["parameters"], [1.0, None])

    def test_the_same_step_sent_again_is_not_made_again(self) -> None:
        host = self.opened(Counter)
        first = self.step(host, 0, query(0, 1.0))
        self.assertEqual(self.step(host, 0, query(0, 1.0)), first)
        self.assertEqual(self.step(host, 1, query(0, 1.0))["replies"][0]["parameters"][0], 2.0)

    def test_the_same_step_with_other_queries_is_made(self) -> None:
        host = self.opened(Doubler)
        self.step(host, 0, query(0, 1.0))
        self.assertEqual(self.step(host, 0, query(0, 5.0))["replies"][0]["parameters"], [10.0])

    def test_opening_again_starts_over_unless_it_resumes(self) -> None:
        host = self.opened(Counter)
        self.step(host, 0, query(0, 1.0))
        self.ask(host, "environment.open", simulation="s", resume=1)
        self.assertEqual(self.step(host, 1, query(0, 1.0))["replies"][0]["parameters"][0], 2.0)
        self.ask(host, "environment.open", simulation="s")
        self.assertEqual(self.step(host, 0, query(0, 1.0))["replies"][0]["parameters"][0], 1.0)

    def test_saves_and_restores(self) -> None:
        host = self.opened(Counter)
        self.step(host, 0, query(0, 1.0))
        state = self.ask(host, "environment.save", simulation="s")["state"]
        self.step(host, 1, query(0, 1.0))
        self.assertEqual(self.ask(host, "environment.restore", simulation="s", state=state), {})
        self.assertEqual(self.step(host, 1, query(0, 1.0))["replies"][0]["parameters"][0], 2.0)
        self.assertEqual(self.ask(host, "environment.restore", simulation="s", state="?")["code"], hosting.SNAPSHOT)

    def test_closing_forgets_the_simulation(self) -> None:
        host = self.opened(Counter, "gone")
        self.assertEqual(self.ask(host, "environment.close", simulation="gone"), {})
        self.assertIn("gone", Counter.closings)
        error = self.step(host, 0, simulation="gone")
        self.assertEqual(error["code"], hosting.NOT_FOUND)
        self.assertIn('"gone" is not open here. Send environment.open first.', error["message"])

    def test_a_mistake_in_the_class_is_reported_with_its_place(self) -> None:
        host = self.opened(Broken)
        trace = io.StringIO()
        with contextlib.redirect_stderr(trace):
            error = self.step(host, 4, query(0, 0.0))
        self.assertEqual(error["code"], hosting.ENVIRONMENT_FAILED)
        self.assertRegex(error["message"], r"^broken: ZeroDivisionError in step\(\) at test_hosting.py:\d+: "
                                           r"(float )?division by zero")
        self.assertEqual(error["data"], {"environment": "broken", "retryable": False, "step": 4})
        self.assertIn("Traceback", trace.getvalue())

    def test_a_class_without_a_method_is_told_in_whole_sentences(self) -> None:
        class Mistyped(Environment):
            def answr(self, query: Query) -> List[float]:
                return [1]

        host = self.opened(Mistyped)
        with contextlib.redirect_stderr(io.StringIO()):
            error = self.step(host, 4, query(0, 0.0))
        self.assertTrue(error["message"].endswith("defines neither answer(self, query) nor step(self, queries). "
                                                  "The environment's standard error has the whole trace."), error["message"])

    def test_an_answer_that_is_not_finite_is_an_error(self) -> None:
        error = self.step(self.opened(Infinite), 0, query(7, 1.0))
        self.assertEqual(error["code"], hosting.NON_FINITE)
        self.assertIn("infinite: query 7 was answered with inf as value 2", error["message"])

    def test_too_few_answers_are_an_error(self) -> None:
        error = self.step(self.opened(Short), 0, query(0, 1.0))
        self.assertIn("short: step() gave 0 answers to 1 queries", error["message"])

    def test_wrong_shapes_are_refused_with_their_path(self) -> None:
        host = self.opened(Doubler)
        cases: List[Tuple[Dict[str, Any], str]] = [
            ({"id": -1}, "params.queries[0].id"),
            ({"id": 0, "parameters": ["x"]}, "params.queries[0].parameters[0]"),
            ({"id": 0, "position": [1.0, 2.0]}, "params.queries[0].position"),
            ({"id": 0, "following": {"symbol": 1}}, "params.queries[0].following.symbol")]
        for wrong, path in cases:
            error = self.step(host, 0, wrong)
            self.assertEqual((error["code"], error["data"]), (wire.INVALID_PARAMETERS, {"path": path}))
        self.assertEqual(self.ask(host, "environment.dance")["code"], wire.METHOD_NOT_FOUND)

    def test_a_notification_is_not_answered(self) -> None:
        self.assertIsNone(hosting.Host(Doubler).handle(wire.notification("environment.describe", {})))

    def test_a_connection_has_so_many_simulations_and_no_more(self) -> None:
        host = hosting.Host(Doubler())
        with mock.patch.object(hosting, "SIMULATIONS", 3):
            for k in range(3):
                self.assertEqual(self.ask(host, "environment.open", simulation=f"sim-{k}"), {})
            error = self.ask(host, "environment.open", simulation="sim-3")
            self.assertEqual((error["code"], error["data"]["limit"]), (hosting.LIMIT, "simulations"))
            # those that are there may be opened again, and a closed one makes room
            self.assertEqual(self.ask(host, "environment.open", simulation="sim-0"), {})
            self.ask(host, "environment.close", simulation="sim-1")
            self.assertEqual(self.ask(host, "environment.open", simulation="sim-3"), {})

    def test_greets_whoever_connects(self) -> None:
        host = hosting.Host(Doubler)
        self.assertEqual(self.ask(host, "hello", protocol=[1, 2])["protocol"], 1)
        self.assertEqual(self.ask(host, "hello", protocol=[2])["code"], hosting.VERSION_UNKNOWN)


class Offering(unittest.TestCase):
    """A fake server that an environment offers itself to."""

    def setUp(self) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(self.listener.close)
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"

    def test_greets_offers_and_answers(self) -> None:
        errors: List[BaseException] = []

        def run() -> None:
            try:
                with contextlib.redirect_stderr(io.StringIO()):
                    hosting.offer(hosting.Host(Doubler), "twice", self.address)
            except BaseException as error:
                errors.append(error)

        environment = threading.Thread(target=run)
        environment.start()
        connection, _ = self.listener.accept()
        channel = wire.SocketChannel(connection, "environment")
        hello = channel.receive(10)
        assert hello is not None
        self.assertEqual((hello["method"], hello["params"]["roles"]), ("hello", ["environment"]))
        channel.send(wire.result(hello["id"], {"protocol": 1}))
        offer = channel.receive(10)
        assert offer is not None
        self.assertEqual((offer["method"], offer["params"]), ("environment.offer", {"name": "twice"}))
        channel.send(wire.result(offer["id"], {}))
        self.assertEqual(hosting.call(channel, 1, "environment.open", {"simulation": "s"}), {})
        replies = hosting.call(channel, 2, "environment.step", {"simulation": "s", "step": 0, "queries": [query(0, 4)]})
        self.assertEqual(replies, {"replies": [{"id": 0, "parameters": [8.0]}]})
        channel.close()
        environment.join(10)
        self.assertEqual(errors, [])

    def test_a_server_that_is_away_is_named(self) -> None:
        self.listener.close()
        with self.assertRaisesRegex(ConnectionLost, "Nothing answers at " + self.address):
            hosting.offer(hosting.Host(Doubler), "twice", self.address)


class Mistakes(unittest.TestCase):
    """A wrong answer ends neither the program nor the session: it is an error that says what is wrong."""

    def error_of(self, environment: Type[Environment]) -> str:
        host = hosting.Host(environment)
        host.handle(wire.request(1, "environment.open", {"simulation": "s"}))
        heard = io.StringIO()
        with contextlib.redirect_stderr(heard):
            response = host.handle(wire.request(2, "environment.step", {
                "simulation": "s", "step": 3, "queries": [query(0, 1), query(1, 2)]}))
        assert response is not None
        error = response["error"]
        self.assertEqual((error["data"]["step"], error["data"]["retryable"]), (3, False))
        # the person at the program sees it too
        self.assertIn(error["message"].split(": ", 1)[1], heard.getvalue())
        return str(error["message"])

    def test_answers_of_the_wrong_shape(self) -> None:
        for answers, message in (
                (1.5, "step() returned the number 1.5; expected a list with one answer for every query"),
                (None, "step() returned None (NoneType); expected a list"),
                ([1.0, 2.0], "query 0 was answered with the number 1.0; expected a list of the module's values"),
                ([[1], "high"], "query 1 was answered with 'high' (str); expected a list"),
                ([[1], ["high"]], "query 1 was answered with 'high' (str) as value 1; expected a number or None"),
                ([[1], [[2]]], "query 1 was answered with [2] (list) as value 1; expected a number or None"),
                ([[1]], "step() gave 1 answers to 2 queries"),
                ([[1], [float("nan")]], "query 1 was answered with nan as value 1")):
            Careless.answers = answers
            self.assertIn("careless: " + message, self.error_of(Careless))

    def test_columns_of_the_wrong_shape(self) -> None:
        for column, message in (
                (1.5, "step_columns() returned the number 1.5; expected one number for every query"),
                (["a", "b"], "step_columns() returned ['a', 'b'] (list)"),
                ([1.0], "step_columns() returned 1 rows for 2 queries"),
                ([1.0, float("inf")], "query 1 was answered with inf as value 1")):
            WrongColumn.column = column
            self.assertIn("wrongcolumn: " + message, self.error_of(WrongColumn))

    def test_a_mistake_of_the_package_itself_is_an_error_too(self) -> None:
        host = hosting.Host(Doubler)
        with contextlib.redirect_stderr(io.StringIO()):
            response = host.handle(wire.request(2, "environment.open", {"simulation": "s", "seed": "x"}))
        assert response is not None
        self.assertEqual(response["error"]["code"], wire.INTERNAL_ERROR)


class Arrays(unittest.TestCase):
    """Steps in binary blocks, with NumPy and without."""

    def setUp(self) -> None:
        self.modules = [blocks.numpy] if blocks.numpy is None else [blocks.numpy, None]

    def each(self, check: Callable[[], None]) -> None:
        for module in self.modules:
            with mock.patch.object(blocks, "numpy", module), mock.patch.object(hosting, "numpy", module), \
                    mock.patch.object(queries, "numpy", module):
                check()

    def opened(self, environment: Type[Environment]) -> hosting.Host:
        host = hosting.Host(environment)
        host.handle(wire.request(1, "environment.open", {"simulation": "s"}))
        return host

    def test_a_column_answers_a_column(self) -> None:
        def check() -> None:
            response, arrays = in_blocks(self.opened(HeightColumn), 2, [1, 2, 3, 4, 5.5, 6])
            assert response is not None and arrays is not None
            self.assertEqual(response["result"], {})
            self.assertEqual([list(row) for row in arrays["parameters"].tolist()], [[2.0], [5.5]])
        self.each(check)

    def test_text_is_answered_as_text(self) -> None:
        def check() -> None:
            response = self.opened(HeightColumn).handle(wire.request(2, "environment.step", {
                "simulation": "s", "step": 0, "queries": [
                    {"id": 0, "symbol": "E", "parameters": [1], "position": [0, 7, 0]},
                    {"id": 1, "symbol": "D", "parameters": [], "position": [0, 8, 0],
                     "following": {"symbol": "F", "parameters": [2, 3]}}]}))
            assert response is not None
            self.assertEqual(response["result"], {"replies": [{"id": 0, "parameters": [7.0]},
                                                              {"id": 1, "parameters": [8.0]}]})
        self.each(check)

    def test_an_environment_of_single_answers_takes_arrays_too(self) -> None:
        def check() -> None:
            response, arrays = in_blocks(self.opened(Doubler), 2, [0] * 6)
            assert response is not None
            self.assertIsNone(arrays)
            self.assertEqual(response["result"], {"replies": [{"id": 0, "parameters": [1.0]},
                                                              {"id": 1, "parameters": [1.0]}]})
        self.each(check)

    def test_wrong_tables_are_refused_with_their_path(self) -> None:
        entry: Dict[str, Any] = {"name": "a", "dtype": "<f8", "shape": [1], "offset": 0, "bytes": 8}
        cases: List[Tuple[Dict[str, Any], str]] = [
                ({"dtype": "<i8"}, "bin[0].dtype: expected one of <f8, <f4, <u4"),
                ({"shape": [2]}, "bin[0].bytes: shape and dtype make 16 bytes, found 8"),
                ({"shape": [-1]}, "bin[0].shape: expected a list of whole numbers"),
                ({"offset": 4}, "bin[0].offset: expected a multiple of 8 within binBytes=8"),
                ({"offset": 8}, "bin[0].offset: expected a multiple of 8 within binBytes=8")]
        for change, message in cases:
            with self.assertRaises(ProtocolError) as caught:
                blocks.read_blocks([{**entry, **change}], bytearray(8))
            self.assertIn(message, str(caught.exception))

    def test_blocks_cross_a_channel_and_need_agreement(self) -> None:
        one, other = socket.socketpair()
        sender, receiver = wire.SocketChannel(one, "one"), wire.SocketChannel(other, "other")
        receiver.agree({"capabilities": ["bin"]})
        sender.send(wire.notification("x", {}), {"a": array("d", [1.5, 2.5]), "b": array("I", [7])})
        sender.send(wire.notification("y", {}))
        first = receiver.receive(10)
        second = receiver.receive(10)
        assert first is not None and second is not None
        self.assertEqual((first.blocks["a"].tolist(), first.blocks["b"].tolist()), ([1.5, 2.5], [7]))
        self.assertEqual((second["method"], dict(second.blocks)), ("y", {}))
        receiver.agree({})
        sender.send(wire.notification("x", {}), {"a": array("d", [1.5])})
        with self.assertRaisesRegex(ConnectionLost, "binary blocks that were not agreed on"):
            receiver.receive(10)
        sender.close()
        receiver.close()


class Programs(unittest.TestCase):
    """The example of ten lines as a program."""

    def setUp(self) -> None:
        self.command = [sys.executable, str(PACKAGE_FOLDER / "examples" / "ceiling.py")]
        self.variables = {**os.environ, "PYTHONPATH": str(PACKAGE_FOLDER)}

    def test_answers_over_standard_input_and_output(self) -> None:
        requests = [wire.request(1, "environment.open", {"simulation": "s"}),
                    wire.request(2, "environment.step", {"simulation": "s", "step": 0, "queries": [
                        {"id": 0, "symbol": "E", "position": [0.0, 5.9, 0.0]},
                        {"id": 1, "symbol": "E", "position": [0.0, 6.0, 0.0]}]})]
        done = subprocess.run(self.command, input=b"".join(map(wire.encode, requests)), stdout=subprocess.PIPE,
                              env=self.variables, timeout=60, check=True)
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(answers[1]["result"], {"replies": [{"id": 0, "parameters": [1.0]}, {"id": 1, "parameters": [0.0]}]})

    def test_listens_for_a_server(self) -> None:
        with subprocess.Popen([*self.command, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, env=self.variables,
                              text=True) as process:
            try:
                assert process.stdout is not None
                line = process.stdout.readline()
                self.assertRegex(line, r"^listening on 127\.0\.0\.1:\d+$")
                host, port = wire.parse_address(line.split()[-1])
                channel = wire.SocketChannel.connect(host, port, 10)
                self.assertEqual(hosting.call(channel, 1, "environment.describe", {})["name"], "ceiling")
                channel.close()
            finally:
                process.terminate()

    def test_an_address_that_other_machines_reach_is_refused_unless_allowed(self) -> None:
        done = subprocess.run([*self.command, "--listen", "0.0.0.0:0"], capture_output=True, env=self.variables, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("'0.0.0.0' can be reached from other machines", done.stderr)
        self.assertIn("--insecure", done.stderr)
        with subprocess.Popen([*self.command, "--listen", "0.0.0.0:0", "--insecure"], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, env=self.variables, text=True) as process:
            assert process.stdout is not None
            self.assertIn("listening on 0.0.0.0:", process.stdout.readline())
            process.terminate()

    def test_silent_connections_keep_no_server_out(self) -> None:
        def bound() -> None:
            resource.setrlimit(resource.RLIMIT_NOFILE, (40, 40))

        with subprocess.Popen([*self.command, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              env=self.variables, text=True, preexec_fn=bound) as process, contextlib.ExitStack() as stack:
            stack.callback(process.terminate)
            assert process.stdout is not None
            host, port = wire.parse_address(process.stdout.readline().split()[-1])
            known = wire.SocketChannel.connect(host, port, 10)
            stack.callback(known.close)
            self.assertEqual(hosting.call(known, 1, "environment.describe", {})["name"], "ceiling")
            for _ in range(100):
                stack.enter_context(socket.create_connection((host, port), 10))
            for number in range(5):
                channel = wire.SocketChannel.connect(host, port, 10)
                stack.callback(channel.close)
                self.assertEqual(hosting.call(channel, number, "environment.describe", {})["name"], "ceiling")
            # and the one that has spoken was not closed for them
            self.assertEqual(hosting.call(known, 2, "environment.describe", {})["name"], "ceiling")

    def test_a_silent_connection_ends_before_the_first_message_only(self) -> None:
        near, far = socket.socketpair()
        with near, far:
            hosting.answer_all(hosting.Host(Doubler), wire.SocketChannel(near, "silent"), 0.05)
            far.sendall(wire.encode(wire.request(1, "environment.open", {"simulation": "s"})))
            answering = threading.Thread(target=hosting.answer_all, args=(hosting.Host(Doubler), wire.SocketChannel(near, "peer"), 5.0))
            answering.start()
            channel = wire.SocketChannel(far, "host")
            self.assertEqual((channel.receive(10) or {})["id"], 1)
            far.shutdown(socket.SHUT_WR)
            answering.join(10)
            self.assertFalse(answering.is_alive())

    def test_an_interrupt_ends_it_cleanly(self) -> None:
        ways: List[List[str]] = [["--listen", "127.0.0.1:0"], []]
        for arguments in ways:
            # a test that runs in the background is started with interrupts ignored, and hands that on
            with subprocess.Popen([*self.command, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, env=self.variables,
                                  preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)) as process:
                # whatever goes wrong, the end of the block does not wait for it
                watchdog = threading.Timer(60, process.kill)
                watchdog.start()
                self.addCleanup(watchdog.cancel)
                assert process.stdout is not None and process.stdin is not None
                # it is at work
                if arguments:
                    process.stdout.readline()
                else:
                    process.stdin.write(wire.encode(wire.request(1, "environment.describe")))
                    process.stdin.flush()
                    process.stdout.readline()
                process.send_signal(signal.SIGINT)
                _, errors = process.communicate(timeout=60)
                self.assertEqual((process.returncode, errors), (0, b""))

    def test_says_what_it_is_and_how_it_is_used(self) -> None:
        done = subprocess.run([*self.command, "--describe"], stdout=subprocess.PIPE, env=self.variables, timeout=60,
                              check=True)
        self.assertEqual(json.loads(done.stdout)["name"], "ceiling")
        done = subprocess.run([*self.command, "--offer", "nowhere"], stderr=subprocess.PIPE, env=self.variables,
                              timeout=60, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"ceiling: 'nowhere' is not an address. Expected HOST:PORT", done.stderr)


if __name__ == "__main__":
    unittest.main()
