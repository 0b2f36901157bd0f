"""The language server as editors start it: over the pipes of the program."""

import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from support import GALLERY, REPOSITORY, SECONDS, program

from espalier import Server, ServerError

MODEL = """#define RATIO 0.7
Lsystem: 1
derivation length: 3
Axiom: A(1)
A(x) --> F(x)A(x * RATOI)
endlsystem
"""


class Editor:
    """An editor that talks to a program of its own."""

    def __init__(self) -> None:
        self.process = subprocess.Popen([program(), "language-server"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.diagnostics: dict[str, list] = {}
        self.count = 0

    def send(self, message: dict) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self.process.stdin is not None
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self.process.stdin.flush()

    def receive(self) -> dict:
        assert self.process.stdout is not None
        length = 0
        while line := self.process.stdout.readline().strip():
            name, value = line.split(b":")
            if name == b"Content-Length":
                length = int(value)
        return json.loads(self.process.stdout.read(length))

    def ask(self, method: str, parameters: dict) -> dict:
        self.count += 1
        self.send({"id": self.count, "method": method, "params": parameters})
        while True:
            message = self.receive()
            if message.get("id") == self.count:
                return message
            if message.get("method") == "textDocument/publishDiagnostics":
                self.diagnostics[message["params"]["uri"]] = message["params"]["diagnostics"]

    def open(self, uri: str, text: str) -> None:
        document = {"uri": uri, "languageId": "espalier", "version": 1, "text": text}
        self.send({"method": "textDocument/didOpen", "params": {"textDocument": document}})

    def end(self) -> int:
        self.ask("shutdown", {})
        self.send({"method": "exit"})
        return self.process.wait(timeout=SECONDS)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            pipe.close()


class LanguageServer(unittest.TestCase):
    def setUp(self) -> None:
        self.editor = Editor()
        self.addCleanup(self.editor.close)
        self.editor.ask("initialize", {"capabilities": {}})

    def test_a_mistake_is_marked_and_its_hint_mends_it(self) -> None:
        self.editor.open("file:///new/tree.l", MODEL)
        place = {"textDocument": {"uri": "file:///new/tree.l"}, "position": {"line": 4, "character": 9}}
        hover = self.editor.ask("textDocument/hover", place)["result"]
        self.assertIn("advances", hover["contents"]["value"])
        (mistake,) = self.editor.diagnostics["file:///new/tree.l"]
        self.assertEqual(mistake["range"], {"start": {"line": 4, "character": 19}, "end": {"line": 4, "character": 24}})
        self.assertIn("did you mean 'RATIO'?", mistake["message"])
        change = {"textDocument": {"uri": "file:///new/tree.l", "version": 2},
                  "contentChanges": [{"range": mistake["range"], "text": "RATIO"}]}
        self.editor.send({"method": "textDocument/didChange", "params": change})
        self.editor.ask("textDocument/hover", place)
        self.assertEqual(self.editor.diagnostics["file:///new/tree.l"], [])
        self.assertEqual(self.editor.end(), 0)

    def test_every_model_of_the_gallery_has_the_messages_of_check(self) -> None:
        for model in sorted(GALLERY.glob("*/*.l")):
            uri = model.as_uri()
            self.editor.open(uri, model.read_text(encoding="utf-8"))
            symbols = self.editor.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})["result"]
            text = model.read_text(encoding="utf-8")
            if "system:" in text.lower() and "\n#define" in text:
                self.assertTrue(symbols, model)
            tokens = self.editor.ask("textDocument/semanticTokens/full", {"textDocument": {"uri": uri}})["result"]
            self.assertEqual(len(tokens["data"]) % 5, 0)
            self.assertEqual([one["message"] for one in self.editor.diagnostics[uri] if one["severity"] == 1], [], model)
            self.editor.send({"method": "textDocument/didClose", "params": {"textDocument": {"uri": uri}}})
        self.assertEqual(self.editor.end(), 0)

    def test_what_is_no_message_is_refused_with_advice(self) -> None:
        done = subprocess.run([program(), "language-server"], input="hello\r\n\r\n", capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(done.returncode, 1)
        self.assertIn("docs/editors.md", done.stderr)

    def test_a_page_has_the_same_help_over_the_protocol_of_a_server(self) -> None:
        server = Server(program(), arguments=["--log-level", "off"])
        self.addCleanup(server.stop)
        with server.connect() as client:
            def say(**message: object) -> list:
                asked = json.dumps({"jsonrpc": "2.0", **message})
                return [json.loads(text) for text in client.call("editor.message", {"message": asked})["messages"]]

            say(id=1, method="initialize", params={"capabilities": {}})
            document = {"uri": "page:/tree.l", "languageId": "espalier", "version": 1,
                        "text": "#include \"/etc/passwd\"\n" + MODEL}
            (published,) = say(method="textDocument/didOpen", params={"textDocument": document})
            messages = [one["message"] for one in published["params"]["diagnostics"]]
            # only what the page opens is read
            self.assertTrue(any("cannot read" in text or "no file" in text for text in messages), messages)
            self.assertNotIn("root:", json.dumps(messages))
            (hover,) = say(id=2, method="textDocument/hover", params={
                "textDocument": {"uri": "page:/tree.l"}, "position": {"line": 5, "character": 9}})
            self.assertIn("advances", hover["result"]["contents"]["value"])

    def test_a_page_sees_how_often_the_run_has_applied_each_production(self) -> None:
        server = Server(program(), arguments=["--log-level", "off"])
        self.addCleanup(server.stop)
        text = MODEL.replace("RATOI", "RATIO").replace("endlsystem", "F(x) : x < 0 --> A(x)\nendlsystem")
        with server.connect() as client:
            def lenses(**run: str) -> list:
                asked = json.dumps({"jsonrpc": "2.0", "id": 2, "method": "textDocument/codeLens",
                                    "params": {"textDocument": {"uri": "model.l"}}})
                (answer,) = client.call("editor.message", {"message": asked, **run})["messages"]
                return [(one["range"]["start"]["line"], one["command"]["title"]) for one in json.loads(answer)["result"]]

            for message in ({"id": 1, "method": "initialize", "params": {"capabilities": {}}},
                            {"method": "textDocument/didOpen", "params": {"textDocument": {
                                "uri": "model.l", "languageId": "espalier", "version": 1, "text": text}}}):
                client.call("editor.message", {"message": json.dumps({"jsonrpc": "2.0", **message})})
            made = client.call("simulation.create", {"model": {"source": text}, "seed": 1, "countProductions": True})
            run = {"simulation": made["simulation"]}
            self.assertEqual(lenses(**run), [])
            client.call("simulation.run", run)
            self.assertEqual(lenses(**run), [(4, "applied 3 times, 1 in step 3"), (5, "never applied in 3 steps")])
            # the same figures as data
            answer = client.call("simulation.get", {**run, "what": "productions"})
            self.assertEqual([(one["line"], one["last"], one["total"]) for one in answer["productions"]], [(5, 1, 3), (6, 0, 0)])
            self.assertEqual((answer["since"], answer["productions"][0]["file"]), (0, "model.l"))
            self.assertEqual(answer["productions"][0]["production"], "A(x) --> F(x)A(x * 0.7)")
            # the same bits as a run that does not count
            other = client.call("simulation.create", {"model": {"source": text}, "seed": 1})
            client.call("simulation.run", {"simulation": other["simulation"]})
            hashes = [client.call("simulation.get", {"simulation": one["simulation"], "what": "state-hash"})["stateHash"]
                      for one in (made, other)]
            self.assertEqual(hashes[0], hashes[1])
            self.assertEqual(lenses(simulation=other["simulation"]), [])
            self.assertEqual(lenses(simulation="sim-000000000000"), [])
            self.assertEqual(lenses(), [])
            with self.assertRaisesRegex(ServerError, "countProductions"):
                client.call("simulation.get", {"simulation": other["simulation"], "what": "productions"})

    @unittest.skipUnless(shutil.which("nvim"), "Neovim is not installed (Debian: neovim)")
    def test_long_neovim_shows_the_mistake(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "tree.l").write_text(MODEL, encoding="utf-8")
            (Path(folder) / "test.lua").write_text(
                "vim.g.espalier_program = os.getenv('ESPALIER_PROGRAM_OF_TEST')\n"
                f"dofile('{REPOSITORY}/clients/editors/nvim/espalier.lua')\n"
                "vim.cmd('edit tree.l')\n"
                "vim.wait(20000, function() return #vim.diagnostic.get(0) > 0 end)\n"
                "local one = vim.diagnostic.get(0)[1]\n"
                "io.stdout:write(one.lnum .. ':' .. one.col .. ' ' .. one.message)\n"
                "vim.cmd('quitall!')\n", encoding="utf-8")
            done = subprocess.run(["nvim", "--headless", "-u", "NONE", "-c", "luafile test.lua"], cwd=folder, capture_output=True,
                                  text=True, timeout=SECONDS, env={**os.environ, "ESPALIER_PROGRAM_OF_TEST": str(program())},
                                  stdin=subprocess.DEVNULL)
            self.assertTrue((done.stdout + done.stderr).startswith("4:19 unknown name 'RATOI'"), done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
