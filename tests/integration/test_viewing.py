"""Plants in a page: self-contained, with the geometry that the program exports."""

import base64
import json
import re
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List, Tuple
from unittest import mock

from support import REPOSITORY, program

import espalier
from espalier import EspalierError, View
from espalier import viewing

FLOAT = 5126
# from a JSON list of frames to a JSON list of .glb files in base64
UNPACK = f"""
import {{ readFrame }} from "{(REPOSITORY / "clients/web/src/view/plant_frames.js").as_uri()}";
import {{ readFileSync }} from "node:fs";
const files = await Promise.all(JSON.parse(readFileSync(0, "utf8")).map(readFrame));
console.log(JSON.stringify(files.map((file) => Buffer.from(file).toString("base64"))));
"""


def parts_of(frame: bytes) -> Tuple[Dict[str, Any], List[List[Tuple[float, ...]]]]:
    """The text of a .glb file, and the numbers of each accessor by component."""
    length, size = struct.unpack_from("<II", frame, 8)
    assert length == len(frame)
    document = json.loads(frame[20:20 + size])
    data = frame[28 + size:]
    numbers = []
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        code = {FLOAT: "f", 5125: "I", 5123: "H", 5121: "B"}[accessor["componentType"]]
        components = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        stride = view.get("byteStride", components * struct.calcsize(code))
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        rows = [struct.unpack_from(f"<{components}{code}", data, start + stride * row) for row in range(accessor["count"])]
        numbers.append(list(zip(*rows)))
    return document, numbers


class Viewing(unittest.TestCase):
    def frames_in(self, page: str) -> List[bytes]:
        """The frames that a page shows, in order, unpacked by the script of the page."""
        found = re.search(r"const frames = (\[.*?\]);\n", page)
        order = re.search(r"(\[[0-9, ]*\])\.map", page)
        assert found is not None and order is not None
        done = subprocess.run(["node", "--input-type=module", "--eval", UNPACK], input=found.group(1), capture_output=True, text=True,
                              timeout=60, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        frames = [base64.b64decode(frame) for frame in json.loads(done.stdout)]
        return [frames[index] for index in json.loads(order.group(1))]

    def assert_same_plant(self, shown: bytes, exact: bytes) -> None:
        """Coordinates within half a step of 14 bits, normals within half a step of 8 bits, all else equal."""
        (found, numbers), (wanted, expected) = parts_of(shown), parts_of(exact)
        self.assertEqual([accessor["count"] for accessor in found["accessors"]], [accessor["count"] for accessor in wanted["accessors"]])
        self.assertEqual((found["nodes"], found["meshes"], found["materials"]), (wanted["nodes"], wanted["meshes"], wanted["materials"]))
        normals = {primitive["attributes"]["NORMAL"] for mesh in wanted["meshes"] for primitive in mesh["primitives"]}
        for index, (now, before) in enumerate(zip(numbers, expected)):
            if wanted["accessors"][index]["componentType"] != FLOAT:
                self.assertEqual(now, before)
                continue
            steps = 255 if index in normals else 16383
            widest = max(max(column) - min(column) for column in before)
            error = max(abs(x - y) for ours, theirs in zip(now, before) for x, y in zip(ours, theirs))
            self.assertLessEqual(error, 0.51 * widest / steps, wanted["accessors"][index])

    def test_shows_a_simulation_with_every_frame_of_its_growth(self) -> None:
        with mock.patch.dict("os.environ", {"ESPALIER_PROGRAM": program()}), espalier.local() as client:
            plant = client.create(gallery="branch-tiers", environment=[{"type": "honda", "radius": 0.5}], seed=7)
            snapshots = []
            for _ in range(3):
                plant.step()
                snapshots.append(plant.save())
            growth = plant.view(snapshots)
            now = plant.view()
        self.assertEqual(len(growth.frames), 3)
        self.assertEqual(growth.frames[-1], now.frames[0])
        self.assertTrue(all(frame[:4] == b"glTF" for frame in growth.frames))
        self.assertLess(len(growth.frames[0]), len(growth.frames[2]))
        page = growth.html()
        for shown, exact in zip(self.frames_in(page), growth.frames):
            self.assert_same_plant(shown, exact)
        # nothing is loaded from elsewhere
        self.assertEqual(re.findall(r'<(?:script|link|img)[^>]+(?:src|href)=', page), [])

    def test_a_page_with_eight_steps_is_small(self) -> None:
        with mock.patch.dict("os.environ", {"ESPALIER_PROGRAM": program()}), espalier.local() as client:
            tree = client.create(gallery="light-tree", seed=7)
            growth = []
            for _ in range(8):
                tree.step()
                growth.append(tree.save())
            small = len(tree.view(growth).html())
            self.assertLess(small, 2_000_000)
            # a state that is shown again costs nothing
            again = tree.view(growth + growth[-1:]).html()
        self.assertLess(len(again), small + 100)
        self.assertEqual(len(self.frames_in(again)), 9)

    def test_writes_a_page_and_fits_a_notebook(self) -> None:
        view = View([b"glTF"], title="a <b> & c", height=123)
        with tempfile.TemporaryDirectory() as folder:
            view.save(Path(folder) / "plant.html")
            page = (Path(folder) / "plant.html").read_text(encoding="utf-8")
        self.assertIn("<title>a &lt;b&gt; &amp; c</title>", page)
        self.assertEqual(page.count("</script"), 1)
        cell = view._repr_html_()
        self.assertIn("height:123px", cell)
        self.assertNotIn('srcdoc="<', cell)

    def test_says_what_is_missing(self) -> None:
        with self.assertRaisesRegex(EspalierError, "at least one frame"):
            View([])
        with mock.patch.object(viewing, "SCRIPTS", (Path("nowhere.js"),)), self.assertRaisesRegex(EspalierError, "install Node.js 18 or newer.*install the package again"):
            View([b"glTF"]).html()


if __name__ == "__main__":
    unittest.main()
