"""A private server for notebooks and scripts. It starts on demand and ends with the program."""

from __future__ import annotations

import threading
from typing import Dict, List, Optional, Sequence, Type

from . import wire
from .client import Client
from .environment import Environment
from .errors import EspalierError
from .hosting import Host, answer_all, open_offer
from .program import find_program
from .server import Server

class Local(Client):
    """A client together with the server that it started; both end with close() or the `with` block."""

    def __init__(self, program: Optional[str] = None, *, arguments: Sequence[str] = (),
                 timeout: Optional[float] = None) -> None:
        """Starts `espalier serve` on a free port of this machine and connects to it. `program`: find_program() by
        default. `arguments` follow `serve`; without --gallery the server has the gallery of the program."""
        found = find_program() if program is None else program
        more: List[str] = list(arguments)
        if "--log-level" not in more:
            more += ["--log-level", "warn"]
        self._server = Server(found, arguments=more)
        self._offers: List[wire.Channel] = []
        try:
            super().__init__(self._server.address, timeout=timeout)
        except BaseException:
            self._server.stop()
            raise

    def __enter__(self) -> "Local":
        return self

    @property
    def address(self) -> str:
        """Where the server listens, for other programs."""
        return self._server.address

    def attach(self, environment: Type[Environment], name: Optional[str] = None) -> Dict[str, str]:
        """Runs an environment of this program in a thread and returns its entry for `environment=[…]` of create. The thread
        answers while the caller waits for a step. An exception in it is printed and fails the step."""
        chosen = environment.name() if name is None else name
        channel = open_offer(chosen, self.address)
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
        self._server.stop()


def local(program: Optional[str] = None, *, arguments: Sequence[str] = (), timeout: Optional[float] = None) -> Local:
    """A server on this machine and a client of it, without a terminal:

        import espalier

        with espalier.local() as client:
            simulation = client.create(gallery="branch-tiers", seed=7)
            simulation.step(8)
    """
    return Local(program, arguments=arguments, timeout=timeout)
