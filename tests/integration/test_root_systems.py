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
        self.assertEqual(lines[0], "trait\torder\tvalue\tunit")
        return {(name, order): float(value) for name, order, value, _ in (line.split("\t") for line in lines[1:])}

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

    def test_traits_say_their_units(self) -> None:
        def units(*arguments: str) -> Dict[str, str]:
            return {line.split("\t")[0]: line.split("\t")[3] for line in espalier("traits", *arguments).stdout.splitlines()[1:]}

        counts = {"number": "1", "magnitude": "1", "altitude": "1", "path_length": "1"}
        lengths = ("length", "mean_length", "diameter", "height", "width")
        for file, unit in ((self.written_in("mm"), "mm"), (self.written_in("unknown"), "length"), (self.table, "length")):
            self.assertEqual(units(str(file)), {**counts, **dict.fromkeys(lengths, unit)})
        world = self.folder / "world.json"
        world.write_text('{"lengthUnit": "cm"}', encoding="utf-8")
        found = units(model("lilac"), "--steps", "3", "--world", str(world))
        self.assertEqual((found["leaf_area"], found["leaf_inclination"], found["crown_top"]), ("cm^2", "degree", "cm"))
        self.assertEqual(units(model("lilac"), "--steps", "3")["length"], "m")

    def test_traits_of_a_file_are_those_in_the_world(self) -> None:
        rsml = self.folder / "upright.rsml"
        rsml.write_text("""<rsml><metadata><unit>cm</unit></metadata><scene><plant ID="1"><root ID="1"><geometry><polyline>
<point x="0" y="0" z="0"/><point x="3" y="0" z="-20"/></polyline></geometry></root></plant></scene></rsml>""", encoding="utf-8")
        world = self.folder / "world.json"
        world.write_text('{"lengthUnit": "mm", "up": [0, 0, 1], "north": [0, 1, 0]}', encoding="utf-8")
        for arguments, height, width in (((), 0, 20), (("--up", "z"), 20, 3), (("--world", str(world)), 200, 30),
                                         (("--world", str(world), "--up", "x"), 30, 200)):
            found = self.traits(str(rsml), *arguments)
            self.assertEqual((found["height", ""], found["width", ""]), (height, width), msg=str(arguments))
        self.assertIn("width\t\t30\tmm", espalier("traits", str(rsml), "--world", str(world)).stdout)
        self.assertIn("height\t\t", espalier("traits", str(self.table), "--world", str(world)).stdout)
        rsml.write_text(rsml.read_text(encoding="utf-8").replace("cm", "pixel"), encoding="utf-8")
        self.assertIn("its lengths in 'pixel' cannot be converted to those of the world in 'mm'",
                      espalier("traits", str(rsml), "--world", str(world), status=1).stderr)

    def test_roots_without_a_diameter_do_not_take_up_water_by_hairlines(self) -> None:
        self.table.write_text("node\tparent\tx\ty\tz\n0\t-1\t0\t0\t0\n1\t0\t0\t-10\t0\n", encoding="utf-8")
        xylem = self.folder / "xylem.json"
        xylem.write_text('{"type": "xylem", "collar": "head"}', encoding="utf-8")
        run = espalier("derive", str(self.table), "--steps", "2", "--environment", str(xylem), status=1)
        self.assertIn("has no width. Give the key 'radius', draw roots with a width, or give a file of roots their diameters",
                      " ".join(run.stderr.split()))
        xylem.write_text('{"type": "xylem", "collar": "head", "radius": 0.0005}', encoding="utf-8")
        espalier("derive", str(self.table), "--steps", "2", "--environment", str(xylem))

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
        espalier("run", str(self.table), "--every", "-o", str(self.folder / "day-%04d.rsml"), "--quiet")
        for day in range(5):
            tree = ElementTree.parse(self.folder / f"day-{day:04d}.rsml")
            self.assertEqual(tree.findtext("metadata/time-sequence/index"), str(day))
            segments = sum(len(line.findall("point")) - 1 for line in tree.iter("polyline"))
            self.assertEqual(segments, sum(1 for emerged in days[1:] if emerged <= day))
        # ages at the end are those of the file
        text = espalier("derive", str(self.table)).stdout
        self.assertEqual(sorted(float(part.split(",")[0]) for part in text.split("?E(")[1:]), sorted(4.0 - day for day in days[1:]))

    def write_with_days(self, days: Tuple[int, ...]) -> None:
        lines = TABLE.splitlines()
        self.table.write_text("\n".join([lines[0] + "\temergence"] + [f"{line}\t{day}" for line, day in zip(lines[1:], days)]) + "\n",
                              encoding="utf-8")

    def test_growth_in_one_file_is_read_and_written_again_identically(self) -> None:
        days = (0, 0, 1, 3, 2, 4, 4)
        self.write_with_days(days)
        files = [self.folder / name for name in ("one.rsml", "two.rsml")]
        espalier("run", str(self.table), "--every", "-o", str(files[0]))
        espalier("run", str(files[0]), "--every", "-o", str(files[1]))
        self.assertEqual(*(file.read_bytes() for file in files))
        # an independent reader finds the day of each point
        found = set()
        for root in ElementTree.parse(files[0]).iter("root"):
            points = root.findall("geometry/polyline/point")
            samples = root.findall("functions/function[@name='emergence_time']/sample")
            self.assertEqual(len(points), len(samples))
            found |= {(tuple(point.get(axis) for axis in "xyz"), sample.get("value")) for point, sample in zip(points[1:], samples[1:])}
        rows = [line.split("\t") for line in TABLE.splitlines()[1:]]
        self.assertEqual(found, {(tuple(row[2:5]), str(day)) for row, day in list(zip(rows, days))[1:]})
        # with steps of half a day the file has days
        espalier("run", str(self.table), "--every", "--step-duration", "12 h", "-o", str(files[1]))
        values = {sample.get("value") for sample in ElementTree.parse(files[1]).findall(".//function[@name='emergence_time']/sample")}
        self.assertEqual(values, {"0", "0.5", "1", "1.5", "2"})

    def test_days_that_begin_late_stay_as_they_are(self) -> None:
        self.write_with_days((3, 3, 4, 6, 5, 7, 7))
        files = [self.folder / name for name in ("one.rsml", "two.rsml")]
        espalier("run", str(self.table), "--every", "-o", str(files[0]))
        espalier("run", str(files[0]), "--every", "-o", str(files[1]))
        for file in files:
            values = {sample.get("value") for sample in ElementTree.parse(file).findall(".//function[@name='emergence_time']/sample")}
            self.assertEqual(values, {"3", "4", "5", "6", "7"})
        self.assertEqual(*(file.read_bytes() for file in files))

    def test_a_time_series_of_files_is_an_animation(self) -> None:
        self.write_with_days((0, 0, 1, 3, 2, 4, 4))
        whole, again = self.folder / "whole.rsml", self.folder / "again.rsml"
        espalier("run", str(self.table), "--every", "-o", str(whole))
        series = str(self.folder / "day-%04d.rsml")
        espalier("run", str(self.table), "--every", "-o", series)
        espalier("run", series, "--every", "-o", str(again))
        self.assertEqual(again.read_bytes(), whole.read_bytes())
        percent = self.folder / "50%.rsml"
        percent.write_bytes(whole.read_bytes())
        espalier("run", str(percent), "--every", "-o", str(again))
        self.assertEqual(again.read_bytes(), whole.read_bytes())
        first = self.folder / "day-0000.rsml"
        first.write_text(first.read_text().replace("<unit>unknown</unit>", "<unit>cm</unit>"))
        self.assertIn("the files have different units: 'cm' and ''. Write all in one unit", espalier("run", series, "-o", str(again), status=1).stderr)
        self.assertIn("and none with another number", espalier("run", str(self.folder / "no-%d.rsml"), "-o", str(again), status=1).stderr)

    def test_the_number_of_a_file_of_a_series_is_its_day(self) -> None:
        self.write_with_days((0, 0, 1, 3, 2, 4, 4))
        espalier("run", str(self.table), "--every", "-o", str(self.folder / "day-%04d.rsml"))
        for day, number in ((4, 25), (3, 17), (2, 15), (1, 11), (0, 10)):  # scans of some days
            (self.folder / f"day-{day:04d}.rsml").rename(self.folder / f"day-{number:04d}.rsml")
        (self.folder / "day-16.rsml").write_text("no file of the series")
        again = self.folder / "again.rsml"
        espalier("run", str(self.folder / "day-%04d.rsml"), "--every", "-o", str(again))
        days = sorted(float(sample.get("value", "")) for sample in ElementTree.parse(again).findall(".//function[@name='emergence_time']/sample"))
        self.assertEqual(sorted(set(days)), [0, 1, 5, 7, 15])

    def test_a_root_without_a_diameter_is_written_and_measured_without_one(self) -> None:
        rsml, again = self.folder / "thin.rsml", self.folder / "again.rsml"
        points = '<geometry><polyline><point x="{}" y="-1"/><point x="1" y="-2"/></polyline></geometry>'
        rsml.write_text("<rsml><metadata><unit>\u00b5m</unit></metadata><scene><plant><root>" + points.format(0) + "<root>" + points.format(2) +
                        '<functions><function name="diameter"><sample value="0.25"/></function></functions></root></root></plant></scene></rsml>',
                        encoding="utf-8")
        run = espalier("run", str(rsml), "-o", str(again))
        self.assertEqual(run.stderr.count("warning"), 0, run.stderr)
        for file in (rsml, again):
            traits = self.traits(str(file))
            self.assertEqual(traits["diameter", "2"], 0.25)
            self.assertNotIn(("diameter", "1"), traits)
        self.assertEqual(ElementTree.parse(again).findtext("metadata/unit"), "um")
        self.assertEqual(len(ElementTree.parse(again).findall(".//function")), 1)

    def test_a_file_without_roots_is_no_plant(self) -> None:
        rsml, picture = self.folder / "none.rsml", self.folder / "none.png"
        rsml.write_text("<rsml><scene><plant/></scene></rsml>", encoding="utf-8")
        self.assertIn("it has no roots", espalier("run", str(rsml), "-o", str(picture), status=1).stderr)
        self.assertFalse(picture.exists())
        wrong = self.written_in("cm")
        for number in ("77", "-3", "0.5"):
            wrong.write_text(wrong.read_text().replace('parent-node value="1"', f'parent-node value="{number}"'))
            right = espalier("traits", str(self.written_in("mm"))).stdout.replace("\tmm\n", "\tcm\n")
            done = espalier("traits", str(wrong))
            self.assertIn(f"names a point that is not there: line 6 has the parent-node {number}, and the parent has the points 0 to 2",
                          " ".join(done.stderr.split()))
            self.assertEqual(done.stdout, right)
            wrong = self.written_in("cm")

    def test_many_days_are_an_animation_too_and_what_are_no_days_is_said(self) -> None:
        self.write_with_days((0, 0, 1, 3, 2, 4, 20_000))
        text = espalier("check", str(self.table)).stdout
        self.assertIn("no errors", text)
        self.assertIn("W(1,", espalier("derive", str(self.table), "--steps", "19999").stdout)
        self.write_with_days((0, 0, 1, 3, 2, 4, 86_400_000))
        picture = self.folder / "late.png"
        run = espalier("run", str(self.table), "-o", str(picture), status=1)
        self.assertIn("the times of emergence span 86400000 days, and an animation has a step a day, at most 1000000", run.stderr)
        self.assertFalse(picture.exists())

    def written_in(self, unit: str) -> Path:
        """A hand-made file: a root of 40 with a lateral of 10, in lengths of a unit."""
        file = self.folder / f"hand-{unit}.rsml"
        file.write_text(f"""<?xml version="1.0"?>
<rsml xmlns:po="http://www.plantontology.org/xml-dtd/po.dtd"><metadata><version>1</version><unit>{unit}</unit><resolution>1</resolution>
<last-modified>2026-01-01</last-modified><software>by hand</software><user>nobody</user><file-key>1</file-key></metadata>
<scene><plant ID="1" label="barley"><root ID="1.1" label="primary" po:accession="PO:0020127"><geometry><polyline><point x="0" y="0"/>
<point x="0" y="-20"/><point x="0" y="-40"/></polyline></geometry><functions><function domain="polyline" name="diameter"><sample>2</sample>
<sample>2</sample><sample>1</sample></function></functions><root ID="1.1.1"><properties><parent-node value="1"/></properties><geometry><polyline>
<point x="0" y="-20"/><point x="10" y="-20"/></polyline></geometry></root></root></plant></scene></rsml>""", encoding="utf-8")
        return file

    def test_lengths_come_in_the_unit_of_the_world_or_make_it(self) -> None:
        again = self.folder / "again.rsml"
        for unit in ("mm", "cm", "inch", "pixel", "unknown"):
            espalier("run", str(self.written_in(unit)), "-o", str(again))
            tree = ElementTree.parse(again)
            self.assertEqual(tree.findtext("metadata/unit"), unit)
            self.assertEqual([point.get("y") for point in tree.iter("point")], ["0", "-20", "-40", "-20", "-20"])
            once = again.read_bytes()
            espalier("run", str(again), "-o", str(self.folder / "twice.rsml"))
            self.assertEqual((self.folder / "twice.rsml").read_bytes(), once)
        # a world says the unit of everything
        world = self.folder / "world.json"
        world.write_text('{"lengthUnit": "cm"}', encoding="utf-8")
        for unit, last in (("mm", "-4"), ("cm", "-40"), ("m", "-4000"), ("inch", "-101.6"), ("unknown", "-40")):
            espalier("run", str(self.written_in(unit)), "--world", str(world), "-o", str(again))
            tree = ElementTree.parse(again)
            self.assertEqual(tree.findtext("metadata/unit"), "cm")
            self.assertEqual([point.get("y") for point in tree.iter("point")][2], last)
        # a model takes a file in its own unit, metres unless a world says another
        draws = self.folder / "draws.l"
        draws.write_text("Lsystem: 1\nderivation length: 0\nAxiom: @M(0,0,0)@R(1,0,0)!(1)F(1)?E(0,0,0,0,0,0,0,0,0,0)\nendlsystem\n", encoding="utf-8")
        run = espalier("derive", str(draws), "--from", str(self.written_in("cm")))
        self.assertIn("its lengths in cm are converted to those of the world in m", run.stderr)
        self.assertIn("!(0.02)F(0.2)", run.stdout)

    def test_a_length_of_unknown_size_is_refused_in_a_world_of_metres(self) -> None:
        world = self.folder / "world.json"
        world.write_text('{"lengthUnit": "cm"}', encoding="utf-8")
        picture = self.folder / "pixel.png"
        run = espalier("run", str(self.written_in("pixel")), "--world", str(world), "-o", str(picture), status=1)
        self.assertIn("its lengths in 'pixel' cannot be converted to those of the world in 'cm'. Write its lengths in m, dm", run.stderr)
        self.assertFalse(picture.exists())

    def test_a_unit_that_is_none_is_refused(self) -> None:
        rsml = self.folder / "far.rsml"
        rsml.write_text("<rsml><metadata><unit>parsec</unit></metadata><scene/></rsml>", encoding="utf-8")
        picture = self.folder / "far.png"
        run = espalier("run", str(rsml), "-o", str(picture), status=1)
        self.assertIn("the unit 'parsec' is unknown. Write one of m, dm, cm, mm, um, nm, inch, pixel, or unknown", run.stderr)
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
