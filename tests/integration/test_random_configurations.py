"""No configuration that a schema allows ends the server, stays without an answer, or makes a state that its snapshot
does not hold."""

import json
import os
import random
import time
import unittest
from typing import Any, Dict, List, Optional

import random_configurations
from support import program

from espalier import Client, ConnectionLost, Server, ServerError

CALL_SECONDS = 3
LIMITS = ["--limit", f"callSeconds={CALL_SECONDS}", "--limit", "memoryBytes=600000000", "--workers", "2",
          "--log-level", "off"]
INTERNAL = -32603
# the time that an answer may take: the seconds of its call, on a machine with other work
PATIENCE = 30.0


def answer(client: Client, method: str, parameters: Dict[str, Any]) -> Optional[Any]:
    """The answer, or nothing when it is an error that says what is wrong."""
    try:
        return client.call(method, parameters)
    except ServerError as error:
        if error.code == INTERNAL:
            raise AssertionError(f"{method} answers {error}") from error
        return None


def hash_after_steps(client: Client, simulation: str, steps: int) -> Optional[str]:
    """Nothing when a step fails, or the server has no memory for the state."""
    if answer(client, "simulation.step", {"simulation": simulation, "steps": steps}) is None:
        return None
    found = answer(client, "simulation.get", {"simulation": simulation, "what": "state-hash"})
    return str(found["stateHash"]) if found else None


class RandomConfigurations(unittest.TestCase):
    def test_a_hundred_configurations(self) -> None:
        self.run_configurations(seed=1, most=100, seconds=20.0)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes minutes: ./dev test --all long")
    def test_long_thousands_of_configurations(self) -> None:
        self.run_configurations(seed=int(time.time()), most=1_000_000, seconds=300.0)

    def run_configurations(self, *, seed: int, most: int, seconds: float) -> None:
        draw = random.Random(seed)
        end = time.monotonic() + seconds
        stepped = 0
        with Server(program(), arguments=LIMITS) as server, server.connect(timeout=PATIENCE) as client:
            processes: List[Any] = client.call("environment.list")["environments"]
            for number in range(most):
                if time.monotonic() > end:
                    break
                configuration = random_configurations.configuration(draw, draw.choice(processes))
                case = {"model": random_configurations.model(draw), "seed": 1, "environment": [configuration],
                        "world": random_configurations.world(draw), "save": False}
                with self.subTest(seed=seed, number=number):
                    try:
                        stepped += self.run_case(client, case)
                    except (AssertionError, ConnectionLost, ServerError) as error:
                        raise AssertionError(f"{error}; seed {seed}, {json.dumps(case)}") from error
        self.assertGreater(stepped, 0)

    def run_case(self, client: Client, case: Dict[str, Any]) -> int:
        """Steps, and steps the snapshot of the middle. Returns whether the configuration was accepted and stepped."""
        created = answer(client, "simulation.create", case)
        if created is None:
            return 0
        simulation = created["simulation"]
        try:
            if hash_after_steps(client, simulation, 2) is None:
                return 0
            saved = answer(client, "simulation.save", {"simulation": simulation})
            expected = hash_after_steps(client, simulation, 1)
            # a snapshot that does not fit into the memory of the server is refused
            restored = saved and answer(client, "simulation.restore",
                                        {"simulation": simulation, "snapshot": saved["snapshot"]})
            found = hash_after_steps(client, simulation, 1) if restored else None
            if expected is not None and found is not None:
                self.assertEqual(found, expected, "a restored simulation goes on otherwise")
            return 1
        finally:
            client.call("simulation.delete", {"simulation": simulation})
