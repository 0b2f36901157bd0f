"""Starts a server on this machine, for tests, notebooks and demonstrations."""

from __future__ import annotations

import os
import shutil
import subprocess
from types import TracebackType
from typing import IO, List, Optional, Sequence, Type, Union

from .client import Client
from .errors import ServerFailed

STOP_SECONDS = 10.0


class Server:
    """The program `espalier serve` on a free port of this machine. It ends with the `with` block, and with this program.

        with Server() as server, server.connect() as client:
            …

    >>> import os
    >>> with espalier.Server(os.environ.get("ESPALIER_PROGRAM", "espalier"), arguments=["--log-level", "off"]) as server:
    ...     with server.connect() as other:
    ...         other.status()["protocol"]
    1
    """

    def __init__(self, program: Union[str, "os.PathLike[str]"] = "espalier", *, arguments: Sequence[str] = (),
                 listen: str = "127.0.0.1:0", errors: Union[None, int, IO[bytes]] = None) -> None:
        """Starts the program and waits until it listens. `arguments` follow `serve --listen ADDRESS`; its log goes to
        `errors` (None: this program's standard error)."""
        found = shutil.which(os.fspath(program))
        if found is None:
            raise ServerFailed(f"There is no program '{os.fspath(program)}'. Install Espalier (docs/install.md) or build it with "
                               "'./dev build', and give the path of its program.")
        # a server whose standard input ends, because this program ended in whatever way, ends too
        command: List[str] = [found, "serve", "--listen", listen, "--until-input-ends", *arguments]
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors)
        except OSError as error:
            raise ServerFailed(f"'{found}' cannot be started ({error.strerror or error}).") from None
        self.address = self._wait_until_listening(found)

    def _wait_until_listening(self, program: str) -> str:
        assert self._process.stdout is not None
        while True:
            line = self._process.stdout.readline().decode("utf-8", "replace")
            if line.startswith("listening on "):
                return line[len("listening on "):].strip()
            if not line:
                status = self._process.wait()
                self._process.stdout.close()
                raise ServerFailed(f"'{program} serve' ended with status {status} before it listened. "
                                   "Its messages on standard error say why.")

    @property
    def process_id(self) -> int:
        return self._process.pid

    @property
    def is_running(self) -> bool:
        return self._process.poll() is None

    def connect(self, *, name: str = "python", token: Optional[str] = None, timeout: Optional[float] = None) -> Client:
        """A client of this server."""
        return Client(self.address, name=name, token=token, timeout=timeout)

    def stop(self) -> int:
        """Asks the server to end, waits for it and returns its exit status."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(STOP_SECONDS)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                stream.close()
        return self._process.returncode

    def __repr__(self) -> str:
        state = "running" if self.is_running else f"ended with status {self._process.returncode}"
        return f"<Server: {self.address}, {state}>"

    def __enter__(self) -> "Server":
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.stop()
