"""The examples of protocol/README.md, played line by line against a server: what it answers is what is written there."""

import json
import re
import socket
import tempfile
import unittest
from collections import deque
from pathlib import Path
from typing import Any, Deque, Dict, List

from support import EXAMPLES, GALLERY, REPOSITORY, SECONDS, espalier, model, program, python, stdio

from espalier import Server

README = REPOSITORY / "protocol" / "README.md"

# values that differ from run to run: only their type is compared
VOLATILE = {"milliseconds", "bytes", "content", "snapshot", "uptimeSeconds", "storeBytes", "outboxBytes", "stringBytes",
            "environmentBytes", "frameBytes", "decodingBytes", "compilingBytes", "databaseBytes", "traceBytes", "usedBytes", "boundBytes", "cpuSeconds",
            "sessions", "workers", "server"}
# abbreviated in the text: the members and elements that are there must be in the answer
ABBREVIATED = {"limits", "gallery", "entries", "pictures", "files"}
# names that the server makes: those of the text stand for others
NAMES = {"simulation", "stream", "model", "session"}
# ids of examples that need a run that lasts, a peer that leaves, a smaller limit or binary blocks; each has a test of its own
NOT_PLAYED = {7, 30, 36, 37, "s4", "s5", "s6", "s7"}
# requests of which the text only shows the error
ASKED: Dict[int, Dict[str, Any]] = {31: {"jsonrpc": "2.0", "id": 31, "method": "simulation.step",
                                         "params": {"simulation": "any", "steps": "three"}}}


def examples() -> List[Dict[str, Any]]:
    """The messages of all json blocks, in order."""
    blocks = re.findall(r"```json\n(.*?)```", README.read_text(encoding="utf-8"), re.S)
    return [json.loads(line) for block in blocks for line in block.splitlines()]


class Player:
    """One connection with the messages of the text."""

    def __init__(self, test: unittest.TestCase, address: str) -> None:
        self.test = test
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), SECONDS)
        self.lines = self.socket.makefile("r", encoding="utf-8", newline="\n")
        self.heard: Deque[Dict[str, Any]] = deque()
        self.names: Dict[str, str] = {}  # of the text: what they are here

    def close(self) -> None:
        self.lines.close()
        self.socket.close()

    def say(self, message: Dict[str, Any]) -> None:
        text = json.dumps(message)
        for written, real in self.names.items():
            text = text.replace(f'"{written}"', f'"{real}"')
        self.socket.sendall(text.encode("utf-8") + b"\n")

    def hear(self, wanted: Any) -> Dict[str, Any]:
        """The first message that is wanted, of those that came already and those to come."""
        for message in self.heard:
            if wanted(message):
                self.heard.remove(message)
                return message
        while True:
            line = self.lines.readline()
            self.test.assertTrue(line, "the server closed the connection")
            message = json.loads(line)
            if wanted(message):
                return dict(message)
            self.heard.append(message)

    def compare(self, written: Any, real: Any, path: str, key: str = "") -> None:
        same = self.test.assertEqual
        if key in NAMES and isinstance(written, str) and isinstance(real, str):
            same(self.names.setdefault(written, real), real, path)
        elif key in VOLATILE and not path.endswith("statistics.bytes"):
            same(isinstance(written, str), isinstance(real, str), path)
        elif isinstance(written, dict) and isinstance(real, dict):
            if key not in ABBREVIATED:
                same(sorted(written), sorted(real), path)
            for name, value in written.items():
                self.test.assertIn(name, real, path)
                self.compare(value, real[name], f"{path}.{name}", name)
        elif isinstance(written, list) and isinstance(real, list):
            if key in ABBREVIATED:
                self.test.assertLessEqual(set(written), set(real), path)
                return
            same(len(written), len(real), path)
            if key == "simulations":
                # in the order of names that the server made
                written = sorted(written, key=lambda entry: self.names.get(entry["simulation"], ""))
            for index, value in enumerate(written):
                self.compare(value, real[index], f"{path}[{index}]")
        else:
            # as text: -0.0 is not 0
            same(json.dumps(written), json.dumps(real), path)

    def play(self, message: Dict[str, Any]) -> Dict[str, Any]:
        """Says or hears one line of the text; what really came, or the line."""
        method, identifier = message.get("method"), message.get("id")
        is_servers = isinstance(identifier, str) and identifier.startswith("s")
        if method and (is_servers or method in ("stream.data", "stream.end")):
            stream = self.names.get(message["params"].get("stream", ""))
            real = self.hear(lambda heard: heard.get("method") == method and heard["params"].get("stream") == stream)
            if is_servers:
                self.names[str(identifier)] = real["id"]
            self.compare(message["params"], real["params"], f"{method} {identifier or ''}")
            return real
        if method or is_servers:
            self.say(message)
            return message
        real = self.hear(lambda heard: heard.get("id") == identifier and "method" not in heard)
        for part in ("result", "error"):
            self.compare(message.get(part), real.get(part), f"the {part} of {identifier}")
        return real


class Examples(unittest.TestCase):
    def test_are_what_a_server_answers(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        models = tempfile.TemporaryDirectory()
        self.addCleanup(models.cleanup)
        server = Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off", "--data", folder.name, "--models", models.name])
        self.addCleanup(server.stop)
        player = Player(self, server.address)
        self.addCleanup(player.close)
        played = 0
        for message in examples():
            about = message["params"].get("id") if message.get("method") in ("$/cancel", "$/progress") else message.get("id")
            if about in NOT_PLAYED or about is None and "error" in message or "bin" in message:
                continue
            if about in ASKED:
                player.say(ASKED[about])
            player.play(message)
            played += 1
        self.assertGreater(played, 100)
        self.assertEqual([message for message in player.heard if "id" in message], [])

    def test_the_environment_of_the_first_screen_grows_the_plant_of_the_package(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "ceiling.py"
            script.write_text(README.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0], encoding="utf-8")
            grown = [espalier("derive", model("light-tree"), "--quiet", "--environment", stdio(python(path))).stdout
                     for path in (script, EXAMPLES / "ceiling.py")]
        self.assertEqual(grown[0], grown[1])
        self.assertIn("F", grown[0])

    def test_the_first_conversation_is_what_a_server_says(self) -> None:
        server = Server(program(), arguments=["--log-level", "off"])
        self.addCleanup(server.stop)
        player = Player(self, server.address)
        self.addCleanup(player.close)
        block = README.read_text(encoding="utf-8").split("$ nc ")[1].split("```")[0]
        simulation = ""
        lines = block.splitlines()[1:]
        self.assertEqual(len(lines), 10)
        for line in lines:
            if simulation:
                line = re.sub(r"sim-[0-9a-f]{12}", simulation, line)
            if '"method"' in line and '"id"' in line:
                player.socket.sendall(line.encode("utf-8") + b"\n")
                continue
            heard = player.lines.readline().rstrip("\n")
            created = re.search(r"sim-[0-9a-f]{12}", heard)
            simulation = created.group() if created else simulation
            wanted = re.sub(r"sim-[0-9a-f]{12}", simulation, line)
            self.assertRegex(heard, "^" + ".*".join(re.escape(part.strip()) for part in wanted.split("…")) + "$")


if __name__ == "__main__":
    unittest.main()
