"""A live link: a thread reads the geometry of a simulation on a server, and a timer shows the newest of it."""

import threading
from typing import Any, Optional

import bpy
from espalier import Client, glb

from . import scene

SECONDS = 0.1  # between two looks of the timer


class Link:
    """Follows a simulation as a viewer, which never slows it. Steps that come faster than they can be shown are left out."""

    def __init__(self, address: str, token: str, simulation: str, name: str = "Espalier") -> None:
        self.client = Client(address, name="blender", token=token or None, timeout=30)
        try:
            known = [each["simulation"] for each in self.client.simulations()]
            if not known:
                raise ValueError("the server has no simulation. Create one, and connect again")
            if simulation and simulation not in known:
                raise ValueError(f"the server has no simulation '{simulation}'. It has: {', '.join(known)}")
            self.simulation = self.client.simulation(simulation or known[-1])
            self.stream = self.simulation.stream("geometry", arrays=True, credits=1)
        except BaseException:
            self.client.close()
            raise
        self.name = name
        self.step = -1  # that is shown
        self.problem = ""  # why the link ended
        self._lock = threading.Lock()
        self._newest: Optional[Any] = None
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        try:
            while True:
                frame = self.stream.read()
                with self._lock:
                    self._newest = frame
        except Exception as error:  # the user sees every end of the link
            self.problem = str(error) or type(error).__name__

    def show(self) -> bool:
        """Shows the newest state, if there is one that is not shown. Only for the main thread of Blender."""
        with self._lock:
            frame, self._newest = self._newest, None
        if frame is None:
            return False
        scene.show(glb.read(bytes(frame.columns["glb"])), self.name)
        self.step = frame.step
        return True

    def close(self) -> None:
        self.client.close()
        self._thread.join(timeout=5)


current: Optional[Link] = None


def open_link(address: str, token: str, simulation: str) -> None:
    global current
    close_link()
    current = Link(address, token, simulation)
    if not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=SECONDS)


def close_link() -> None:
    global current
    if current is not None:
        current.close()
        current = None


def _look() -> Optional[float]:
    if current is None:
        return None
    try:
        current.show()
    except glb.GlbError as error:
        current.problem = str(error)
    return None if current.problem else SECONDS
