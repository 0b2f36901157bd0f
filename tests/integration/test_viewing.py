"""Plants in a page: self-contained, with the geometry that the program exports."""

import base64
import gzip
import json
import re
import tempfile
import unittest
from pathlib import Path
from typing import List
from unittest import mock

from support import program

import espalier
from espalier import EspalierError, View
from espalier import viewing


class Viewing(unittest.TestCase):
    def frames_in(self, page: str) -> List[bytes]:
        """The frames that a page shows, in order."""
        found = re.search(r"const frames = (\[.*?\]);\n.*, (\[.*?\])\.map", page)
        assert found is not None
        frames = [gzip.decompress(base64.b64decode(frame)) for frame in json.loads(found.group(1))]
        return [frames[index] for index in json.loads(found.group(2))]

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
        self.assertEqual(self.frames_in(page), growth.frames)
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
            self.assertLess(small, 8_000_000)
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
        self.assertEqual(page.count("</script"), 2)
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
