"""Strangers on the wire: silent connections end in time and lock nobody out, and no request keeps the network thread."""

import json
import multiprocessing
import os
import shlex
import socket
import ssl
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any, Dict, List, Optional

from support import REPOSITORY, SECONDS, Process, Server, program

from espalier import Client

HELLO = {"protocol": [1], "roles": ["controller"], "name": "probe", "version": "1"}
PROCESSES = multiprocessing.get_context("fork")
LONGEST_PING = 0.5  # seconds, on a machine that compiles beside the test


class Raw:
    """A connection that speaks lines."""

    def __init__(self, address: str, hello: Optional[Dict[str, Any]] = None) -> None:
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), SECONDS)
        self.lines = self.socket.makefile("rb")
        self.last_id = 0
        self.hello = self.ask("hello", HELLO if hello is None else hello)

    def ask(self, method: str, params: Dict[str, Any]) -> Dict[str, Any]:
        """The answer; notifications before it are skipped."""
        self.last_id += 1
        message = {"jsonrpc": "2.0", "id": self.last_id, "method": method, "params": params}
        self.socket.sendall(json.dumps(message).encode() + b"\n")
        while True:
            line = self.lines.readline()
            if not line:
                raise ConnectionError("closed")
            answer = dict(json.loads(line))
            if answer.get("id") == self.last_id and "method" not in answer:
                return answer

    def close(self) -> None:
        self.lines.close()
        self.socket.close()


class Pinging:
    """A second client, a process of its own, that pings all the time: a long answer that this one reads does not hold it up."""

    def __init__(self, address: str) -> None:
        self._began = PROCESSES.Value("d", time.monotonic())
        self._longest = PROCESSES.Value("d", 0.0)
        self._process = PROCESSES.Process(target=self._ping, args=(address,), daemon=True)
        self._process.start()

    def _ping(self, address: str) -> None:
        peer = Raw(address)
        while True:
            self._began.value = time.monotonic()
            peer.ask("ping", {})
            with self._longest.get_lock():
                self._longest.value = max(self._longest.value, time.monotonic() - self._began.value)
            time.sleep(0.001)

    def take_longest(self) -> float:
        """The longest answer since the last call."""
        with self._longest.get_lock():
            longest = max(self._longest.value, time.monotonic() - self._began.value)
            self._longest.value = 0.0
        return longest

    def stop(self) -> None:
        self._process.terminate()
        self._process.join(SECONDS)


def is_closed_within(peer: socket.socket, seconds: float) -> bool:
    """Whether the other side closes the connection in that time; what it says before is read."""
    end = time.monotonic() + seconds
    try:
        while True:
            peer.settimeout(max(end - time.monotonic(), 0.001))
            if not peer.recv(4096):
                return True
    except socket.timeout:
        return False
    except OSError:
        return True


class Strangers(unittest.TestCase):
    def connect(self, address: str) -> socket.socket:
        host, port = address.rsplit(":", 1)
        made = socket.create_connection((host, int(port)), SECONDS)
        self.addCleanup(made.close)
        return made

    def test_a_peer_that_never_begins_tls_is_closed_in_time(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            certificate, key = os.path.join(folder, "c.pem"), os.path.join(folder, "k.pem")
            subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                            "-nodes", "-days", "2", "-keyout", key, "-out", certificate, "-subj", "/CN=localhost"],
                           capture_output=True, check=True)
            server = Server("--certificate", certificate, "--key", key, "--limit", "handshakeMilliseconds=500")
            self.addCleanup(server.stop)
            silent = [self.connect(address) for address in (server.address, server.http)]
            for peer in silent:
                self.assertTrue(is_closed_within(peer, 10), "a silent peer keeps its connection")
            # TLS is spoken, and no request or hello follows
            trusting = ssl.create_default_context(cafile=certificate)
            trusting.check_hostname = False
            for address in (server.address, server.http):
                encrypted = trusting.wrap_socket(self.connect(address))
                self.addCleanup(encrypted.close)
                self.assertTrue(is_closed_within(encrypted, 10), "a peer that says nothing keeps its connection")

    def test_more_silent_connections_than_descriptors_lock_nobody_out(self) -> None:
        command = (f"ulimit -n 200; exec {shlex.quote(program())} serve --listen 127.0.0.1:0 --http 127.0.0.1:0 "
                   "--log-level off --limit handshakeMilliseconds=60000")
        server = Process(["bash", "-c", command])
        self.addCleanup(server.stop)
        http = server._stream.readline().split()[-1]
        silent = [self.connect(address) for _ in range(200) for address in (server.address, http)]
        for _ in range(3):
            with Client(server.address, timeout=SECONDS) as client:
                self.assertEqual(client.status()["sessions"], 1)
            with socket.create_connection(("127.0.0.1", int(http.rsplit(":", 1)[1])), SECONDS) as browser:
                browser.sendall(b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n")
                self.assertTrue(browser.recv(100).startswith(b"HTTP/1.1 200"))
        self.assertTrue(is_closed_within(silent[0], SECONDS))


class NothingBlocks(unittest.TestCase):
    """The network thread answers pings whatever others ask for."""

    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.models = Path(self.folder.name) / "models"
        self.models.mkdir()
        self.server = Server("--data", str(Path(self.folder.name) / "data"), "--models", str(self.models), "--allow-spawn")
        self.addCleanup(self.server.stop)
        self.peer = Raw(self.server.address)
        self.addCleanup(self.peer.close)
        self.pinging = Pinging(self.server.address)
        self.addCleanup(self.pinging.stop)

    def result(self, method: str, **params: Any) -> Dict[str, Any]:
        answer = self.peer.ask(method, params)
        self.assertIn("result", answer, (method, str(answer)[:300]))
        return dict(answer["result"])

    def greet(self, hello: Dict[str, Any]) -> Dict[str, Any]:
        """The result of hello on a new connection: it is said once on each."""
        peer = Raw(self.server.address, hello)
        self.addCleanup(peer.close)
        self.assertIn("result", peer.hello)
        return dict(peer.hello["result"])

    def test_environments_that_do_not_end_when_they_are_asked(self) -> None:
        # it goes on after its input has ended, and signals do not end it
        command = f"trap '' TERM; {shlex.quote(program())} environment height --stdio; sleep 4"
        model = {"source": "Lsystem: 1\nderivation length: 9\nAxiom: A?E(0)\nA --> A\nendlsystem\n"}
        made: List[str] = []
        for _ in range(12):
            made.append(self.result("simulation.create", model=model, save=False,
                                    environment=[{"type": "stdio", "command": command}])["simulation"])
        self.pinging.take_longest()
        for simulation in made:
            self.result("simulation.delete", simulation=simulation)
        time.sleep(0.5)
        self.assertLess(self.pinging.take_longest(), LONGEST_PING)

    def test_every_method_with_a_big_plant(self) -> None:
        # doubles for AGES steps, to more than a million modules; then each step draws half a million random numbers
        source = ("#define AGES 19\nLsystem: 1\nderivation length: 30\nAxiom: A(0)\nA(x) : x == 15 --> F(1)A(x+1)+(1)A(x+1)\n"
                  "A(x) : x < AGES --> A(x+1)+(1)A(x+1)\nA(x) --> A(AGES+ran(1))\nendlsystem\n")
        simulation = self.result("simulation.create", model={"source": source}, save=False)["simulation"]
        self.result("simulation.step", simulation=simulation, steps=20)
        big = {"simulation": simulation}
        statistics = self.result("simulation.get", **big, what="statistics")["statistics"]
        self.assertGreater(statistics["modules"], 1_000_000)
        snapshot = self.result("simulation.save", **big, snapshot=True)["snapshot"]
        asked: Dict[str, List[Dict[str, Any]]] = {
            "model.check": [{"source": source + " " * 5_000_000}],
            "model.load": [{"source": source}],
            "model.list": [{}],
            "model.save": [{"name": "big", "files": {"big.l": source + " " * 5_000_000}}],
            "model.read": [{"gallery": "light-tree"}, {"saved": "big"}],
            "editor.message": [{"message": "{}"}],
            "simulation.create": [{"model": {"source": source}}],
            "simulation.step": [big],
            "simulation.run": [{**big, "until": 24}],
            "simulation.get": [{**big, "what": what} for what in ("string", "state-hash", "turtle", "statistics", "model")],
            "simulation.save": [{**big, "checkpoint": "kept"}],
            "simulation.restore": [{**big, "checkpoint": "kept"}, {**big, "snapshot": snapshot}],
            "simulation.pause": [big],
            "simulation.set": [{**big, "parameters": {"AGES": 18}}],
            "simulation.edit": [{**big, "action": "prune", "plant": 0, "module": 1}],
            "simulation.fork": [big],
            "simulation.trace": [{**big, "trace": True}],
            "simulation.list": [{}],
            "environment.list": [{}],
            "environment.offer": [{"name": "mine"}],
            "stream.open": [{**big, "what": "turtle"}],
            "stream.ack": [{"stream": "", "sequence": 0}],
            "stream.close": [{"stream": ""}],
            "server.status": [{}],
            "ping": [{"x": [{"a": [1, 2]}] * 200_000}],
            "hello": [HELLO],
            "$/cancel": [{"id": 0}],
            "simulation.reset": [big],
            "simulation.delete": [big],
        }
        schema = json.loads((REPOSITORY / "protocol" / "espalier-1.schema.json").read_text(encoding="utf-8"))
        # the server itself sends these
        sent = {"environment.describe", "environment.open", "environment.step", "environment.save", "environment.restore",
                "environment.close", "stream.data", "stream.end", "server.shutdown", "$/progress"}
        self.assertEqual(set(schema["$defs"]["methods"]) - sent, set(asked))
        stream = ""
        self.pinging.take_longest()
        for method, calls in asked.items():
            for params in calls:
                if method == "hello":
                    result = self.greet(params)
                else:
                    result = self.result(method, **({**params, "stream": stream} if "stream" in params else params))
                stream = result.get("stream", stream)
                longest = self.pinging.take_longest()
                self.assertLess(longest, LONGEST_PING, method)


if __name__ == "__main__":
    unittest.main()
