"""A viewer of differences holds bitwise the same state as a viewer of whole frames."""

import unittest
from dataclasses import fields
from typing import Any, Dict, List, Optional
from unittest import mock

from support import program

from espalier import Client, Frame, Server, blocks

SECONDS = 20
# growth at every tip and within, organs that disappear, chance
GROWING = """Lsystem: 1
derivation length: 400
Axiom: F(1)A(0)
A(x) : x < 9 --> F(1)[+(ran(90))B(0)]A(x+1)
A(x) : x >= 9 --> F(0.5)A(x-9)
B(x) : x > 5 --> *
B(x) --> F(ran(1))[-(50)C(x)]?E(x)B(x+1)
C(x) : x > 2 --> *
C(x) --> F(0.1)C(x+1)
endlsystem
"""


def bits(frame: Frame) -> Dict[str, Any]:
    """The data of a frame about the plant, with numbers as their bytes."""
    held: Dict[str, Any] = {"step": frame.step, "string": frame.string, "records": [repr(record) for record in frame.records]}
    for name, column in frame.columns.items():
        held[name] = (list(column.shape), bytes(column.tobytes()) if len(column) else b"")
    if frame.geometry is not None:
        held["geometry"] = {one.name: getattr(frame.geometry, one.name) for one in fields(frame.geometry)}
        for name, table in held["geometry"].items():
            if hasattr(table, "tobytes"):
                held["geometry"][name] = (table.tolist(), bytes(table.tobytes()) if len(table) else b"")
    return held


class Differences(unittest.TestCase):
    def setUp(self) -> None:
        server = Server(program(), arguments=["--log-level", "off"])
        self.addCleanup(server.stop)
        self.controller = server.connect(timeout=SECONDS)
        self.addCleanup(self.controller.close)
        self.viewer = server.connect(timeout=SECONDS)
        self.addCleanup(self.viewer.close)
        self.simulation = self.controller.create(GROWING, seed=7, environment=[{"type": "honda", "radius": 0.1}])

    def follow(self, steps: int, **options: Any) -> List[bool]:
        """Follows the growth in both ways, now and then too slowly; which frames were key frames."""
        watched = self.viewer.simulation(self.simulation.identifier)
        with watched.stream(delta=True, credits=2, **options) as differences, \
                watched.stream(delta=False, credits=2, **options) as whole:
            keys: List[bool] = []
            self.assertEqual(bits(differences.read(SECONDS)), bits(whole.read(SECONDS)))
            for step in range(1, steps + 1):
                if step % 10 == 0:
                    # nobody reads: both miss frames, and are shown the latest when they do
                    self.simulation.step(3)
                elif step == steps // 2:
                    self.simulation.reset()
                    self.simulation.step(5)
                else:
                    self.simulation.step()
                now = self.simulation.get("statistics")["step"]
                shown: Optional[Frame] = None
                while shown is None or shown.step != now:
                    shown = differences.read(SECONDS)
                    keys.append(shown.key)
                expected = whole.read(SECONDS)
                while expected.step != now:
                    expected = whole.read(SECONDS)
                self.assertEqual(bits(shown), bits(expected), f"step {now}")
            return keys

    def test_columns(self) -> None:
        keys = self.follow(60, arrays=True)
        self.assertIn(False, keys)

    def test_columns_in_single_precision_of_some_symbols(self) -> None:
        self.follow(40, arrays=True, single=True, symbols=["F", "E"])

    def test_columns_without_numpy(self) -> None:
        from espalier import frames

        with mock.patch.object(blocks, "numpy", None), mock.patch.object(frames, "numpy", None):
            self.follow(25, arrays=True)
            self.follow(25, arrays=True, symbols=["F"])

    def test_records(self) -> None:
        self.follow(40)
        self.follow(20, symbols=["F"], single=True)

    def test_geometry(self) -> None:
        for options in ({}, {"arrays": True}, {"arrays": True, "single": True, "symbols": ["F"]}):
            keys = self.follow(30, what="geometry", columns=True, **options)
            if blocks.numpy is not None:
                self.assertIn(False, keys, options)

    def test_strings(self) -> None:
        self.follow(60, what="string")


class Queries(unittest.TestCase):
    def follow(self, client: Client, **options: Any) -> List[Frame]:
        simulation = client.create("Lsystem: 1\nderivation length: 3\nAxiom: F(2)A?E(0.5)\nA --> F(1)A\nendlsystem\n",
                                   environment=[{"type": "height"}])
        with simulation.stream("queries", **options) as stream:
            simulation.step(2)
            return [stream.read(SECONDS) for _ in range(3)]

    def test_they_come_after_the_model_was_compiled_anew(self) -> None:
        with Server(program(), arguments=["--log-level", "off"]) as server, server.connect(timeout=SECONDS) as client:
            simulation = client.create("Lsystem: 1\n#define HIGH 3\nderivation length: 9\nAxiom: F(HIGH)A?E(0)\n"
                                       "A > ?E(h) --> F(HIGH)A\nendlsystem\n", environment=[{"type": "height"}])
            with simulation.stream("queries", credits=None) as stream:
                simulation.step()
                simulation.set({"HIGH": 5})
                simulation.step()
                frame = stream.read(SECONDS)
                while frame.step != 2:
                    frame = stream.read(SECONDS)
                self.assertEqual([query["position"] for query in frame.queries], [[0, 6, 0]])

    def test_what_a_step_asked_and_was_answered(self) -> None:
        with Server(program(), arguments=["--log-level", "off"]) as server, server.connect(timeout=SECONDS) as client:
            first, second, third = self.follow(client)
            self.assertEqual((list(first.queries), list(first.replies)), ([], []))
            self.assertEqual([query["position"] for query in second.queries], [[0, 2, 0]])
            self.assertEqual(second.queries[0]["parameters"], [0.5])
            self.assertEqual(list(second.replies), [{"id": 0, "parameters": [2]}])
            self.assertEqual(list(third.replies), [{"id": 0, "parameters": [3]}])
            # the same in blocks, and nothing of other symbols
            frame = self.follow(client, arrays=True)[2]
            self.assertEqual(frame.count, 1)
            self.assertEqual(frame.columns["position"].tolist(), [[0, 3, 0]])
            self.assertEqual((frame.columns["replies"].tolist(), frame.columns["set"].tolist()), ([3], [1]))
            self.assertEqual(self.follow(client, arrays=True, symbols=["F"])[2].count, 0)


if __name__ == "__main__":
    unittest.main()
