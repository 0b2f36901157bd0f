"""Many sessions, simulations and viewers at a time: nobody waits for somebody else's work."""

import json
import os
import resource
import socket
import statistics
import threading
import time
import unittest
from typing import Any, Dict, List, Optional

from support import SECONDS, program

from espalier import Client, Server

# long enough to go on while the others are watched; every step changes the string
RUNNING = """Lsystem: 1
derivation length: 100000
Axiom: A(0.5)
A(x) --> A(ran(1) + x/2)
endlsystem
"""
WATCHED = """Lsystem: 1
derivation length: 100000
Axiom: X
X --> X
endlsystem
""".replace("Axiom: X", "Axiom: " + "F(1)+(1)" * 500 + "X")
HELLO = {"jsonrpc": "2.0", "id": 1, "method": "hello",
         "params": {"protocol": [1], "roles": ["controller", "viewer"], "name": "idle", "version": "1"}}


class Raw:
    """A connection that says what it is told and reads when it is told."""

    def __init__(self, address: str) -> None:
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), timeout=SECONDS)
        self.file = self.socket.makefile("rb")
        self.send(HELLO)
        self.greeting = self.read()

    def send(self, message: Dict[str, Any]) -> None:
        self.socket.sendall(json.dumps(message).encode() + b"\n")

    def read(self) -> Dict[str, Any]:
        line = self.file.readline()
        if not line:
            raise ConnectionError("closed")
        return dict(json.loads(line))

    def ask(self, method: str, params: Dict[str, Any]) -> Dict[str, Any]:
        self.send({"jsonrpc": "2.0", "id": 2, "method": method, "params": params})
        return self.read()

    def close(self) -> None:
        self.file.close()
        self.socket.close()


class ManyAtOnce(unittest.TestCase):
    def short_requests(self, client: Client, simulation: str, count: int) -> List[float]:
        """How long pairs of a short compilation and a short look take."""
        waits = []
        for _ in range(count):
            begin = time.monotonic()
            self.assertTrue(client.check("Lsystem: 1\nAxiom: A\nA --> A\nendlsystem\n").valid)
            client.call("simulation.get", {"simulation": simulation, "what": "statistics"})
            waits.append(time.monotonic() - begin)
        return waits

    def shares_are_even(self, client: Client, names: List[str]) -> None:
        """Each running simulation makes as many steps as another, up to a factor of two. Counted in steps, not in time."""
        def steps() -> Dict[str, int]:
            listed = client.call("simulation.list")["simulations"]
            return {entry["simulation"]: entry["step"] for entry in listed if entry["simulation"] in names}

        before = steps()
        made: Dict[str, int] = {}
        while min(made.values(), default=0) < 1000:
            made = {name: step - before[name] for name, step in steps().items()}
            # one that is left behind ends the wait
            if max(made.values()) > 100_000:
                break
        self.assertEqual(len(made), len(names))
        self.assertLessEqual(max(made.values()), 2 * min(made.values()), made)

    def crowd(self, idle: int, simulations: int, viewers: int, probes: int) -> None:
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        server = Server(program(), arguments=["--log-level", "off", "--limit", "sessions=3000"])
        self.addCleanup(server.stop)
        peers: List[Raw] = []
        self.addCleanup(lambda: [peer.close() for peer in peers])

        # sessions that only stand there
        for _ in range(idle):
            peers.append(Raw(server.address))
            self.assertEqual(peers[-1].greeting["result"]["protocol"], 1)

        client = server.connect(timeout=SECONDS)
        self.addCleanup(client.close)
        watched = client.create(WATCHED, seed=1).identifier
        # simulations that run until they are paused
        names = [client.create(RUNNING, seed=seed).identifier for seed in range(simulations)]
        runners = []
        for group in range(0, simulations, 10):
            runner = Raw(server.address)
            peers.append(runner)
            runners.append(runner)
            for index, name in enumerate(names[group:group + 10]):
                runner.send({"jsonrpc": "2.0", "id": 100 + index, "method": "simulation.run",
                             "params": {"simulation": name}})

        # viewers of one more, of whom one never reads
        seen: List[Optional[int]] = [None] * viewers

        def watch(index: int, viewer: Raw) -> None:
            while True:
                frame = viewer.read()
                if frame.get("method") == "stream.data":
                    seen[index] = int(frame["params"]["step"])
                    if seen[index] == 60:
                        return

        watchers = []
        for index in range(viewers):
            viewer = Raw(server.address)
            peers.append(viewer)
            viewer.send({"jsonrpc": "2.0", "id": 2, "method": "stream.open",
                         "params": {"simulation": watched, "what": "turtle"}})
            if index > 0:
                watchers.append(threading.Thread(target=watch, args=(index, viewer)))
                watchers[-1].start()
        for _ in range(60):
            client.call("simulation.step", {"simulation": watched})
        for watcher in watchers:
            watcher.join(SECONDS)
        self.assertEqual(seen[1:], [60] * (viewers - 1))

        # short requests of somebody else meanwhile
        with server.connect(timeout=SECONDS) as prober:
            waits = self.short_requests(prober, watched, probes)
            status = prober.status()
        self.assertGreaterEqual(status["sessions"], idle + viewers)
        self.assertEqual(status["simulations"], simulations + 1)
        # the viewer that reads nothing gets at most a quarter of its outbox, not 60 frames
        self.assertLess(status["memory"]["outboxBytes"], 64_000_000)
        self.shares_are_even(client, names)
        waits.sort()
        print(f"{idle} idle sessions, {simulations} running simulations, {viewers} viewers: two short requests took "
              f"{1e3 * statistics.median(waits):.1f} ms (median), {1e3 * waits[len(waits) * 99 // 100]:.1f} ms (99 of 100)")
        # nobody's work has kept them waiting for its end: everything still runs
        self.assertEqual(status["running"], simulations)

        for name in names:
            client.call("simulation.pause", {"simulation": name})
        steps = []
        for group, runner in enumerate(runners):
            for _ in names[10 * group:10 * group + 10]:
                answer = runner.read()
                self.assertIn("result", answer, answer)
                steps.append(answer["result"]["step"])
        self.assertEqual(len(steps), simulations)

    def test_short_requests_are_answered_beside_many_running_simulations(self) -> None:
        self.crowd(idle=100, simulations=20, viewers=10, probes=20)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes long: ./dev test --all")
    def test_long_a_thousand_idle_sessions_a_hundred_simulations_fifty_viewers(self) -> None:
        self.crowd(idle=1000, simulations=100, viewers=50, probes=200)


if __name__ == "__main__":
    unittest.main()
