"""`python3 -m espalier.mcp --http`: the official SDK over HTTP, several hosts at once, and requests that are not answered."""

from __future__ import annotations

import http.client
import json
import os
import resource
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple
from unittest import mock

from support import SECONDS, Process, program, variables
from test_mcp import COMMAND, MODEL, SDK, call, check_answers, request, said

from espalier import listening
from espalier.mcp import http as mcp_http
from espalier.mcp import tools as mcp_tools
from espalier.mcp.http import SESSIONS, HttpServer

TOKEN = "a-token-of-this-test"
JSON = {"Content-Type": "application/json"}


class OverHttp(unittest.TestCase):
    def setUp(self) -> None:
        folder = Path(self.folder())
        (folder / "token").write_text(TOKEN + "\n", encoding="ascii")
        self.process = Process([*COMMAND, "--http", "127.0.0.1:0", "--http-token-file", str(folder / "token")],
                               ESPALIER_PROGRAM=program())
        self.addCleanup(self.process.stop)
        self.url = self.process.first_line.split("MCP on ")[1]
        self.port = int(self.url.split(":")[2].split("/")[0])

    def folder(self) -> str:
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        return made.name

    def send(self, method: str = "POST", message: Any = None, *, path: str = "/mcp", session: Optional[str] = None,
             headers: Optional[Mapping[str, str]] = None, token: str = TOKEN) -> Tuple[int, Any, Dict[str, str]]:
        """Status, answer and headers."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=SECONDS)
        try:
            sent = {**JSON, "Authorization": f"Bearer {token}", **({"Mcp-Session-Id": session} if session else {}), **(headers or {})}
            body = message if isinstance(message, bytes) or message is None else json.dumps(message).encode()
            connection.request(method, path, body, sent)
            answer = connection.getresponse()
            content = answer.read()
            return answer.status, json.loads(content) if content else None, dict(answer.getheaders())
        finally:
            connection.close()

    def begin(self) -> str:
        status, answer, headers = self.send(message=request(1, "initialize", protocolVersion="2025-06-18"))
        self.assertEqual((status, answer["result"]["protocolVersion"]), (200, "2025-06-18"))
        session = headers["Mcp-Session-Id"]
        self.assertEqual(self.send(message={"jsonrpc": "2.0", "method": "notifications/initialized"}, session=session)[:2], (202, None))
        return session

    @unittest.skipUnless((SDK / "node_modules").is_dir() and shutil.which("node"), "the SDK is not installed: npm ci in tests/mcp")
    def test_a_plant_is_checked_grown_explained_drawn_and_read(self) -> None:
        done = subprocess.run(["node", str(SDK / "client.js"), self.url], capture_output=True, text=True, timeout=SECONDS, check=True,
                              env=variables(ESPALIER_MCP_TOKEN=TOKEN))
        check_answers(self, json.loads(done.stdout))

    def test_each_session_has_its_plants_and_they_end_with_it(self) -> None:
        sessions = [self.begin(), self.begin()]
        for session in sessions:
            for number in range(mcp_tools.SIMULATIONS + 1):
                _, answer, _ = self.send(message=call(number, "create", source=MODEL, seed=number), session=session)
            self.assertIn("Call `delete` for one", said(answer))
        self.assertEqual(self.send("DELETE", session=sessions[0])[0], 204)
        self.assertEqual(self.send("DELETE", session=sessions[0])[0], 404)
        status, answer, _ = self.send(message=request(1, "ping"), session=sessions[0])
        self.assertEqual((status, answer["error"]["message"]), (404, "The session has ended. Send initialize again."))
        self.assertEqual(self.send(message=request(1, "ping"), session=sessions[1])[1]["result"], {})
        # more sessions than there are places: the one used least recently ends; its plants would fill the server
        for _ in range(SESSIONS):
            session = self.begin()
            for number in range(mcp_tools.SIMULATIONS):
                _, answer, _ = self.send(message=call(number, "create", source=MODEL, seed=number), session=session)
                self.assertFalse(answer["result"]["isError"], answer)
        self.assertEqual(self.send(message=request(1, "ping"), session=sessions[1])[0], 404)

    def test_an_initialize_that_is_wrong_takes_no_place(self) -> None:
        session = self.begin()
        for _ in range(SESSIONS + 1):
            status, _, headers = self.send(message={"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": 5})
            self.assertEqual(status, 400)
            self.assertNotIn("Mcp-Session-Id", headers)
        self.assertEqual(self.send(message=request(1, "ping"), session=session)[0], 200)

    def test_hosts_at_once_get_their_own_answers(self) -> None:
        found: List[str] = []

        def grow(steps: int) -> None:
            session = self.begin()
            made = json.loads(said(self.send(message=call(1, "create", source=MODEL, seed=1), session=session)[1]))["simulation"]
            self.send(message=call(2, "step", simulation=made, steps=steps), session=session)
            found.append(said(self.send(message=call(3, "query", simulation=made, what="string"), session=session)[1]))

        threads = [threading.Thread(target=grow, args=(1 + number % 2,)) for number in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(SECONDS)
        self.assertEqual(sorted(found), ["F[+A]A"] * 3 + ["F[+F[+A]A]F[+A]A"] * 3)

    def test_what_may_not_connect_is_told_why(self) -> None:
        first = request(1, "initialize")
        cases: List[Tuple[int, str, Dict[str, Any]]] = [
            (401, "needs its token", dict(message=first, token="wrong")),
            (401, "needs its token", dict(message=first, token="")),
            (403, "other machines", dict(message=first, headers={"Origin": "http://evil.example"})),
            (403, "other machines", dict(message=first, headers={"Origin": "null"})),
            (404, "is at /mcp", dict(message=first, path="/")),
            (405, "begins no streams", dict(method="GET", message=None)),
            (400, "Send initialize first", dict(message=request(1, "ping"))),
            (400, "Send initialize first", dict(message=b"[" * 100_000)),
            (400, "Send initialize first", dict(message=b"\xff\xfe")),
            (404, "session has ended", dict(message=request(1, "ping"), session="0" * 32)),
            (400, "MCP-Protocol-Version", dict(message=first, headers={"MCP-Protocol-Version": "1999-01-01"})),
            (413, "4000000 bytes", dict(message=b"", headers={"Content-Length": "4000001"})),
            (413, "4000000 bytes", dict(message=b"", headers={"Content-Length": "9" * 30})),
            (411, "Content-Length", dict(message=b"", headers={"Content-Length": "-1"})),
            (415, "application/json", dict(message=first, headers={"Content-Type": "text/plain"}))]
        for status, words, parameters in cases:
            with self.subTest(words=words, parameters=str(parameters)[:100]):
                found, answer, _ = self.send(**{"method": "POST", **parameters})
                self.assertEqual(found, status, answer)
                self.assertIn(words, answer["error"]["message"])
        self.assertEqual(self.send(message=first, headers={"Origin": "http://localhost:3000"})[0], 200)

    def test_connections_without_the_token_keep_no_host_out(self) -> None:
        with ExitStack() as stack:
            def strangers(said: bytes) -> None:
                for _ in range(listening.WAITING + 12):
                    stranger = stack.enter_context(socket.create_connection(("127.0.0.1", self.port), SECONDS))
                    stranger.sendall(said)

            owner = http.client.HTTPConnection("127.0.0.1", self.port, timeout=SECONDS)
            stack.callback(owner.close)
            for said in (b"", b"POST /mcp HTTP/1.1\r\nHost: x\r\n", b"POST /mcp HTTP/1.1\r\nAuthorization: Bearer wrong\r\nContent-Length: 9\r\n"):
                strangers(said)
                # at once, and again on the connection that has shown the token
                begun = time.monotonic()
                owner.request("POST", "/mcp", json.dumps(request(1, "initialize")), {**JSON, "Authorization": f"Bearer {TOKEN}"})
                answer = owner.getresponse()
                self.assertEqual((answer.status, len(answer.read()) > 9), (200, True))
                self.begin()
                self.assertLess(time.monotonic() - begun, mcp_http.HEAD_SECONDS / 2)

    def test_hosts_that_keep_their_connections_keep_no_other_out(self) -> None:
        with ExitStack() as stack:
            for _ in range(listening.TRUSTED + 5):
                idle = http.client.HTTPConnection("127.0.0.1", self.port, timeout=SECONDS)
                stack.callback(idle.close)
                idle.request("POST", "/mcp", json.dumps(request(1, "ping")), {**JSON, "Authorization": f"Bearer {TOKEN}"})
                answer = idle.getresponse()
                self.assertEqual((answer.status, len(answer.read()) > 9), (400, True))
            # nor does a message that does not come to its end
            for _ in range(listening.TRUSTED + 5):
                slow = stack.enter_context(socket.create_connection(("127.0.0.1", self.port), SECONDS))
                slow.sendall(b"POST /mcp HTTP/1.1\r\nAuthorization: Bearer " + TOKEN.encode() +
                             b"\r\nContent-Type: application/json\r\nContent-Length: 900\r\n\r\n{")
            self.begin()

    def test_a_server_that_is_gone_is_named(self) -> None:
        session = self.begin()
        children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(self.process.process.pid)], capture_output=True, text=True, check=True)
        os.kill(int(children.stdout), signal.SIGKILL)
        for message, known in ((call(1, "gallery"), session), (request(1, "initialize"), None)):
            status, answer, _ = self.send(message=message, session=known)
            self.assertEqual((status, answer["error"]["message"][:40]), (503, "The server of the plants does not answer"))

    def test_it_ends_with_its_server(self) -> None:
        session = self.begin()
        self.send(message=call(1, "create", source=MODEL, seed=1), session=session)
        processes = subprocess.run(["ps", "-o", "pid=", "--ppid", str(self.process.process.pid)], capture_output=True, text=True, check=True)
        children = processes.stdout.split()
        self.assertEqual(len(children), 1)
        self.process.process.terminate()
        self.assertEqual(self.process.wait(), 143)
        self.assertFalse(Path(f"/proc/{children[0]}").exists())


class Places(unittest.TestCase):
    """Of connections, in a server of this process that has no tools."""

    def serve(self, token: Optional[str] = TOKEN) -> int:
        def open_tools(stack: ExitStack) -> mcp_tools.Tools:
            self.fail("no session begins")

        server = HttpServer(("127.0.0.1", 0), open_tools, token)
        self.addCleanup(server.server_close)
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(server.shutdown)
        return int(server.server_address[1])

    def test_a_head_that_comes_byte_by_byte_ends(self) -> None:
        with mock.patch.object(mcp_http, "HEAD_SECONDS", 0.4), \
                socket.create_connection(("127.0.0.1", self.serve()), SECONDS) as slow, self.assertRaises(OSError):
            begun = time.monotonic()
            while time.monotonic() - begun < SECONDS:
                slow.sendall(b"X")
                time.sleep(0.05)

    def test_a_head_has_a_bound(self) -> None:
        port = self.serve()
        for head, status in ((b"GET /" + b"x" * 70_000 + b" HTTP/1.1\r\n", b" 414 "),
                             (b"GET /mcp HTTP/1.1\r\n" + b"".join(b"X%d: " % number + b"x" * 60_000 + b"\r\n" for number in range(9)), b" 431 ")):
            with self.subTest(status=status), socket.create_connection(("127.0.0.1", port), SECONDS) as peer:
                try:
                    peer.sendall(head)
                    self.assertIn(status, peer.recv(100))
                except ConnectionError:
                    # it was closed while much was still on its way
                    self.assertEqual(status, b" 431 ")

    def test_a_waiting_connection_gives_way_to_one_of_its_own_address_first(self) -> None:
        admission = listening.Admission(waiting=3, trusted=2, per_address=2)
        near = [mock.Mock(name=f"connection {number}") for number in range(9)]

        def closed() -> List[int]:
            return [number for number, one in enumerate(near) if one.shutdown.called]

        admission.enter(near[0], "192.0.2.1")
        admission.enter(near[1], "")
        admission.enter(near[2], "192.0.2.1")
        admission.enter(near[3], "192.0.2.1")
        self.assertEqual(closed(), [0])
        # this machine has no bound of its own: the oldest of all goes
        admission.enter(near[4], "")
        self.assertEqual(closed(), [0, 1])
        self.assertFalse(admission.trust(near[1]))
        for number in (2, 3):
            self.assertTrue(admission.trust(near[number]))
        self.assertTrue(admission.begin(near[2]))
        # the idle one goes for the next that is trusted, never one that is being answered
        self.assertTrue(admission.trust(near[4]))
        self.assertEqual(closed(), [0, 1, 3])
        self.assertTrue(admission.begin(near[4]))
        admission.enter(near[5], "")
        self.assertFalse(admission.trust(near[5]))
        admission.end(near[2])
        self.assertTrue(admission.trust(near[5]))
        self.assertEqual(closed(), [0, 1, 2, 3])
        admission.leave(near[5])
        admission.enter(near[6], "")
        self.assertTrue(admission.trust(near[6]))
        self.assertEqual(closed(), [0, 1, 2, 3])
        self.assertFalse(admission.evict_one())
        admission.enter(near[7], "")
        self.assertTrue(admission.evict_one())
        self.assertEqual(closed(), [0, 1, 2, 3, 7])

    def test_one_that_gives_way_is_waited_for(self) -> None:
        admission = listening.Admission()
        connection = mock.Mock()
        admission.enter(connection, "")
        # its thread closes it when it has seen the end
        left = threading.Event()

        def leave() -> None:
            left.set()
            admission.leave(connection)

        connection.shutdown.side_effect = lambda how: threading.Timer(0.2, leave).start()
        self.assertTrue(admission.evict_one(60))
        self.assertTrue(left.is_set())

    def test_connections_are_closed_for_others_only(self) -> None:
        admission = mock.Mock()
        with socket.create_server(("127.0.0.1", 0)) as listener, socket.socket() as peer:
            limits = resource.getrlimit(resource.RLIMIT_NOFILE)
            accepting = threading.Thread(target=listening.accepted, args=(listener, admission), daemon=True)
            # no descriptor is left, and nobody comes
            resource.setrlimit(resource.RLIMIT_NOFILE, (1, limits[1]))
            try:
                accepting.start()
                accepting.join(0.3)
                self.assertTrue(accepting.is_alive())
            finally:
                resource.setrlimit(resource.RLIMIT_NOFILE, limits)
            admission.evict_one.assert_not_called()
            peer.connect(listener.getsockname())
            accepting.join(10)
            self.assertFalse(accepting.is_alive())


class Options(unittest.TestCase):
    def test_a_token_may_have_any_letters(self) -> None:
        def open_tools(stack: ExitStack) -> mcp_tools.Tools:
            self.fail("no session begins")

        with HttpServer(("127.0.0.1", 0), open_tools, "Bäume") as server:
            thread = threading.Thread(target=server.serve_forever)
            thread.start()
            try:
                for token, status in (("Bäume", 400), ("Baume", 401)):
                    connection = http.client.HTTPConnection("127.0.0.1", server.server_address[1], timeout=SECONDS)
                    connection.request("POST", "/mcp", b"{}", {**JSON, "Authorization": f"Bearer {token}".encode()})
                    self.assertEqual(connection.getresponse().status, status, token)
                    connection.close()
            finally:
                server.shutdown()
                thread.join()

    def test_a_place_that_others_reach_needs_a_token(self) -> None:
        for place, words in (("0.0.0.0:0", "--http-token-file"), ("127.0.0.1", "HOST:PORT"), (":80", "HOST:PORT"), ("127.0.0.1:99999", "HOST:PORT")):
            done = subprocess.run([*COMMAND, "--http", place], capture_output=True, text=True, timeout=SECONDS, check=False,
                                  env=variables(ESPALIER_PROGRAM=program()), stdin=subprocess.DEVNULL)
            self.assertEqual((done.returncode, done.stdout), (1, ""), place)
            self.assertIn(words, done.stderr)


if __name__ == "__main__":
    unittest.main()
