"""Everything a server does, again and again for a long time: its memory must stay flat. `./dev soak` runs it.

Controllers create, step, edit, fork, save, restore, cancel and delete simulations with environments inside, spawned and
offered; viewers follow differences and whole frames, some read nothing, some leave in the middle of a frame; peers say
nonsense. Resident memory is read every few seconds. After a warm-up the largest value of the last third may exceed the
largest of the first by a tenth and 20 MB.
"""

import argparse
import random
import re
import socket
import statistics
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Callable, Dict, List

from support import PACKAGE, Process, program  # noqa: F401  (makes the package importable)

from espalier import Client, Environment, EspalierError, Query, hosting

SECONDS = 60
GROWING = """Lsystem: 1
derivation length: 40
Axiom: F(1)A(0)
A(x) --> F(ran(1))[+(ran(90))B(0)]?E(0.5)A(x+1)
B(x) : x > 6 --> *
B(x) --> F(ran(1))[-(50)F(0.1)]B(x+1)
endlsystem
"""


class Height(Environment):
    """Answers the height."""

    needs = ("position",)

    def answer(self, query: Query) -> List[float]:
        return [query.position[1]]


class Soak:
    def __init__(self, address: str, seconds: float) -> None:
        self.address = address
        self.end = time.monotonic() + seconds
        self.counts: Dict[str, int] = {}
        self.failures: List[str] = []
        self.lock = threading.Lock()

    def count(self, what: str, number: int = 1) -> None:
        with self.lock:
            self.counts[what] = self.counts.get(what, 0) + number

    def repeat(self, body: Callable[[random.Random], None], seed: int) -> threading.Thread:
        """Runs a part again and again in a thread of its own; an error that is not expected ends the soak as a failure."""
        dice = random.Random(seed)

        def run() -> None:
            while time.monotonic() < self.end and not self.failures:
                try:
                    body(dice)
                except Exception as error:  # noqa: BLE001
                    self.failures.append(f"{body.__name__}: {type(error).__name__}: {error}")

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        return thread

    def grow(self, dice: random.Random) -> None:
        """A simulation's whole life."""
        kinds: List[Dict[str, Any]] = [{"type": "honda", "radius": 0.1}, {"type": "offered", "name": "height"},
                                       {"type": "stdio", "command": f"'{program()}' environment height --stdio"}]
        with Client(self.address, timeout=SECONDS) as client:
            plant = client.create(GROWING, seed=dice.randrange(1000), environment=[dice.choice(kinds)])
            with plant.stream(dice.choice(["turtle", "string", "queries"])) as stream:
                plant.step(dice.randrange(1, 8))
                self.count("frames", 1 if stream.read(SECONDS).step >= 0 else 0)
                snapshot = plant.save()
                client.call("simulation.save", {"simulation": plant.identifier, "checkpoint": "here", "snapshot": False})
                step = plant.get("statistics")["step"]
                before = plant.get("state-hash")["stateHash"]
                plant.step(dice.randrange(1, 20))
                if dice.random() < 0.5:
                    plant.restore(snapshot)
                else:
                    client.call("simulation.restore", {"simulation": plant.identifier, "checkpoint": "here"})
                if plant.get("state-hash")["stateHash"] != before:
                    raise AssertionError(f"another state after it was restored at step {step}")
                client.call("simulation.edit", {"simulation": plant.identifier, "module": 0, "action": "insert",
                                                "modules": [{"symbol": "+", "parameters": [20]}]})
                self.count("steps", int(plant.step(5).step))
            client.call("simulation.delete", {"simulation": plant.identifier})
            self.count("simulations")

    def cancel(self, dice: random.Random) -> None:
        """Runs that are given up, by word and by leaving."""
        client = Client(self.address, timeout=SECONDS)
        plant = client.create(GROWING.replace("length: 40", "length: 100000"), seed=1, save=False)
        client._channel.send({"jsonrpc": "2.0", "id": 999, "method": "simulation.run",
                              "params": {"simulation": plant.identifier}})
        if dice.random() < 0.5:
            client.notify("$/cancel", {"id": 999})
        client.close()
        with Client(self.address, timeout=SECONDS) as other:
            other.call("simulation.delete", {"simulation": plant.identifier})
        self.count("cancelled")

    def watch(self, dice: random.Random) -> None:
        """A viewer of the simulation that all watch: in any form, at any speed."""
        with Client(self.address, timeout=SECONDS) as client:
            plants = [entry for entry in client.simulations() if entry["name"] == "watched"]
            if not plants:
                time.sleep(0.1)
                return
            options: Dict[str, Any] = {"arrays": dice.random() < 0.7, "delta": dice.random() < 0.8, "single": dice.random() < 0.5}
            if dice.random() < 0.3:
                options["max_hz"] = 20.0
            # it may be gone at any moment
            try:
                plant = client.simulation(str(plants[0]["simulation"]))
                with plant.stream(**options) as stream:
                    for _ in range(dice.randrange(1, 40)):
                        stream.read(SECONDS)
                        self.count("frames")
                        if dice.random() < 0.05:
                            time.sleep(0.3)
            except EspalierError:
                pass

    def stare(self, dice: random.Random) -> None:
        """A viewer that opens a stream without credits and reads nothing, then leaves."""
        host, port = self.address.rsplit(":", 1)
        with socket.create_connection((host, int(port)), SECONDS) as peer:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            peer.sendall(b'{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1]}}\n')
            lines = peer.makefile("rb")
            lines.readline()
            with Client(self.address, timeout=SECONDS) as client:
                names = [entry["simulation"] for entry in client.simulations() if entry["name"] == "watched"]
            for name in names:
                peer.sendall(b'{"jsonrpc":"2.0","id":2,"method":"stream.open","params":{"what":"turtle","simulation":"'
                             + str(name).encode() + b'"}}\n')
            time.sleep(dice.uniform(0.5, 3.0))
            lines.close()
        self.count("viewers that read nothing")

    def annoy(self, dice: random.Random) -> None:
        """A peer that does not keep to the protocol."""
        host, port = self.address.rsplit(":", 1)
        nonsense = [b"\x00" * 100, b"{" * 5000 + b"\n", b'{"jsonrpc":"2.0","id":1e999}\n', b"\xff\xfe\n", b"GET / HTTP/1.1\r\n\r\n",
                    b'{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[99]}}\n',
                    b'{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"capabilities":["bin"]}}\n'
                    b'{"jsonrpc":"2.0","id":2,"method":"x","bin":[],"binBytes":100000}\n1234']
        with socket.create_connection((host, int(port)), SECONDS) as peer:
            peer.sendall(dice.choice(nonsense))
            if dice.random() < 0.5:
                peer.settimeout(0.2)
                try:
                    peer.recv(1000)
                except OSError:
                    pass
        self.count("rude peers")
        time.sleep(0.02)

    def keep_growing(self, dice: random.Random) -> None:
        """The simulation that is watched: big enough that viewers fall behind."""
        with Client(self.address, timeout=SECONDS) as client:
            plant = client.create(GROWING.replace("[-(50)F(0.1)]", "[-(50)F(0.1)][&(40)F(1)F(1)F(1)F(1)F(1)F(1)F(1)F(1)]"), seed=3,
                                  environment=[{"type": "honda", "radius": 0.1}], name="watched")
            for _ in range(3):
                for _ in range(38):
                    plant.step()
                    self.count("steps")
                    time.sleep(0.01)
                plant.reset()
            client.call("simulation.delete", {"simulation": plant.identifier})


def resident_bytes(process_id: int) -> int:
    found = re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{process_id}/status").read_text(encoding="ascii"))
    assert found is not None
    return 1024 * int(found.group(1))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    minutes = parser.parse_args().minutes
    seconds = 60.0 * minutes
    with tempfile.TemporaryDirectory() as folder:
        serve = Process([program(), "serve", "--listen", "127.0.0.1:0", "--data", folder, "--log-level", "off",
                         "--allow-spawn", "--limit", "simulations=1000", "--limit", "outboxBytes=8000000"])
        offered = [hosting.open_offer("height", serve.address)]
        threading.Thread(target=hosting.answer_all, args=(hosting.Host(Height), offered[0]), daemon=True).start()
        soak = Soak(serve.address, seconds)
        parts = [soak.grow, soak.grow, soak.cancel, soak.keep_growing, soak.watch, soak.watch, soak.watch, soak.stare, soak.annoy]
        threads = [soak.repeat(part, seed) for seed, part in enumerate(parts)]
        samples: List[int] = []
        begin = time.monotonic()
        shown = 0.0
        while time.monotonic() < soak.end and not soak.failures and serve.process.poll() is None:
            time.sleep(min(2.0, seconds / 60.0))
            samples.append(resident_bytes(serve.process.pid))
            if time.monotonic() - shown > 60.0:
                shown = time.monotonic()
                print(f"{(shown - begin) / 60.0:4.1f} min: {samples[-1] / 1e6:.0f} MB resident; "
                      + ", ".join(f"{number} {what}" for what, number in sorted(soak.counts.items())), flush=True)
        for thread in threads:
            thread.join(2 * SECONDS)
        for channel in offered:
            channel.close()
        if serve.process.poll() is not None:
            soak.failures.append(f"the server ended with {serve.process.poll()}")
        else:
            with Client(serve.address, timeout=SECONDS) as client:
                status = client.status()
            if status["sessions"] > 5 or status["damaged"] != 0:
                soak.failures.append(f"something was left behind: {status}")
            serve.stop()
    # the caches of the first tenth fill up
    steady = samples[len(samples) // 10:] or [0]
    third = max(1, len(steady) // 3)
    early, late = max(steady[:third]), max(steady[-third:])
    print(f"{minutes:g} minutes: " + ", ".join(f"{number} {what}" for what, number in sorted(soak.counts.items())))
    print(f"resident memory: {early / 1e6:.1f} MB at most in the first third, {late / 1e6:.1f} MB in the last; "
          f"median {statistics.median(steady) / 1e6:.1f} MB")
    if late > 1.1 * early + 20e6:
        soak.failures.append("memory grows")
    for failure in soak.failures:
        print(f"soak: {failure}", file=sys.stderr)
    print("soak: FAILED" if soak.failures else "soak: flat and clean")
    return 1 if soak.failures else 0


if __name__ == "__main__":
    sys.exit(main())
