"""The exceptions of the package."""

from __future__ import annotations

from typing import Any, Dict, List, Optional


class EspalierError(Exception):
    """Base of all errors of this package. The message is a whole sentence."""


class ConnectionLost(EspalierError):
    """The other side cannot be reached, ended the connection, or did not answer in time."""


class ProtocolError(EspalierError):
    """The other side sent something that is not a message of the protocol."""


class ServerFailed(EspalierError):
    """The program `espalier` could not be started or ended early."""


class ServerError(EspalierError):
    """The server refused a request.

    `code` is the error code of the protocol, `data` its further information (or None).
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
