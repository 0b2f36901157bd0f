"""Messages as lines: one UTF-8 JSON object per line, JSON-RPC 2.0 inside; behind it raw numbers when both sides agreed.

Numbers must be finite. Python prints a double with the fewest digits that read back as the same double, as the
protocol requires. A value therefore keeps all its bits.
"""

from __future__ import annotations

import errno
import json
import socket
import ssl
import time
from typing import Any, BinaryIO, Dict, List, Mapping, Optional, Sequence

from .blocks import Blocks, pack, read_blocks
from .errors import ConnectionLost, ProtocolError

Message = Dict[str, Any]


class Received(Dict[str, Any]):
    """A received message with its arrays by name."""

    blocks: Blocks = {}

# numbers of JSON-RPC 2.0
PARSE_ERROR = -32700
INVALID_REQUEST = -32600
METHOD_NOT_FOUND = -32601
INVALID_PARAMETERS = -32602
INTERNAL_ERROR = -32603

MAXIMUM_LINE_BYTES = 256_000_000
MAXIMUM_BLOCK_BYTES = 1_000_000_000

# sent in the hello of this side
CAPABILITIES = ("bin", "strict")
LIMITS = {"lineBytes": MAXIMUM_LINE_BYTES, "blockBytes": MAXIMUM_BLOCK_BYTES}


def _refuse_constant(name: str) -> Any:
    raise ValueError(f"{name} is not a finite number")


def encode(message: Message) -> bytes:
    """The line of a message, with its newline. A number that is not finite raises ProtocolError."""
    try:
        text = json.dumps(message, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    except ValueError as error:
        raise ProtocolError(f"A message holds a number that is not finite, which cannot be sent ({error}).") from None
    except TypeError as error:
        raise ProtocolError(f"A message holds a value that JSON does not have: {error}.") from None
    # half of a character pair has no UTF-8, but an escape that JSON knows
    return text.encode("utf-8", "backslashreplace") + b"\n"


def decode(line: bytes) -> Received:
    """The message of a line. Anything but one JSON object with finite numbers raises ProtocolError."""
    try:
        message = json.loads(line.decode("utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:  # the latter: a thousand lists, one in the other
        start = line[:60].decode("utf-8", "replace").strip()
        raise ProtocolError(f"Expected a JSON object on a line, found '{start}' ({error}).") from None
    if not isinstance(message, dict):
        raise ProtocolError(f"Expected a JSON object on a line, found a {type(message).__name__}.")
    return Received(message)


def request(identifier: Any, method: str, parameters: Optional[Message] = None) -> Message:
    return {"jsonrpc": "2.0", "id": identifier, "method": method, "params": parameters or {}}


def notification(method: str, parameters: Message) -> Message:
    return {"jsonrpc": "2.0", "method": method, "params": parameters}


def result(identifier: Any, value: Any) -> Message:
    return {"jsonrpc": "2.0", "id": identifier, "result": value}


def failure(identifier: Any, code: int, message: str, data: Any = None) -> Message:
    error: Message = {"code": code, "message": message}
    if data is not None:
        error["data"] = data
    return {"jsonrpc": "2.0", "id": identifier, "error": error}


class Refusal(Exception):
    """A request that is answered with an error."""

    def __init__(self, code: int, message: str, data: Any = None) -> None:
        super().__init__(message)
        self.code = code
        self.data = data


def parse_address(address: str) -> "tuple[str, int]":
    """HOST:PORT, or PORT alone for the local machine; `tcp://` in front is allowed."""
    text = address[len("tcp://"):] if address.startswith("tcp://") else address
    host, _, port = text.rpartition(":")
    if not port.isdigit() or int(port) > 65535:
        raise ProtocolError(f"'{address}' is not an address. Expected HOST:PORT, as in 127.0.0.1:4321.")
    return host.strip("[]") or "127.0.0.1", int(port)


def nothing_answers(address: str, error: OSError) -> ConnectionLost:
    return ConnectionLost(f"Nothing answers at {address} ({error.strerror or error}). "
                          f"Start a server there with 'espalier serve --listen {address}'.")


def lost(peer: str, error: OSError) -> ConnectionLost:
    if error.errno == errno.EBADF:
        return ConnectionLost(f"The connection to {peer} is closed on this side: close() was called. Make another client.")
    return ConnectionLost(f"The connection to {peer} is lost ({error.strerror or error}).")


def pieces_of(message: Message, blocks: Optional[Blocks]) -> List[Any]:
    """The bytes-like pieces of a message on a line, with the arrays behind it when there are some."""
    if not blocks:
        return [encode(message)]
    table, pieces, total = pack(blocks)
    return [encode({**message, "bin": table, "binBytes": total}), *pieces]


def announced_bytes(message: Message, takes_blocks: bool, peer: str) -> Optional[int]:
    """How many bytes of arrays follow a message; None: it has no arrays."""
    total = message.get("binBytes")
    if total is None:
        return None
    if not takes_blocks:
        raise ConnectionLost(f"{peer} sent binary blocks that were not agreed on.")
    if isinstance(total, bool) or not isinstance(total, int) or not 0 <= total <= MAXIMUM_BLOCK_BYTES:
        raise ConnectionLost(f"{peer} sent binBytes {total!r}; expected at most {MAXIMUM_BLOCK_BYTES}.")
    return total


def has_blocks(hello: Mapping[str, Any]) -> bool:
    """Whether the other side named the capability `bin` in its hello, or in its answer to it."""
    if not isinstance(hello, dict):
        raise ProtocolError(f"Expected an object as the answer to hello, found a {type(hello).__name__}.")
    capabilities = hello.get("capabilities")
    return isinstance(capabilities, list) and "bin" in capabilities


def encrypted(address: str, timeout: float) -> socket.socket:
    """A TLS connection to HOST:PORT."""
    host, port = parse_address(address)
    channel = SocketChannel.connect(host, port, timeout)
    try:
        return ssl.create_default_context().wrap_socket(channel.release(), server_hostname=host)
    except (ssl.SSLError, OSError) as error:
        raise ConnectionLost(f"{address} does not accept an encrypted connection ({error}).") from None


class Channel:
    """A two-way stream of messages."""

    peer = "the other side"
    # both sides named the capability `bin` in their hello
    takes_blocks = False

    def agree(self, hello: Mapping[str, Any]) -> None:
        """Reads the capabilities in the hello of the other side, or in its answer."""
        self.takes_blocks = has_blocks(hello)

    def send(self, message: Message, blocks: Optional[Blocks] = None) -> None:
        """Sends a message, and arrays behind it when there are some (only when they were agreed on)."""
        self._write(pieces_of(message, blocks))

    def receive(self, timeout: Optional[float] = None) -> Optional[Received]:
        """The next message; None when the other side has ended. Raises TimeoutError after `timeout` seconds."""
        deadline = None if timeout is None else time.monotonic() + timeout
        line = self._read_line(deadline)
        if line is None:
            return None
        message = decode(line)
        total = announced_bytes(message, self.takes_blocks, self.peer)
        if total is None:
            return message
        raw = self._read_bytes(total, deadline)
        if raw is None:
            return None
        message.blocks = read_blocks(message.get("bin"), raw)
        return message

    def close(self) -> None:
        raise NotImplementedError

    def _write(self, pieces: Sequence[Any]) -> None:
        """Sends bytes-like pieces one after the other."""
        raise NotImplementedError

    def _read_line(self, deadline: Optional[float]) -> Optional[bytes]:
        """The next line; None at the end of the stream."""
        raise NotImplementedError

    def _read_bytes(self, count: int, deadline: Optional[float]) -> Optional[bytearray]:
        """The bytes behind the last line; None when the stream ends before."""
        raise NotImplementedError


class SocketChannel(Channel):
    """Messages over a connected socket."""

    def __init__(self, connection: socket.socket, peer: str) -> None:
        self._socket = connection
        self._buffer = bytearray()
        self._searched = 0  # bytes of the buffer known to hold no newline
        self.peer = peer

    @classmethod
    def connect(cls, host: str, port: int, timeout: float) -> "SocketChannel":
        peer = f"{host}:{port}"
        try:
            connection = socket.create_connection((host, port), timeout)
        except OSError as error:
            raise nothing_answers(peer, error) from None
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return cls(connection, peer)

    def release(self) -> socket.socket:
        """The socket, for another channel."""
        return self._socket

    def _write(self, pieces: Sequence[Any]) -> None:
        try:
            self._socket.settimeout(None)
            for piece in pieces:
                self._socket.sendall(piece)
        except OSError as error:
            raise lost(self.peer, error) from None

    def _read_line(self, deadline: Optional[float]) -> Optional[bytes]:
        while True:
            end = self._buffer.find(b"\n", self._searched)
            if end >= 0:
                line = bytes(self._buffer[:end])
                del self._buffer[: end + 1]
                self._searched = 0
                return line
            self._searched = len(self._buffer)
            if self._searched > MAXIMUM_LINE_BYTES:
                raise ConnectionLost(f"{self.peer} sent a line of more than {MAXIMUM_LINE_BYTES} bytes.")
            if not self._fill(deadline):
                return None

    def _read_bytes(self, count: int, deadline: Optional[float]) -> Optional[bytearray]:
        # straight into the memory that the arrays will look at
        raw = bytearray(count)
        view = memoryview(raw)
        filled = min(count, len(self._buffer))
        view[:filled] = self._buffer[:filled]
        del self._buffer[:filled]
        while filled < count:
            got = self._read_into(view[filled:], deadline)
            if got == 0:
                return None
            filled += got
        return raw

    def _read_into(self, view: memoryview, deadline: Optional[float]) -> int:
        self._set_timeout(deadline)
        try:
            return self._socket.recv_into(view)
        except socket.timeout:
            raise TimeoutError from None
        except ConnectionError:
            return 0
        except OSError as error:
            raise lost(self.peer, error) from None

    def _set_timeout(self, deadline: Optional[float]) -> None:
        remaining = None if deadline is None else deadline - time.monotonic()
        if remaining is not None and remaining <= 0:
            raise TimeoutError
        self._socket.settimeout(remaining)

    def _fill(self, deadline: Optional[float]) -> bool:
        """Reads some bytes into the buffer; False at the end of the stream."""
        self._set_timeout(deadline)
        try:
            piece = self._socket.recv(1 << 18)
        except socket.timeout:
            raise TimeoutError from None
        except ConnectionError:
            return False
        except OSError as error:
            raise lost(self.peer, error) from None
        self._buffer += piece
        return bool(piece)

    def close(self) -> None:
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._socket.close()


class PipeChannel(Channel):
    """Messages over a pair of byte streams: standard input and output of a spawned environment."""

    def __init__(self, reader: BinaryIO, writer: BinaryIO, peer: str) -> None:
        self._reader = reader
        self._writer = writer
        self.peer = peer

    def _write(self, pieces: Sequence[Any]) -> None:
        try:
            for piece in pieces:
                self._writer.write(piece)
            self._writer.flush()
        except (OSError, ValueError) as error:
            raise ConnectionLost(f"The pipe to {self.peer} is closed ({error}).") from None

    def _read_line(self, deadline: Optional[float]) -> Optional[bytes]:
        line = self._reader.readline(MAXIMUM_LINE_BYTES + 1)
        if not line:
            return None
        if not line.endswith(b"\n"):
            if len(line) > MAXIMUM_LINE_BYTES:
                raise ConnectionLost(f"{self.peer} sent a line of more than {MAXIMUM_LINE_BYTES} bytes.")
            return None
        return line

    def _read_bytes(self, count: int, deadline: Optional[float]) -> Optional[bytearray]:
        raw = bytearray(self._reader.read(count))
        return raw if len(raw) == count else None

    def close(self) -> None:
        for stream in (self._reader, self._writer):
            try:
                stream.close()
            except OSError:
                pass
