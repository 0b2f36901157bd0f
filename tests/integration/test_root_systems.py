"""Root systems in files: read as plants, written, and measured."""

import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Dict, Tuple

from support import espalier, model

TABLE = """node	parent	x	y	z	radius	order
0	-1	0	0	0	0.1	1
1	0	0.1	-1	0	0.1	1
2	1	0.3	-2	0.1	0.1	1
3	2	0.3	-3.5	0.2	0.08	1
4	1	1.25	-1.5	0.4	0.05	2
5	4	2.25	-1.75	0.9	0.05	2
6	2	-0.7	-2.5	0.1	0.04	2
"""


class RootSystems(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.table = self.folder / "roots.tsv"
        self.table.write_text(TABLE, encoding="utf-8")

    def traits(self, *arguments: str) -> Dict[Tuple[str, str], float]:
        lines = espalier("traits", *arguments).stdout.splitlines()
        self.assertEqual(lines[0], "trait\torder\tvalue")
        return {(name, order): float(value) for name, order, value in (line.split("\t") for line in lines[1:])}

    def test_a_table_is_a_plant_and_is_written_as_rsml(self) -> None:
        expected = self.traits(str(self.table))
        self.assertEqual((expected["number", "1"], expected["number", "2"]), (1, 2))
        self.assertEqual(expected["magnitude", ""], 3)
        rsml = self.folder / "written.rsml"
        espalier("run", "--from", str(self.table), "-o", str(rsml))
        for file in (rsml, self.table):
            picture = self.folder / "again.rsml"
            espalier("run", str(file), "-o", str(picture))
            for found in (self.traits(str(file)), self.traits(str(picture))):
                self.assertEqual(found.keys(), expected.keys())
                for name, value in expected.items():
                    self.assertAlmostEqual(found[name], value, 9, msg=str(name))

    def test_a_file_that_is_read_and_written_again_is_identical(self) -> None:
        files = [self.folder / name for name in ("one.rsml", "two.rsml")]
        espalier("run", str(self.table), "-o", str(files[0]))
        espalier("run", str(files[0]), "-o", str(files[1]))
        self.assertEqual(*(file.read_bytes() for file in files))
        # an independent reader finds the numbers of the table, digit by digit
        points = {tuple(point.get(axis) for axis in "xyz") for point in ElementTree.parse(files[1]).iter("point")}
        rows = [line.split("\t") for line in TABLE.splitlines()[1:]]
        self.assertEqual(points, {tuple(row[2:5]) for row in rows})

    def test_days_of_emergence_are_an_animation(self) -> None:
        days = (0, 0, 1, 3, 2, 4, 4)
        lines = TABLE.splitlines()
        self.table.write_text("\n".join([lines[0] + "\temergence"] + [f"{line}\t{day}" for line, day in zip(lines[1:], days)]) + "\n",
                              encoding="utf-8")
        espalier("run", str(self.table), "--every", "-o", str(self.folder / "day.rsml"), "--quiet")
        for day in range(5):
            tree = ElementTree.parse(self.folder / f"day-{day:04d}.rsml")
            self.assertEqual(tree.findtext("metadata/time-sequence/index"), str(day))
            segments = sum(len(line.findall("point")) - 1 for line in tree.iter("polyline"))
            self.assertEqual(segments, sum(1 for emerged in days[1:] if emerged <= day))
        # ages at the end are those of the file
        text = espalier("derive", str(self.table)).stdout
        self.assertEqual(sorted(float(part.split(",")[0]) for part in text.split("?E(")[1:]), sorted(4.0 - day for day in days[1:]))

    def test_a_unit_that_is_none_is_refused(self) -> None:
        rsml = self.folder / "far.rsml"
        rsml.write_text("<rsml><metadata><unit>parsec</unit></metadata><scene/></rsml>", encoding="utf-8")
        picture = self.folder / "far.png"
        run = espalier("run", str(rsml), "-o", str(picture), status=1)
        self.assertIn("the unit 'parsec' is unknown. Write one of m, dm, cm, mm, um, inch, pixel, or unknown", run.stderr)
        self.assertFalse(picture.exists())

    def test_roots_from_a_file_take_up_water(self) -> None:
        xylem = self.folder / "xylem.json"
        xylem.write_text('{"type": "xylem", "collar": "head", "collarHead": -5, "soilHead": -1, "kx": 0.001, "kr": 0.001}',
                         encoding="utf-8")
        text = espalier("derive", str(self.table), "--environment", str(xylem)).stdout
        queries = [part.split(")")[0].split(",") for part in text.split("?E(")[1:]]
        self.assertEqual(len(queries), 6)
        uptake = sum(float(query[4]) for query in queries)
        self.assertGreater(uptake, 0)
        self.assertAlmostEqual(uptake / float(queries[0][6]), 1, 9)

    def test_models_have_traits_too(self) -> None:
        traits = self.traits(model("roots-in-soil"), "--seed", "1", "--steps", "10")
        self.assertGreater(traits["magnitude", ""], 2)
        self.assertGreater(traits["length", ""], 0)

    def test_leaves_of_a_model_have_area_index_and_angles(self) -> None:
        # on a stalk of 3 a level and an upright square of side 1
        leaves = self.folder / "leaves.l"
        leaves.write_text("Lsystem: 1\nderivation length: 1\nAxiom: F(3)[/(90)&(90){.f(1).+(90)f(1).+(90)f(1).}]"
                          "[{.f(1).+(90)f(1).+(90)f(1).}]\nendlsystem\n", encoding="utf-8")
        traits = self.traits(str(leaves), "--ground", "4")
        self.assertEqual(traits["leaf_number", ""], 2)
        self.assertAlmostEqual(traits["leaf_area_index", ""], 0.5, 9)
        self.assertAlmostEqual(traits["leaf_inclination", ""], 45, 5)
        self.assertAlmostEqual(traits["leaf_angle", "5"], 0.5, 9)
        self.assertAlmostEqual(traits["leaf_angle", "85"], 0.5, 9)
        self.assertAlmostEqual(traits["crown_base", ""], 3, 9)
        self.assertAlmostEqual(traits["crown_top", ""], 4, 9)

    def test_wrong_files_are_named_with_their_line(self) -> None:
        self.table.write_text(TABLE.replace("6\t2", "6\t6"), encoding="utf-8")
        for command in (("traits", str(self.table)), ("derive", str(self.table))):
            self.assertIn("line 8: the node 6 is its own ancestor", espalier(*command, status=1).stderr)
        self.assertIn("there is no file 'none.rsml'", espalier("traits", "none.rsml", status=1).stderr)


if __name__ == "__main__":
    unittest.main()
