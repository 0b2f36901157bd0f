"""Commands and addresses of environments: only what the operator lists is started or dialled, from wherever an entry comes."""

import contextlib
import json
import shlex
import socket
import sys
import tempfile
import threading
import unittest
import unittest.mock
from pathlib import Path
from typing import Any, Dict, List

from support import SECONDS, Process, Server, espalier, program

import espalier as package
from espalier import Client, ServerError

SOURCE = "Lsystem: 1\nderivation length: 5\nAxiom: F(1)A?E(0)\nA?E(x) : x < 5 --> F(1)A?E(0)\nendlsystem\n"
HEIGHT = {"type": "height"}


class Spawning(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.marker = self.folder / "started"
        # an environment that leaves a mark when it starts
        self.command = f"touch {shlex.quote(str(self.marker))}; {shlex.quote(program())} environment height --stdio"

    def serve(self, *arguments: str, configuration: str = "") -> Server:
        file = self.folder / "serve.toml"
        file.write_text(configuration, encoding="utf-8")
        server = Server("--config", str(file), *arguments)
        self.addCleanup(server.stop)
        return server

    def client(self, server: Server) -> Client:
        client = Client(server.address, timeout=SECONDS)
        self.addCleanup(client.close)
        return client

    def refused(self, client: Client, method: str, words: str, **parameters: Any) -> None:
        with self.assertRaises(ServerError) as caught:
            client.call(method, parameters)
        self.assertEqual(caught.exception.code, 1003, caught.exception)
        self.assertIn(words, str(caught.exception))
        self.assertFalse(self.marker.exists(), f"{method} started the command")

    def create(self, *environment: Dict[str, Any], **more: Any) -> Dict[str, Any]:
        return {"model": {"source": SOURCE}, "environment": list(environment), "seed": 1, **more}

    def test_a_listed_command_is_started_by_its_name_and_without_a_shell(self) -> None:
        script = self.folder / "say words.py"
        said = self.folder / "said"
        script.write_text("import os, sys\n"
                          f"open({str(said)!r}, 'w').write(repr(sys.argv[1:]))\n"
                          f"os.execv({program()!r}, ['espalier', 'environment', 'height', '--stdio'])\n", encoding="utf-8")
        server = self.serve(configuration=f'[spawn]\nlight = "{sys.executable} \'{script}\' $HOME ; \'a  b\'"\n'
                                          f'more = ["{sys.executable}", "{script}", "x", "..."]\n')
        client = self.client(server)
        inside = client.create(SOURCE, environment=[HEIGHT], seed=1)
        inside.run()
        spawned = client.create(SOURCE, environment=[{"type": "stdio", "name": "light"}], seed=1)
        spawned.run()
        self.assertEqual(spawned.string(), inside.string())
        self.assertEqual(said.read_text(encoding="utf-8"), repr(["$HOME", ";", "a  b"]))
        listed = client.call("simulation.list")["simulations"]
        self.assertIn(["stdio:light"], [entry["environment"] for entry in listed])
        client.call("simulation.create", self.create({"type": "stdio", "name": "more", "arguments": ["$(id)", "-v"]}))
        self.assertEqual(said.read_text(encoding="utf-8"), repr(["x", "$(id)", "-v"]))
        self.refused(client, "simulation.create", "takes no arguments from clients",
                     **self.create({"type": "stdio", "name": "light", "arguments": ["-v"]}))
        self.refused(client, "simulation.create", "Did you mean 'light'?", **self.create({"type": "stdio", "name": "lihgt"}))
        with self.assertRaisesRegex(ServerError, "arguments: expected a list of texts"):
            client.call("simulation.create", self.create({"type": "stdio", "name": "more", "arguments": "-v"}))

    def test_a_command_of_a_client_is_refused_from_wherever_it_comes(self) -> None:
        gallery = self.folder / "gallery" / "trap"
        gallery.mkdir(parents=True)
        entry = {"type": "stdio", "command": self.command}
        (gallery / "forest.json").write_text(json.dumps({
            "models": [{"name": "a", "file": "trap.l"}], "plants": [{"position": [0, 0, 0]}], "environment": [entry]}),
            encoding="utf-8")
        (gallery / "trap.l").write_text(SOURCE, encoding="utf-8")
        client = self.client(self.serve("--gallery", str(gallery.parent)))
        for environment in ([entry], [HEIGHT, {**entry, "name": "Other"}], [{**entry, "policy": "keep"}],
                            [{**entry, "policy": "fallback:height"}], [{**entry, "name": "light"}],
                            [{"type": "stdio", "command": ""}]):
            self.refused(client, "simulation.create", "[spawn]", **self.create(*environment))
        self.refused(client, "simulation.create", "[spawn]", model={"gallery": "trap"})
        # other words do not name a program
        for kind in ("plugin", "STDIO", "stdio:" + self.command, "legacy"):
            with self.assertRaises(ServerError):
                client.call("simulation.create", self.create({**entry, "type": kind, "library": "x.so"}))
            self.assertFalse(self.marker.exists())
        # a fallback is a built-in, never a command
        with self.assertRaisesRegex(ServerError, "stdio"):
            client.call("simulation.create", self.create({"type": "offered", "name": "x", "policy": "fallback:stdio"}))
        self.assertEqual(client.call("simulation.list")["simulations"], [])

    def test_a_stored_simulation_does_not_start_what_the_operator_no_longer_permits(self) -> None:
        data = str(self.folder / "data")
        entry = {"type": "stdio", "command": self.command}
        server = self.serve("--data", data, "--allow-spawn")
        with Client(server.address, timeout=SECONDS) as client:
            simulation = client.call("simulation.create", self.create(entry))["simulation"]
            client.call("simulation.step", {"simulation": simulation, "steps": 2})
            snapshot = client.call("simulation.save", {"simulation": simulation})["snapshot"]
            hashed = client.call("simulation.get", {"simulation": simulation, "what": "state-hash"})
        server.stop()
        self.marker.unlink()
        server = self.serve("--data", data)
        with Client(server.address, timeout=SECONDS) as client:
            self.assertIn("[spawn]", client.call("simulation.list")["simulations"][0]["damaged"])
            named = {"simulation": simulation}
            for method, more in (("simulation.step", {}), ("simulation.fork", {}), ("simulation.reset", {"seed": 2}),
                                 ("simulation.set", {"parameters": {"x": 1}}), ("simulation.trace", {"trace": True}),
                                 ("simulation.restore", {"snapshot": snapshot}), ("simulation.get", {"what": "string"})):
                self.refused(client, method, "[spawn]", **named, **more)
            # a snapshot brings its state and not its environment
            other = client.create(SOURCE, environment=[HEIGHT], seed=1)
            client.call("simulation.restore", {"simulation": other.identifier, "snapshot": snapshot})
            other.step(1)
            self.assertFalse(self.marker.exists())
        server.stop()
        with Client(self.serve("--data", data, "--allow-spawn").address, timeout=SECONDS) as client:
            self.assertEqual(client.call("simulation.get", {"simulation": simulation, "what": "state-hash"}), hashed)
            client.call("simulation.step", {"simulation": simulation})

    def test_only_listed_addresses_are_dialled(self) -> None:
        listening = Process([program(), "environment", "height", "--listen", "127.0.0.1:0"])
        self.addCleanup(listening.stop)
        entry = {"type": "tcp", "address": listening.address}
        client = self.client(self.serve())
        self.refused(client, "simulation.create", f"--allow-dial {listening.address}", **self.create(entry))
        self.refused(client, "simulation.create", "--allow-dial", **self.create({**entry, "policy": "keep"}))
        client = self.client(self.serve(configuration=f'allow-dial = ["127.0.0.1:1", "{listening.address}"]\n'))
        for address in (listening.address, "tcp://" + listening.address):
            client.call("simulation.create", self.create({**entry, "address": address}))
        self.refused(client, "simulation.create", "--allow-dial", **self.create({**entry, "address": "127.0.0.1:2"}))
        client = self.client(self.serve("--allow-dial", "any"))
        client.call("simulation.create", self.create(entry))
        # a permission to dial is none to start
        self.refused(client, "simulation.create", "[spawn]", **self.create({"type": "stdio", "command": self.command}))

    def test_a_command_that_cannot_start_is_an_error_at_start(self) -> None:
        for line, words in (('light = "/no/such/program --x"', "names the program '/no/such/program', which is not there"),
                            ('light = "python3 /no/such/light.py"', "names the file '/no/such/light.py', which is not there"),
                            ('light = ""', "is empty"), ('"li ght" = "true"', "unusual name")):
            file = self.folder / "wrong.toml"
            file.write_text(f"[spawn]\n{line}\n", encoding="utf-8")
            self.assertIn(words, espalier("serve", "--config", str(file), "--listen", "127.0.0.1:0", status=2).stderr)

    def test_a_started_program_has_none_of_the_servers_descriptors(self) -> None:
        seen = self.folder / "descriptors"
        command = f"ls -l /proc/self/fd > {shlex.quote(str(seen))}; {self.command}"
        client = self.client(self.serve("--allow-spawn", "--data", str(self.folder / "data")))
        client.call("simulation.create", self.create({"type": "stdio", "command": command}))
        text = seen.read_text(encoding="utf-8")
        self.assertNotIn("socket:", text)
        self.assertNotIn("espalier.sqlite", text)

    def test_a_snapshot_starts_nothing_on_the_command_line(self) -> None:
        model = self.folder / "model.l"
        model.write_text(SOURCE, encoding="utf-8")
        snapshot = str(self.folder / "a.snapshot")
        configuration = self.folder / "environment.json"
        configuration.write_text(json.dumps([{"type": "stdio", "command": self.command}]), encoding="utf-8")
        for environment in ("stdio:" + self.command, str(configuration)):
            espalier("run", str(model), "--environment", environment, "--steps", "2", "-o", snapshot)
            self.assertTrue(self.marker.exists())
            self.marker.unlink()
            refused = espalier("run", "--resume", snapshot, "-o", str(self.folder / "a.string"), status=1)
            self.assertIn("a snapshot may come from a stranger", refused.stderr)
            self.assertFalse(self.marker.exists())
            espalier("run", "--resume", snapshot, "--environment", environment, "-o", str(self.folder / "b.snapshot"))
            self.marker.unlink()
        # and it dials no address
        served = Process([program(), "environment", "height", "--listen", "127.0.0.1:0"])
        self.addCleanup(served.stop)
        address = f"tcp://{served.address}"
        espalier("run", str(model), "--environment", address, "--steps", "2", "-o", snapshot)
        refused = espalier("run", "--resume", snapshot, "-o", str(self.folder / "a.string"), status=1)
        self.assertIn(f"the snapshot asks to dial '{address}'", " ".join(refused.stderr.split()))
        espalier("run", "--resume", snapshot, "--environment", address, "-o", str(self.folder / "b.snapshot"))

    def test_a_folder_a_forest_and_a_plan_start_nothing_unless_they_are_trusted(self) -> None:
        (self.folder / "m.l").write_text(SOURCE, encoding="utf-8")
        own = {"type": "stdio", "command": self.command}
        plan = {"model": "m.l", "measures": {"n": {"count": "*"}}}
        forest = {"models": [{"name": "a", "file": "m.l"}], "plants": [{"position": [0, 0, 0]}]}
        files = {"m.json": own, "named.json": {**forest, "environment": f"stdio:{self.command}"}, "plan.json": {**plan, "environment": f"stdio:{self.command}"},
                 "held.json": {**forest, "environment": own}, "library.json": {**forest, "environment": "other.so"}}
        for name, content in files.items():
            (self.folder / name).write_text(json.dumps(content), encoding="utf-8")
        (self.folder / "other.so").write_bytes(b"")
        string = str(self.folder / "out.svg")
        for command in (("check", "m.l"), ("derive", "m.l"), ("run", "m.l", "-o", string), ("run", "named.json", "-o", string),
                        ("run", "held.json", "-o", string), ("run", "library.json", "-o", string),
                        ("sweep", "plan.json", "-o", str(self.folder / "r.sqlite"))):
            with contextlib.chdir(self.folder):
                refused = " ".join(espalier(*command, "--quiet", status=1).stderr.split())
            self.assertIn("--allow-folder-programs starts it, for folders that you trust", refused, command)
            self.assertFalse(self.marker.exists(), f"{command} started the command")
        for trusted in (("--allow-folder-programs",), ("--environment", f"stdio:{self.command}")):
            espalier("derive", str(self.folder / "m.l"), "--quiet", *trusted)
            self.assertTrue(self.marker.exists())
            self.marker.unlink()

    def test_a_folder_and_a_forest_dial_nothing_unless_they_are_trusted(self) -> None:
        (self.folder / "m.l").write_text(SOURCE, encoding="utf-8")
        listener = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(listener.close)
        listener.setblocking(False)
        address = f"127.0.0.1:{listener.getsockname()[1]}"
        forest = {"models": [{"name": "a", "file": "m.l"}], "plants": [{"position": [0, 0, 0]}]}
        plan = {"model": "m.l", "measures": {"n": {"count": "*"}}}
        own = {"type": "tcp", "address": address}
        files = {"m.json": own, "held.json": {**forest, "environment": own}, "plan.json": {**plan, "environment": f"tcp://{address}"},
                 "named.json": {**forest, "environment": f"tcp://{address}"}, "set.json": {**forest, "environment": [{"type": "height"}, own]},
                 "socket.json": {**forest, "environment": {"type": "tcp", "address": f"unix:{self.folder}/s"}}}
        for name, content in files.items():
            (self.folder / name).write_text(json.dumps(content), encoding="utf-8")
        string = str(self.folder / "out.svg")
        for command in (("derive", "m.l"), ("run", "m.l", "-o", string), *(("run", name, "-o", string) for name in list(files)[1:] if name != "plan.json"),
                        ("sweep", "plan.json", "-o", str(self.folder / "r.sqlite"))):
            with contextlib.chdir(self.folder):
                refused = " ".join(espalier(*command, "--quiet", status=1).stderr.split())
            self.assertIn("--allow-folder-programs dials it, for folders that you trust", refused, command)
            with self.assertRaises(BlockingIOError, msg=command):
                listener.accept()
        # with the permission, and with the user's own words, it is dialled
        for trusted in (("--allow-folder-programs",), ("--environment", f"tcp://{address}")):
            listener.setblocking(True)
            accepted: List[Any] = []
            thread = threading.Thread(target=lambda: accepted.append(listener.accept()[0].close()))
            thread.start()
            espalier("derive", str(self.folder / "m.l"), "--quiet", *trusted, status=1)
            thread.join(SECONDS)
            self.assertEqual(len(accepted), 1)

    def test_a_local_server_is_private_and_may_start_commands(self) -> None:
        with unittest.mock.patch.dict("os.environ", {"ESPALIER_PROGRAM": program()}), package.local() as client:
            self.assertTrue(client.address.startswith("unix:"), client.address)
            path = Path(client.address[len("unix:"):])
            self.assertEqual((path.stat().st_mode & 0o777, path.parent.stat().st_mode & 0o777), (0o600, 0o700))
            for token in (None, "guess"):
                with self.assertRaises(ServerError) as caught:
                    Client(client.address, token=token)
                self.assertEqual(caught.exception.code, 1003)
            with Client(client.address, token=client.token) as other:
                self.assertEqual(other.status()["sessions"], 2)
            client.create(SOURCE, environment=[{"type": "stdio", "command": self.command}]).step()
            self.assertTrue(self.marker.exists())
        self.assertFalse(path.parent.exists())


if __name__ == "__main__":
    unittest.main()
