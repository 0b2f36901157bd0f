"""A server that is killed at any moment, or whose disk is full, loses nothing that it has answered."""

import os
import random
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Dict, List

from support import Process, program

from espalier import Client, ConnectionLost, Server, ServerError

LAST = 400
# each step depends on everything before it: random draws, and an environment with many queries
GROWING = """Lsystem: 1
derivation length: 400
Axiom: A(0)
A(x) --> F(ran(1))?E(0.5)[+(ran(90))B(x)]A(x+1)
B(x) : x > 3 --> *
B(x) --> F(ran(1))B(x+1)
endlsystem
"""
WALKING = """Lsystem: 1
derivation length: 400
Axiom: A(0.5)
A(x) --> A(ran(1) + x/2)
endlsystem
"""


def state_hash(client: Client, simulation: str) -> str:
    return str(client.call("simulation.get", {"simulation": simulation, "what": "state-hash"})["stateHash"])


def step_of(client: Client, simulation: str) -> int:
    return int(client.call("simulation.get", {"simulation": simulation, "what": "statistics"})["step"])


def create_all(client: Client) -> List[str]:
    names = []
    for seed in range(4):
        environment = [{"type": "honda", "radius": 0.1}] if seed % 2 == 0 else None
        names.append(client.create(GROWING if seed % 2 == 0 else WALKING, seed=seed, environment=environment).identifier)
    return names


def uninterrupted() -> List[List[str]]:
    """The state after every step of each simulation, of a server that nobody kills."""
    with Server(program(), arguments=["--log-level", "off"]) as server, server.connect(timeout=60) as client:
        hashes = []
        for simulation in create_all(client):
            made = [state_hash(client, simulation)]
            for _ in range(LAST):
                client.call("simulation.step", {"simulation": simulation})
                made.append(state_hash(client, simulation))
            hashes.append(made)
        return hashes


class NothingLost(unittest.TestCase):
    def kill_again_and_again(self, rounds: int, seconds: float) -> int:
        """Kills a server under load until either is over; returns how often."""
        expected = uninterrupted()
        dice = random.Random(7)
        begin = time.monotonic()
        killed = 0
        with tempfile.TemporaryDirectory() as folder:
            arguments = ["--data", folder, "--log-level", "off"]
            server = Server(program(), arguments=arguments)
            with server.connect(timeout=60) as client:
                names = create_all(client)
            while killed < rounds or time.monotonic() - begin < seconds:
                answered: Dict[str, int] = {}
                with server.connect(timeout=60) as client:
                    for name in names:
                        if step_of(client, name) >= LAST:
                            client.call("simulation.reset", {"simulation": name})
                        answered[name] = step_of(client, name)
                count = threading.Semaphore(0)

                def load(name: str) -> None:
                    try:
                        with server.connect(timeout=60) as own:
                            while answered[name] < LAST:
                                answered[name] = int(own.call("simulation.step", {"simulation": name})["step"])
                                count.release()
                    except (ConnectionLost, ServerError):
                        pass
                    finally:
                        for _ in range(LAST):
                            count.release()

                threads = [threading.Thread(target=load, args=(name,)) for name in names]
                for thread in threads:
                    thread.start()
                # some answers later, while the others are anywhere
                for _ in range(dice.randrange(1, 200)):
                    count.acquire()
                os.kill(server.process_id, 9)
                killed += 1
                for thread in threads:
                    thread.join()
                server.stop()
                server = Server(program(), arguments=arguments)
                with server.connect(timeout=60) as client:
                    for index, name in enumerate(names):
                        step = step_of(client, name)
                        self.assertIn(step, (answered[name], answered[name] + 1), f"{name} after kill {killed}")
                        self.assertEqual(state_hash(client, name), expected[index][step], f"{name} at step {step}")
            server.stop()
        return killed

    def test_killed_at_any_moment_it_loses_at_most_the_step_it_was_in(self) -> None:
        self.assertGreaterEqual(self.kill_again_and_again(rounds=5, seconds=0), 5)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes minutes: ./dev test --all")
    def test_long_killed_for_minutes_it_loses_at_most_the_step_it_was_in(self) -> None:
        seconds = float(os.environ.get("ESPALIER_KILL_SECONDS", "180"))
        killed = self.kill_again_and_again(rounds=10, seconds=seconds)
        print(f"killed {killed} times")

    def test_a_full_disk_fails_steps_and_the_server_lives(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            # no file of the server may be larger than 256 KiB
            serve = Process(["bash", "-c", f"ulimit -f 256; exec '{program()}' serve --listen 127.0.0.1:0 "
                                           f"--data '{folder}' --log-level off"])
            self.addCleanup(serve.stop)
            with Client(serve.address, timeout=60) as client:
                simulation = client.create("Lsystem: 1\nderivation length: 30\nAxiom: A(1)\n"
                                           "A(x) --> A(ran(1))A(ran(1))\nendlsystem\n", seed=1)
                with self.assertRaises(ServerError) as caught:
                    client.call("simulation.run", {"simulation": simulation.identifier})
                self.assertEqual(caught.exception.code, 1014)
                self.assertIn("is complete, but the data folder", str(caught.exception))
                step = step_of(client, simulation.identifier)
                self.assertEqual(caught.exception.data["step"], step)
                self.assertGreater(step, 3)
                self.assertEqual(client.status()["simulations"], 1)
            self.assertEqual(sorted(entry.name for entry in Path(folder).iterdir())[0], "espalier.sqlite")
            serve.stop()
            # with room again it is where it was saved last
            with Server(program(), arguments=["--data", folder, "--log-level", "off"]) as server:
                with server.connect(timeout=60) as client:
                    self.assertIn(step_of(client, simulation.identifier), (step - 1, step))
                    client.call("simulation.step", {"simulation": simulation.identifier})


if __name__ == "__main__":
    unittest.main()
