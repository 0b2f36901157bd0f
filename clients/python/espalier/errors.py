"""The exceptions of the package."""

from __future__ import annotations

import warnings
from typing import Any, Dict, List, Mapping, Optional, Sequence


class EspalierError(Exception):
    """Base of all errors of this package. The message is a whole sentence.

    >>> try:
    ...     client.create("no-such-model.l")
    ... except espalier.EspalierError as error:
    ...     print(str(error)[:50])
    There is no model file or folder 'no-such-model.l'
    """


class ModelWarning(UserWarning):
    """A warning about a model, shown when a simulation of it is created: its place, what is wrong and what to do.

    >>> import warnings
    >>> with warnings.catch_warnings(record=True) as seen:
    ...     warnings.simplefilter("always")
    ...     plant = client.create("Lsystem: 1\\nAxiom: A\\nA --> A(y)\\nendlsystem\\n")
    >>> print(str(seen[0].message).splitlines()[0])
    model.l:3:9: warning: unknown name 'y' in the successor of A: its value is 0
    """


class ConnectionLost(EspalierError):
    """The other side cannot be reached, ended the connection, or did not answer in time.

    >>> try:
    ...     espalier.Client("127.0.0.1:1")
    ... except espalier.ConnectionLost as error:
    ...     print(str(error)[:30])
    Nothing answers at 127.0.0.1:1
    """


class ProtocolError(EspalierError):
    """The other side sent something that is not a message of the protocol.

    >>> try:
    ...     espalier.Client("nowhere")
    ... except espalier.ProtocolError as error:
    ...     print(error)
    'nowhere' is not an address. Expected HOST:PORT, as in 127.0.0.1:4321.
    """


class ServerFailed(EspalierError):
    """The program `espalier` could not be started or ended early.

    >>> try:
    ...     espalier.local("no-such-program")
    ... except espalier.ServerFailed as error:
    ...     print(str(error)[:38])
    There is no program 'no-such-program'.
    """


class RunWarning(UserWarning):
    """A run of a model has a warning, has failed, or has no value of a measure. `warnings.filterwarnings("ignore",
    category=espalier.RunWarning)` hides them.

    >>> import warnings
    >>> with warnings.catch_warnings(record=True) as caught, espalier.Model(
    ...         "borchert-honda", steps=2, measures={"m": {"mean": "b", "of": "I(b,m,v,c)", "where": "b < 0"}}) as model:
    ...     warnings.simplefilter("always")
    ...     value = model([])
    >>> str(caught[0].message)[:30]
    "The measure 'm' has no value i"
    """


class ServerError(EspalierError):
    """The server refused a request.

    `code` is the error code of the protocol, `data` its further information (or None).

    >>> try:
    ...     client.simulation("sim-unknown")
    ... except espalier.ServerError as error:
    ...     print(error.code)
    1011
    """

    def __init__(self, code: int, message: str, data: Any = None) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.data = data

    def _member(self, name: str) -> Any:
        return self.data.get(name) if isinstance(self.data, dict) else None

    @property
    def is_retryable(self) -> bool:
        """The same request may succeed later (an environment that is away may come back)."""
        return self._member("retryable") is True

    @property
    def diagnostics(self) -> List[Dict[str, Any]]:
        """The errors of the model, if the model is the reason."""
        found = self._member("diagnostics")
        return [item for item in found if isinstance(item, dict)] if isinstance(found, list) else []

    @property
    def step(self) -> Optional[int]:
        """The step that failed, when one did."""
        found = self._member("step")
        return found if isinstance(found, int) else None

    @property
    def printed(self) -> str:
        """What the model has printed (`printf`) since the last answer, before a step failed."""
        return str(self._member("printed") or "")


def warn_of_run(sentences: Sequence[str]) -> None:
    """Shows the warnings of steps, at the line of the caller's caller."""
    for sentence in sentences:
        warnings.warn(sentence, RunWarning, stacklevel=3)


def warn_about(created: Mapping[str, Any]) -> None:
    """Shows the warnings in the answer to a creation, at the line of the caller's caller."""
    for diagnostic in created.get("diagnostics", []):
        if diagnostic.get("severity") == "warning":
            warnings.warn(str(diagnostic.get("text", "")), ModelWarning, stacklevel=3)
