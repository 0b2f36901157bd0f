"""A private server for notebooks and scripts. It starts on demand and ends with the program."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
import threading
from typing import Dict, List, Optional, Sequence, Type

from . import wire
from .client import Client
from .environment import Environment
from .errors import EspalierError
from .hosting import Host, answer_all, open_offer
from .program import find_program
from .server import Server

LONGEST_SOCKET_PATH = 100  # bytes; the system's bound is a little more


def private_folder() -> str:
    """A new folder that only this user can enter, with a path short enough for a socket in it."""
    folder = tempfile.mkdtemp(prefix="espalier-")
    if len(os.fsencode(folder)) + len("/socket") <= LONGEST_SOCKET_PATH:
        return folder
    os.rmdir(folder)
    return tempfile.mkdtemp(prefix="espalier-", dir="/tmp")


class Local(Client):
    """A client together with the server that it started; both end with close() or the `with` block."""

    def __init__(self, program: Optional[str] = None, *, arguments: Sequence[str] = (),
                 timeout: Optional[float] = None) -> None:
        """Starts `espalier serve` on a socket that only this user can reach, with a token that only this program knows,
        and connects to it. The server may start commands and dial addresses, because its only client is this program.
        `program`: find_program() by default. `arguments` follow `serve`; without --gallery the server has the gallery of
        the program."""
        found = find_program() if program is None else program
        self._folder = private_folder()
        self._offers: List[wire.Channel] = []
        try:
            self.token = secrets.token_hex(32)
            token_file = os.path.join(self._folder, "token")
            with open(os.open(token_file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:
                file.write(self.token + "\n")
            more: List[str] = ["--token-file", token_file, "--allow-spawn", "--allow-dial", "any", *arguments]
            if "--log-level" not in more:
                more += ["--log-level", "warn"]
            self._server = Server(found, arguments=more, listen="unix:" + os.path.join(self._folder, "socket"))
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        try:
            super().__init__(self._server.address, token=self.token, timeout=timeout)
        except BaseException:
            self._stop()
            raise

    def __enter__(self) -> "Local":
        return self

    @property
    def address(self) -> str:
        """Where the server listens, for other programs of this user. They need `token`."""
        return self._server.address

    def attach(self, environment: Type[Environment], name: Optional[str] = None) -> Dict[str, str]:
        """Runs an environment of this program in a thread and returns its entry for `environment=[…]` of create. The thread
        answers while the caller waits for a step. An exception in it is printed and fails the step."""
        chosen = environment.name() if name is None else name
        channel = open_offer(chosen, self.address, self.token)
        self._offers.append(channel)

        def answer() -> None:
            try:
                answer_all(Host(environment), channel)
            except (EspalierError, OSError):
                pass  # the connection ends when this object is closed
            finally:
                # the server never waits for a thread that has ended
                channel.close()

        threading.Thread(target=answer, name=f"environment {chosen}", daemon=True).start()
        return {"type": "offered", "name": chosen}

    def close(self) -> None:
        """Ends the connection, the attached environments and the server."""
        super().close()
        for channel in self._offers:
            channel.close()
        self._offers.clear()
        self._stop()

    def _stop(self) -> None:
        self._server.stop()
        shutil.rmtree(self._folder, ignore_errors=True)


def local(program: Optional[str] = None, *, arguments: Sequence[str] = (), timeout: Optional[float] = None) -> Local:
    """A server on this machine and a client of it, without a terminal:

        import espalier

        with espalier.local() as client:
            simulation = client.create(gallery="branch-tiers", seed=7)
            simulation.step(8)
    """
    return Local(program, arguments=arguments, timeout=timeout)
