"""Plants over the Model Context Protocol: `python3 -m espalier.mcp` speaks it on standard input and output (JSON-RPC,
one message a line), or over HTTP with `--http`.

A host of the protocol can check models, grow plants, explain steps, look at pictures and read states. It reaches no
files and starts no commands: the module starts a private server without --allow-spawn and --allow-dial, or uses
`--server` with the rights of a token.
"""

from __future__ import annotations

import json
from typing import IO, Any, Dict, Mapping, Optional

from .. import wire
from ..errors import ConnectionLost, EspalierError, ServerError
from ..version import VERSION
from .tools import TOOLS, Tools, content

VERSIONS = ("2025-06-18", "2025-03-26", "2024-11-05")  # newest first
LINE_BYTES = 4_000_000


class Conversation:
    """Answers the messages of one host."""

    def __init__(self, tools: Tools) -> None:
        self._tools = tools

    def answer(self, line: bytes) -> Optional[Dict[str, Any]]:
        """The response to a line; None: the line is a notification or a response."""
        identifier = None
        try:
            message = read(line)
            if "id" not in message or "result" in message or "error" in message:
                return None
            if type(message["id"]) not in (str, int):  # a bool is no number here
                raise wire.Refusal(wire.INVALID_REQUEST, "The id of a request is a text or a whole number.")
            identifier = message["id"]
            method, parameters = message.get("method"), message.get("params", {})
            if not isinstance(method, str):
                raise wire.Refusal(wire.INVALID_REQUEST, "A request names its method with a text.")
            if not isinstance(parameters, dict):
                raise wire.Refusal(wire.INVALID_PARAMETERS, "params: expected an object.")
            return wire.result(identifier, self._result(method, parameters))
        except wire.Refusal as refusal:
            return wire.failure(identifier, refusal.code, str(refusal))

    def _result(self, method: str, parameters: Mapping[str, Any]) -> Dict[str, Any]:
        if method == "initialize":
            wanted = parameters.get("protocolVersion")
            return {"protocolVersion": wanted if wanted in VERSIONS else VERSIONS[0], "capabilities": {"tools": {}},
                    "serverInfo": {"name": "espalier", "version": VERSION},
                    "instructions": "Check a model first, then create, step, query and render it. "
                                    "`gallery` has models to start from."}
        if method == "ping":
            return {}
        if method == "tools/list":
            return {"tools": [tool.described(name) for name, tool in TOOLS.items()]}
        if method == "tools/call":
            return self._call(parameters.get("name"), parameters.get("arguments", {}))
        raise wire.Refusal(wire.METHOD_NOT_FOUND, f"The method '{method[:100]}' is unknown. "
                                                  "Known: initialize, ping, tools/list, tools/call.")

    def _call(self, name: Any, arguments: Any) -> Dict[str, Any]:
        if not isinstance(name, str) or name not in TOOLS:
            raise wire.Refusal(wire.INVALID_PARAMETERS, f"There is no tool of that name. Known: {', '.join(TOOLS)}.")
        try:
            return {"content": self._tools.call(name, arguments), "isError": False}
        except ConnectionLost:
            raise
        except ServerError as error:
            said = "\n".join([error.message, *(item["text"] for item in error.diagnostics if "text" in item)])
        except EspalierError as error:
            said = str(error)
        except UnicodeEncodeError:
            said = "A text has half of a character pair (\\ud800 to \\udfff). Send whole characters."
        return {"content": content(said), "isError": True}


def read(line: bytes) -> Dict[str, Any]:
    """The message in a line."""
    if len(line.rstrip(b"\n")) > LINE_BYTES:
        raise wire.Refusal(wire.INVALID_REQUEST, f"A line has {LINE_BYTES} bytes at most.")
    try:
        message = json.loads(line)
    except (ValueError, RecursionError):
        raise wire.Refusal(wire.PARSE_ERROR, "The line is not a JSON text.") from None
    if not isinstance(message, dict) or message.get("jsonrpc") != "2.0":
        raise wire.Refusal(wire.INVALID_REQUEST, "Expected one object of JSON-RPC 2.0 in each line.")
    return message


def serve(tools: Tools, source: IO[bytes], target: IO[bytes]) -> None:
    """Answers until the host closes its side."""
    conversation = Conversation(tools)
    while line := source.readline(LINE_BYTES + 1):
        # of a line that is too long only the begin is kept
        rest = line
        while rest and not rest.endswith(b"\n"):
            rest = source.readline(LINE_BYTES)
        answer = conversation.answer(line) if line.strip() else None
        if answer is not None:
            # escaped: half of a character pair cannot be written as UTF-8
            target.write(json.dumps(answer).encode() + b"\n")
            target.flush()
