"""Which connections of a listener may stay: strangers never lock out a peer that is known."""

from __future__ import annotations

import errno
import socket
import threading
import time
from collections import OrderedDict
from typing import Any, Dict, Optional, Tuple

WAITING = 128  # connections whose peers are not known yet
TRUSTED = 32
PER_ADDRESS = 16  # waiting connections of one address of another machine
LOOK_SECONDS = 60.0
LEAVE_SECONDS = 1.0  # for the thread of a connection to close it


class Admission:
    """Counts connections. A connection waits until its peer has sent a request that is allowed; then it is trusted. When all places
    are taken, the connection that has waited longest is closed, or among the trusted ones the one that has been idle longest.
    Thread-safe.
    """

    def __init__(self, waiting: int = WAITING, trusted: int = TRUSTED, per_address: int = PER_ADDRESS) -> None:
        self._bounds = waiting, trusted, per_address
        self._lock = threading.Condition()
        # by age: the oldest first
        self._waiting: "OrderedDict[Any, str]" = OrderedDict()  # connection: address; empty: this machine
        self._idle: "OrderedDict[Any, None]" = OrderedDict()
        self._busy: Dict[Any, None] = {}
        self._evicted: Dict[Any, None] = {}  # until they leave

    def enter(self, connection: Any, address: str) -> None:
        """A connection was accepted. `address`: of the peer; empty: this machine."""
        waiting, _, per_address = self._bounds
        with self._lock:
            own = [other for other, place in self._waiting.items() if place == address] if address else []
            if len(own) >= per_address:
                self._evict(own[0])
            elif len(self._waiting) >= waiting:
                self._evict(next(iter(self._waiting)))
            self._waiting[connection] = address

    def trust(self, connection: Any) -> bool:
        """Its request is allowed. False: all places are taken by requests that are being answered, or it was closed."""
        with self._lock:
            if connection in self._waiting:
                if len(self._idle) + len(self._busy) >= self._bounds[1] and not self._evict(next(iter(self._idle), None)):
                    return False
                del self._waiting[connection]
            elif connection not in self._idle:
                return False
            self._idle[connection] = None
            self._idle.move_to_end(connection)
            return True

    def begin(self, connection: Any) -> bool:
        """Its request is answered now, and it keeps its place meanwhile. False: it was closed."""
        with self._lock:
            if connection not in self._idle:
                return False
            del self._idle[connection]
            self._busy[connection] = None
            return True

    def end(self, connection: Any) -> None:
        """The request is answered."""
        with self._lock:
            if self._busy.pop(connection, 0) is None:
                self._idle[connection] = None

    def leave(self, connection: Any) -> None:
        """The connection ends: it is closed now, but its descriptor is not another's yet."""
        with self._lock:
            self._waiting.pop(connection, None)
            self._idle.pop(connection, None)
            self._busy.pop(connection, None)
            self._evicted.pop(connection, None)
            self._lock.notify_all()

    def evict_one(self, seconds: float = 0.0) -> bool:
        """Closes the connection that has waited longest, and waits until it has left, so many seconds at most. False: none waits."""
        with self._lock:
            connection = next(iter(self._waiting), None)
            is_evicted = self._evict(connection)
            self._lock.wait_for(lambda: connection not in self._evicted, seconds)
            return is_evicted

    def _evict(self, connection: Optional[Any]) -> bool:
        if connection is None:
            return False
        self._waiting.pop(connection, None)
        self._idle.pop(connection, None)
        self._evicted[connection] = None
        try:
            # its thread reads the end and closes it
            connection.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        return True


def accepted(listener: socket.socket, admission: Admission) -> Tuple[socket.socket, Any]:
    """The next connection and the address of its peer. Raises OSError when there is none."""
    # with a time limit, Python waits for a connection before it takes a descriptor for it. Without, accept() fails while there are no
    # descriptors, and connections would be closed for nobody
    listener.settimeout(LOOK_SECONDS)
    while True:
        try:
            return listener.accept()
        except socket.timeout:
            continue
        except OSError as error:
            # a connection that waits gives back its descriptor
            if error.errno in (errno.EMFILE, errno.ENFILE) and not admission.evict_one(LEAVE_SECONDS):
                time.sleep(0.1)
            raise


def is_loopback(address: str) -> bool:
    return address == "::1" or address.startswith(("127.", "::ffff:127."))
