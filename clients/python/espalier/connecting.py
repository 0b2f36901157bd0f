"""Connects to a server by its address, over any transport."""

from __future__ import annotations

import socket

from .errors import EspalierError
from .websocket import WebSocketChannel
from .wire import Channel, SocketChannel, encrypted, nothing_answers, parse_address


def connect(address: str, timeout: float) -> Channel:
    """A channel to a server: HOST:PORT (or tcp://…), tls://HOST:PORT, unix:PATH, or ws://HOST:PORT and wss://HOST:PORT of
    its HTTP side. This machine must trust the certificate of tls and wss; SSL_CERT_FILE names another certificate."""
    if address.startswith("unix:"):
        path = address[len("unix:"):]
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connection.connect(path)
        except OSError as error:
            connection.close()
            raise nothing_answers(address, error) from None
        return SocketChannel(connection, address)
    scheme, separator, rest = address.partition("://")
    if separator and scheme in ("ws", "wss"):
        return WebSocketChannel.open(rest.rstrip("/"), timeout, scheme == "wss")
    if separator and scheme == "tls":
        return SocketChannel(encrypted(rest, timeout), address)
    return SocketChannel.connect(*parse_address(address), timeout)


def token_in(file: str) -> str:
    """The token in the first line of a file."""
    try:
        with open(file, encoding="utf-8") as opened:
            token = opened.readline().strip()
    except (OSError, UnicodeError):
        token = ""
    if not token:
        raise EspalierError(f"The token file '{file}' cannot be read, or its first line is empty. "
                            "`espalier token new NAME -o FILE` makes one.")
    return token
