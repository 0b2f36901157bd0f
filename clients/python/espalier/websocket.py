"""Messages over the WebSocket of the HTTP side of a server (RFC 6455), for networks that allow only HTTP."""

from __future__ import annotations

import base64
import hashlib
import os
import socket
import struct
import time
from typing import Any, Generator, List, Optional, Tuple, Union

from .blocks import Blocks, pack, read_blocks
from .errors import ConnectionLost, ProtocolError
from .wire import (MAXIMUM_BLOCK_BYTES, MAXIMUM_LINE_BYTES, Channel, Message, Received, SocketChannel, decode,
                   encode, encrypted, lost, parse_address)

PATH = "/espalier/1"
_KEY = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_TEXT, _BINARY, _CLOSE, _PING, _PONG = 1, 2, 8, 9, 10


def _masked(data: bytes, mask: bytes) -> bytes:
    """Exclusive or with the mask over and over, as one big number: a loop in Python would take a second for 10 MB."""
    repeated = (mask * (len(data) // 4 + 1))[:len(data)]
    mixed = int.from_bytes(data, "little") ^ int.from_bytes(repeated, "little")
    return mixed.to_bytes(len(data), "little")


class Frames:
    """Frames of one WebSocket without the socket: the bytes to send, and the messages in received bytes.

    `message` is a generator so that a blocking and a waiting socket can both feed it: it yields how many bytes it needs
    and is sent them (None: the other side has ended), or yields bytes that are to be sent.
    """

    def __init__(self, peer: str) -> None:
        self.peer = peer

    def encoded(self, message: Message, blocks: Optional[Blocks]) -> bytes:
        """The frame of a message: a text, or binary with its arrays."""
        if not blocks:
            return self.frame(_TEXT, encode(message)[:-1])
        table, pieces, total = pack(blocks)
        text = encode({**message, "bin": table, "binBytes": total})[:-1]
        head = struct.pack("<I", len(text)) + text
        return self.frame(_BINARY, b"".join([head, bytes(-len(head) % 8), *(bytes(piece) for piece in pieces)]))

    def closing(self) -> bytes:
        return self.frame(_CLOSE, b"")

    def frame(self, kind: int, data: bytes) -> bytes:
        mask = os.urandom(4)
        size = len(data)
        head = bytes([0x80 | kind])
        if size < 126:
            head += bytes([0x80 | size])
        elif size < 65536:
            head += bytes([0x80 | 126]) + struct.pack(">H", size)
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", size)
        return head + mask + _masked(data, mask)

    def message(self, takes_blocks: bool) -> Generator[Union[int, bytes], Optional[bytes], Optional[Received]]:
        """The next message; None at the end."""
        kind, data = yield from self._whole()
        if kind == _CLOSE:
            return None
        if kind == _TEXT:
            return decode(data)
        if not takes_blocks or len(data) < 4:
            raise ConnectionLost(f"{self.peer} sent a binary frame that was not agreed on.")
        length = struct.unpack_from("<I", data)[0]
        message = decode(data[4:4 + length])
        begin = 4 + length + -(4 + length) % 8
        message.blocks = read_blocks(message.get("bin"), bytearray(data[begin:]))
        return message

    def _whole(self) -> Generator[Union[int, bytes], Optional[bytes], Tuple[int, bytes]]:
        """Kind and data of the next whole message; (close, nothing) at the end."""
        parts: List[bytes] = []
        kind = 0
        while True:
            head = yield 2
            if head is None:
                return _CLOSE, b""
            opcode = head[0] & 15
            size = head[1] & 127
            if size >= 126:
                more = yield (2 if size == 126 else 8)
                size = int.from_bytes(more or b"", "big")
            if size > MAXIMUM_LINE_BYTES + MAXIMUM_BLOCK_BYTES:
                raise ConnectionLost(f"{self.peer} sent a frame of {size} bytes.")
            data = yield size
            if data is None or opcode == _CLOSE:
                return _CLOSE, b""
            if opcode == _PING:
                yield self.frame(_PONG, data)
            elif opcode in (0, _TEXT, _BINARY):
                kind = opcode or kind
                parts.append(data)
                if head[0] & 128:
                    return kind, parts[0] if len(parts) == 1 else b"".join(parts)
            elif opcode != _PONG:
                raise ProtocolError(f"{self.peer} sent a frame of the unknown kind {opcode}.")


class Upgrade:
    """The HTTP request that turns a connection into a WebSocket, and the expected answer."""

    def __init__(self, address: str, peer: str) -> None:
        self._peer = peer
        self._key = base64.b64encode(os.urandom(16)).decode("ascii")
        self.request = (f"GET {PATH} HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                        f"Sec-WebSocket-Key: {self._key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode("ascii")

    def check(self, head: bytes) -> None:
        """Raises ConnectionLost when the head of the answer does not open a WebSocket."""
        accepted = base64.b64encode(hashlib.sha1((self._key + _KEY).encode("ascii")).digest())
        if b" 101 " not in head.split(b"\r\n", 1)[0] or accepted not in head:
            raise ConnectionLost(f"{self._peer} does not open a WebSocket: {head.split(chr(13).encode())[0]!r}.")


class WebSocketChannel(Channel):
    """A text frame for each message, a binary one when it has arrays."""

    def __init__(self, connection: socket.socket, peer: str) -> None:
        self._socket = connection
        self._frames = Frames(peer)
        self.peer = peer
        self._buffer = bytearray()

    @classmethod
    def open(cls, address: str, timeout: float, is_encrypted: bool) -> "WebSocketChannel":
        """Connects to HOST:PORT and asks for the upgrade."""
        host, port = parse_address(address)
        connection = (encrypted(address, timeout) if is_encrypted
                      else SocketChannel.connect(host, port, timeout).release())
        channel = cls(connection, f"{'wss' if is_encrypted else 'ws'}://{address}")
        upgrade = Upgrade(address, channel.peer)
        connection.sendall(upgrade.request)
        try:
            upgrade.check(channel._head(time.monotonic() + timeout))
        except ConnectionLost:
            channel.close()
            raise
        return channel

    def _head(self, deadline: float) -> bytes:
        while True:
            end = self._buffer.find(b"\r\n\r\n")
            if end >= 0:
                head = bytes(self._buffer[:end])
                del self._buffer[:end + 4]
                return head
            if not self._fill(deadline):
                raise ConnectionLost(f"{self.peer} closed the connection instead of opening a WebSocket.")

    def send(self, message: Message, blocks: Optional[Blocks] = None) -> None:
        self._send(self._frames.encoded(message, blocks))

    def receive(self, timeout: Optional[float] = None) -> Optional[Received]:
        deadline = None if timeout is None else time.monotonic() + timeout
        reading = self._frames.message(self.takes_blocks)
        wanted = next(reading)
        try:
            while True:
                if isinstance(wanted, bytes):
                    self._send(wanted)
                    wanted = next(reading)
                else:
                    wanted = reading.send(self._take(wanted, deadline))
        except StopIteration as end:
            found: Optional[Received] = end.value
            return found

    def close(self) -> None:
        try:
            self._send(self._frames.closing())
            self._socket.shutdown(socket.SHUT_RDWR)
        except (OSError, ConnectionLost):
            pass
        self._socket.close()

    def _send(self, frame: bytes) -> None:
        try:
            self._socket.settimeout(None)
            self._socket.sendall(frame)
        except OSError as error:
            raise lost(self.peer, error) from None

    def _take(self, count: int, deadline: Optional[float]) -> Optional[bytes]:
        while len(self._buffer) < count:
            if not self._fill(deadline):
                return None
        data = bytes(self._buffer[:count])
        del self._buffer[:count]
        return data

    def _fill(self, deadline: Optional[float]) -> bool:
        remaining = None if deadline is None else deadline - time.monotonic()
        if remaining is not None and remaining <= 0:
            raise TimeoutError
        try:
            self._socket.settimeout(remaining)
            piece: Any = self._socket.recv(1 << 18)
        except socket.timeout:
            raise TimeoutError from None
        except OSError:
            return False
        self._buffer += piece
        return bool(piece)
