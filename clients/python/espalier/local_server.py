"""A private server for notebooks and scripts. It starts on demand and ends with the program."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
import threading
import weakref
from typing import Any, Dict, List, Optional, Sequence, Tuple, Type, Union

from . import wire
from .client import Client
from .environment_process import EnvironmentProcess
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


def _remove(folder: str, owner: int) -> None:
    """A process that its program has forked ends too, and the folder is not its own."""
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)


class PrivateServer(Server):
    """A server on a socket that only this user can reach, with a token that only this program knows."""

    def __init__(self, program: str, arguments: Sequence[str]) -> None:
        """`arguments` follow `serve`; without --log-level only warnings are shown."""
        folder = private_folder()
        # also of a program that ends without stop()
        self._remove_folder = weakref.finalize(self, _remove, folder, os.getpid())
        try:
            self.token = secrets.token_hex(32)
            token_file = os.path.join(folder, "token")
            with open(os.open(token_file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:
                file.write(self.token + "\n")
            more = ["--token-file", token_file, *arguments]
            if "--log-level" not in more:
                more += ["--log-level", "warn"]
            super().__init__(program, arguments=more, listen="unix:" + os.path.join(folder, "socket"))
        except BaseException:
            self._remove_folder()
            raise

    def __enter__(self) -> "PrivateServer":
        return self

    def stop(self) -> int:
        status = super().stop()
        self._remove_folder()
        return status


def _is_defined_again(before: Any, now: Any) -> bool:
    """Both are classes with one name in one module."""
    return (isinstance(before, type) and isinstance(now, type)
            and (before.__module__, before.__qualname__) == (now.__module__, now.__qualname__))


class Local(Client):
    """A client together with the server that it started; both end with close() or the `with` block."""

    def __init__(self, program: Optional[str] = None, *, arguments: Sequence[str] = (),
                 timeout: Optional[float] = None) -> None:
        """Starts `espalier serve` on a socket that only this user can reach, with a token that only this program knows,
        and connects to it. The server may start commands and dial addresses, because its only client is this program.
        `program`: find_program() by default. `arguments` follow `serve`; without --gallery the server has the gallery of
        the program."""
        found = find_program() if program is None else program
        self._offers: List[wire.Channel] = []
        self._attached: List[Tuple[Any, str, wire.Channel]] = []  # what answers now, its name and its connection
        self._server = PrivateServer(found, ["--allow-spawn", "--allow-dial", "any", *arguments])
        self.token = self._server.token
        try:
            super().__init__(self._server.address, token=self.token, timeout=timeout)
        except BaseException:
            self._server.stop()
            raise

    def __enter__(self) -> "Local":
        return self

    @property
    def address(self) -> str:
        """Where the server listens, for other programs of this user. They need `token`."""
        return self._server.address

    def attach(self, environment: Union[Type[EnvironmentProcess], EnvironmentProcess],
               name: Optional[str] = None) -> Dict[str, str]:
        """Runs an environment of this program in a thread and returns its entry for `environment` of create(), which also
        takes the class itself. A class makes an object for every simulation; an object serves them all. The thread answers
        while the caller waits for a step. An exception in it is printed and fails the step.

        >>> class Ceiling(espalier.Environment):
        ...     def answer(self, query):
        ...         return [1 if query.position[1] < 3 else 0]
        >>> client.attach(Ceiling)
        {'type': 'offered', 'name': 'ceiling'}
        """
        chosen = environment.name() if name is None else name
        channel = open_offer(chosen, self.address, self.token)
        self._offers.append(channel)
        # the latest of a name is asked, as when a notebook's cell runs again
        self._attached = [known for known in self._attached if known[1] != chosen] + [(environment, chosen, channel)]

        def answer() -> None:
            try:
                answer_all(Host(environment), channel)
            except (EspalierError, OSError):
                pass  # the connection ends when this object is closed
            finally:
                self._attached = [known for known in self._attached if known[2] is not channel]
                # the server never waits for a thread that has ended
                channel.close()

        threading.Thread(target=answer, name=f"environment {chosen}", daemon=True).start()
        return {"type": "offered", "name": chosen}

    def _offer(self, environment: Union[Type[EnvironmentProcess], EnvironmentProcess]) -> Dict[str, str]:
        """The entry of an environment that create() was given. What answers already goes on. Two objects, or two classes
        from different places, get two names; a class that was defined again replaces the earlier one."""
        for known, name, _ in self._attached:
            if known is environment:
                return {"type": "offered", "name": name}
        taken = {name: known for known, name, _ in self._attached}
        chosen = environment.name()
        number = 2
        while chosen in taken and not _is_defined_again(taken[chosen], environment):
            chosen = f"{environment.name()}-{number}"
            number += 1
        return self.attach(environment, chosen)

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
            simulation = client.create(gallery="branch-tiers", environment="honda", seed=7)
            simulation.step(8)

    The server ends with the block, with close(), and with this program, however it ends.

    >>> with espalier.local() as other:
    ...     other.create(gallery="classic-algae").step(3).step
    3
    """
    return Local(program, arguments=arguments, timeout=timeout)
