"""Quantities in space as files: written by a run, read again by `espalier field`."""

import json
import struct
import tempfile
import unittest
from pathlib import Path
from typing import List

from support import GALLERY, espalier, model, program, stdio


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

    def test_every_variant_has_its_files(self) -> None:
        table = self.folder / "water.csv"
        self.grow("--variants", "2", "--field", f"waterContent={table}", "--field", str(self.folder / "water.vti"),
                  "--quiet")
        self.assertEqual(sorted(path.name for path in self.folder.glob("water*")),
                         ["water-001.csv", "water-001.vti", "water-002.csv", "water-002.vti"])
        for variant in (1, 2):
            rows = self.rows((self.folder / f"water-00{variant}.csv").read_text(encoding="utf-8"), ",")
            self.assertEqual([row[0] for row in rows], ["step", "0", "1", "2", "3", "4", "5"])

    def test_a_run_begins_with_the_field_of_another(self) -> None:
        self.grow("--field", str(self.folder / "water.vti"), "--field", f"waterContent={self.folder / 'first.csv'}",
                  "--quiet")
        soil = json.loads((GALLERY / "roots-in-soil" / "roots-in-soil.json").read_text(encoding="utf-8"))
        later = self.folder / "later.json"
        later.write_text(json.dumps({**soil, "fieldFile": "water.vti"}), encoding="utf-8")
        self.grow("--environment", str(later), "--field", f"waterContent={self.folder / 'second.csv'}", "--quiet")
        first, second = (self.rows((self.folder / f"{name}.csv").read_text(encoding="utf-8"), ",")
                         for name in ("first", "second"))
        # the water of the end is there at the beginning; the heads of the file are its state, to the solver's tolerance
        self.assertAlmostEqual(float(second[1][4]), float(first[-1][4]), 5)
        self.assertGreater(float(second[1][4]) - float(first[1][4]), 1e-3)
        # contradictions are said
        later.write_text(json.dumps({**soil, "fieldFile": "water.vti", "gridSize": [4, 4, 1]}), encoding="utf-8")
        self.assertIn("its 'gridSize' is [40,25,1], and the configuration has [4,4,1]",
                      self.grow("--environment", str(later), status=1))

    def test_an_environment_that_runs_apart_writes_its_fields_where_it_runs(self) -> None:
        soil = str(GALLERY / "roots-in-soil" / "roots-in-soil.json")
        self.grow("--field", f"waterContent={self.folder / 'inside.csv'}", "--field", str(self.folder / "inside.vti"),
                  "--quiet")
        apart = [program(), "environment", "soil-water", "--configuration", soil, "--stdio", "--field",
                 f"waterContent={self.folder / 'apart.csv'}", "--field", str(self.folder / "apart.vti")]
        self.grow("--environment", stdio(apart), "--quiet")
        for suffix in ("csv", "vti"):
            self.assertEqual((self.folder / f"apart.{suffix}").read_bytes(),
                             (self.folder / f"inside.{suffix}").read_bytes())
        self.grow("--environment", stdio([*apart, "--every"]), "--quiet")
        self.assertEqual(len(list(self.folder.glob("apart-*.vti"))), 6)
        # what it cannot write fails the step
        said = self.grow("--environment", stdio([*apart[:-1], str(self.folder / "no" / "a.vti")]), "--quiet", status=1)
        self.assertIn("could not write its fields of step", said)

    def test_what_cannot_be_written_or_read_is_said(self) -> None:
        said = self.grow("--field", "x.txt", status=2)
        self.assertIn("--field x.txt: a field is written as .vti, .raw, .png or .csv; choose one of these", said)
        self.assertIn("make the other file by `python3 -m espalier.fields FILE.vti OUT.nc`", self.grow("--field", "x.nc", status=2))
        self.assertIn("there is no view 'q': write x, y or z for the mean along an axis, or z:0.5 for a slice",
                      self.grow("--field", "water@q=x.png", status=2))
        self.assertIn("there is no field 'sugar'. There are: waterContent, pressureHead",
                      self.grow("--field", f"sugar={self.folder / 'x.png'}", status=1))
        self.assertIn("'waterContent' reaches from -0.025 to 0.025 along z: choose a slice there",
                      self.grow("--field", f"waterContent@z:3={self.folder / 'x.png'}", status=1))
        self.assertIn("the environment holds no quantity in space: choose one that does, such as soil-water",
                      espalier("run", model("branch-tiers"), "--steps", "1", "-o", str(self.folder / "a.svg"), "--field",
                               str(self.folder / "x.vti"), status=1).stderr)
        self.assertIn("there is no file 'nowhere.vti'", espalier("field", "nowhere.vti", status=1).stderr)
        broken = self.folder / "broken.vti"
        broken.write_text("<VTKFile>", encoding="utf-8")
        self.assertIn("broken.vti: the file is no VTK image data file (.vti) with cell data. `python3 -m",
                      espalier("field", str(broken), status=1).stderr)
        lonely = self.folder / "lonely.raw"
        lonely.write_bytes(b"")
        self.assertIn("there is no header", espalier("field", str(lonely), status=1).stderr)


if __name__ == "__main__":
    unittest.main()
