"""Point clouds: read from LAS and PLY, counted in cells, and given to environments."""

import json
import math
import shutil
import struct
import subprocess
import tempfile
import unittest
from array import array
from collections import Counter
from pathlib import Path
from typing import Any, Dict, List, Tuple

import point_files
from las_reader import las_points
from support import REPOSITORY, espalier

READER = REPOSITORY / "tests" / "points"
Cells = Dict[Tuple[int, ...], float]

SEEKER = """Lsystem: 1
derivation length: 1
Axiom: ?E(1,0,0,0,0)
endlsystem
"""


class Points(unittest.TestCase):
    maxDiff = 2000

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name: str, content: bytes) -> Path:
        (self.folder / name).write_bytes(content)
        return self.folder / name

    def field(self, file: Path, name: str, *arguments: str) -> Cells:
        """The numbers of the cells by the whole multiples of their places."""
        raw = self.folder / "field.raw"
        espalier("points", str(file), "--cell-size", "1", "--field", f"{name}={raw}", *arguments)
        header = json.loads(Path(f"{raw}.json").read_text(encoding="utf-8"))
        numbers = array("d", raw.read_bytes())
        first = [round(number) for number in header["position"]]
        across, up = header["cells"][0], header["cells"][1]
        return {(first[0] + i % across, first[1] + i // across % up, first[2] + i // (across * up)): number
                for i, number in enumerate(numbers)}

    def table(self, file: Path) -> Dict[str, List[str]]:
        rows = [line.split("\t") for line in espalier("points", str(file)).stdout.splitlines()]
        self.assertEqual(rows[0], ["property", "value"])
        return {row[0]: row[1:] for row in rows[1:]}

    def refused(self, file: Path, *arguments: str) -> str:
        picture = self.folder / "none.vti"
        run = espalier("points", str(file), "--cell-size", "1", "--field", str(picture), *arguments, status=1)
        self.assertEqual((run.stdout, run.stderr.count("\n")), ("", 1))
        self.assertFalse(picture.exists())
        return run.stderr

    def test_every_version_and_format_gives_the_same_points(self) -> None:
        points = point_files.tree(200)
        expected = [str(len(points))]
        for minor, form in [(2, form) for form in range(4)] + [(3, form) for form in range(6)] + [(4, form) for form in range(11)]:
            file = self.write("a.las", point_files.las(points, minor, form, classes=[2, 5] * 100, extra=minor))
            table = self.table(file)
            self.assertEqual((table["points"], table["class 2"], table["class 5"]), (expected, ["100"], ["100"]), (minor, form))
            for axis in range(3):
                self.assertAlmostEqual(float(table["minimum"][axis]), min(point[axis] for point in points), 9)
                self.assertAlmostEqual(float(table["maximum"][axis]), max(point[axis] for point in points), 9)
        for form in ("ascii", "binary_little_endian", "binary_big_endian"):
            table = self.table(self.write("a.ply", point_files.ply(points, form)))
            self.assertEqual((table["points"], table["unit"]), (expected, ["unknown"]))

    @unittest.skipUnless((READER / "node_modules").is_dir() and shutil.which("node"), "@loaders.gl is not installed: npm ci in tests/points")
    def test_counts_agree_with_a_reader_that_is_not_ours(self) -> None:
        points = point_files.tree(4000)
        for name, content in (("a.las", point_files.las(points, 2, 3)), ("b.las", point_files.las(points, 3, 1)),
                              ("c.ply", point_files.ply(points)), ("d.ply", point_files.ply(points, "binary_big_endian"))):
            file = self.write(name, content)
            text = subprocess.run(["node", str(READER / "count.js"), str(file), "1"], capture_output=True, text=True, check=True, timeout=60)
            theirs: Dict[str, Any] = json.loads(text.stdout)
            counts = self.field(file, "pointCount", "--axes", "file")
            self.assertEqual({",".join(map(str, cell)): count for cell, count in counts.items() if count > 0}, theirs["cells"])
            self.assertEqual(self.table(file)["points"], [str(theirs["points"])])
        # a 1.4 file of the same points, which that reader does not know, has the same counts
        newest = self.field(self.write("e.las", point_files.las(points, 4, 6)), "pointCount", "--axes", "file")
        self.assertEqual(newest, self.field(self.folder / "a.las", "pointCount", "--axes", "file"))

    def test_counts_agree_with_a_reader_of_the_tables_of_las_1_4(self) -> None:
        points = [(x + 0.0005, y + 0.0005, z + 0.0005) for x, y, z in point_files.tree(2000)]
        records = [point_files.record("someone", 1, b"12345")]
        for minor, form in [(2, 3), (3, 5)] + [(4, form) for form in range(11)]:
            content = point_files.las(points, minor, form, classes=[2, 5, 6, 9, 18 if form >= 6 else 31] * 400, withheld=range(0, 2000, 7),
                                      records=records, extra=form)
            file = self.write("a.las", content)
            theirs = [point for point in las_points(content) if not point.isWithheld]
            self.assertEqual(len(theirs), 2000 - 286)
            table = self.table(file)
            self.assertEqual(table["points"], [str(len(theirs))], (minor, form))
            kinds = {f"class {kind}": [str(count)] for kind, count in Counter(point.kind for point in theirs).items()}
            self.assertEqual({name: value for name, value in table.items() if name.startswith("class ")}, kinds, (minor, form))
            cells = Counter(tuple(math.floor(number) for number in point.place) for point in theirs)
            ours = {cell: count for cell, count in self.field(file, "pointCount", "--axes", "file").items() if count > 0}
            self.assertEqual(ours, cells, (minor, form))

    def test_lists_of_vertices_and_elements_before_them_are_passed_over(self) -> None:
        points = point_files.tree(50)
        expected = self.field(self.write("plain.ply", point_files.ply(points, "binary_little_endian")), "pointCount")
        for form in ("ascii", "binary_little_endian", "binary_big_endian"):
            file = self.write("lists.ply", point_files.ply_with_lists(points, form))
            self.assertEqual(self.table(file)["points"], ["50"], form)
            self.assertEqual(self.field(file, "pointCount"), expected, form)

    def test_up_in_the_file_is_up_in_the_world(self) -> None:
        points = [(1.6, 2.7, 7.6), (1.7, 2.8, 7.7), (0.7, 0.7, 0.7)]
        self.assertEqual({cell: count for cell, count in self.field(self.write("a.las", point_files.las(points)), "pointCount").items() if count},
                         {(1, 7, -3): 2, (0, 0, -1): 1})
        self.assertEqual({cell: count for cell, count in self.field(self.write("a.ply", point_files.ply(points)), "pointCount").items() if count},
                         {(1, 2, 7): 2, (0, 0, 0): 1})
        moved = self.field(self.folder / "a.las", "pointCount", "--origin", "1,2,7", "--scale", "2")
        self.assertEqual({cell: count for cell, count in moved.items() if count}, {(1, 1, -2): 2, (-1, -13, 2): 1})

    def test_withheld_points_are_left_out(self) -> None:
        for minor, form in ((2, 1), (4, 6)):
            self.assertEqual(self.table(self.write("a.las", point_files.las([(0, 0, 0), (1, 1, 1)], minor, form, withheld=[1])))["points"], ["1"])
            nothing = self.write("b.las", point_files.las([(0, 0, 0), (1, 1, 1)], minor, form, withheld=[0, 1]))
            self.assertIn("has 2 points, all marked as withheld", self.refused(nothing))

    def test_gaps_and_leaf_area_follow_the_law_of_beer(self) -> None:
        # pulses along a narrow column of cells meet leaves of density a by the law exp(-a G d); the rest end at a wall.
        # the depth of each is a quantile, so P of a cell of edge 1 is exp(-a G) up to 1/n
        density, count = 1.2, 4000
        points = []
        for i in range(count):
            depth = -math.log(1 - (i + 0.5) / count) / (density * 0.5)
            points.append((min(depth, 4.5), 0.5, 0.5))
        file = self.write("a.ply", point_files.ply(points, "binary_little_endian"))
        gaps = self.field(file, "gapFraction", "--scanner", "-0.000001,0.5,0.5")
        leaves = self.field(file, "leafAreaDensity", "--scanner", "-0.000001,0.5,0.5")
        pulses = self.field(file, "pulses", "--scanner", "-0.000001,0.5,0.5")
        for cell in range(4):
            self.assertAlmostEqual(gaps[cell, 0, 0], math.exp(-density * 0.5), 2)
            self.assertAlmostEqual(leaves[cell, 0, 0], density, 1)
            self.assertAlmostEqual(pulses[cell, 0, 0], count * math.exp(-density * 0.5 * cell), delta=1)
        self.assertTrue(math.isnan(leaves[4, 0, 0]), "where all pulses end there is no number")
        # a pulse with two echoes is half a pulse at each
        half = self.write("a.las", point_files.las([(0.5, 0.5, 0.5), (1.5, 0.5, 0.5)], returns=2))
        self.assertEqual(self.field(half, "pulses", "--axes", "file", "--scanner", "-1,0.5,0.5"), {(0, 0, 0): 1, (1, 0, 0): 0.5})
        # points of another class stop pulses and are no leaves
        wall = self.write("b.las", point_files.las([(0.5, 0.5, 0.5), (0.5, 0.5, 0.5)], classes=[2, 5]))
        self.assertEqual(self.field(wall, "gapFraction", "--axes", "file", "--scanner", "-1,0.5,0.5", "--classes", "5"), {(0, 0, 0): 0.5})

    def test_without_the_place_of_the_scanner_leaf_area_is_refused(self) -> None:
        file = self.write("a.las", point_files.las(point_files.tree(40)))
        for name in ("gapFraction", "leafAreaDensity"):
            run = espalier("points", str(file), "--cell-size", "1", "--field", f"{name}={self.folder / 'a.vti'}", status=1)
            self.assertIn("the file does not say where its pulses came from", run.stderr)
        self.assertEqual(espalier("points", str(file), "--field", str(self.folder / "a.vti"), status=1).stderr,
                         "error: give the size of the cells with --cell-size\n")

    def answers(self, configuration: Dict[str, Any]) -> List[float]:
        model = self.write("seeker.l", SEEKER.encode())
        file = self.write("world.json", json.dumps(configuration).encode())
        text = espalier("derive", str(model), "--environment", str(file)).stdout
        return [float(number) for number in text.split("?E(")[1].split(")")[0].split(",")]

    def assert_close(self, found: List[float], expected: List[float]) -> None:
        """A LAS file has whole multiples of its scale, so coordinates differ in the last bits."""
        for one, other in zip(found, expected, strict=True):
            self.assertAlmostEqual(one, other, 12)

    def test_points_are_attractors_markers_and_obstacles(self) -> None:
        self.write("a.las", point_files.las([(0, 0, 2), (0.01, 0, 2.01), (5, 0, 100)], classes=[5, 5, 2]))
        rows = [[0, 2, 0], [0.01, 2.01, 0]]
        chosen = {"pointFile": "a.las", "pointClasses": [5]}
        self.assert_close(self.answers({"type": "attractors", **chosen, "pointStrength": 3}),
                          self.answers({"type": "attractors", "points": [[*row, 3] for row in rows]}))
        markers = self.answers({"type": "colonization", "occupancyRadius": 0.1, **chosen})
        self.assert_close(markers, self.answers({"type": "colonization", "occupancyRadius": 0.1, "points": rows}))
        self.assertEqual((markers[0], markers[4]), (1, 2))
        self.assertEqual(self.answers({"type": "colonization", "occupancyRadius": 0.1, "pointSpacing": 0.5, **chosen})[4], 1)
        solid = self.answers({"type": "obstacles", **chosen, "pointRadius": 0.25})
        self.assert_close(solid, self.answers({"type": "obstacles", "spheres": [[*row, 0.25] for row in rows]}))
        self.assertAlmostEqual(solid[1], 1.75, 12)

    def test_wrong_configurations_are_refused_in_one_sentence(self) -> None:
        self.write("a.las", point_files.las([(0, 0, 2)]))
        self.write("a.ply", point_files.ply([(0, 0, 2)]))
        self.write("far.ply", point_files.ply([(400000, 5600000, 2), (400001, 5600002, 5)]))
        model = self.write("seeker.l", SEEKER.encode())
        for keys, says in (({"pointFile": "none.las"}, "none.las' of the environment 'obstacles': it cannot be read"),
                           ({"pointFile": "a.las"}, "points are solid with a radius. Set 'pointRadius', a length"),
                           ({"pointFile": "a.las", "pointRadius": -1}, "'pointRadius' must be above 0"),
                           ({"pointFile": "a.las", "pointOrigin": [1, 2]}, "'pointOrigin' must be three numbers"),
                           ({"pointFile": "far.ply", "pointRadius": 1}, "its points lie 5614268 from the origin"),
                           ({"pointfile": "a.las"}, "Did you mean 'pointFile'?"),
                           ({"pointFile": "a.las", "pointAxes": "up"}, "'pointAxes' must be \"world\" or \"file\""),
                           ({"pointFile": "a.ply", "pointClasses": [2]}, "it has no classes, so 'pointClasses' cannot choose"),
                           ({"pointFile": "a.las", "pointClasses": [9], "pointRadius": 1}, "no point is left. Choose other classes"),
                           ({"pointFile": "a.las", "pointRadius": 1, "spheres": [[0, 0, 0, 1]]}, "the configuration has 'spheres' too"),
                           ({"type": "height", "pointFile": "a.las"}, "the environment 'height' takes no points")):
            file = self.write("world.json", json.dumps({"type": "obstacles", **keys}).encode())
            run = espalier("derive", str(model), "--environment", str(file), status=1)
            self.assertIn(says, run.stderr)

    def test_damaged_files_are_refused_in_one_sentence(self) -> None:
        whole = point_files.las(point_files.tree(20), 4, 6)
        patched = lambda at, data: whole[:at] + data + whole[at + len(data):]
        for content, says in ((whole[:100], "is cut short: it ends within the header of a LAS file"),
                              (patched(131, struct.pack("<d", 0.0)), "has a scale that is not above 0"),
                              (patched(147, struct.pack("<d", -0.001)), "has a scale that is not above 0"),
                              (whole[:-1], "is cut short: it holds 19 of its 20 points"),
                              (patched(247, struct.pack("<Q", 2 ** 63)), "has 9223372036854775808 points, more than 100000000"),
                              (patched(247, struct.pack("<Q", 90_000_000)), "is cut short: it holds 20 of its 90000000 points"),
                              (patched(96, b"\xff\xff\xff\xff"), "is cut short: it holds 0 of its 20 points"),
                              (patched(94, b"\xff\xff"), "has a header that is too short for its version or longer than the file"),
                              (patched(25, b"\x05"), "is of LAS version 1.5. Give a file of version 1.2, 1.3 or 1.4"),
                              (patched(104, b"\x86"), "is compressed (LAZ). Unpack it to LAS"),
                              (patched(104, b"\x0b"), "has the point format 11. Give a file with a format from 0 to 10"),
                              (patched(105, b"\x0c\x00"), "has points of 12 bytes, and its point format needs 30"),
                              (patched(131, struct.pack("<d", math.nan)), "has a scale or an offset that is no number"),
                              (b"lots of text", "is neither a LAS nor a PLY file"),
                              (b"ply\nformat ascii 1.0\n", "is cut short: its header has no end_header"),
                              (b"ply\nformat text 1.0\nend_header\n", "line 2: the format is not ascii, binary_little_endian"),
                              (b"ply\nformat ascii 1.0\nelement face 1\nend_header\n", "line 4: there is no element 'vertex' with x, y and z"),
                              (b"ply\nformat ascii 1.0\nelement face one\nend_header\n", "line 3: expected one element 'face' with the number of them"),
                              (b"ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "line 3: expected one element 'vertex'"),
                              (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int a\nend_header\n", "line 4: the length of a list has the type 'float'"),
                              (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int\nend_header\n", "line 4: expected 'property TYPE NAME'"),
                              *[(content, "is cut short: it holds 0 of its 2 points") for content in point_files.hostile_plys()],
                              (point_files.ply_with_lists([(1, 2, 3)], "ascii").replace(b"\n2 7 8 1", b"\n-1 7 8 1"), "has a list without a length in line 19"),
                              (point_files.ply_with_lists([(1, 2, 3), (4, 5, 6)], "ascii").replace(b"\n2 7 8 1", b"\n2 8 1"), "has 5 numbers in line 19, and its points have 6"),
                              (point_files.ply_with_lists([(1, 2, 3), (4, 5, 6)], "binary_big_endian")[:-4], "is cut short: it holds 1 of its 2 points"),
                              (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n", "line 4: the type 'half' is unknown"),
                              (b"ply\nformat ascii 1.0\nhello\nend_header\n", "line 3: 'hello' is not expected there"),
                              (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n", "line 5: there is no element 'vertex' with x, y and z"),
                              (point_files.ply([(1, 2, 3)]).replace(b"1 7 2", b"1 7 two"), "has something that is no number in line 12"),
                              (point_files.ply([(1, 2, 3), (4, 5, 6)]).replace(b"1 7 2 3.0", b"1 7 2 3.0 9").replace(b"1 7 2 3\n", b"1 7 2 3 9\n"), "has 5 numbers in line 12, and its points have 4"),
                              (point_files.ply([(1, 2, 3), (4, 5, 6)]).replace(b"1 7 2", b"1 7"), "has 3 numbers in line 12, and its points have 4"),
                              (point_files.ply([(1, 2, 3)]).replace(b"1 7 2", b"1 7 2,5"), "has a comma in line 12. Write decimal points"),
                              (point_files.ply([(1, 2, 3)])[:-3], "is cut short: it holds 0 of its 1 points"),
                              (point_files.ply([(1, 2, 3)], "binary_big_endian")[:-1], "is cut short: it holds 0 of its 1 points"),
                              (point_files.ply([(1, 2, 3)]).replace(b"vertex 1", b"vertex 4000000000"), "has 4000000000 points, more than"),
                              (point_files.ply([(math.inf, 2, 3)], "binary_big_endian"), "has a point that is not finite")):
            self.assertIn(says, self.refused(self.write("bad.las", content)))

    def test_lengths_that_are_no_metres_are_refused(self) -> None:
        points = point_files.tree(8)
        file = self.write("a.las", point_files.las(points, records=[point_files.geo_keys((1024, 1), (3076, 9001))]))
        self.assertEqual(self.table(file)["unit"], ["m"])
        # UTM 33 N with heights above NAVD88, both known by their numbers alone
        named = self.write("named.las", point_files.las(points, records=[point_files.geo_keys((1024, 1), (3072, 32633), (4096, 5703))]))
        self.assertEqual(self.table(named)["unit"], ["m"])
        for records, says in (([point_files.geo_keys((1024, 1), (3076, 9003))], "has lengths in US survey feet (unit 9003"),
                              ([point_files.geo_keys((1024, 1), (3072, 2263))], "has lengths in US survey feet (unit 9003"),
                              ([point_files.geo_keys((1024, 1), (3072, 32633), (4096, 6360))], "has lengths in US survey feet (unit 9003"),
                              ([point_files.geo_keys((1024, 1), (3072, 4326))], "has angles (unit 9122"),
                              ([point_files.geo_keys((1024, 2))], "has coordinates in degrees. Convert it to a projection in metres"),
                              ([point_files.record("LASF_Projection", 2112, b'PROJCS["a",UNIT["US survey foot",0.3048]]')], "has lengths in feet"),
                              ([point_files.record("LASF_Projection", 2112, b'GEOGCS["WGS 84"]')], "has coordinates in degrees")):
            self.assertIn(says, self.refused(self.write("a.las", point_files.las(points, records=records))))

    def test_a_cloud_with_too_many_cells_or_none_is_refused(self) -> None:
        far = self.write("far.ply", point_files.ply([(0, 0, 0), (1e9, 1e9, 1e9)]))
        self.assertIn("the points fill more than 10000000 cells of that size: choose a larger --cell-size", self.refused(far))
        self.assertIn("the file has no points, so there are no cells", self.refused(self.write("none.las", point_files.las([]))))
        plain = self.write("plain.ply", point_files.ply([(0, 0, 0)]))
        self.assertIn("the file has no classes, so --classes cannot choose", self.refused(plain, "--classes", "5"))
        self.assertIn("there is no file 'nowhere.las'", espalier("points", "nowhere.las", status=1).stderr)


if __name__ == "__main__":
    unittest.main()
