"""The transports of a server as strangers use them: raw sockets, HTTP, WebSockets, a Unix socket, TLS."""

import contextlib
import io
import json
import os
import re
import signal
import socket
import ssl
import subprocess
import tempfile
import threading
import unittest
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any, Dict, Iterator, List
from unittest import mock

from support import EXAMPLES, REPOSITORY, Process, Server, espalier, model, program, python

from espalier import Client, ConnectionLost, Environment, Query, ServerError, hosting, wire

MODEL = ("Lsystem: 1\nderivation length: 6\nAxiom: F(1)A?E(0)\n"
         "A > ?E(h) : h < 3 --> F(1)A\nA > ?E(h) : h >= 3 --> *\nendlsystem\n")


class Height(Environment):
    """Answers the height."""

    needs = ("position",)

    def answer(self, query: Query) -> List[float]:
        return [query.position[1]]


@contextlib.contextmanager
def offered(address: str, environment: Any, name: str) -> Iterator[None]:
    """An environment offered to a server over any transport, answered by a thread."""
    channel = hosting.open_offer(name, address)
    thread = threading.Thread(target=hosting.answer_all, args=(hosting.Host(environment), channel), daemon=True)
    thread.start()
    try:
        yield
    finally:
        channel.close()
        thread.join(30)


class RawSocket(unittest.TestCase):
    """Only what protocol/README.md says, a socket and text: create, step and watch."""

    def setUp(self) -> None:
        self.server = Server()
        self.addCleanup(self.server.stop)
        host, port = self.server.address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), 30)
        self.addCleanup(self.socket.close)
        self.lines = self.socket.makefile("r", encoding="utf-8", newline="\n")
        self.addCleanup(self.lines.close)

    def say(self, text: str) -> None:
        self.socket.sendall(text.encode("utf-8") + b"\n")

    def hear(self) -> Dict[str, Any]:
        heard: Dict[str, Any] = json.loads(self.lines.readline())
        return heard

    def test_creates_steps_and_watches(self) -> None:
        self.say('{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"roles":["controller"],'
                 '"name":"nc","version":"1"}}')
        self.assertEqual(self.hear()["result"]["protocol"], 1)
        self.say('{"jsonrpc":"2.0","id":2,"method":"simulation.create","params":{"model":{"source":' + json.dumps(MODEL)
                 + '},"seed":7,"environment":[{"type":"height"}]}}')
        created = self.hear()["result"]
        name = json.dumps(created["simulation"])
        self.say('{"jsonrpc":"2.0","id":3,"method":"stream.open","params":{"simulation":' + name
                 + ',"what":"string"}}')
        self.say('{"jsonrpc":"2.0","id":4,"method":"simulation.step","params":{"simulation":' + name + ',"steps":2}}')
        heard = [self.hear() for _ in range(5)]
        answers = {message["id"]: message["result"] for message in heard if "id" in message}
        frames = [message["params"] for message in heard if message.get("method") == "stream.data"]
        self.assertEqual(answers[4]["step"], 2)
        self.assertEqual([(frame["step"], frame["string"]) for frame in frames],
                         [(0, "F(1)A?E(0)"), (1, "F(1)F(1)A?E(1)"), (2, "F(1)F(1)F(1)A?E(2)")])

    def test_blocks_that_were_not_agreed_end_the_session(self) -> None:
        self.say('{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1]}}')
        self.hear()
        self.say('{"jsonrpc":"2.0","id":2,"method":"server.status","params":{},"bin":[],"binBytes":8}')
        self.assertEqual(self.hear()["error"]["code"], 1002)
        self.assertEqual(self.lines.readline(), "")


class Http(unittest.TestCase):
    def setUp(self) -> None:
        self.server = Server("--allow-origin", "https://plants.example")
        self.addCleanup(self.server.stop)

    def get(self, path: str) -> "tuple[int, str, str]":
        try:
            with urllib.request.urlopen(f"http://{self.server.http}{path}", timeout=30) as response:
                return response.status, response.headers["Content-Type"], response.read().decode("utf-8")
        except urllib.error.HTTPError as error:
            with error:
                return error.code, error.headers["Content-Type"], error.read().decode("utf-8")

    def test_pages(self) -> None:
        status, kind, text = self.get("/")
        self.assertEqual((status, kind), (200, "text/html; charset=utf-8"))
        self.assertIn("<title>Espalier</title>", text)
        status, kind, text = self.get("/health")
        self.assertEqual((status, kind, json.loads(text)["status"]), (200, "application/json", "ok"))
        self.assertEqual(self.get("/nothing")[0], 404)
        self.assertEqual(self.get("/espalier/1")[0], 426)

    def test_metrics_count_what_is_done(self) -> None:
        with Client(self.server.address) as client:
            simulation = client.create(MODEL, environment=[{"type": "height"}], seed=1)
            simulation.step(3)
            _, kind, text = self.get("/metrics")
        self.assertTrue(kind.startswith("text/plain"))
        self.assertIn("espalier_steps_total 3\n", text)
        self.assertIn("espalier_queries_total 3\n", text)
        self.assertIn("espalier_sessions 1\n", text)
        self.assertIn("espalier_simulations 1\n", text)
        self.assertRegex(text, r"(?m)^espalier_workers [1-9]\d*$")
        self.assertIn('espalier_step_seconds_bucket{le="+Inf"} 3\n', text)
        self.assertIn("espalier_step_seconds_count 3\n", text)
        for line in text.splitlines():
            self.assertRegex(line, r'^(# (HELP|TYPE) espalier_\w+ .+|espalier_\w+(\{(\w+="[^"]+",?)+\})? [0-9.e+-]+)$')

    def upgrade(self, origin: str) -> str:
        host, port = self.server.http.rsplit(":", 1)
        with socket.create_connection((host, int(port)), 30) as connection:
            connection.sendall((f"GET /espalier/1 HTTP/1.1\r\nHost: {self.server.http}\r\nUpgrade: websocket\r\n"
                                "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                                f"Sec-WebSocket-Version: 13\r\nOrigin: {origin}\r\n\r\n").encode("ascii"))
            return connection.recv(1000).decode("ascii")

    def test_pages_of_other_hosts_open_no_websocket(self) -> None:
        self.assertIn("403 Forbidden", self.upgrade("https://elsewhere.example"))
        self.assertIn("101 Switching Protocols", self.upgrade("http://" + self.server.http))
        self.assertIn("101 Switching Protocols", self.upgrade("https://plants.example"))

    def test_rubbish_is_no_request(self) -> None:
        host, port = self.server.http.rsplit(":", 1)
        with socket.create_connection((host, int(port)), 30) as connection:
            connection.sendall(b"\x00\x01rubbish\r\n\r\n")
            self.assertEqual(connection.recv(100), b"")
        with socket.create_connection((host, int(port)), 30) as connection:
            connection.sendall(b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 5000)
            # bytes that were not read can make the system reset the connection before the answer has come
            self.assertIn(self.ended(connection)[:12], (b"", b"HTTP/1.1 431"))
        self.assertEqual(self.get("/health")[0], 200)

    @staticmethod
    def ended(connection: socket.socket) -> bytes:
        try:
            return connection.recv(100)
        except ConnectionResetError:
            return b""


class EveryTransport(unittest.TestCase):
    """The same model and seed give the same state hash, however the environment is spoken to."""

    def hash_of(self, client: Client, environment: Dict[str, Any], source: str = MODEL) -> str:
        simulation = client.create(source, environment=[environment], seed=7)
        while not simulation.step().finished:
            pass
        return str(simulation.get("state-hash")["stateHash"])

    def test_one_hash(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        server = Server("--allow-spawn", "--allow-dial", "any")
        self.addCleanup(server.stop)
        built_in = Process([program(), "environment", "height", "--listen", "127.0.0.1:0"])
        self.addCleanup(built_in.stop)
        hashes: Dict[str, str] = {}
        with Client(server.address) as client:
            hashes["inside"] = self.hash_of(client, {"type": "height"})
            hashes["tcp, dialled"] = self.hash_of(client, {"type": "tcp", "address": built_in.address})
            hashes["stdio"] = self.hash_of(client, {"type": "stdio", "command": " ".join(
                f"'{word}'" for word in [program(), "environment", "height", "--stdio"])})
            for capabilities in ((), ("bin",)):
                way = "blocks" if capabilities else "text"
                with mock.patch.object(wire, "CAPABILITIES", capabilities):
                    for address in (server.address, "ws://" + server.http):
                        name = f"{address.split(':')[0]}-{way}"
                        with offered(address, Height, name):
                            hashes[f"offered over {name}"] = self.hash_of(client, {"type": "offered", "name": name})
        with Client("ws://" + server.http) as client:
            hashes["controlled over a WebSocket"] = self.hash_of(client, {"type": "height"})
        self.assertEqual(set(hashes.values()), {hashes["inside"]}, hashes)

    def test_one_hash_with_any_number_of_threads(self) -> None:
        # chance and queries in a string long enough to be divided among threads
        source = ("Lsystem: 1\nderivation length: 14\nAxiom: A(1)?E(0)\n"
                  "A(x) --> A(ran(1))[+(90*x)F(x)?E(x)]A(ran(1))\nendlsystem\n")
        hashes: Dict[str, str] = {}
        for threads in ("1", "2", "4"):
            with tempfile.TemporaryDirectory() as folder:
                server = Server("--threads", threads, "--data", folder)
                with Client(server.address) as client:
                    hashes[f"inside, {threads} threads"] = self.hash_of(client, {"type": "height"}, source)
                with Client("ws://" + server.http) as client, offered(server.address, Height, "height"):
                    hashes[f"offered, {threads} threads"] = self.hash_of(client, {"type": "offered", "name": "height"},
                                                                         source)
                # killed, and started again with another number
                server.process.kill()
                server.stop()
                again = Server("--threads", "3", "--data", folder)
                with Client(again.address) as client:
                    for simulation in client.simulations():
                        found = client.simulation(str(simulation["simulation"])).get("state-hash")["stateHash"]
                        hashes[f"{simulation['environment']} killed, {threads} threads"] = str(found)
                again.stop()
        self.assertEqual(len(hashes), 12)
        self.assertEqual(set(hashes.values()), {hashes["inside, 1 threads"]}, hashes)

    def test_a_unix_socket(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "espalier.socket")
            server = Server(listen="unix:" + path)
            try:
                self.assertEqual(server.first_line, "listening on unix:" + path)
                self.assertEqual(os.stat(path).st_mode & 0o777, 0o600)
                with Client("unix:" + path) as client:
                    self.assertEqual(client.create(MODEL, environment=[{"type": "height"}], seed=1).step(2).step, 2)
                refused = espalier("serve", "--listen", "unix:" + path, status=1)
                self.assertIn("another server does. Choose another path with --listen", refused.stderr)
            finally:
                server.stop()
            self.assertFalse(os.path.exists(path))
            with self.assertRaisesRegex(ConnectionLost, "Nothing answers at unix:"):
                Client("unix:" + path)

    def test_a_unix_socket_takes_the_place_of_a_dead_socket_only(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path, link = os.path.join(folder, "notes.txt"), os.path.join(folder, "link")
            Path(path).write_text("notes", encoding="utf-8")
            os.symlink(path, link)
            for taken in (path, link):
                refused = espalier("serve", "--listen", "unix:" + taken, status=1)
                self.assertIn("a file that is no socket has this name. Choose another path with --listen.", refused.stderr)
            self.assertEqual((Path(path).read_text(encoding="utf-8"), os.readlink(link)), ("notes", path))
            refused = espalier("serve", "--listen", f"unix:{folder}/" + "x" * 200, status=1)
            self.assertIn("and 107 are the most. Choose a shorter path with --listen.", refused.stderr)
            # one that was killed leaves its socket behind
            dead = os.path.join(folder, "dead")
            killed = Server(listen="unix:" + dead)
            killed.process.kill()
            killed.stop()
            self.assertTrue(os.path.exists(dead))
            server = Server(listen="unix:" + dead)
            self.addCleanup(server.stop)
            with Client("unix:" + dead) as client:
                self.assertEqual(client.simulations(), [])

    def test_a_server_that_ends_leaves_the_unix_socket_of_another(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "socket")
            first = Server(listen="unix:" + path)
            self.addCleanup(first.stop)
            os.remove(path)
            second = Server(listen="unix:" + path)
            self.addCleanup(second.stop)
            first.stop()
            with Client("unix:" + path) as client:
                self.assertEqual(client.simulations(), [])
            second.stop()
            self.assertFalse(os.path.exists(path))

    def test_encrypted(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            certificate, key = os.path.join(folder, "c.pem"), os.path.join(folder, "k.pem")
            made = subprocess.run(
                ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
                 "-days", "2", "-keyout", key, "-out", certificate, "-subj", "/CN=localhost",
                 "-addext", "subjectAltName=IP:127.0.0.1"], capture_output=True, check=False)
            self.assertEqual(made.returncode, 0, made.stderr)
            server = Server("--certificate", certificate, "--key", key, "--token", "secret")
            self.addCleanup(server.stop)
            trusting = ssl.create_default_context(cafile=certificate)
            with mock.patch.object(ssl, "create_default_context", lambda: trusting):
                for address in ("tls://" + server.address, "wss://" + server.http):
                    with Client(address, token="secret") as client:
                        self.assertEqual(client.create(MODEL, environment=[{"type": "height"}]).step(2).step, 2)
            # the command line too, when it trusts the certificate
            for address in ("tls://" + server.address, "wss://" + server.http):
                told = espalier("connect", address, "--trust", certificate, "--token", "secret", "list").stdout
                self.assertIn('"step":2', told)
                self.assertIn("verify failed", espalier("connect", address, "--token", "secret", "list", status=1).stderr)
                self.assertIn("The server does not know this token", espalier(
                    "connect", address, "--trust", certificate, "--token", "guess", "list", status=1).stderr)
            # a peer without TLS gets nothing
            with self.assertRaises(ConnectionLost):
                Client(server.address, token="secret", timeout=30)
            with self.assertRaisesRegex(ConnectionLost, "does not accept an encrypted connection"):
                Client("tls://" + server.address, token="secret")
            wrong = espalier("serve", "--listen", "127.0.0.1:0", "--certificate", key, "--key", key, status=1)
            self.assertIn("./dev certificate makes one for tests", wrong.stderr)
            self.check_renewal(folder)
            # a key of another kind: OpenSSL takes it, and every connection would fail
            other = os.path.join(folder, "rsa.pem")
            subprocess.run(["openssl", "genrsa", "-out", other, "2048"], check=True, capture_output=True)
            wrong = espalier("serve", "--listen", "127.0.0.1:0", "--certificate", certificate, "--key", other, status=1)
            self.assertIn("is not that of the certificate", wrong.stderr)

    def check_renewal(self, folder: str) -> None:
        """SIGHUP takes a new certificate, and keeps the old one when the new one is wrong."""
        files = [os.path.join(folder, name) for name in ("now.pem", "now.key")]

        def renew(name: str) -> None:
            subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                            "-keyout", files[1], "-out", files[0], "-subj", f"/CN={name}"], check=True, capture_output=True)

        renew("first")
        server = Server("--certificate", files[0], "--key", files[1], "--token", "secret")
        self.addCleanup(server.stop)
        host, port = server.address.rsplit(":", 1)

        def shown() -> str:
            der = ssl.PEM_cert_to_DER_cert(ssl.get_server_certificate((host, int(port))))
            return "second" if b"second" in der else "first"

        self.assertEqual(shown(), "first")
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        with socket.create_connection((host, int(port)), 60) as plain, context.wrap_socket(plain) as open_one:
            renew("second")
            server.process.send_signal(signal.SIGHUP)
            while shown() != "second":
                pass
            open_one.sendall(b'{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"token":"secret"}}\n')
            self.assertIn(b'"result"', open_one.recv(100_000))
        with open(files[0], "w", encoding="ascii") as file:
            file.write("no certificate")
        server.process.send_signal(signal.SIGHUP)
        for _ in range(5):
            self.assertEqual(shown(), "second")

    def test_other_machines_need_a_token_and_encryption(self) -> None:
        for option in ("--listen", "--http"):
            refused = espalier("serve", option, "0.0.0.0:0", *(["--listen", "127.0.0.1:0"] if option == "--http" else []),
                               status=1)
            self.assertIn("give a token that clients must send", refused.stderr)
            refused = espalier("serve", option, "0.0.0.0:0", "--token", "x",
                               *(["--listen", "127.0.0.1:0"] if option == "--http" else []), status=1)
            self.assertIn("give --certificate FILE and --key FILE, add --insecure", refused.stderr)


class CommandLine(unittest.TestCase):
    """`espalier connect` over what is not plain TCP."""

    def test_reaches_a_server_over_a_websocket_and_a_socket_of_the_file_system(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "espalier.socket")
            server = Server(listen="unix:" + path)
            self.addCleanup(server.stop)
            for address in ("unix:" + path, "ws://" + server.http):
                created = espalier("connect", address, "create", "--gallery", "branch-tiers", "--seed", "7").stdout.strip()
                self.assertIn(created, espalier("connect", address, "list").stdout)
                espalier("connect", address, "step", created, "2")
                self.assertIn("?E", espalier("connect", address, "get", created).stdout)

    def test_says_why_it_cannot(self) -> None:
        for address in ("ws://127.0.0.1:1", "tls://127.0.0.1:1", "unix:/nonexistent/socket"):
            self.assertIn(f"Cannot connect to {address}: ", espalier("connect", address, "list", status=1).stderr)
        self.assertIn("it is not of the form wss://HOST:PORT", espalier("connect", "wss://nowhere", "list", status=1).stderr)


class ErrorNumbers(unittest.TestCase):
    """The frozen numbers of protocol/README.md, each with what a stranger does to get it."""

    HELLO = '{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1]}}'

    def answers(self, address: str, *lines: str) -> List[Dict[str, Any]]:
        """The answers to lines sent one after the other."""
        host, port = address.rsplit(":", 1)
        with socket.create_connection((host, int(port)), 30) as connection:
            with connection.makefile("r", encoding="utf-8", newline="\n") as heard:
                found = []
                for line in lines:
                    connection.sendall(line.encode("utf-8") + b"\n")
                    found.append(json.loads(heard.readline()))
                return found

    def code(self, address: str, *lines: str) -> int:
        return int(self.answers(address, *lines)[-1]["error"]["code"])

    @staticmethod
    def request(method: str, **parameters: Any) -> str:
        return wire.encode(wire.request(9, method, parameters)).decode("utf-8").rstrip("\n")

    def create(self, source: str, **more: Any) -> str:
        return self.request("simulation.create", model={"source": source}, **more)

    def test_of_a_server(self) -> None:
        server = Server("--limit", "modules=50", "--limit", "handshakeMilliseconds=30000")
        self.addCleanup(server.stop)
        address = server.address
        self.assertEqual(self.code(address, "rubbish"), -32700)
        self.assertEqual(self.code(address, '{"jsonrpc":"2.0","id":1}'), -32600)
        self.assertEqual(self.code(address, self.HELLO, self.request("simulation.grow")), -32601)
        self.assertEqual(self.code(address, self.HELLO, self.request("simulation.step", simulation=3)), -32602)
        self.assertEqual(self.code(address, '{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[2]}}'), 1001)
        self.assertEqual(self.code(address, self.HELLO, '{"jsonrpc":"2.0","id":2,"method":"x","bin":[],"binBytes":8}'), 1002)
        away = self.create(MODEL, environment=[{"type": "offered", "name": "nobody"}])
        self.assertEqual(self.code(address, self.HELLO, away), 1006)
        self.assertEqual(self.code(address, self.HELLO, self.create("Lsystem: 1\nAxiom: A(\nendlsystem\n")), 1009)
        self.assertEqual(self.code(address, self.HELLO, self.request("simulation.step", simulation="sim-none")), 1011)
        self.assertEqual(self.code(address, self.request("server.status")), 1012)
        with Client(address) as client:
            def refused(simulation: Any, method: str, **parameters: Any) -> int:
                with self.assertRaises(ServerError) as caught:
                    client.call(method, {"simulation": simulation.identifier, **parameters})
                return caught.exception.code

            many = client.create("Lsystem: 1\nderivation length: 9\nAxiom: A\nA --> AA\nendlsystem\n")
            self.assertEqual(refused(many, "simulation.run"), 1004)
            nan = client.create("Lsystem: 1\nderivation length: 3\nAxiom: A(1)\nA(x) --> A(sqrt(0-x))\nendlsystem\n")
            self.assertEqual(refused(nan, "simulation.step"), 1008)
            self.assertEqual(refused(nan, "simulation.restore", snapshot="AAAA"), 1013)

    def test_of_time_tokens_and_cancelling(self) -> None:
        server = Server("--limit", "handshakeMilliseconds=50", "--token", "secret")
        self.addCleanup(server.stop)
        host, port = server.address.rsplit(":", 1)
        with socket.create_connection((host, int(port)), 30) as silent, \
                silent.makefile("r", encoding="utf-8", newline="\n") as heard:
            self.assertEqual(json.loads(heard.readline())["error"]["code"], 1005)
        self.assertEqual(self.code(server.address, self.HELLO), 1003)
        with Client(server.address, token="secret") as client:
            endless = client.create("Lsystem: 1\nderivation length: 100000000\nAxiom: A\nA --> A\nendlsystem\n", save=False)
            run = client._start("simulation.run", {"simulation": endless.identifier})
            client.notify("$/cancel", {"id": run})
            with self.assertRaises(ServerError) as caught:
                client._wait_for(run, "simulation.run")
            self.assertEqual(caught.exception.code, 1010)

    def test_of_an_environment_that_is_asked_for_a_step_it_left_behind(self) -> None:
        built_in = Process([program(), "environment", "density3d", "--listen", "127.0.0.1:0"])
        self.addCleanup(built_in.stop)
        step = {"simulation": "s", "iteration": 0, "time": 0, "queries": [
            {"id": 0, "symbol": "E", "parameters": [0, 0, 0, 0], "position": [0, 1, 0]}]}
        asked = [self.request("environment.open", simulation="s", symbols=["E"]),
                 self.request("environment.step", step=5, **step), self.request("environment.step", step=3, **step)]
        self.assertEqual(self.code(built_in.address, *asked), 1007)


class StreamsInBlocks(unittest.TestCase):
    def test_columns_are_the_records(self) -> None:
        server = Server()
        self.addCleanup(server.stop)
        for address in (server.address, "ws://" + server.http):
            with Client(address) as client:
                simulation = client.create(gallery="branch-tiers", environment=[{"type": "honda", "radius": 0.5}], seed=7)
                simulation.step(4)
                for symbols in (None, ["F"]):
                    with simulation.stream(symbols=symbols) as stream:
                        records = stream.read().records
                    with simulation.stream(symbols=symbols, arrays=True) as stream:
                        frame = stream.read()
                    self.assertEqual(frame.count, len(records))
                    columns = {name: array.tolist() for name, array in frame.columns.items()}
                    self.assertGreater(len(records), 20)
                    for row, record in enumerate(records):
                        self.assertEqual(tuple(columns["position"][row]), record.position)
                        self.assertEqual(tuple(columns["heading"][row]), record.heading)
                        self.assertEqual((columns["plant"][row], columns["module"][row], columns["width"][row],
                                          frame.symbols[columns["symbol"][row]], columns["colour"][row]),
                                         (record.plant, record.module, record.width, record.symbol, record.colour))
                        begin, end = columns["parameterOffset"][row], columns["parameterOffset"][row + 1]
                        self.assertEqual(tuple(columns["parameters"][begin:end]), record.parameters)
                        parent = columns["parent"][row]
                        self.assertEqual(None if parent == 0xFFFFFFFF else parent, record.parent)
                        if symbols:
                            self.assertEqual(columns["index"][row], record.index)
                with simulation.stream(arrays=True, single=True) as stream:
                    self.assertEqual(memoryview(stream.read().columns["position"]).format.lstrip("<"), "f")

    def test_they_need_agreement(self) -> None:
        server = Server()
        self.addCleanup(server.stop)
        with mock.patch.object(wire, "CAPABILITIES", ()), Client(server.address) as client:
            simulation = client.create(MODEL, environment=[{"type": "height"}])
            with self.assertRaisesRegex(ServerError, "params.bin: binary blocks were not agreed on") as caught:
                simulation.stream(arrays=True)
            self.assertEqual(caught.exception.code, 1002)


class Traces(unittest.TestCase):
    """A recorded run is made again without its environment."""

    def test_records_and_replays_and_names_a_changed_reply(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for suffix in (".trace", ".trace.zst"):
                trace = os.path.join(folder, "tiers" + suffix)
                espalier("derive", model("branch-tiers"), "--quiet", "--trace", trace,
                         "--environment", f"stdio:{' '.join(python(EXAMPLES / 'honda.py'))}")
                self.assertRegex(espalier("replay", trace).stdout, r"^\d+ steps with \d+ queries: the same as recorded$")
            self.assertIn("the same as recorded", espalier("replay", trace, "--threads", "4").stdout)
            plain = os.path.join(folder, "tiers.trace")
            content = Path(plain).read_bytes()
            # the last double 1.0 of the recording is a reply
            place = content.rindex(bytes.fromhex("000000000000f03f"))
            Path(plain).write_bytes(content[:place] + b"\x01" + content[place + 1:])
            changed = espalier("replay", plain, status=1)
            self.assertRegex(changed.stderr, r"first divergence: step \d+, plant 0, module \d+ \('E'\): the recorded reply "
                             "is not the one that was given")
            self.assertIn("this is not a trace", espalier("replay", model("branch-tiers"), status=1).stderr)
            self.assertIn("cannot write the trace", espalier(
                "derive", model("branch-tiers"), "--trace", os.path.join(folder, "none", "x"), status=1).stderr)


class EnvironmentCheck(unittest.TestCase):
    """The messages to the author of an environment."""

    def check(self, text: str, *arguments: str, status: int = 0) -> str:
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "environment.py"
            script.write_text("import random\nfrom espalier import Environment, Variable\n" + text, encoding="utf-8")
            return espalier("environment", "check", "stdio:" + " ".join(f"'{word}'" for word in python(script)),
                            *arguments, status=status).stdout

    def test_a_right_one(self) -> None:
        found = self.check("class Right(Environment):\n"
                           "    needs = ('position',)\n"
                           "    outputs = (Variable('light', 'W/m2'),)\n"
                           "    def answer(self, query):\n"
                           "        return [query.position[1]]\n"
                           "Right.serve()\n")
        for line in ("ok    connect: it takes text and binary blocks",
                     "ok    describe: right, needs position, has no state", "ok    units: output 'light' in W/m2",
                     "ok    replies do not depend on the order of the queries", "ok    a query with NaN is refused",
                     "all is right"):
            self.assertIn(line, found.splitlines())
        self.assertRegex(found, r"queries +median ms +99 % ms +queries/s\n +1 +[0-9.]+ +[0-9.]+ +\d+\n")

    def test_one_that_starts_slowly_as_on_a_busy_machine(self) -> None:
        slow = ("import time\ntime.sleep(2.2)\nclass Slow(Environment):\n    def answer(self, query):\n        return [1]\nSlow.serve()\n")
        self.assertIn("ok    describe: slow, needs", self.check(slow))

    def test_a_run_waits_for_one_that_starts_slowly_too(self) -> None:
        # 4 s: such a one was once taken for one that only answers environment.step, and not opened
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "slow.py"
            script.write_text("import time\ntime.sleep(4.2)\nfrom espalier import Environment\nclass Slow(Environment):\n"
                              "    isOpen = 0\n    def opened(self):\n        self.isOpen = 1\n"
                              "    def answer(self, query):\n        return [self.isOpen]\nSlow.serve()\n", encoding="utf-8")
            model_file = Path(folder) / "model.l"
            model_file.write_text("Lsystem: 1\nderivation length: 2\nAxiom: A\nA --> ?E(7)\nendlsystem\n", encoding="utf-8")
            run = espalier("derive", str(model_file), "--environment", "stdio:" + " ".join(f"'{word}'" for word in python(script)))
            self.assertEqual(run.stdout.strip(), "?E(1)")

    def test_built_ins_are_right(self) -> None:
        for name in ("height", "honda", "density3d"):
            found = espalier("environment", "check", f"stdio:'{program()}' environment {name} --stdio").stdout
            self.assertTrue(found.endswith("all is right\n"), found)

    def test_one_that_depends_on_chance_and_order(self) -> None:
        found = self.check("class Wrong(Environment):\n"
                           "    def step(self, queries):\n"
                           "        return [[index + random.random()] for index, _ in enumerate(queries)]\n"
                           "Wrong.serve()\n", status=1)
        self.assertIn("wrong opened again with the same seed it gives the same replies: query 0 got", found)
        self.assertIn("wrong replies do not depend on the order of the queries", found)
        self.assertTrue(found.endswith("not all is right\n"))

    def test_one_that_forgets_its_state_and_answers_too_much(self) -> None:
        found = self.check("class Forgetful(Environment):\n"
                           "    is_stateful = True\n"
                           "    count = 0\n"
                           "    def step(self, queries):\n"
                           "        self.count += 1\n"
                           "        return [[self.count, 0, 0] for _ in queries]\n"
                           "Forgetful.serve()\n", status=1)
        self.assertIn("wrong shapes: 2 values more than the queries have parameters", found)
        self.assertIn("wrong after restoring its state it goes on as before", found)

    def test_the_queries_of_a_recorded_run(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            trace = os.path.join(folder, "height.trace")
            espalier("derive", model("growth-to-a-height"), "--quiet", "--environment", "height", "--trace", trace)
            height = f"stdio:'{program()}' environment height --stdio"
            same = espalier("environment", "check", height, "--trace", trace).stdout
            self.assertRegex(same, r"ok    trace: the same replies to \d+ queries in \d+ steps as recorded")
            other = espalier("environment", "check", f"stdio:'{program()}' environment constant --stdio", "--trace", trace,
                             status=1).stdout
            self.assertRegex(other, r"wrong trace: step 0, plant 0, module \d+: value 1 is ")

    def test_one_that_is_not_there(self) -> None:
        self.assertIn("wrong connect: environment 'stdio:exit 3'",
                      espalier("environment", "check", "stdio:exit 3", status=1).stdout)


if __name__ == "__main__":
    unittest.main()
