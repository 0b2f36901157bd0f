"""The Streamable HTTP transport of the Model Context Protocol (2025-06-18): each POST to /mcp has one message and one answer in JSON. There
are no streams of the server's own. A session holds its simulations until DELETE, or until others need its place.
"""

from __future__ import annotations

import hmac
import io
import json
import secrets
import socket
import threading
import time
from collections import OrderedDict
from contextlib import ExitStack
from http.client import HTTPException
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Callable, Dict, Optional, Tuple
from urllib.parse import urlsplit

from .. import wire
from ..errors import EspalierError
from ..listening import Admission, accepted, is_loopback
from . import LINE_BYTES, VERSIONS, Conversation
from .tools import Tools

PATH = "/mcp"
SESSIONS = 8
HEAD_SECONDS = 10.0  # for the whole head of a first request
IDLE_SECONDS = 60.0  # for the whole head of a later request, for a message, and for reading an answer
HEAD_BYTES = 131_072
READ_BYTES = 65_536  # at a time
LOOPBACK = ("127.0.0.1", "::1", "localhost")


class Session:
    """The conversation of one host. One message at a time."""

    def __init__(self, open_tools: Callable[[ExitStack], Tools]) -> None:
        self._lock = threading.Lock()
        self._stack = ExitStack()
        tools = open_tools(self._stack)
        self._stack.callback(tools.close)
        self._conversation = Conversation(tools)

    def answer(self, message: bytes) -> Optional[Dict[str, Any]]:
        with self._lock:
            return self._conversation.answer(message)

    def close(self) -> None:
        with self._lock:
            self._stack.close()


class HttpServer(ThreadingHTTPServer):
    """Listens on `address`. `open_tools` makes the tools of a session and puts what they need on a stack. With a token each request needs it."""

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, address: Tuple[str, int], open_tools: Callable[[ExitStack], Tools], token: Optional[str] = None) -> None:
        self.address_family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self.token = token
        self._open_tools = open_tools
        self._sessions: "OrderedDict[str, Session]" = OrderedDict()  # the one used last at the end
        self._lock = threading.Lock()
        self.admission = Admission()
        super().__init__(address, Handler)

    def get_request(self) -> Tuple[Any, Any]:
        return accepted(self.socket, self.admission)

    def process_request(self, request: Any, client_address: Any) -> None:
        self.admission.enter(request, "" if is_loopback(client_address[0]) else client_address[0])
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        # before its descriptor may be another connection's
        self.admission.leave(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A host that leaves, or sends nothing for long, ends its connection."""

    def open_session(self) -> Tuple[str, Session]:
        identifier, session, left = secrets.token_hex(16), Session(self._open_tools), None
        with self._lock:
            if len(self._sessions) >= SESSIONS:
                _, left = self._sessions.popitem(last=False)
            self._sessions[identifier] = session
        if left is not None:
            left.close()
        return identifier, session

    def session(self, identifier: str) -> Optional[Session]:
        with self._lock:
            if identifier in self._sessions:
                self._sessions.move_to_end(identifier)
            return self._sessions.get(identifier)

    def end_session(self, identifier: str) -> bool:
        with self._lock:
            session = self._sessions.pop(identifier, None)
        if session is not None:
            session.close()
        return session is not None

    def server_close(self) -> None:
        super().server_close()
        for identifier in list(self._sessions):
            self.end_session(identifier)


class Incoming(io.RawIOBase):
    """The input from a peer, up to a moment and a number of bytes: a peer that sends byte after byte ends at them, too."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self.allow(HEAD_SECONDS, HEAD_BYTES)

    def allow(self, seconds: float, byte_count: int) -> None:
        self._end, self._left = time.monotonic() + seconds, byte_count

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        seconds = self._end - time.monotonic()
        if seconds <= 0.0:
            raise socket.timeout("the request is not complete")
        if self._left <= 0:
            raise HTTPException("the request is too long")
        self._connection.settimeout(seconds)
        count = self._connection.recv_into(buffer)
        self._left -= count
        return count


class Handler(BaseHTTPRequestHandler):
    server: HttpServer
    protocol_version = "HTTP/1.1"

    def setup(self) -> None:
        super().setup()
        self._incoming = Incoming(self.connection)
        self._seconds = HEAD_SECONDS
        self.rfile = io.BufferedReader(self._incoming, READ_BYTES)

    def handle_one_request(self) -> None:
        self._incoming.allow(self._seconds, HEAD_BYTES)
        try:
            super().handle_one_request()
        finally:
            self.server.admission.end(self.connection)

    def version_string(self) -> str:
        return "espalier"

    def log_message(self, format: str, *arguments: Any) -> None:
        pass

    def do_POST(self) -> None:
        if not self._is_allowed():
            return
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit()):
            self._refuse(411, "Say how long the message is: Content-Length.")
        elif len(length) > 9 or int(length) > LINE_BYTES:
            self._refuse(413, f"A message has {LINE_BYTES} bytes at most.")
        elif self.headers.get_content_type() != "application/json":
            self._refuse(415, "Send one message of JSON-RPC with Content-Type: application/json.")
        else:
            self._incoming.allow(IDLE_SECONDS, int(length) + READ_BYTES)
            body = self.rfile.read(int(length))
            # a message that comes slowly may lose its place until here
            if len(body) == int(length) and self.server.admission.begin(self.connection):
                self._answer(body)
            else:
                self.close_connection = True

    def _answer(self, body: bytes) -> None:
        named = self.headers.get("Mcp-Session-Id")
        if named is None and not is_initialize(body):
            self._refuse(400, "Send initialize first, with an object as its params, and then the Mcp-Session-Id of its answer with every request.", is_kept=True)
            return
        try:
            identifier, session = (named, self.server.session(named)) if named is not None else self.server.open_session()
            if session is None:
                self._refuse(404, "The session has ended. Send initialize again.", is_kept=True)
                return
            answer = session.answer(body)
        except (EspalierError, OSError):
            self._refuse(503, "The server of the plants does not answer. Start it again, or python3 -m espalier.mcp when it has its own.")
            return
        # escaped: half of a character pair cannot be written as UTF-8
        self._send(202 if answer is None else 200, b"" if answer is None else json.dumps(answer).encode(),
                   {"Mcp-Session-Id": identifier} if named is None else {})

    def do_DELETE(self) -> None:
        if self._is_allowed():
            if self.server.end_session(self.headers.get("Mcp-Session-Id", "")):
                self._send(204, b"")
            else:
                self._refuse(404, "There is no session of that Mcp-Session-Id.")

    def do_GET(self) -> None:
        if self._is_allowed():
            self._refuse(405, "This server begins no streams. POST one message.", {"Allow": "POST, DELETE"})

    do_PUT = do_HEAD = do_PATCH = do_OPTIONS = do_GET

    def _is_allowed(self) -> bool:
        """Whether the request may come from where it comes. Otherwise it is answered."""
        origin, version = self.headers.get("Origin"), self.headers.get("MCP-Protocol-Version")
        if self.path.split("?")[0] != PATH:
            self._refuse(404, f"The Model Context Protocol is at {PATH}.")
        elif origin is not None and not is_of_this_machine(origin):
            # a page elsewhere may have led a browser here (DNS rebinding)
            self._refuse(403, "Pages of other machines may not connect.")
        elif self.server.token is not None and not hmac.compare_digest(
                self.headers.get("Authorization", "").encode("latin-1"), f"Bearer {self.server.token}".encode()):
            self._refuse(401, "This server needs its token: Authorization: Bearer TOKEN.", {"WWW-Authenticate": "Bearer"})
        elif version is not None and version not in VERSIONS:
            self._refuse(400, f"MCP-Protocol-Version must be one of {', '.join(VERSIONS)}.")
        elif not self.server.admission.trust(self.connection):
            self._refuse(503, "All connections of this server are being answered. Ask again.")
        else:
            self._seconds = IDLE_SECONDS
            return True
        return False

    def _refuse(self, status: int, message: str, headers: Optional[Dict[str, str]] = None, *, is_kept: bool = False) -> None:
        """Answers with an error. Unless the body has been read, nothing more can be read from the connection."""
        self.close_connection = self.close_connection or not is_kept
        answer = wire.failure(None, wire.INVALID_REQUEST, message)
        self._send(status, json.dumps(answer).encode(), headers or {})

    def _send(self, status: int, body: bytes, headers: Optional[Dict[str, str]] = None) -> None:
        self.connection.settimeout(IDLE_SECONDS)
        self.send_response(status)
        sent = {**(headers or {}), **({"Connection": "close"} if self.close_connection else {}),
                **({"Content-Type": "application/json"} if body else {}), **({} if status == 204 else {"Content-Length": str(len(body))})}
        for name, value in sent.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)


def is_initialize(body: bytes) -> bool:
    try:
        message = json.loads(body)
    except (ValueError, RecursionError):
        return False
    return (isinstance(message, dict) and message.get("method") == "initialize" and "id" in message
            and isinstance(message.get("params", {}), dict))


def is_of_this_machine(origin: str) -> bool:
    try:
        return urlsplit(origin).hostname in LOOPBACK
    except ValueError:
        return False


def serve_http(place: str, open_tools: Callable[[ExitStack], Tools], token: Optional[str]) -> None:
    """Answers hosts over HTTP until it is interrupted."""
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
