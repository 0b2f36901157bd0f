"""The client against a fake server at the other end of a socket pair."""

import base64
import socket
import threading
import unittest
from typing import Any, Callable, Dict, List, Optional

from espalier import Client, ConnectionLost, EspalierError, ServerError, Server, ServerFailed, wire

RECORD = {"plant": 0, "module": 1, "symbol": "F", "parameters": [1.5], "position": [0.0, 1.5, 0.0],
          "heading": [0.0, 1.0, 0.0], "left": [-1.0, 0.0, 0.0], "up": [0.0, 0.0, -1.0], "width": 0.1, "colour": 96,
          "branchOrder": 0, "parent": None}
STEPPED = {"step": 3, "finished": False, "truncated": False, "saved": False, "statistics": {"modules": 5, "queries": 1}}


def frame(step: int, finished: bool = False) -> wire.Message:
    return wire.notification("stream.data", {"stream": "t1", "simulation": "s1", "step": step, "sequence": step,
                                             "key": True, "missed": 0, "finished": finished, "records": [RECORD]})


class FakeServer:
    """Answers requests by a table of method to result (or a function of the params), and keeps what it was sent."""

    def __init__(self, results: Dict[str, Any]) -> None:
        near, far = socket.socketpair()
        self.near = wire.SocketChannel(near, "the server")
        self.far = wire.SocketChannel(far, "the client")
        self.received: List[wire.Message] = []
        self.before: Dict[str, List[wire.Message]] = {}  # sent before the answer of a method
        self._results = {"hello": {"protocol": 1, "session": "1", "roles": ["controller", "viewer"]}, **results}
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while True:
            message: Optional[wire.Message] = self.far.receive()
            if message is None:
                return
            self.received.append(message)
            if "id" not in message:
                continue
            for notification in self.before.get(message["method"], []):
                self.far.send(notification)
            answer = self._results.get(message["method"])
            if isinstance(answer, Exception):
                self.far.close()
                return
            if callable(answer):
                answer = answer(message["params"])
            if isinstance(answer, dict) and "code" in answer:
                self.far.send({"jsonrpc": "2.0", "id": message["id"], "error": answer})
            else:
                self.far.send(wire.result(message["id"], answer))

    def close(self) -> None:
        self.near.close()
        self._thread.join(10)
        self.far.close()


class Talking(unittest.TestCase):
    def client(self, results: Dict[str, Any]) -> Client:
        self.server = FakeServer(results)
        self.addCleanup(self.server.close)
        return Client.over(self.server.near, timeout=10)

    def sent(self, method: str) -> Any:
        return [message["params"] for message in self.server.received if message["method"] == method]

    def test_says_hello_first(self) -> None:
        self.client({})
        self.assertEqual(self.server.received[0]["method"], "hello")
        self.assertEqual((self.sent("hello")[0]["protocol"], self.sent("hello")[0]["roles"]), ([1], ["controller", "viewer"]))

    def test_creates_and_steps(self) -> None:
        client = self.client({"simulation.create": {"simulation": "s1", "step": 0}, "simulation.step": STEPPED,
                              "simulation.get": {"step": 3, "string": "FFA"}})
        simulation = client.create("Lsystem: 1", seed=7, environment=[{"type": "honda", "radius": 0.5}],
                                   plants=[(1.0, 0.0, 0.0)], save=False)
        self.assertEqual(self.sent("simulation.create"), [{
            "model": {"source": "Lsystem: 1"}, "seed": 7, "environment": [{"type": "honda", "radius": 0.5}],
            "plants": [{"position": [1.0, 0.0, 0.0]}], "save": False}])
        made = simulation.step(3)
        self.assertEqual((made.step, made.finished, made.statistics["modules"]), (3, False, 5))
        self.assertEqual(self.sent("simulation.step"), [{"simulation": "s1", "steps": 3}])
        self.assertEqual(simulation.string(), "FFA")

    def test_a_model_is_given_in_exactly_one_way(self) -> None:
        client = self.client({})
        with self.assertRaisesRegex(EspalierError, "in exactly one way"):
            client.create()
        with self.assertRaisesRegex(EspalierError, "in exactly one way"):
            client.create("Lsystem: 1", gallery="bush")

    def test_frames_that_arrive_before_an_answer_are_kept_and_acknowledged(self) -> None:
        client = self.client({"simulation.create": {"simulation": "s1"}, "stream.open": {"stream": "t1"},
                              "simulation.step": STEPPED, "stream.close": {}})
        simulation = client.create(gallery="bush")
        with simulation.stream(symbols=["F"]) as stream:
            self.server.before["simulation.step"] = [frame(1), frame(2, finished=True)]
            simulation.step()
            frames = list(stream)
        self.assertEqual([item.step for item in frames], [1, 2])
        self.assertEqual(frames[0].records[0].position, (0.0, 1.5, 0.0))
        self.assertEqual(frames[0].records[0].branch_order, 0)
        self.assertEqual(self.sent("stream.ack"), [{"stream": "t1", "sequence": 1}, {"stream": "t1", "sequence": 2}])
        self.assertEqual(self.sent("stream.open")[0]["select"], {"symbols": ["F"]})
        self.assertEqual(self.sent("stream.close"), [{"stream": "t1"}])

    def test_a_stream_that_the_server_ends_says_why(self) -> None:
        client = self.client({"simulation.create": {"simulation": "s1"}, "stream.open": {"stream": "t1"},
                              "simulation.delete": {}, "stream.close": {}})
        simulation = client.create(gallery="bush")
        stream = simulation.stream()
        self.server.before["simulation.delete"] = [
            wire.notification("stream.end", {"stream": "t1", "reason": "the simulation was deleted"})]
        simulation.delete()
        with self.assertRaisesRegex(EspalierError, "The stream has ended: the simulation was deleted"):
            stream.read(10)

    def test_errors_carry_code_message_and_data(self) -> None:
        failing = {"code": 1006, "message": "the environment 'light' is away", "data": {"step": 4, "retryable": True}}
        client = self.client({"simulation.create": {"simulation": "s1"}, "simulation.step": failing})
        with self.assertRaises(ServerError) as caught:
            client.create(gallery="bush").step()
        self.assertEqual((caught.exception.code, str(caught.exception), caught.exception.step),
                         (1006, "the environment 'light' is away", 4))
        self.assertTrue(caught.exception.is_retryable)

    def test_snapshots_are_bytes(self) -> None:
        packed = base64.b64encode(b"ESPALIER\x01").decode()
        client = self.client({"simulation.create": {"simulation": "s1"}, "simulation.save": {"snapshot": packed},
                              "simulation.restore": {}})
        simulation = client.create(gallery="bush")
        simulation.restore(simulation.save())
        self.assertEqual(self.sent("simulation.restore"), [{"simulation": "s1", "snapshot": packed}])

    def test_steps_end_when_the_model_is_finished(self) -> None:
        steps: List[int] = []

        def step(parameters: Dict[str, Any]) -> Dict[str, Any]:
            steps.append(len(steps) + 1)
            return {**STEPPED, "step": len(steps), "finished": len(steps) == 3}

        client = self.client({"simulation.create": {"simulation": "s1"}, "simulation.step": step})
        self.assertEqual([made.step for made in client.create(gallery="bush").steps()], [1, 2, 3])

    def test_a_server_that_goes_away_is_a_lost_connection(self) -> None:
        client = self.client({"server.status": RuntimeError()})
        with self.assertRaisesRegex(ConnectionLost, "closed the connection before it answered server.status"):
            client.status()

    def test_a_server_that_is_silent_is_a_timeout(self) -> None:
        release = threading.Event()
        waiting: Callable[[Dict[str, Any]], Any] = lambda _: {} if release.wait(10) else {}
        client = self.client({"server.status": waiting})
        self.addCleanup(release.set)
        client._timeout = 0.05
        with self.assertRaisesRegex(ConnectionLost, "did not answer server.status within 0.05 seconds"):
            client.status()


class Launching(unittest.TestCase):
    def test_a_program_that_is_not_there(self) -> None:
        with self.assertRaisesRegex(ServerFailed, "There is no program 'no-such-espalier'. Install Espalier"):
            Server("no-such-espalier")

    def test_a_program_that_ends_at_once(self) -> None:
        with self.assertRaisesRegex(ServerFailed, "ended with status 0 before it listened"):
            Server("true")


if __name__ == "__main__":
    unittest.main()
