"""Plants over the Model Context Protocol: `python3 -m espalier.mcp` speaks it on standard input and output (JSON-RPC, one message a line), or
over HTTP with `--http`.

A host of the protocol can check models, grow plants, explain steps, look at pictures and read states. It reaches no files and starts no
commands: the module starts a private server without --allow-spawn and --allow-dial, or uses `--server` with the rights of a token.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

from ..client import Client
from ..errors import ConnectionLost, EspalierError, ServerError
from ..local_server import private_folder
from ..program import find_program
from ..server import Server
from ..version import VERSION
from .tools import ANSWER_CHARACTERS, MODULES, PART_CHARACTERS, SECONDS, SESSIONS, SIMULATIONS, TOOLS, Arguments, Unfit, fitting

# newest first
VERSIONS = ("2025-06-18", "2025-03-26", "2024-11-05")
LINE_BYTES = 4_000_000
PARSE_ERROR, INVALID_REQUEST, UNKNOWN_METHOD, INVALID_PARAMETERS = -32700, -32600, -32601, -32602

Content = List[Dict[str, Any]]


class Refused(Exception):
    """A message that is answered with an error of JSON-RPC."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


def text(value: str) -> Content:
    """A text as content. A long one is cut, and says so."""
    if len(value) > ANSWER_CHARACTERS:
        value = (f"{value[:ANSWER_CHARACTERS]}\n[The answer has {len(value)} characters; {ANSWER_CHARACTERS} of them are above. "
                 "Ask for a part: `from` and `count` of query.]")
    return [{"type": "text", "text": value}]


def as_json(value: Any) -> Content:
    return text(json.dumps(value, ensure_ascii=False, allow_nan=False))


class Tools:
    """What the tools do, over a client of a server."""

    def __init__(self, client: Client, program: str, seconds: float = SECONDS) -> None:
        self._client = client
        self._program = program
        self._seconds = seconds
        self._made: List[str] = []  # simulations

    def call(self, name: str, arguments: Arguments) -> Content:
        tools: Dict[str, Callable[[Arguments], Content]] = {
            "check": self._check, "gallery": self._gallery, "environments": self._environments, "create": self._create,
            "step": self._step, "explain": self._explain, "render": self._render, "query": self._query, "delete": self._delete}
        return tools[name](arguments)

    def close(self) -> None:
        """Deletes the simulations that are left."""
        for simulation in self._made:
            try:
                self._client.call("simulation.delete", {"simulation": simulation})
            except EspalierError:
                pass  # it is gone, or the server is
        self._made.clear()

    def _ask(self, method: str, parameters: Mapping[str, Any]) -> Any:
        """A request that is given up when it takes too long."""
        identifier = self._client._start(method, parameters)
        timer = threading.Timer(self._seconds, self._client.notify, ("$/cancel", {"id": identifier}))
        timer.start()
        try:
            return self._client._wait_for(identifier, method)
        except ServerError as error:
            if error.code == 1010:
                raise EspalierError(f"{error.message} A call may take {self._seconds:g} seconds: ask for fewer steps.") from None
            raise
        finally:
            timer.cancel()

    def _check(self, arguments: Arguments) -> Content:
        checked = self._ask("model.check", {"source": arguments["source"]})
        lines = [item["text"] for item in checked["diagnostics"]]
        if checked["valid"]:
            lines.append(f"The model is valid. Derivation length {checked['derivationLength']}; symbols: {' '.join(checked['symbols'])}")
        else:
            lines.append("The model is not valid.")
        return text("\n".join(lines))

    def _gallery(self, arguments: Arguments) -> Content:
        if "name" not in arguments:
            return text("\n".join(self._ask("model.list", {})["entries"]))
        read = self._ask("model.read", {"gallery": arguments["name"]})
        parts = [f"=== {name}\n{content}" for name, content in read["files"].items()]
        if read.get("environment"):
            parts.append(f"=== environment for create\n{json.dumps(read['environment'])}")
        return text("\n".join(parts))

    def _environments(self, arguments: Arguments) -> Content:
        known = self._ask("environment.list", {})["environments"]
        if "name" not in arguments:
            return as_json([item["name"] for item in known])
        for item in known:
            if item["name"] == arguments["name"]:
                return as_json(item)
        raise EspalierError(f"There is no environment '{arguments['name']}'. `environments` without a name lists them.")

    def _create(self, arguments: Arguments) -> Content:
        if ("source" in arguments) == ("gallery" in arguments):
            raise Unfit("create takes either `source`, the text of a model, or `gallery`, the name of one.")
        if len(self._made) >= SIMULATIONS:
            raise EspalierError(f"There are {SIMULATIONS} simulations. Call `delete` for one that is not needed: {' '.join(self._made)}")
        named = "source" if "source" in arguments else "gallery"
        parameters = {"model": {named: arguments[named]}, "save": False, "limits": {"modules": MODULES, "queries": MODULES}}
        for name in ("environment", "seed", "parameters"):
            if name in arguments:
                parameters[name] = arguments[name]
        created = self._ask("simulation.create", parameters)
        self._made.append(created["simulation"])
        return as_json({key: created[key] for key in ("simulation", "step", "seed", "derivationLength", "plants", "finished") if key in created}
                       | {"diagnostics": [item["text"] for item in created.get("diagnostics", [])]})

    def _step(self, arguments: Arguments) -> Content:
        return as_json(self._ask("simulation.step", {"simulation": arguments["simulation"], "steps": arguments.get("steps", 1)}))

    def _explain(self, arguments: Arguments) -> Content:
        explained = self._ask("simulation.get", {"simulation": arguments["simulation"], "what": "explanation",
                                                 "module": arguments["module"], "plant": arguments.get("plant", 0)})
        return text(explained["explanation"])

    def _render(self, arguments: Arguments) -> Content:
        saved = self._ask("simulation.save", {"simulation": arguments["simulation"]})
        with tempfile.TemporaryDirectory(prefix="espalier-mcp-") as folder:
            snapshot, picture = Path(folder) / "plant.snapshot", Path(folder) / "plant.png"
            snapshot.write_bytes(base64.b64decode(saved["snapshot"]))
            size = f"{arguments.get('width', 800)}x{arguments.get('height', 600)}"
            try:
                done = subprocess.run([self._program, "export", str(snapshot), "-o", str(picture), "--size", size, "--quiet"],
                                      stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=self._seconds, check=False)
            except subprocess.TimeoutExpired:
                raise EspalierError(f"The picture takes more than {self._seconds:g} seconds: ask for a smaller one.") from None
            if done.returncode != 0:
                raise EspalierError(done.stderr.strip() or "The picture could not be drawn.")
            return [{"type": "image", "data": base64.b64encode(picture.read_bytes()).decode("ascii"), "mimeType": "image/png"}]

    def _query(self, arguments: Arguments) -> Content:
        what, first, count = arguments["what"], arguments.get("from", 0), arguments.get("count", PART_CHARACTERS)
        parameters = {"simulation": arguments["simulation"], "what": what}
        if what == "string":
            whole = self._ask("simulation.get", {**parameters, "plant": arguments.get("plant", 0)})["string"]
            part = whole[first:first + count]
            if len(part) < len(whole):
                return text(f"{part}\n[Characters {first} to {first + len(part)} of {len(whole)}.]")
            return text(whole)
        if what == "turtle":
            records = self._ask("simulation.get", parameters)["records"]
            part = records[first:first + min(count, 200)]
            return as_json({"first": first, "of": len(records), "records": part})
        return as_json(self._ask("simulation.get", parameters))

    def _delete(self, arguments: Arguments) -> Content:
        self._ask("simulation.delete", {"simulation": arguments["simulation"]})
        if arguments["simulation"] in self._made:
            self._made.remove(arguments["simulation"])
        return text("The simulation is deleted.")


class Conversation:
    """Answers the messages of one host."""

    def __init__(self, tools: Tools) -> None:
        self._tools = tools

    def answer(self, line: bytes) -> Optional[Dict[str, Any]]:
        """The response to a line; None: the line is a notification or a response."""
        identifier = None
        try:
            try:
                message = json.loads(line)
            except (ValueError, RecursionError):
                raise Refused(PARSE_ERROR, "The line is not a JSON text.") from None
            if not isinstance(message, dict) or message.get("jsonrpc") != "2.0":
                raise Refused(INVALID_REQUEST, "Expected one object of JSON-RPC 2.0 in each line.")
            if "id" not in message or "result" in message or "error" in message:
                return None
            identifier = message["id"]
            if isinstance(identifier, bool) or not isinstance(identifier, (str, int)):
                identifier = None
                raise Refused(INVALID_REQUEST, "The id of a request is a text or a whole number.")
            if not isinstance(message.get("method"), str):
                raise Refused(INVALID_REQUEST, "A request names its method with a text.")
            parameters = message.get("params", {})
            if not isinstance(parameters, dict):
                raise Refused(INVALID_PARAMETERS, "params: expected an object.")
            return {"jsonrpc": "2.0", "id": identifier, "result": self._result(message["method"], parameters)}
        except Refused as refused:
            return {"jsonrpc": "2.0", "id": identifier, "error": {"code": refused.code, "message": str(refused)}}

    def _result(self, method: str, parameters: Mapping[str, Any]) -> Dict[str, Any]:
        if method == "initialize":
            wanted = parameters.get("protocolVersion")
            return {"protocolVersion": wanted if wanted in VERSIONS else VERSIONS[0], "capabilities": {"tools": {}},
                    "serverInfo": {"name": "espalier", "version": VERSION},
                    "instructions": "Check a model first, then create, step, query and render it. `gallery` has models to start from."}
        if method == "ping":
            return {}
        if method == "tools/list":
            return {"tools": [{"name": name, "description": tool.description, "inputSchema": tool.schema()} for name, tool in TOOLS.items()]}
        if method == "tools/call":
            return self._call(parameters.get("name"), parameters.get("arguments", {}))
        raise Refused(UNKNOWN_METHOD, f"The method '{method[:100]}' is unknown. Known: initialize, ping, tools/list, tools/call.")

    def _call(self, name: Any, arguments: Any) -> Dict[str, Any]:
        if not isinstance(name, str) or name not in TOOLS:
            raise Refused(INVALID_PARAMETERS, f"There is no tool of that name. Known: {', '.join(TOOLS)}.")
        try:
            return {"content": self._tools.call(name, fitting(name, arguments)), "isError": False}
        except ConnectionLost:
            raise
        except ServerError as error:
            details = [item["text"] for item in error.diagnostics if "text" in item]
            return {"content": text("\n".join([error.message, *details])), "isError": True}
        except (EspalierError, Unfit) as error:
            return {"content": text(str(error)), "isError": True}
        except UnicodeEncodeError:
            return {"content": text("A text has half of a character pair (\\ud800 to \\udfff). Send whole characters."), "isError": True}


def lines(source: IO[bytes]) -> Iterator[Tuple[bytes, bool]]:
    """Lines of the host, each with whether it is whole: of a line that is too long only the begin is kept."""
    while True:
        line = source.readline(LINE_BYTES + 1)
        if not line:
            return
        is_whole = len(line) <= LINE_BYTES or line.endswith(b"\n")
        rest = line
        while rest and not rest.endswith(b"\n"):
            rest = source.readline(LINE_BYTES)
        if line.strip():
            yield line, is_whole


def serve(tools: Tools, source: IO[bytes], target: IO[bytes]) -> None:
    """Answers until the host closes its side."""
    conversation = Conversation(tools)
    for line, is_whole in lines(source):
        if is_whole:
            answer = conversation.answer(line)
        else:
            answer = {"jsonrpc": "2.0", "id": None,
                      "error": {"code": INVALID_REQUEST, "message": f"A line has {LINE_BYTES} bytes at most."}}
        if answer is not None:
            # escaped: half of a character pair cannot be written as UTF-8
            target.write(json.dumps(answer).encode() + b"\n")
            target.flush()


def private_server(program: str, stack: ExitStack, simulations: int) -> Tuple[str, str]:
    """A server of its own, which starts no commands, dials nobody, and is small: its address and token."""
    folder = private_folder()
    stack.callback(shutil.rmtree, folder, ignore_errors=True)
    token = secrets.token_hex(32)
    token_file = os.path.join(folder, "token")
    with open(os.open(token_file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:
        file.write(token + "\n")
    server = stack.enter_context(Server(program, listen=f"unix:{folder}/socket", arguments=[
        "--token-file", token_file, "--log-level", "warn", "--limit", f"simulations={simulations}", "--limit", "memoryBytes=4000000000",
        "--limit", f"callSeconds={SECONDS}"]))
    return server.address, token


def first_line(file: Optional[str]) -> Optional[str]:
    return Path(file).read_text(encoding="ascii").splitlines()[0] if file else None


def serve_http(place: str, open_tools: Callable[[ExitStack], Tools], token: Optional[str]) -> None:
    """Answers hosts over HTTP until it is interrupted."""
    from .http import LOOPBACK, PATH, HttpServer

    host, _, port = place.rpartition(":")
    host = host.strip("[]")
    if not (port.isdigit() and host and int(port) < 65536):
        raise EspalierError(f"--http needs HOST:PORT, and found '{place}'.")
    if token is None and host not in LOOPBACK:
        raise EspalierError("Other machines could reach the tools: give --http-token-file FILE, or listen on 127.0.0.1.")
    with HttpServer((host, int(port)), open_tools, token) as server:
        shown = f"[{host}]" if ":" in host else host
        print(f"MCP on http://{shown}:{server.server_address[1]}{PATH}", flush=True)
        server.serve_forever()


def main(arguments: Optional[Sequence[str]] = None) -> int:
    parser = argparse.ArgumentParser(prog="python3 -m espalier.mcp",
                                     description="Speaks the Model Context Protocol on standard input and output, or over HTTP.")
    parser.add_argument("--server", metavar="ADDRESS", help="a running server, as HOST:PORT or unix:PATH; without it a private one is started")
    parser.add_argument("--token-file", metavar="FILE", help="the token for --server, in the first line; its role bounds the tools")
    parser.add_argument("--http", metavar="HOST:PORT", help="listen here instead (Streamable HTTP); port 0 takes a free one and prints it")
    parser.add_argument("--http-token-file", metavar="FILE", help="the token that hosts need, in the first line; needed beyond this machine")
    options = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with ExitStack() as stack:
        try:
            program = find_program()
            address, token = options.server, first_line(options.token_file)
            if address is None:
                address, token = private_server(program, stack, SIMULATIONS * (SESSIONS if options.http else 1))

            def open_tools(stack: ExitStack) -> Tools:
                return Tools(stack.enter_context(Client(address, name="mcp", token=token)), program)

            if options.http:
                serve_http(options.http, open_tools, first_line(options.http_token_file))
            else:
                serve(open_tools(stack), sys.stdin.buffer, sys.stdout.buffer)
        except (EspalierError, OSError, IndexError, UnicodeError) as error:
            print(f"espalier.mcp: {error or 'the token file is empty'}", file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            return 130
    return 0
