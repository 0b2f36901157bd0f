"""Geometry for environments: read whole and as differences, from text and from blocks."""

import unittest
from typing import Any, ClassVar, Dict, List, Sequence, Tuple
from unittest import mock

from espalier import Answer, Environment, Geometry, ProtocolError, Query, blocks, geometry, hosting, wire

WHOLE: Dict[str, Any] = {
    "form": "whole", "widths": "world", "symbols": ["F", "L"],
    "segmentPlant": [0, 0], "segmentModule": [0, 1], "segmentSymbol": [0, 0], "segmentColour": [128, 128],
    "segmentOrder": [0, 0], "segmentStart": [[0, 0, 0], [0, 1, 0]], "segmentEnd": [[0, 1, 0], [0, 2, 0]],
    "segmentStartWidth": [0.5, 0.25], "segmentEndWidth": [0.25, 0.25],
    "organPlant": [0, 0], "organModule": [4, 9], "organSymbol": [1, 1], "organColour": [3, 4], "organOrder": [1, 1],
    "organKind": [1, 2], "organVertices": [3, 4], "organTriangles": [1, 2],
    "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [5, 0, 0], [6, 0, 0], [6, 1, 0], [5, 1, 0]],
    "triangles": [[0, 1, 2], [0, 1, 2], [0, 2, 3]]}
# the second segment moved, a leaf fell, the other's module is 3 further back, and there is a new one before it
DIFFERENCE: Dict[str, Any] = {
    "form": "difference", "widths": "world", "symbols": ["G", "L"],
    "segmentRuns": [[0, 1, 0], [4294967295, 1, 0]], "organRuns": [[4294967295, 1, 0], [1, 1, 4294967293]],
    "segmentPlant": [0], "segmentModule": [1], "segmentSymbol": [0], "segmentColour": [128], "segmentOrder": [0],
    "segmentStart": [[0, 1, 0]], "segmentEnd": [[0, 2, 1]], "segmentStartWidth": [0.25], "segmentEndWidth": [0.25],
    "organPlant": [0], "organModule": [3], "organSymbol": [1], "organColour": [9], "organOrder": [2],
    "organKind": [4], "organVertices": [3], "organTriangles": [1], "vertices": [[7, 7, 7], [8, 7, 7], [8, 8, 7]],
    "triangles": [[0, 1, 2]]}


class Watcher(Environment):
    """Answers how many triangles there are, and keeps what it saw."""

    needs = ("parameters", "geometry")
    seen: ClassVar[List[Any]] = []

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        assert self.geometry is not None
        self.seen.append(self.geometry)
        return [[len(self.geometry.triangles)] for _ in queries]


def step(shape: Dict[str, Any], number: int) -> wire.Message:
    return wire.request(number, "environment.step", {"simulation": "s1", "step": number, "iteration": 0, "time": 0,
                                                     "geometry": shape, "queries": [{"id": 0, "symbol": "E"}]})


class Reading(unittest.TestCase):
    def test_the_whole_has_indices_among_all_vertices(self) -> None:
        for numpy in {None, blocks.numpy}:
            with mock.patch.object(geometry, "numpy", numpy):
                found = geometry.read_geometry(WHOLE, {}, None)
                self.assertEqual(found.symbols, ("F", "L"))
                self.assertFalse(found.are_widths_pixels)
                self.assertEqual(found.segment_module.tolist(), [0, 1])
                self.assertEqual(found.segment_end.tolist(), [[0, 1, 0], [0, 2, 0]])
                self.assertEqual(found.vertex_offset.tolist(), [0, 3, 7])
                self.assertEqual(found.triangle_offset.tolist(), [0, 1, 3])
                self.assertEqual(found.triangles.tolist(), [[0, 1, 2], [3, 4, 5], [3, 5, 6]])

    def test_no_geometry_at_all(self) -> None:
        empty = {name: [] if isinstance(value, list) else value for name, value in WHOLE.items()}
        for numpy in {None, blocks.numpy}:
            with mock.patch.object(geometry, "numpy", numpy):
                found = geometry.read_geometry(empty, {}, None)
                self.assertEqual(len(found.triangles), 0)
                self.assertEqual(found.vertex_offset.tolist(), [0])

    @unittest.skipIf(blocks.numpy is None, "NumPy is not installed")
    def test_a_difference_goes_on_from_the_one_before(self) -> None:
        before = geometry.read_geometry(WHOLE, {}, None)
        found = geometry.read_geometry(DIFFERENCE, {}, before)
        self.assertEqual(found.symbols, ("F", "L", "G"))
        self.assertEqual(found.segment_symbol.tolist(), [0, 2])
        self.assertEqual(found.segment_end.tolist(), [[0, 1, 0], [0, 2, 1]])
        self.assertEqual(found.organ_module.tolist(), [3, 6])
        self.assertEqual(found.organ_colour.tolist(), [9, 4])
        self.assertEqual(found.vertex_offset.tolist(), [0, 3, 7])
        self.assertEqual(found.vertices.tolist(), [[7, 7, 7], [8, 7, 7], [8, 8, 7], *WHOLE["vertices"][3:]])
        self.assertEqual(found.triangles.tolist(), [[0, 1, 2], [3, 4, 5], [3, 5, 6]])
        # nothing before it is left
        gone = {**DIFFERENCE, "segmentRuns": [[4294967295, 1, 0]], "organRuns": [[4294967295, 1, 0]]}
        self.assertEqual(len(geometry.read_geometry(gone, {}, before).triangles), 1)

    @unittest.skipIf(blocks.numpy is None, "NumPy is not installed")
    def test_a_wrong_difference_is_refused(self) -> None:
        before = geometry.read_geometry(WHOLE, {}, None)
        for runs, words in (([[1, 2, 0], [4294967295, 1, 0]], "a run of segments goes beyond"),
                            ([[0, 2, 0]], "the runs do not take all new segments")):
            with self.assertRaisesRegex(ProtocolError, words):
                geometry.read_geometry({**DIFFERENCE, "segmentRuns": runs}, {}, before)
        with self.assertRaisesRegex(ProtocolError, "no geometry came before it"):
            geometry.read_geometry(DIFFERENCE, {}, None)

    def test_wrong_shapes_are_refused_with_their_place(self) -> None:
        wrong: List[Tuple[Dict[str, Any], str]] = [
            ({"form": "part"}, r"params\.geometry\.form: expected whole or difference"),
            ({"symbols": 3}, r"params\.geometry\.symbols: expected a list of texts"),
            ({"vertices": [[0, 0]]}, r"params\.geometry\.vertices\[0\]: expected 3 numbers"),
            ({"organKind": ["x"]}, r"params\.geometry\.organKind\[0\]: expected a number"),
            ({"segmentEnd": None}, r"params\.geometry\.segmentEnd: expected a list")]
        for change, words in wrong:
            with self.assertRaisesRegex(ProtocolError, words):
                geometry.read_geometry({**WHOLE, **change}, {}, None)
        with self.assertRaisesRegex(ProtocolError, r"bin\.segmentPlant: the block is missing"):
            geometry.read_geometry(WHOLE, {"plant": memoryview(b"")}, None)


class Hosting(unittest.TestCase):
    def setUp(self) -> None:
        Watcher.seen.clear()
        self.host = hosting.Host(Watcher)
        self.host.handle(wire.request(1, "environment.open", {"simulation": "s1"}))

    def answer(self, message: wire.Message) -> Dict[str, Any]:
        answered = self.host.handle(message)
        assert answered is not None
        return answered

    def test_says_how_it_takes_geometry(self) -> None:
        self.assertEqual(Watcher.description()["geometry"], "whole" if blocks.numpy is None else "difference")
        self.assertNotIn("geometry", Environment.description())

    @unittest.skipIf(blocks.numpy is None, "NumPy is not installed")
    def test_the_environment_sees_all_of_it_in_every_step(self) -> None:
        self.assertEqual(self.answer(step(WHOLE, 0))["result"]["replies"][0]["parameters"], [3])
        self.assertIn("result", self.answer(step(DIFFERENCE, 1)))
        self.assertEqual([len(one.segment_plant) for one in Watcher.seen], [2, 2])
        self.assertEqual(Watcher.seen[1], geometry.read_geometry(DIFFERENCE, {}, Watcher.seen[0]))
        self.assertNotEqual(Watcher.seen[1], Watcher.seen[0])
        self.assertIsInstance(Watcher.seen[0], Geometry)

    def test_a_wrong_geometry_is_answered_with_its_path(self) -> None:
        error = self.answer(step({**WHOLE, "form": 1}, 0))["error"]
        self.assertEqual((error["code"], error["data"]["path"]), (-32602, "params.geometry.form"))


if __name__ == "__main__":
    unittest.main()
