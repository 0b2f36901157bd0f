"""Headless Chromium, driven over its debugging protocol: opens a page, evaluates expressions, takes pictures."""

import base64
import json
import shutil
import subprocess
import tempfile
import time
import urllib.request
from typing import Any, Optional

from support import SECONDS

from espalier.websocket import Upgrade, WebSocketChannel
from espalier.wire import SocketChannel

PROGRAM = shutil.which("chromium")
OPTIONS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
           "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--use-gl=angle",
           "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--window-size=1100,700", "--remote-debugging-port=0")

TURN_SECONDS = 0.02
# for one answer of the browser: it draws without a graphics card, and others may have the processor
PATIENCE_SECONDS = 10 * SECONDS


class Browser:
    """One page. Use it as a context manager."""

    def __init__(self, address: str, *more: str) -> None:
        assert PROGRAM is not None
        self._folder = tempfile.mkdtemp()
        self._process = subprocess.Popen([PROGRAM, *OPTIONS, f"--user-data-dir={self._folder}", *more, "about:blank"],
                                         stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self._channel: Optional[WebSocketChannel] = None
        self._next_id = 0
        try:
            self._connect()
            self._call("Page.enable")
            self._call("Page.navigate", url=address)
            self.wait_for('document.readyState === "complete" && location.href !== "about:blank"')
        except BaseException:
            self.close()
            raise

    def _connect(self) -> None:
        """Speaks with the first page of the browser."""
        assert self._process.stderr is not None
        for line in self._process.stderr:
            if "DevTools listening on ws://" in line:
                host = line.split("ws://")[1].split("/")[0]
                break
        else:
            raise AssertionError("Chromium ended before it could be spoken to.")
        deadline = time.monotonic() + SECONDS
        while time.monotonic() < deadline:
            with urllib.request.urlopen(f"http://{host}/json/list", timeout=SECONDS) as answer:
                pages = [page for page in json.load(answer) if page["type"] == "page"]
            if pages:
                break
        path = pages[0]["webSocketDebuggerUrl"].split(host)[1]
        name, port = host.split(":")
        socket = SocketChannel.connect(name, int(port), SECONDS).release()
        channel = WebSocketChannel(socket, host)
        upgrade = Upgrade(host, host)
        socket.sendall(upgrade.request.replace(b"/espalier/1", path.encode("ascii")))
        upgrade.check(channel._head(time.monotonic() + SECONDS))
        self._channel = channel

    def _call(self, method: str, **parameters: Any) -> Any:
        assert self._channel is not None
        self._next_id += 1
        self._channel.send({"id": self._next_id, "method": method, "params": parameters})
        while True:
            message = self._channel.receive(PATIENCE_SECONDS)
            if message is None:
                raise AssertionError("Chromium closed the connection.")
            if message.get("id") == self._next_id:
                if "error" in message:
                    raise AssertionError(f"{method}: {message['error']}")
                return message["result"]

    def evaluate(self, expression: str) -> Any:
        """The value of an expression in the page; a promise is awaited."""
        found = self._call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in found:
            raise AssertionError(f"{expression}: {found['exceptionDetails']}")
        return found["result"].get("value")

    def wait_for(self, expression: str) -> Any:
        """Waits until an expression is true in the page, and returns its value. It gives up after so many turns of the
        page's own loop, which are slow where the page is: a busy machine does not fail a test."""
        for _ in range(int(SECONDS / TURN_SECONDS)):
            value = self.evaluate(expression)
            if value:
                return value
            self.evaluate(f"new Promise((done) => setTimeout(done, {1000 * TURN_SECONDS}))")
        raise AssertionError(f"{expression} did not become true; the page says: {self.evaluate('document.body.innerText')}")

    def drag(self, x: int, y: int, to_x: int, to_y: int) -> None:
        """Moves the mouse with its button pressed."""
        def mouse(kind: str, at_x: int, at_y: int) -> None:
            self._call("Input.dispatchMouseEvent", type=kind, x=at_x, y=at_y, button="left", buttons=1, clickCount=1)

        mouse("mousePressed", x, y)
        for part in range(1, 6):
            mouse("mouseMoved", x + (to_x - x) * part // 5, y + (to_y - y) * part // 5)
        mouse("mouseReleased", to_x, to_y)

    def picture(self) -> bytes:
        """A PNG file of what the page shows."""
        return base64.b64decode(self._call("Page.captureScreenshot", format="png")["data"])

    def close(self) -> None:
        if self._channel is not None:
            self._channel.close()
        self._process.terminate()
        self._process.wait(SECONDS)
        if self._process.stderr is not None:
            self._process.stderr.close()
        # its helpers may still write there
        shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()
