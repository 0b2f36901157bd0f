"""Quantities in space as files: written by a run, read again by `espalier field`."""

import json
import struct
import tempfile
import unittest
from pathlib import Path
from typing import List

from support import espalier, model


class Fields(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def grow(self, *arguments: str, status: int = 0) -> str:
        """Runs a model with soil for a few days; what it says."""
        return espalier("run", model("roots-in-soil"), "--seed", "1", "--steps", "5", "-o",
                        str(self.folder / "roots.png"), *arguments, status=status).stderr

    def rows(self, text: str, separator: str) -> List[List[str]]:
        return [line.split(separator) for line in text.splitlines()]

    def test_a_field_is_written_and_read_again_in_every_format(self) -> None:
        vti, raw, png = (self.folder / f"water.{suffix}" for suffix in ("vti", "raw", "png"))
        said = self.grow("--field", str(vti), "--field", f"pressureHead={raw}", "--field", f"waterContent@z={png}")
        self.assertIn(f"wrote {vti} (waterContent, pressureHead)", said)
        self.assertIn("dark blue 0 to yellow", said, "stones hold no water")
        self.assertEqual(png.read_bytes()[:4], b"\x89PNG")
        header = json.loads((self.folder / "water.raw.json").read_text(encoding="utf-8"))
        self.assertEqual(header["cells"], [40, 25, 1])
        heads = struct.unpack("<1000d", raw.read_bytes())
        table = self.rows(espalier("field", str(vti)).stdout, "\t")
        self.assertEqual([row[0] for row in table], ["field", "waterContent", "pressureHead"])
        self.assertEqual(table[2][1:3], ["m", "40x25x1"])
        self.assertAlmostEqual(float(table[2][3]), min(heads), 12)
        self.assertEqual(self.rows(espalier("field", str(raw)).stdout, "\t")[1], table[2])
        # a slice of what was read is the picture that was written
        again = self.folder / "again.png"
        espalier("field", str(vti), "--quiet", "--field", f"waterContent@z={again}")
        self.assertEqual(again.read_bytes(), png.read_bytes())

    def test_a_table_has_a_row_for_each_step_and_water_is_kept_in_it(self) -> None:
        table = self.folder / "water.csv"
        self.grow("--field", f"waterContent={table}", "--quiet")
        rows = self.rows(table.read_text(encoding="utf-8"), ",")
        self.assertEqual(rows[0], ["step", "field", "unit", "minimum", "mean", "maximum", "integral"])
        self.assertEqual([row[0] for row in rows[1:]], ["0", "1", "2", "3", "4", "5"])
        # two millimetres of rain a day on 2 m by 5 cm, less what the roots take, which is little
        water = [float(row[6]) for row in rows[1:]]
        for before, after in zip(water, water[1:]):
            self.assertAlmostEqual((after - before) / (0.002 * 2 * 0.05), 1.0, delta=0.1)

    def test_every_step_has_its_file(self) -> None:
        self.grow("--every", "--field", str(self.folder / "water.vti"), "--quiet")
        self.assertEqual(len(list(self.folder.glob("water-*.vti"))), 6)

    def test_what_cannot_be_written_or_read_is_said(self) -> None:
        said = self.grow("--field", "x.txt", status=2)
        self.assertIn("--field x.txt: a field is written as .vti, .raw, .png or .csv; choose one of these", said)
        self.assertIn("there is no view 'q': write x, y or z for the mean along an axis, or z:0.5 for a slice",
                      self.grow("--field", "water@q=x.png", status=2))
        self.assertIn("there is no field 'sugar'. There are: waterContent, pressureHead",
                      self.grow("--field", f"sugar={self.folder / 'x.png'}", status=1))
        self.assertIn("'waterContent' reaches from -0.025 to 0.025 along z: choose a slice there",
                      self.grow("--field", f"waterContent@z:3={self.folder / 'x.png'}", status=1))
        self.assertIn("the environment holds no quantity in space",
                      espalier("run", model("branch-tiers"), "--steps", "1", "-o", str(self.folder / "a.svg"), "--field",
                               str(self.folder / "x.vti"), status=1).stderr)
        self.assertIn("there is no field file", espalier("field", "nowhere.vti", status=1).stderr)
        broken = self.folder / "broken.vti"
        broken.write_text("<VTKFile>", encoding="utf-8")
        self.assertIn("broken.vti: the file is no VTK image data file with cell data",
                      espalier("field", str(broken), status=1).stderr)
        lonely = self.folder / "lonely.raw"
        lonely.write_bytes(b"")
        self.assertIn("there is no header", espalier("field", str(lonely), status=1).stderr)


if __name__ == "__main__":
    unittest.main()
