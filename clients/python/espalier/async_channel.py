"""Messages over the streams of asyncio: lines, or the frames of a WebSocket. wire.py has the same for sockets that wait."""

from __future__ import annotations

import asyncio
import ssl
from typing import Any, Mapping, Optional

from .blocks import read_blocks
from .errors import ConnectionLost
from .websocket import Frames, Upgrade
from .wire import (MAXIMUM_LINE_BYTES, Message, Received, announced_bytes, decode, has_blocks, lost, nothing_answers,
                   parse_address, pieces_of)


class AsyncChannel:
    """A two-way stream of messages: one a line, raw arrays behind it."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, peer: str) -> None:
        self._reader = reader
        self._writer = writer
        self.peer = peer
        # both sides named the capability `bin` in their hello
        self.takes_blocks = False

    def agree(self, hello: Mapping[str, Any]) -> None:
        """Reads the capabilities in the answer to hello."""
        self.takes_blocks = has_blocks(hello)

    async def send(self, message: Message) -> None:
        """Sends a message; waits while the other side does not read."""
        self.post(message)
        try:
            await self._writer.drain()
        except OSError as error:
            raise lost(self.peer, error) from None

    def post(self, message: Message) -> None:
        """Hands over a small message without waiting until it is sent."""
        for piece in pieces_of(message, None):
            self._writer.write(piece)

    async def receive(self) -> Optional[Received]:
        """The next message; None when the other side has ended."""
        try:
            line = await self._reader.readuntil(b"\n")
            message = decode(line)
            total = announced_bytes(message, self.takes_blocks, self.peer)
            if total is not None:
                message.blocks = read_blocks(message.get("bin"), bytearray(await self._reader.readexactly(total)))
            return message
        except asyncio.LimitOverrunError:
            raise ConnectionLost(f"{self.peer} sent a line of more than {MAXIMUM_LINE_BYTES} bytes.") from None
        except (asyncio.IncompleteReadError, ConnectionError):
            return None
        except OSError as error:
            raise lost(self.peer, error) from None

    async def close(self) -> None:
        """Ends the connection."""
        self._writer.close()
        try:
            await self._writer.wait_closed()
        except (OSError, asyncio.CancelledError):
            pass


class AsyncWebSocketChannel(AsyncChannel):
    """The same over a WebSocket."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, peer: str) -> None:
        super().__init__(reader, writer, peer)
        self._frames = Frames(peer)

    async def open(self, address: str) -> None:
        """Asks for the upgrade."""
        upgrade = Upgrade(address, self.peer)
        self._writer.write(upgrade.request)
        try:
            upgrade.check(await self._reader.readuntil(b"\r\n\r\n"))
        except (asyncio.IncompleteReadError, ConnectionError):
            raise ConnectionLost(f"{self.peer} closed the connection instead of opening a WebSocket.") from None

    def post(self, message: Message) -> None:
        self._writer.write(self._frames.encoded(message, None))

    async def receive(self) -> Optional[Received]:
        reading = self._frames.message(self.takes_blocks)
        wanted = next(reading)
        try:
            while True:
                if isinstance(wanted, bytes):
                    self._writer.write(wanted)
                    wanted = next(reading)
                else:
                    wanted = reading.send(await self._take(wanted))
        except StopIteration as end:
            found: Optional[Received] = end.value
            return found

    async def _take(self, count: int) -> Optional[bytes]:
        try:
            return await self._reader.readexactly(count)
        except (asyncio.IncompleteReadError, ConnectionError):
            return None

    async def close(self) -> None:
        self._writer.write(self._frames.closing())
        await super().close()


async def connect(address: str) -> AsyncChannel:
    """A channel to a server: HOST:PORT (or tcp://…), tls://HOST:PORT, unix:PATH, ws://HOST:PORT or wss://HOST:PORT."""
    try:
        if address.startswith("unix:"):
            path = address[len("unix:"):]
            return AsyncChannel(*await asyncio.open_unix_connection(path, limit=MAXIMUM_LINE_BYTES), address)
        scheme, separator, rest = address.partition("://")
        rest = rest.rstrip("/") if separator else address
        host, port = parse_address(rest)
        encryption = ssl.create_default_context() if scheme in ("tls", "wss") else None
        reader, writer = await asyncio.open_connection(host, port, ssl=encryption, limit=MAXIMUM_LINE_BYTES)
    except ssl.SSLError as error:
        raise ConnectionLost(f"{address} cannot be spoken to encrypted ({error}).") from None
    except OSError as error:
        raise nothing_answers(address, error) from None
    if not separator or scheme not in ("ws", "wss"):
        return AsyncChannel(reader, writer, f"{host}:{port}")
    channel = AsyncWebSocketChannel(reader, writer, address)
    try:
        await channel.open(rest)
    except BaseException:
        await channel.close()
        raise
    return channel
