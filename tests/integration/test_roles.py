"""Tokens and roles: each connection may do what its token grants, for as long as the token holds."""

import datetime
import json
import os
import re
import signal
import socket
import ssl
import stat
import subprocess
import tempfile
import unittest
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any, Dict, List, Tuple

from support import REPOSITORY, SECONDS, Process, Server, espalier, program
from test_transports_strangers import Raw

from espalier import Client, ServerError, wire

SOURCE = "Lsystem: 1\nderivation length: 9\nAxiom: A?E(0)\nA --> FA\nendlsystem\n"
GRANTS = {"controller": {"controller", "viewer", "environment"}, "viewer": {"viewer"}, "environment": {"environment"}}


def role_of_methods() -> Dict[str, str]:
    """The column role of the specification's table, for the methods that the server answers; empty: anyone."""
    page = (REPOSITORY / "protocol" / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([^`]+)` \| (?:the server|both sides) \| (\w*) ?\| ", page, re.MULTILINE)
    return {name: role for name, role in rows if name != "hello"}


def hello(token: str = "", *roles: str, **more: Any) -> Dict[str, Any]:
    said: Dict[str, Any] = {"protocol": [1], "name": "probe", "version": "1", "token": token, **more}
    if roles:
        said["roles"] = list(roles)
    return said


class Roles(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.tokens: Dict[str, str] = {}
        self.lines: List[str] = []

    def new_token(self, name: str, *roles: str, **options: str) -> str:
        """Draws a token; its line is kept for the configuration."""
        more = [word for role in roles for word in ("--role", role)]
        more += [word for option, value in options.items() for word in (f"--{option}", value)]
        token, line = espalier("token", "new", name, *more).stdout.splitlines()
        self.tokens[name] = token
        self.lines.append(line)
        return token

    def configuration(self) -> str:
        file = self.folder / "serve.toml"
        file.write_text("\n".join(["[tokens]", *self.lines, ""]), encoding="utf-8")
        return str(file)

    def serve(self, *arguments: str) -> Server:
        server = Server("--config", self.configuration(), *arguments)
        self.addCleanup(server.stop)
        return server

    def raw(self, server: Server, said: Dict[str, Any]) -> Raw:
        peer = Raw(server.address, said)
        self.addCleanup(peer.close)
        return peer

    def test_every_method_asks_for_its_role(self) -> None:
        for role in GRANTS:
            self.new_token(role, role)
        server = self.serve()
        methods = role_of_methods()
        self.assertGreater(len(methods), 20)
        self.assertEqual(set(methods.values()), {"", "controller", "viewer", "environment"})
        for role, granted in GRANTS.items():
            peer = self.raw(server, hello(self.tokens[role]))
            self.assertEqual(peer.hello["result"]["roles"], [role])
            for method, needed in methods.items():
                answer = peer.ask(method, {})
                code = answer.get("error", {}).get("code", 0)
                self.assertEqual(code == 1003, bool(needed) and needed not in granted, (role, method, answer))
                if code == 1003:
                    self.assertEqual(answer["error"]["data"], {"role": needed, "roles": [role]})
                    self.assertIn(f"{method} needs the role {needed}, and this connection has {role}.",
                                  answer["error"]["message"])
                    self.assertIn(f"`espalier token new NAME --role {needed}`", answer["error"]["message"])

    def test_a_viewer_watches_and_changes_nothing(self) -> None:
        self.new_token("alice", "controller")
        self.new_token("screen", "viewer")
        models = self.folder / "models"
        models.mkdir()
        server = self.serve("--data", str(self.folder / "data"), "--models", str(models))
        with Client(server.address, token=self.tokens["alice"], timeout=SECONDS) as alice, \
                Client("ws://" + server.http, token=self.tokens["screen"], timeout=SECONDS) as screen:
            self.assertEqual(screen.server["roles"], ["viewer"])
            plant = alice.create(SOURCE, environment=[{"type": "height"}], seed=1)
            named = {"simulation": plant.identifier}
            opened = screen.call("stream.open", {**named, "what": "string"})
            self.assertEqual(opened["step"], 0)
            before = screen.call("simulation.get", {**named, "what": "state-hash"})
            for method in ("simulation.delete", "simulation.step", "simulation.reset", "simulation.pause"):
                with self.assertRaises(ServerError) as caught:
                    screen.call(method, named)
                self.assertEqual(caught.exception.code, 1003)
            self.assertEqual(alice.call("simulation.get", {**named, "what": "state-hash"}), before)
            # it reads the models on the server's disk and writes none
            alice.call("model.save", {"name": "mine", "files": {"a.l": ""}})
            self.assertEqual(screen.call("model.read", {"saved": "mine"})["files"], {"a.l": ""})
            with self.assertRaises(ServerError) as caught:
                screen.call("model.save", {"name": "yours", "files": {"a.l": ""}})
            self.assertEqual((caught.exception.code, [path.name for path in models.iterdir()]), (1003, ["mine"]))
            # a notification that needs a role is ignored
            screen.notify("simulation.delete", named)
            self.assertEqual(len(screen.call("simulation.list")["simulations"]), 1)
            plant.step()

    def test_granted_are_the_roles_asked_for_that_the_token_has(self) -> None:
        self.new_token("both", "viewer", "environment")
        self.new_token("alice", "controller")
        server = self.serve()
        for token, asked, granted in (("both", (), ["viewer", "environment"]), ("both", ("controller", "viewer"), ["viewer"]),
                                      ("alice", ("viewer",), ["viewer"]), ("alice", (), ["controller"])):
            self.assertEqual(self.raw(server, hello(self.tokens[token], *asked)).hello["result"]["roles"], granted)
        for said in (hello(self.tokens["both"], "controller"), hello("guess"), hello(), hello(self.tokens["both"][:-1])):
            peer = self.raw(server, said)
            self.assertEqual(peer.hello["error"]["code"], 1003)
            with self.assertRaises(ConnectionError):
                peer.ask("ping", {})

    def test_without_tokens_a_local_program_is_a_controller(self) -> None:
        server = self.serve()
        self.assertEqual(self.raw(server, hello()).hello["result"]["roles"], ["controller"])
        peer = self.raw(server, hello("", "viewer"))
        self.assertEqual(peer.ask("simulation.delete", {"simulation": "x"})["error"]["code"], 1003)

    def test_a_token_that_expires_ends_its_connections(self) -> None:
        # the command draws no token that is past already
        self.new_token("over", "controller", expires="2098-01-01")
        self.lines[-1] = self.lines[-1].replace("2098", "2026")
        soon = datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(seconds=4)
        self.new_token("soon", "viewer", expires=soon.strftime("%Y-%m-%dT%H:%M:%SZ"))
        server = self.serve()
        self.assertIn("The token 'over' expired at 2026-01-01T00:00:00Z",
                      self.raw(server, hello(self.tokens["over"])).hello["error"]["message"])
        silent = self.raw(server, hello(self.tokens["soon"]))
        self.assertIn("result", silent.hello)
        silent.socket.settimeout(SECONDS)
        said = json.loads(silent.lines.readline())
        self.assertEqual((said["id"], said["error"]["code"]), (None, 1003))
        self.assertIn("The token 'soon' expired at", said["error"]["message"])
        self.assertEqual(silent.lines.readline(), b"")
        self.assertIn("error", self.raw(server, hello(self.tokens["soon"])).hello)

    def test_a_run_ends_with_the_token_also_when_its_peer_does_not_read(self) -> None:
        self.new_token("alice", "controller")
        soon = datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(seconds=5)
        self.new_token("soon", "controller", expires=soon.strftime("%Y-%m-%dT%H:%M:%SZ"))
        server = self.serve()
        endless = f"Lsystem: 1\nderivation length: 1000000000\nAxiom: {'F' * 100_000}A\nA --> A\nendlsystem\n"
        peer = self.raw(server, hello(self.tokens["soon"]))
        simulation = peer.ask("simulation.create", {"model": {"source": endless}})["result"]["simulation"]
        for message in ({"id": 8, "method": "stream.open", "params": {"simulation": simulation, "what": "string"}},
                        {"id": 9, "method": "simulation.run", "params": {"simulation": simulation}}):
            peer.socket.sendall(json.dumps({"jsonrpc": "2.0", **message}).encode() + b"\n")
        with Client(server.address, token=self.tokens["alice"], timeout=SECONDS) as alice:
            while alice.status()["sessions"] > 1:
                pass
            while alice.call("simulation.list")["simulations"][0]["running"]:
                pass

    def test_a_hang_up_signal_reads_the_tokens_again(self) -> None:
        self.new_token("alice", "controller")
        self.new_token("mallory", "controller")
        kept, dropped = self.lines
        server = self.serve()
        alice = self.raw(server, hello(self.tokens["alice"]))
        mallory = self.raw(server, hello(self.tokens["mallory"]))
        self.lines = [kept]
        self.configuration()
        server.process.send_signal(signal.SIGHUP)
        mallory.socket.settimeout(SECONDS)
        said = json.loads(mallory.lines.readline())
        self.assertEqual(said["error"]["code"], 1003)
        self.assertIn("has changed or removed the token 'mallory'", said["error"]["message"])
        self.assertIn("error", self.raw(server, hello(self.tokens["mallory"])).hello)
        # neither a mistake nor an empty list opens the server
        for lines in (['alice = "king"'], []):
            self.lines = lines
            self.configuration()
            server.process.send_signal(signal.SIGHUP)
            self.assertIn("result", alice.ask("server.status", {}))
            self.assertIn("error", self.raw(server, hello()).hello)
        self.lines = [kept, dropped]
        self.configuration()
        server.process.send_signal(signal.SIGHUP)
        while "error" in self.raw(server, hello(self.tokens["mallory"])).hello:
            pass
        self.assertIn("result", alice.ask("server.status", {}))

    def test_a_hang_up_signal_reads_the_limits_again(self) -> None:
        file, log = self.folder / "serve.toml", self.folder / "log"

        def write(limits: Dict[str, int], workers: int = 1) -> None:
            lines = [f"{name} = {value}" for name, value in limits.items()]
            file.write_text("\n".join([f'workers = "{workers}"', "[limits]", *lines, ""]), encoding="utf-8")

        def hang_up(said: str) -> None:
            begin = log.stat().st_size
            server._process.send_signal(signal.SIGHUP)
            while said not in log.read_text(encoding="utf-8")[begin:]:
                self.assertIsNone(server._process.poll())

        write({"simulations": 1, "arity": 7, "storeBytes": 40_960})
        with log.open("wb") as errors:
            server = package_server(str(file), errors, "--data", str(self.folder / "data"), "--limit", "openFiles=9")
            self.addCleanup(server.stop)
        client = server.connect(timeout=SECONDS)
        self.addCleanup(client.close)
        first = client.create(SOURCE, environment=[{"type": "height"}])
        with self.assertRaisesRegex(ServerError, "the limit 'simulations' is 1,"):
            client.create(SOURCE, environment=[{"type": "height"}])
        # a bound of the server at once, one of simulations for later ones; the command line wins
        write({"simulations": 3, "modules": 5, "openFiles": 4, "accountStreams": 1, "memoryBytes": 123_456_789})
        hang_up("for simulations that are made or loaded from now on: modules 200000000 -> 5, arity 7 -> 1000")
        said = log.read_text(encoding="utf-8")
        for change in ("simulations 1 -> 3", "accountStreams 0 -> 1", "memoryBytes 0 -> 123456789", "storeBytes 40960 -> 0"):
            self.assertIn(change, said)
        self.assertNotIn("openFiles 9", said)
        self.assertNotIn("only when the server starts", said)
        first.step(8)
        second = client.create(SOURCE, environment=[{"type": "height"}])
        with self.assertRaisesRegex(ServerError, "limit modules"):
            second.step(8)
        self.assertEqual(client.call("server.status")["memory"]["boundBytes"], 123_456_789)
        client.call("stream.open", {"simulation": first.identifier, "what": "string"})
        with self.assertRaisesRegex(ServerError, "the limit 'accountStreams' is 1,"):
            client.call("stream.open", {"simulation": first.identifier, "what": "string"})
        # the limits that a peer is told are the present ones
        raw = Raw(server.address, hello())
        self.addCleanup(raw.close)
        self.assertEqual({name: raw.hello["result"]["limits"][name] for name in ("simulations", "modules", "openFiles")},
                         {"simulations": 3, "modules": 5, "openFiles": 9})
        # nor does a file that would be refused at the start, or one that is written just now
        for text in ("garbage [[[\n", "[limts]\nsimulations = 4\n", "[limits\nsimulations = 4\n", "simulations = 4\n", "", "\0\0",
                     "[limits]\nsimulations = [1, 2]\n", "[limits]\nsimulations = 4\nsimulations = 5\n"):
            file.write_text(text, encoding="utf-8")
            hang_up("tokens, limits and certificate stay as they are: the configuration '")
        self.assertEqual(client.call("server.status")["memory"]["boundBytes"], 123_456_789)
        # a mistake changes nothing, and other settings are named
        write({"simulations": 1, "modul": 5})
        hang_up("tokens, limits and certificate stay as they are: the configuration '")
        client.create(SOURCE, environment=[{"type": "height"}])
        write({"simulations": 3, "modules": 5, "openFiles": 4, "accountStreams": 1, "memoryBytes": 123_456_789}, workers=2)
        hang_up("none has changed")
        self.assertIn("read only when the server starts: workers", log.read_text(encoding="utf-8"))

    def test_a_hang_up_signal_changes_all_or_nothing(self) -> None:
        self.new_token("alice", "controller")
        self.new_token("mallory", "controller")
        kept, dropped = self.lines
        file, log, certificate, key = (self.folder / name for name in ("serve.toml", "log", "now.pem", "now.key"))

        def write(simulations: str, *tokens: str) -> None:
            file.write_text("\n".join(["[limits]", f"simulations = {simulations}", "[tokens]", *tokens, ""]), encoding="utf-8")

        def renew(name: str) -> None:
            subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                            "-keyout", str(key), "-out", str(certificate), "-subj", f"/CN={name}"], check=True, capture_output=True)

        def hang_up(said: str) -> None:
            begin = log.stat().st_size
            server._process.send_signal(signal.SIGHUP)
            while said not in log.read_text(encoding="utf-8")[begin:]:
                self.assertIsNone(server._process.poll())

        renew("first")
        write("5", kept, dropped)
        with log.open("wb") as errors:
            server = package_server(str(file), errors, "--certificate", str(certificate), "--key", str(key))
            self.addCleanup(server.stop)
        trusting = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        trusting.check_hostname, trusting.verify_mode = False, ssl.CERT_NONE

        def now() -> Tuple[int, bool, bool]:
            """The limit of simulations, whether mallory gets in, and whether the certificate is the first one."""
            found = []
            for name in ("alice", "mallory"):
                with socket.create_connection(wire.parse_address(server.address), SECONDS) as plain, trusting.wrap_socket(plain) as peer:
                    peer.sendall(json.dumps(wire.request(1, "hello", hello(self.tokens[name]))).encode() + b"\n")
                    found.append(json.loads(peer.makefile().readline()))
                    shown = b"first" in (peer.getpeercert(True) or b"")
            return found[0]["result"]["limits"]["simulations"], "result" in found[1], shown

        before = (5, True, True)
        self.assertEqual(now(), before)
        first = certificate.read_text(encoding="ascii")
        renew("second")
        second = certificate.read_text(encoding="ascii")
        for limit, tokens, shown, reason in (
                ("7", [kept, 'mallory = "king"'], second, f"the configuration '{file}': "),  # only the tokens are wrong
                ("7", [], second, "without any token the server would be open. Stop it instead."),
                ("many", [kept], second, f"the configuration '{file}': "),  # only the limits
                ("7", [kept], first, "")):  # only the certificate, which has another key
            with self.subTest(limit=limit, tokens=len(tokens)):
                write(limit, *tokens)
                certificate.write_text(shown, encoding="ascii")
                hang_up("tokens, limits and certificate stay as they are: " + reason)
                self.assertEqual(now(), before)
        write("7", kept)
        certificate.write_text(second, encoding="ascii")
        hang_up("read the certificate again")
        self.assertEqual(now(), (7, False, False))

    def test_downloads_need_a_viewer(self) -> None:
        self.new_token("alice", "controller")
        self.new_token("screen", "viewer")
        self.new_token("light", "environment")
        server = self.serve()

        def status(token: str) -> int:
            request = urllib.request.Request(f"http://{server.http}/simulations", headers={"Authorization": f"Bearer {token}"})
            try:
                with urllib.request.urlopen(request, timeout=SECONDS) as answer:
                    return int(answer.status)
            except urllib.error.HTTPError as error:
                with error:
                    return int(error.code)

        self.assertEqual([status(self.tokens[name]) for name in ("alice", "screen", "light")], [200, 200, 401])
        self.assertEqual(status("guess"), 401)

    def test_the_log_says_who_did_what(self) -> None:
        self.new_token("alice", "controller")
        log = self.folder / "log"
        with log.open("wb") as errors:
            server = package_server(self.configuration(), errors)
            self.addCleanup(server.stop)
            with server.connect(token=self.tokens["alice"], timeout=SECONDS) as client:
                plant = client.create(SOURCE, environment=[{"type": "height"}])
                plant.step(3)
                client.call("simulation.delete", {"simulation": plant.identifier})
            server.stop()
        lines = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
        deeds = [(line["message"], line.get("simulation")) for line in lines if line.get("token") == "alice"]
        self.assertIn(("simulation.create", None), deeds)
        self.assertIn(("created", plant.identifier), deeds)
        self.assertIn(("simulation.delete", plant.identifier), deeds)
        self.assertNotIn(self.tokens["alice"], log.read_text(encoding="utf-8"))

    def test_a_new_token_is_shown_once_and_kept_as_a_hash(self) -> None:
        file = self.folder / "alice.token"
        line = espalier("token", "new", "alice", "-o", str(file)).stdout
        token = file.read_text(encoding="utf-8").strip()
        self.assertRegex(token, r"^espalier_[0-9a-f]{64}$")
        self.assertEqual(stat.S_IMODE(os.stat(file).st_mode), 0o600)
        self.assertRegex(line, r'^alice = "controller sha256:[0-9a-f]{64}"\n$')
        self.lines.append(line.strip())
        printed = espalier("serve", "--config", self.configuration(), "--print-config").stdout
        self.assertIn(line, printed)
        self.assertNotIn(token, line + printed)
        server = self.serve()
        listed = espalier("connect", server.address, "--token-file", str(file), "list")
        self.assertEqual(listed.returncode, 0)
        self.assertIn("is there already", espalier("token", "new", "bob", "-o", str(file), status=1).stderr)
        self.assertIn("is no time", espalier("token", "new", "bob", "--expires", "soon", status=2).stderr)
        self.assertIn("unusual name", espalier("token", "new", "bob smith", status=2).stderr)
        espalier("token", "new", "bob", "--role", "king", status=2)
        for wrong in ("controller sha256:12", "king", "controller"):
            self.lines = [f'alice = "{wrong}"']
            self.assertIn("the token 'alice' of [tokens]",
                          espalier("serve", "--config", self.configuration(), "--listen", "127.0.0.1:0", status=2).stderr)


def package_server(configuration: str, errors: Any, *more: str) -> Any:
    from espalier import Server as PackageServer
    return PackageServer(program(), arguments=["--config", configuration, "--log-format", "json", *more], errors=errors)


class Offers(unittest.TestCase):
    """The peers that may take over the name of an offered environment."""

    def serve(self, *tokens: str, **limits: str) -> Server:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        lines = ["[limits]", *[f"{name} = {value}" for name, value in limits.items()], "[tokens]"]
        self.tokens: Dict[str, str] = {}
        for name in tokens:
            token, line = espalier("token", "new", name).stdout.splitlines()
            self.tokens[name] = token
            lines.append(line)
        file = Path(folder.name) / "serve.toml"
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        server = Server("--config", str(file))
        self.addCleanup(server.stop)
        return server

    def offer(self, server: Server, token: str = "", **more: Any) -> Raw:
        peer = Raw(server.address, hello(token, "environment", **more))
        self.addCleanup(peer.close)
        peer.offered = peer.ask("environment.offer", {"name": "light"})  # type: ignore[attr-defined]
        return peer

    def code(self, peer: Raw) -> int:
        return int(peer.offered.get("error", {}).get("code", 0))  # type: ignore[attr-defined]

    def test_only_the_same_token_takes_a_name_over_and_the_waiting_step_is_told(self) -> None:
        server = self.serve("alice", "mallory")
        first = self.offer(server, self.tokens["alice"])
        self.assertEqual(self.code(first), 0)
        self.assertEqual(self.code(self.offer(server, self.tokens["mallory"])), 1016)
        controller = Raw(server.address, hello(self.tokens["alice"]))
        self.addCleanup(controller.close)
        message = {"jsonrpc": "2.0", "id": "c", "method": "simulation.create", "params": {
            "model": {"source": SOURCE}, "environment": [{"type": "offered", "name": "light"}]}}
        controller.socket.sendall(json.dumps(message).encode() + b"\n")
        # the simulation asks the first one, which does not answer
        self.assertEqual(json.loads(first.lines.readline())["method"], "environment.describe")
        self.assertEqual(self.code(self.offer(server, self.tokens["alice"])), 0)
        answer = json.loads(controller.lines.readline())
        self.assertEqual((answer["id"], answer["error"]["code"]), ("c", 1006))
        self.assertIn("was replaced by another connection", answer["error"]["message"])
        self.assertEqual(self.code(self.offer(server, self.tokens["mallory"])), 1016)

    def test_a_name_is_free_when_its_connection_is_closed(self) -> None:
        server = self.serve("alice", "mallory")
        first = self.offer(server, self.tokens["alice"])
        first.socket.shutdown(2)
        with Client(server.address, token=self.tokens["alice"], timeout=SECONDS) as client:
            while client.status()["offered"]:
                pass
        self.assertEqual(self.code(self.offer(server, self.tokens["mallory"])), 0)

    def test_without_tokens_the_older_connection_must_miss_its_heartbeat(self) -> None:
        server = self.serve(heartbeatMilliseconds="1000")
        first = self.offer(server, capabilities=["heartbeat"])
        self.assertEqual(self.code(self.offer(server)), 1016)
        # it is asked whether it is there, and stays silent
        self.assertEqual(json.loads(first.lines.readline())["method"], "ping")
        self.assertEqual(self.code(self.offer(server)), 0)

    def test_a_peer_that_answers_its_heartbeat_keeps_its_name(self) -> None:
        server = self.serve(heartbeatMilliseconds="300")
        first = self.offer(server, capabilities=["heartbeat"])
        for _ in range(2):
            asked = json.loads(first.lines.readline())
            first.socket.sendall(json.dumps({"jsonrpc": "2.0", "id": asked["id"], "result": {}}).encode() + b"\n")
            # its answer is read before its next request is
            first.ask("ping", {})
            self.assertEqual(self.code(self.offer(server)), 1016)

    def test_a_python_environment_tries_again_when_its_name_is_taken(self) -> None:
        server = self.serve(heartbeatMilliseconds="60000")
        first = self.offer(server, capabilities=["heartbeat"])
        script = REPOSITORY / "clients" / "python" / "examples" / "height.py"
        command = ["python3", str(script), "--offer", server.address, "--name", "light", "--reconnect"]
        again = Process(command, speaks_on="stderr")
        self.addCleanup(again.stop)
        self.assertIn("Trying again", again.first_line)
        first.socket.shutdown(2)
        line = ""
        while "is offered to" not in line:
            line = again._stream.readline()
            self.assertTrue(line)


if __name__ == "__main__":
    unittest.main()
