"""`python3 -m espalier.mcp`: the official SDK of the Model Context Protocol as a client, and hosts that send nonsense."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List

from support import REPOSITORY, SECONDS, Server, espalier, program, variables

import espalier as espalier_package
from espalier import mcp
from espalier.mcp import tools as mcp_tools

SDK = REPOSITORY / "tests" / "mcp"
COMMAND = [sys.executable, "-m", "espalier.mcp"]
MODEL = "Lsystem: 1\nderivation length: 4\nAxiom: A\nA --> F[+A]A\nendlsystem\n"


def host(*lines: Any, arguments: "tuple[str, ...]" = ()) -> List[Dict[str, Any]]:
    """Sends lines (texts as they are, objects as JSON) and returns the answers."""
    sent = "".join(line if isinstance(line, str) else json.dumps(line) + "\n" for line in lines)
    done = subprocess.run([*COMMAND, *arguments], input=sent, capture_output=True, text=True, timeout=SECONDS, check=True,
                          env=variables(ESPALIER_PROGRAM=program()))
    return [json.loads(line) for line in done.stdout.splitlines()]


def request(number: int, method: str, **parameters: Any) -> Dict[str, Any]:
    return {"jsonrpc": "2.0", "id": number, "method": method, "params": parameters}


def call(number: int, name: str, **arguments: Any) -> Dict[str, Any]:
    return request(number, "tools/call", name=name, arguments=arguments)


def said(answer: Dict[str, Any]) -> str:
    return str(answer["result"]["content"][0]["text"])


def check_answers(case: unittest.TestCase, answers: Dict[str, Any]) -> None:
    """Compares the tools' answers to the official SDK with the command line."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "model.l").write_text(MODEL, encoding="utf-8")
        derived = espalier("derive", f"{folder}/model.l", "--steps", "3", "--quiet").stdout.strip()
    case.assertEqual(answers["server"]["name"], "espalier")
    case.assertEqual(answers["tools"], list(mcp_tools.TOOLS))
    content = {name: answer["content"][0] for name, answer in answers.items() if isinstance(answer, dict) and "content" in answer}
    case.assertIn("model.l:4:8: warning: this '[' is not closed", content["wrong"]["text"])
    case.assertIn("The model is valid. Derivation length 4", content["check"]["text"])
    case.assertEqual(json.loads(content["step"]["text"])["step"], 3)
    case.assertEqual(content["string"]["text"], derived)
    case.assertIn("Module 3: F", content["explain"]["text"])
    picture = base64.b64decode(content["render"]["data"])
    case.assertEqual((picture[:4], picture[16:24]), (b"\x89PNG", (120).to_bytes(4, "big") + (90).to_bytes(4, "big")))
    case.assertEqual((answers["refused"]["isError"], content["refused"]["text"]), (True, "`steps` of step must be from 1 to 10000."))
    case.assertTrue(answers["spawn"]["isError"])
    case.assertEqual(answers["unknown"], {"code": -32602})


class WithTheOfficialClient(unittest.TestCase):
    @unittest.skipUnless((SDK / "node_modules").is_dir() and shutil.which("node"), "the SDK is not installed: npm ci in tests/mcp")
    def test_a_plant_is_checked_grown_explained_drawn_and_read(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(["node", str(SDK / "client.js"), *COMMAND], cwd=folder, capture_output=True, text=True, timeout=SECONDS,
                                  check=True, env=variables(ESPALIER_PROGRAM=program()))
            self.assertEqual(list(Path(folder).iterdir()), [], "a host starts no commands")
            answers = json.loads(done.stdout)
        check_answers(self, answers)


class TheDoor(unittest.TestCase):
    def test_a_host_reads_what_each_tool_does_and_takes(self) -> None:
        answer, = host(request(1, "tools/list"))
        tools = {tool["name"]: tool for tool in answer["result"]["tools"]}
        self.assertEqual(tools["step"]["description"], "Make steps. Ends early when the model is finished.")
        steps = {"type": "integer", "description": "how many", "minimum": 1, "maximum": 10_000, "default": 1}
        simulation = {"type": "string", "description": "the `simulation` of create", "maxLength": 200}
        self.assertEqual(tools["step"]["inputSchema"], {"type": "object", "properties": {"simulation": simulation, "steps": steps},
                                                        "required": ["simulation"], "additionalProperties": False})
        taken = set()
        for name, tool in tools.items():
            self.assertGreater(len(tool["description"]), 20, name)
            properties = tool["inputSchema"]["properties"]
            taken.update(properties)
            for word, schema in properties.items():
                if "default" in schema:
                    self.assertTrue(schema["minimum"] <= schema["default"] <= schema["maximum"], f"{name}: {word}")
        self.assertEqual(taken, set(mcp_tools.ARGUMENTS))

    def test_it_stays_small(self) -> None:
        lines = [line for name in ("__init__", "__main__", "tools")
                 for line in (Path(mcp.__file__).parent / f"{name}.py").read_text(encoding="utf-8").splitlines()]
        self.assertLessEqual(len(lines), 400)
        self.assertLessEqual(max(map(len, lines)), 120)


class Hosts(unittest.TestCase):
    @staticmethod
    def server() -> espalier_package.Server:
        return espalier_package.Server(program(), arguments=["--log-level", "off", "--gallery", str(REPOSITORY / "clients" / "gallery")])

    def test_bad_lines_are_answered_one_by_one_and_end_nothing(self) -> None:
        answers = host("no JSON\n", "[" * 100_000 + "\n", "[]\n", '{"jsonrpc":"2.0","id":true,"method":"ping"}\n', '"' + "x" * 5_000_000 + '"\n',
                       {"jsonrpc": "2.0", "method": "notifications/initialized"}, {"jsonrpc": "2.0", "id": 9, "result": {}}, "\n",
                       {"jsonrpc": "2.0", "id": 1, "method": "ping", "params": []}, request(2, "resources/list"),
                       request(3, "tools/call", name="nothing"),
                       '{"jsonrpc":"2.0","id":"\\ud800","method":5}\n', request(5, "tools/call", name="check", arguments={"source": "\ud800"}),
                       request(4, "ping"))
        codes = [answer.get("error", {}).get("code") for answer in answers]
        self.assertEqual(codes, [-32700, -32700, -32600, -32600, -32600, -32602, -32601, -32602, -32600, None, None])
        self.assertEqual([answer["id"] for answer in answers], [None] * 5 + [1, 2, 3, "\ud800", 5, 4])
        self.assertTrue(answers[-2]["result"]["isError"])

    def test_the_version_of_the_host_is_taken_when_it_is_known(self) -> None:
        answers = host(request(1, "initialize", protocolVersion="2024-11-05"), request(2, "initialize", protocolVersion="2099-01-01"))
        self.assertEqual([answer["result"]["protocolVersion"] for answer in answers], ["2024-11-05", mcp.VERSIONS[0]])

    def test_arguments_out_of_bounds_are_refused_by_name(self) -> None:
        cases = [(dict(name="check", arguments={}), "check needs `source`: the text of the model."),
                 (dict(name="check", arguments=[]), "The arguments of check must be an object."),
                 (dict(name="check", arguments={"source": 3}), "`source` of check must be a text."),
                 (dict(name="check", arguments={"source": MODEL, "file": "/etc/passwd"}), "check has no argument `file`. It takes: source."),
                 (dict(name="check", arguments={"source": "x" * 1_000_001}), "`source` of check has 1000001 characters; 1000000 are the most."),
                 (dict(name="step", arguments={"simulation": "s", "steps": True}), "`steps` of step must be a whole number."),
                 (dict(name="create", arguments={}), "create takes either `source`, the text of a model, or `gallery`, the name of one."),
                 (dict(name="create", arguments={"gallery": "x", "environment": ["honda"]}), "`environment` of create must be a list of objects."),
                 (dict(name="create", arguments={"gallery": "x", "environment": [{}] * 17}),
                  "`environment` of create has 17 entries; 16 are the most."),
                 (dict(name="query", arguments={"simulation": "s", "what": "files"}),
                  "`what` of query must be one of string, statistics, turtle, state-hash, information."),
                 (dict(name="environments", arguments={"name": "x"}),
                  "There is no environment 'x'. `environments` without a name lists them.")]
        answers = host(*(request(number, "tools/call", **parameters) for number, (parameters, _) in enumerate(cases)))
        for answer, (_, sentence) in zip(answers, cases):
            self.assertTrue(answer["result"]["isError"])
            self.assertEqual(said(answer), sentence)
        self.assertEqual(len(answers), len(cases))

    def test_a_model_that_includes_a_file_of_the_machine_reads_none(self) -> None:
        answer, = host(call(1, "check", source='Lsystem: 1\n#include "/etc/passwd"\n' + MODEL[11:]))
        self.assertIn("The model is not valid.", said(answer))
        self.assertNotIn("root:", said(answer))

    def test_a_model_that_explodes_ends_at_the_limit_and_others_go_on(self) -> None:
        source = "Lsystem: 1\nderivation length: 99\nAxiom: A\nA --> AAAAAAAAAA\nendlsystem\n"
        with self.server() as server, server.connect() as client:
            tools = mcp.Tools(client, program())
            made = json.loads(tools.call("create", {"source": source})[0]["text"])
            conversation = mcp.Conversation(tools)
            answer = conversation.answer(json.dumps(call(1, "step", simulation=made["simulation"], steps=20)).encode())
            assert answer is not None
            self.assertTrue(answer["result"]["isError"])
            self.assertIn(str(mcp_tools.MODULES), said(answer).replace(",", "").replace("'", ""))
            # a long answer is cut and says so
            answer = conversation.answer(json.dumps(call(2, "query", simulation=made["simulation"], what="string")).encode())
            assert answer is not None
            self.assertEqual(said(answer)[-40:].split("\n")[-1], "[Characters 0 to 40000 of 1000000.]")

    def test_a_call_that_takes_too_long_is_given_up(self) -> None:
        source = "Lsystem: 1\nderivation length: 9\nAxiom: A(0)\nA(x) : * {i = 0; while (i < 90000000) {i = i + 1;}} --> A(i)\nendlsystem\n"
        with self.server() as server, server.connect() as client:
            tools = mcp.Tools(client, program(), seconds=0.3)
            made = json.loads(tools.call("create", {"source": source})[0]["text"])
            answer = mcp.Conversation(tools).answer(json.dumps(call(1, "step", simulation=made["simulation"], steps=9)).encode())
            assert answer is not None
            self.assertTrue(answer["result"]["isError"])
            self.assertIn("A call may take 0.3 seconds: ask for fewer steps.", said(answer))

    def test_a_picture_that_takes_too_long_is_given_up(self) -> None:
        with tempfile.TemporaryDirectory() as folder, self.server() as server, server.connect() as client:
            slow = Path(folder) / "slow"
            slow.write_text("#!/bin/sh\nexec sleep 60\n", encoding="ascii")
            slow.chmod(0o700)
            tools = mcp.Tools(client, str(slow), seconds=0.3)
            made = json.loads(tools.call("create", {"gallery": "light-tree"})[0]["text"])["simulation"]
            answer = mcp.Conversation(tools).answer(json.dumps(call(1, "render", simulation=made)).encode())
            assert answer is not None
            self.assertTrue(answer["result"]["isError"])
            self.assertEqual(said(answer), "The picture takes more than 0.3 seconds: ask for a smaller one.")

    def test_simulations_are_counted_and_deleted(self) -> None:
        calls = [call(number, "create", source=MODEL, seed=1) for number in range(mcp_tools.SIMULATIONS + 1)]
        last = host(*calls)[-1]
        self.assertTrue(last["result"]["isError"])
        self.assertIn("Call `delete` for one", said(last))
        with self.server() as server, server.connect() as client:
            tools = mcp.Tools(client, program())
            made = json.loads(tools.call("create", {"gallery": "light-tree"})[0]["text"])["simulation"]
            tools.call("delete", {"simulation": made})
            self.assertEqual(client.simulations(), [])


class OfARunningServer(unittest.TestCase):
    def test_a_file_without_a_token_is_named(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            (Path(name) / "empty").write_text("\ntoken\n", encoding="ascii")
            for file, options in (("empty", ("--server", "127.0.0.1:1", "--token-file")),
                                  ("absent", ("--http", "127.0.0.1:0", "--http-token-file"))):
                done = subprocess.run([*COMMAND, *options, f"{name}/{file}"], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                      timeout=SECONDS, check=False, env=variables(ESPALIER_PROGRAM=program()))
                self.assertEqual((done.returncode, done.stdout), (1, ""))
                self.assertEqual(done.stderr, f"espalier.mcp: The token file '{name}/{file}' cannot be read, or its first line is empty. "
                                              "`espalier token new NAME -o FILE` makes one.\n")

    def test_a_viewer_reads_and_changes_nothing(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            lines, files = ["[tokens]"], {}
            for role in ("viewer", "controller"):
                files[role] = folder / f"{role}.token"
                lines.append(espalier("token", "new", role, "--role", role, "-o", str(files[role])).stdout)
            configuration = folder / "serve.toml"
            configuration.write_text("\n".join(lines), encoding="utf-8")
            configuration.chmod(0o600)
            server = Server("--config", str(configuration))
            self.addCleanup(server.stop)
            arguments = {role: ("--server", server.address, "--token-file", str(file)) for role, file in files.items()}
            made, = host(call(1, "create", source=MODEL, seed=1), arguments=arguments["controller"])
            simulation = json.loads(said(made))["simulation"]
            read, stepped = host(call(1, "query", simulation=simulation, what="string"), call(2, "step", simulation=simulation),
                                 arguments=arguments["viewer"])
            self.assertEqual((said(read), stepped["result"]["isError"]), ("A", True))
            self.assertIn("controller", said(stepped))
            done = subprocess.run([*COMMAND, "--server", server.address], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                  timeout=SECONDS, check=False, env=variables(ESPALIER_PROGRAM=program()))
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn("token", done.stderr)


if __name__ == "__main__":
    unittest.main()
