"""A peer that means harm, or is broken, costs its own session only; every limit holds at its bound and refuses one past it."""

import json
import socket
import sys
import time
import unittest
from typing import Any, Dict

from soak import resident_bytes
from support import program, stdio

from espalier import Client, Server, ServerError

SECONDS = 30
HELLO = b'{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1]}}\n'
MODEL = "Lsystem: 1\nderivation length: 9\nAxiom: A\nA --> AA\nendlsystem\n"


class Peer:
    """A socket and lines."""

    def __init__(self, address: str, *, greets: bool = True) -> None:
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), SECONDS)
        self.lines = self.socket.makefile("rb")
        if greets:
            self.send(HELLO)
            self.read()

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def ask(self, method: str, **parameters: Any) -> Dict[str, Any]:
        self.send(json.dumps({"jsonrpc": "2.0", "id": 7, "method": method, "params": parameters}).encode() + b"\n")
        return self.read()

    def read(self) -> Dict[str, Any]:
        """The next message; empty when the connection is closed."""
        line = self.lines.readline()
        return dict(json.loads(line)) if line else {}

    def close(self) -> None:
        self.lines.close()
        self.socket.close()


class Hostile(unittest.TestCase):
    def serve(self, *limits: str) -> Server:
        arguments = ["--log-level", "off", "--allow-spawn"]
        for limit in limits:
            arguments += ["--limit", limit]
        server = Server(program(), arguments=arguments)
        self.addCleanup(server.stop)
        return server

    def peer(self, server: Server, *, greets: bool = True) -> Peer:
        made = Peer(server.address, greets=greets)
        self.addCleanup(made.close)
        return made

    def assert_serves(self, server: Server) -> None:
        with server.connect(timeout=SECONDS) as client:
            self.assertTrue(client.check(MODEL).valid)

    def error(self, answer: Dict[str, Any], code: int) -> Dict[str, Any]:
        self.assertEqual(answer.get("error", {}).get("code"), code, answer)
        return dict(answer["error"])

    # ---- peers ----

    def assert_idle_peers_cost_little(self, message: bytes, count: int = 4) -> None:
        server = self.serve()
        before = resident_bytes(server.process_id)
        for _ in range(count):
            peer = self.peer(server)
            peer.send(message)
            self.assertEqual(peer.read()["id"], 7)
        end = time.monotonic() + SECONDS
        while resident_bytes(server.process_id) - before > 60_000_000 and time.monotonic() < end:
            time.sleep(0.1)
        self.assertLess(resident_bytes(server.process_id) - before, 60_000_000)

    def test_an_idle_connection_keeps_no_memory_of_its_largest_message(self) -> None:
        self.assert_idle_peers_cost_little(
            json.dumps({"jsonrpc": "2.0", "id": 7, "method": "ping", "params": {"text": "x" * 40_000_000}}).encode() + b"\n")

    def test_an_idle_connection_keeps_no_memory_of_a_step_of_an_environment(self) -> None:
        self.assert_idle_peers_cost_little(
            b'{"jsonrpc":"2.0","id":7,"method":"environment.step","params":{"queries":[' + b"1," * 10_000_000 + b"1]}}\n")

    def test_many_idle_connections_keep_no_memory_of_messages_that_are_not_large(self) -> None:
        self.assert_idle_peers_cost_little(
            b'{"jsonrpc":"2.0","id":7,"method":"environment.step","params":{"queries":[' + b"1," * 400_000 + b"1]}}\n", 100)

    def test_an_idle_connection_keeps_no_memory_of_answers_that_it_read_late(self) -> None:
        server = self.serve()
        before = resident_bytes(server.process_id)
        peer = self.peer(server)
        count = 300_000
        peer.send(b'{"jsonrpc":"2.0","id":7,"method":"server.status"}\n' * count)
        for _ in range(count):
            self.assertTrue(peer.lines.readline())
        end = time.monotonic() + SECONDS
        while resident_bytes(server.process_id) - before > 60_000_000 and time.monotonic() < end:
            time.sleep(0.1)
        self.assertLess(resident_bytes(server.process_id) - before, 60_000_000)

    def test_an_idle_connection_keeps_no_memory_of_the_text_of_a_model(self) -> None:
        server = self.serve("sourceBytes=100000000")
        # memory that is taken once
        self.assert_serves(server)
        before = resident_bytes(server.process_id)
        peer = self.peer(server)
        self.assertIn("result", peer.ask("model.check", source=MODEL + "\n" * 28_000_000))
        end = time.monotonic() + SECONDS
        while resident_bytes(server.process_id) - before > 15_000_000 and time.monotonic() < end:
            time.sleep(0.1)
        self.assertLess(resident_bytes(server.process_id) - before, 15_000_000)

    def test_a_hello_that_trickles_in_is_given_up(self) -> None:
        server = self.serve("handshakeMilliseconds=300")
        slow = self.peer(server, greets=False)
        begin = time.monotonic()
        try:
            for byte in HELLO[:-1]:  # a byte every now and then
                slow.send(bytes([byte]))
                time.sleep(0.05)
                if time.monotonic() - begin > 10:
                    self.fail("it is still listened to")
        except OSError:
            pass
        answer = slow.read() if time.monotonic() - begin < 10 else {}
        if answer:
            self.assertEqual(answer["error"]["code"], 1005)
        self.assert_serves(server)

    def test_peers_that_say_nothing_are_closed_and_make_room(self) -> None:
        server = self.serve("handshakeMilliseconds=300", "sessions=5")
        silent = [self.peer(server, greets=False) for _ in range(5)]
        for peer in silent:
            self.error(peer.read(), 1005)
            self.assertEqual(peer.read(), {})
            peer.close()
        self.greet(server)

    def greet(self, server: Server) -> Peer:
        """A peer for whom there is room, at the latest when the server has seen that others have left."""
        for _ in range(200):
            again = self.peer(server, greets=False)
            again.send(HELLO)
            if "result" in again.read():
                return again
            time.sleep(0.02)
        self.fail("sessions that ended made no room")

    def test_a_peer_that_vanishes_within_a_step_takes_nothing_with_it(self) -> None:
        server = self.serve()
        with server.connect(timeout=SECONDS) as client:
            plant = client.create(MODEL.replace("length: 9", "length: 1000000").replace("AA", "A"), save=False)
            gone = self.peer(server)
            gone.send(json.dumps({"jsonrpc": "2.0", "id": 3, "method": "simulation.run",
                                  "params": {"simulation": plant.identifier}}).encode() + b"\n")
            # no farewell: the connection is reset
            gone.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\x00\x00\x00\x00\x00\x00\x00")
            gone.close()
            step = plant.step().step
            self.assertEqual(plant.step().step, step + 1)

    def test_what_is_not_a_message_is_answered_and_the_session_goes_on(self) -> None:
        server = self.serve()
        peer = self.peer(server)
        for line, code in ((b"{" * 60 + b"\n", -32700), (b"[" * 100_000 + b"\n", -32700), (b"\xff\xfe\xfd\n", -32700),
                           (b'{"jsonrpc":"2.0","id":1,"method":"\xc3\x28"}\n', -32700), (b"\x00\x00\n", -32700),
                           (b'{"jsonrpc":"2.0","id":1e999,"method":"server.status"}\n', None),
                           (b'{"jsonrpc":"2.0","id":99999999999999999999,"method":"server.status"}\n', -32600),
                           (b'{"jsonrpc":"2.0","id":1,"method":"simulation.step","params":{"simulation":"x","steps":1e400}}\n', None),
                           (b'{"jsonrpc":"2.0","id":1,"method":"simulation.step","params":{"simulation":"x","steps":18446744073709551616}}\n',
                            -32602),
                           (b'{"jsonrpc":"2.0","id":1,"method":"server.status","params":{"a":NaN}}\n', -32700),
                           (b'[{"jsonrpc":"2.0","id":1,"method":"server.status"}]\n', -32600)):
            peer.send(line)
            answer = peer.read()
            self.assertIn("error", answer, line[:80])
            if code is not None:
                self.assertEqual(answer["error"]["code"], code, (line[:80], answer))
        self.assertIn("result", peer.ask("server.status"))

    def test_an_error_quotes_the_beginning_of_a_long_text(self) -> None:
        server = self.serve()
        peer = self.peer(server)
        text = "\u00e9".encode() * 100_000
        for line in (b'{"a":"' + text + b'\xff"}\n', b'{"' + text + b'":1,"' + text + b'":2}\n'):
            peer.send(line)
            answer = peer.lines.readline()
            self.assertIn("error", json.loads(answer))
            self.assertLess(len(answer), 1000)

    def test_keys_that_come_twice_are_refused(self) -> None:
        server = self.serve()
        peer = self.peer(server)
        for line in (b'{"jsonrpc":"2.0","id":1,"id":2,"method":"server.status"}\n',
                     b'{"jsonrpc":"2.0","id":1,"method":"simulation.step","params":{"simulation":"a","simulation":"b"}}\n'):
            peer.send(line)
            self.assertIn("error", peer.read(), line)
        self.assertIn("result", peer.ask("server.status"))

    def test_a_flood_of_requests_is_answered_or_refused_one_by_one(self) -> None:
        server = self.serve("requestsPerSession=10")
        with server.connect(timeout=SECONDS) as client:
            plant = client.create(MODEL.replace("length: 9", "length: 1000000").replace("AA", "A"), save=False)
        flood = self.peer(server)
        for number in range(2000):
            flood.send(json.dumps({"jsonrpc": "2.0", "id": number, "method": "simulation.step",
                                   "params": {"simulation": plant.identifier}}).encode() + b"\n")
        answers: Dict[int, Dict[str, Any]] = {}
        while len(answers) < 2000:
            answer = flood.read()
            self.assertNotIn(answer["id"], answers)
            answers[answer["id"]] = answer
        codes = {answer["error"]["data"]["limit"] for answer in answers.values() if "error" in answer}
        self.assertLessEqual(codes, {"requestsPerSession"})
        made = sum("result" in answer for answer in answers.values())
        with server.connect(timeout=SECONDS) as client:
            self.assertEqual(client.simulation(plant.identifier).get("statistics")["step"], made)

    # ---- limits, at the bound and one past it ----

    def test_requests_of_a_session(self) -> None:
        server = self.serve("requestsPerSession=3")
        peer = self.peer(server)
        source = MODEL.replace("length: 9", "length: 1000000000").replace("AA", "A")
        made = peer.ask("simulation.create", model={"source": source}, save=False)
        run = {"method": "simulation.run", "params": {"simulation": made["result"]["simulation"]}}
        for number in (101, 102, 103, 104):
            peer.send(json.dumps({"jsonrpc": "2.0", "id": number, **run}).encode() + b"\n")
        refusal = peer.read()
        self.assertEqual(refusal["id"], 104)
        self.assertEqual({key: refusal["error"]["data"][key] for key in ("limit", "bound", "value")},
                         {"limit": "requestsPerSession", "bound": 3, "value": 4})
        # one that ends makes room for one
        peer.send(b'{"jsonrpc":"2.0","method":"$/cancel","params":{"id":102}}\n')
        self.assertEqual(peer.read()["id"], 102)
        peer.send(b'{"jsonrpc":"2.0","id":105,"method":"server.status"}\n')
        answer = peer.read()
        self.assertEqual((answer["id"], "result" in answer), (105, True))

    def test_sessions(self) -> None:
        server = self.serve("sessions=3")
        peers = [self.peer(server) for _ in range(3)]
        extra = self.peer(server, greets=False)
        extra.send(HELLO)
        error = self.error(extra.read(), 1004)
        self.assertEqual((error["data"]["limit"], error["data"]["bound"]), ("sessions", 3))
        peers[0].close()
        # those that were refused and do not leave take no room
        self.greet(server)

    def test_line_bytes(self) -> None:
        server = self.serve("lineBytes=2000")
        peer = self.peer(server)
        line = b'{"jsonrpc":"2.0","id":1,"method":"server.status","params":{"x":"'
        peer.send(line + b"x" * (2000 - len(line) - 3) + b'"}}\n')
        self.assertIn("result", peer.read())
        peer.send(line + b"x" * (2001 - len(line) - 3) + b'"}}\n')
        self.assertEqual(self.error(peer.read(), 1004)["data"], {"limit": "lineBytes", "value": 2001, "bound": 2000})
        self.assertEqual(peer.read(), {})
        self.assert_serves(server)

    def test_block_bytes(self) -> None:
        server = self.serve("blockBytes=1000")
        for size in (1000, 1008):
            peer = self.peer(server, greets=False)
            peer.send(b'{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"capabilities":["bin"]}}\n')
            peer.read()
            head = {"jsonrpc": "2.0", "id": 2, "method": "server.status", "params": {}, "binBytes": size, "bin": [
                {"name": "x", "dtype": "<f8", "shape": [size // 8], "offset": 0, "bytes": size}]}
            peer.send(json.dumps(head).encode() + b"\n" + b"\x00" * size)
            answer = peer.read()
            if size == 1000:
                self.assertIn("result", answer)
            else:
                self.assertEqual(self.error(answer, 1004)["data"], {"limit": "blockBytes", "value": 1008, "bound": 1000})

    def test_simulations_and_streams(self) -> None:
        server = self.serve("simulations=2", "streamsPerSession=2")
        with server.connect(timeout=SECONDS) as client:
            plants = [client.create(MODEL) for _ in range(2)]
            self.assert_limit(lambda: client.create(MODEL), "simulations", 2)
            streams = [plants[0].stream("string") for _ in range(2)]
            self.assert_limit(lambda: plants[0].stream("string"), "streamsPerSession", 2)
            streams[0].close()
            plants[0].stream("string").close()
            plants[1].delete()
            client.create(MODEL)

    def assert_limit(self, call: Any, limit: str, bound: int) -> None:
        with self.assertRaises(ServerError) as caught:
            call()
        self.assertEqual(caught.exception.code, 1004)
        data = caught.exception.data
        assert isinstance(data, dict)
        self.assertEqual((data["limit"], data["bound"]), (limit, bound))

    def test_of_each_simulation(self) -> None:
        def grown(source: str, *limits: str) -> Client:
            server = self.serve(*limits)
            client = server.connect(timeout=SECONDS)
            self.addCleanup(client.close)
            plant = client.create(source, environment=[{"type": "height"}], save=False)
            plant.step()
            return client

        asking = "Lsystem: 1\nderivation length: 1\nAxiom: {}\nA --> A\nendlsystem\n"
        nested = "Lsystem: 1\nderivation length: 1\nAxiom: A\nA --> {}\nendlsystem\n"
        for limit, bound, within, beyond in (
                ("modules", 8, nested.format("B" * 8), nested.format("B" * 9)),
                ("stringBytes", 100, nested.format("B" * 50), nested.format("B" * 51)),
                ("queries", 3, asking.format("?E(0)" * 3), asking.format("?E(0)" * 4)),
                ("turtleStack", 4, nested.format("[" * 4 + "F" + "]" * 4), nested.format("[" * 5 + "F?E(0)" + "]" * 5))):
            with self.subTest(limit):
                grown(within, f"{limit}={bound}")
                if limit == "turtleStack":
                    server = self.serve(f"{limit}={bound}")
                    with server.connect(timeout=SECONDS) as client:
                        plant = client.create(beyond.replace("length: 1", "length: 2"), environment=[{"type": "height"}])
                        plant.step()
                        self.assert_limit(plant.step, limit, bound)
                else:
                    self.assert_limit(lambda: grown(beyond, f"{limit}={bound}"), limit, bound)

    def test_source_bytes(self) -> None:
        with self.serve("sourceBytes=1000").connect(timeout=SECONDS) as client:
            self.assertTrue(client.check(MODEL).valid)
            model = client.check(MODEL + "/* " + "x" * 2000 + " */\nB --> B\n" * 200)
            self.assertFalse(model.valid)
            self.assertIn("1000", str(model))

    def test_a_line_of_a_spawned_environment_is_as_long_as_one_of_a_peer_and_not_longer(self) -> None:
        script = ("import json, sys\n"
                  "for line in sys.stdin:\n"
                  "    asked = json.loads(line)\n"
                  "    result = {'replies': []} if asked['method'] == 'environment.step' else {}\n"
                  "    said = json.dumps({'jsonrpc': '2.0', 'id': asked['id'], 'result': result})\n"
                  "    print(said + ' ' * (int(sys.argv[1]) - len(said)), flush=True)\n")
        with self.serve("lineBytes=2000").connect(timeout=SECONDS) as client:
            def grown(length: int) -> None:
                client.create("Lsystem: 1\nAxiom: ?E(0)A\nA --> A\nendlsystem\n", environment=[
                    {"type": "stdio", "command": stdio([sys.executable, "-c", script, str(length)])[len("stdio:"):]}]).step()

            grown(2000)
            with self.assertRaisesRegex(ServerError, "the limit 'lineBytes' is 2000") as caught:
                grown(2001)
            self.assertEqual(caught.exception.code, 1006)

    def test_an_answer_of_an_environment_is_read_for_so_long_at_most(self) -> None:
        # the text is made before, so that only reading it takes long
        script = ("import json, sys\n"
                  "many = '[' + '[],' * 20_000_000 + '[]]'\n"
                  "for line in sys.stdin:\n"
                  "    asked = json.loads(line)\n"
                  "    replies = many if asked['method'] == 'environment.step' else '[]'\n"
                  "    print('{\"jsonrpc\":\"2.0\",\"id\":' + json.dumps(asked['id']) + ',\"result\":{\"replies\":' + replies + '}}', flush=True)\n")
        with self.serve("environmentStepMilliseconds=1000").connect(timeout=SECONDS) as client:
            plant = client.create("Lsystem: 1\nAxiom: ?E(0)A\nA --> A\nendlsystem\n", environment=[
                {"type": "stdio", "command": stdio([sys.executable, "-c", script])[len("stdio:"):]}])
            with self.assertRaisesRegex(ServerError, "did not answer within 1000 ms"):
                plant.step()

    def test_steps_of_an_environment_take_so_long_at_most(self) -> None:
        server = self.serve("environmentStepMilliseconds=200")
        silent = self.peer(server)
        self.assertIn("result", silent.ask("environment.offer", name="mute"))
        with server.connect(timeout=SECONDS) as client:
            with self.assertRaises(ServerError) as caught:
                client.create("Lsystem: 1\nAxiom: ?E(0)A\nA --> A\nendlsystem\n",
                              environment=[{"type": "offered", "name": "mute"}]).step()
            self.assertIn(caught.exception.code, (1005, 1006))
            self.assertTrue(client.check(MODEL).valid)


if __name__ == "__main__":
    unittest.main()
