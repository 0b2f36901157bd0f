"""Environments: the requests of the protocol against a class, and the three ways to meet a server."""

import contextlib
import io
import json
import os
import socket
import subprocess
import sys
import threading
import unittest
from pathlib import Path
from typing import Any, ClassVar, Dict, List, Sequence, Tuple

from espalier import Answer, ConnectionLost, Environment, Query, Variable, hosting, wire

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


def query(identifier: int, *parameters: float) -> Dict[str, Any]:
    return {"id": identifier, "plant": 0, "symbol": "E", "parameters": list(parameters)}


class Requests(unittest.TestCase):
    def ask(self, host: hosting.Host, method: str, **parameters: Any) -> Any:
        response = host.handle(wire.request(1, method, parameters))
        assert response is not None
        # what is answered can be sent
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

    def test_an_answer_that_is_not_finite_is_an_error(self) -> None:
        error = self.step(self.opened(Infinite), 0, query(7, 1.0))
        self.assertEqual(error["code"], hosting.NON_FINITE)
        self.assertIn("infinite answered query 7 with inf as value 2", error["message"])

    def test_too_few_answers_are_an_error(self) -> None:
        error = self.step(self.opened(Short), 0, query(0, 1.0))
        self.assertIn("short gave 0 answers to 1 queries", error["message"])

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


class Programs(unittest.TestCase):
    """The example of ten lines as a program."""

    def setUp(self) -> None:
        self.command = [sys.executable, str(PACKAGE_FOLDER / "examples" / "ceiling.py")]
        self.variables = {**os.environ, "PYTHONPATH": str(PACKAGE_FOLDER)}

    def test_answers_over_standard_input_and_output(self) -> None:
        requests = [wire.request(1, "environment.open", {"simulation": "s"}),
                    wire.request(2, "environment.step", {"simulation": "s", "step": 0, "queries": [
                        {"id": 0, "symbol": "E", "position": [0.0, 2.9, 0.0]},
                        {"id": 1, "symbol": "E", "position": [0.0, 3.0, 0.0]}]})]
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
