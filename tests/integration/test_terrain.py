"""Terrain: heights of a GeoTIFF as a field and as the ground of environments, against gdal's own readers."""

import json
import shutil
import struct
import subprocess
import tempfile
import unittest
from array import array
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

from support import espalier

Heights = List[List[float]]
LIBRARY = any(Path(folder, "libgeotiff.so.5").exists() for folder in ("/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib"))
WEST, NORTH, STEP = 400_000.0, 5_600_000.0, 2.0
PROBE = """Lsystem: 1
derivation length: 1
Axiom: @M(X,Y,Z)?E(1,0)
endlsystem
"""


def hills(columns: int = 8, rows: int = 5) -> Heights:
    """Heights of quarters, so that single precision holds them; the first row is the northern one."""
    return [[100 + 0.25 * ((7 * column + 3 * row * row) % 11) for column in range(columns)] for row in range(rows)]


def geotiff(heights: Heights, keys: Sequence[Tuple[int, int]] = ((1024, 1), (1025, 1), (3076, 9001)), is_placed: bool = True,
            items: bytes = b"", no_data: bytes = b"", tile: int = 0) -> bytes:
    """An uncompressed GeoTIFF of 32-bit reals by the pages of TIFF 6.0 and OGC 19-008r4: one strip, or the beginning of one tile."""
    rows, columns = len(heights), len(heights[0])
    data = b"".join(struct.pack(f"<{columns}f", *row) for row in heights)
    entries: List[Tuple[int, int, bytes]] = [  # tag, type, values
        (256, 4, struct.pack("<I", columns)), (257, 4, struct.pack("<I", rows)), (258, 3, struct.pack("<H", 32)), (259, 3, struct.pack("<H", 1)),
        (262, 3, struct.pack("<H", 1)), (273, 4, struct.pack("<I", 8)), (277, 3, struct.pack("<H", 1)), (278, 4, struct.pack("<I", rows)),
        (279, 4, struct.pack("<I", len(data))), (339, 3, struct.pack("<H", 3))]
    if tile:
        entries = [entry for entry in entries if entry[0] not in (273, 278, 279)] + [
            (322, 4, struct.pack("<I", tile)), (323, 4, struct.pack("<I", tile)), (324, 4, struct.pack("<I", 8)), (325, 4, struct.pack("<I", len(data)))]
    if is_placed:
        entries += [(33550, 12, struct.pack("<3d", STEP, STEP, 0)), (33922, 12, struct.pack("<6d", 0, 0, 0, WEST, NORTH, 0))]
    entries.append((34735, 3, struct.pack("<4H", 1, 1, 0, len(keys)) + b"".join(struct.pack("<4H", key, 0, 1, value) for key, value in keys)))
    if items:
        entries.append((42112, 2, b"<GDALMetadata>" + items + b"</GDALMetadata>\0"))
    if no_data:
        entries.append((42113, 2, no_data + b"\0"))
    entries.sort()
    sizes = {2: 1, 3: 2, 4: 4, 12: 8}
    directory, values = b"", b""
    start = 8 + len(data)
    behind = start + 2 + 12 * len(entries) + 4
    for tag, kind, content in entries:
        directory += struct.pack("<HHI", tag, kind, len(content) // sizes[kind])
        if len(content) <= 4:
            directory += content.ljust(4, b"\0")
        else:
            directory += struct.pack("<I", behind + len(values))
            values += content
    return struct.pack("<2sHI", b"II", 42, start) + data + struct.pack("<H", len(entries)) + directory + struct.pack("<I", 0) + values


def with_image(file: bytes, columns: int, rows: int, data: bytes, bits: int = 1, kind: int = 4) -> bytes:
    """A file of one image with another behind it; the kinds are those of TIFF 6.0: 4 a mask, 1 an overview, 5 the mask of one."""
    start = struct.unpack_from("<I", file, 4)[0]
    link = start + 2 + 12 * struct.unpack_from("<H", file, start)[0]
    entries = ((254, 4, kind), (256, 4, columns), (257, 4, rows), (258, 3, bits), (259, 3, 1), (262, 3, 4 if kind & 4 else 1), (273, 4, len(file)),
               (277, 3, 1), (278, 4, rows), (279, 4, len(data)))
    directory = b"".join(struct.pack("<HHI", tag, kind, 1) + struct.pack("<I" if kind == 4 else "<Hxx", value) for tag, kind, value in entries)
    return (file[:link] + struct.pack("<I", len(file) + len(data)) + file[link + 4:] + data +
            struct.pack("<H", len(entries)) + directory + struct.pack("<I", 0))


@unittest.skipUnless(LIBRARY, "libgeotiff5 is not installed")
class Terrain(unittest.TestCase):
    maxDiff = 2000

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name: str, content: bytes) -> Path:
        (self.folder / name).write_bytes(content)
        return self.folder / name

    def heights(self, file: Path) -> Tuple[Heights, Dict[str, Any]]:
        """The heights that we read, the northern row first, and the header of the field."""
        raw = self.folder / "heights.raw"
        espalier("field", str(file), "--field", f"height={raw}")
        header = json.loads(Path(f"{raw}.json").read_text(encoding="utf-8"))
        numbers = array("d", raw.read_bytes())
        columns = header["cells"][0]
        rows = [list(numbers[from_:from_ + columns]) for from_ in range(0, len(numbers), columns)]
        return rows[::-1], header

    def gdal(self, *words: str) -> str:
        return subprocess.run(words, capture_output=True, text=True, check=True, timeout=60, cwd=self.folder).stdout

    def answer(self, configuration: Dict[str, Any], x: float, y: float, z: float) -> List[float]:
        model = self.write("probe.l", PROBE.replace("X", repr(x)).replace("Y", repr(y)).replace("Z", repr(z)).encode())
        file = self.write("world.json", json.dumps(configuration).encode())
        text = espalier("derive", str(model), "--environment", str(file)).stdout
        return [float(number) for number in text.split("?E(")[1].split(")")[0].split(",")]

    def test_a_file_made_by_hand_is_read_number_by_number(self) -> None:
        file = self.write("hills.tif", geotiff(hills()))
        found, header = self.heights(file)
        self.assertEqual(found, hills())
        self.assertEqual((header["cells"], header["cellSize"][:2], header["position"][:2], header["unit"]),
                         ([8, 5, 1], [STEP, STEP], [WEST, NORTH - 5 * STEP], "m"))
        # of a number that belongs to a point the place is that of the point
        points = self.write("points.tif", geotiff(hills(), ((1024, 1), (1025, 2), (3076, 9001))))
        self.assertEqual(self.heights(points)[1]["position"][:2], [WEST - STEP / 2, NORTH - 5 * STEP + STEP / 2])

    def test_heights_have_the_scale_and_the_offset_of_the_file(self) -> None:
        items = b'<Item name="OFFSET" sample="0" role="offset">10</Item><Item name="SCALE" sample="0" role="scale">0.5</Item>'
        found, _ = self.heights(self.write("scaled.tif", geotiff(hills(), items=items)))
        self.assertEqual(found, [[0.5 * height + 10 for height in row] for row in hills()])

    def refusal(self, content: bytes) -> str:
        """The message about a file, in one line."""
        run = espalier("field", str(self.write("bad.tif", content)), status=1)
        self.assertEqual((run.stdout, run.stderr.count("error: ")), ("", 1))
        return " ".join(run.stderr.split())

    def test_no_data_is_found_as_the_file_rounds_it(self) -> None:
        greatest = 3.4028234663852886e38  # of 32 bits
        for text, number in ((b"-3.4028235e+38", -greatest), (b"-3.4028234663852886e+38", -greatest), (b"-1.7976931348623157e+308", -greatest),
                             (b"-1e400", -greatest), (b"-3.402823e+38", -3.402823e38), (b"-3.4e+38", -3.4e38), (b"1e20", 1e20), (b"+1e20", 1e20),
                             (b" 1e20", 1e20), (b"1e-30", 1e-30), (b"1e-400", 0.0), (b"-32767.1", -32767.1), (b"-9999.9", -9999.9), (b"-9999", -9999),
                             (b"nan", float("nan")), (b"inf", float("inf"))):
            holes = hills()
            holes[1][2] = number
            self.assertIn("has 1 of 40 cells without a height. Fill them", self.refusal(geotiff(holes, no_data=text)), text)
            # the number of another file says nothing about this one
            self.assertEqual(self.heights(self.write("whole.tif", geotiff(hills(), no_data=text)))[0], hills(), text)

    def test_cells_that_a_mask_leaves_out_have_no_height(self) -> None:
        # a row of 8 cells is a byte
        self.assertIn("has 3 of 40 cells without a height: its mask leaves them out. Write a number in place of the mask with gdalwarp -dstnodata -9999",
                      self.refusal(with_image(geotiff(hills()), 8, 5, b"\x7f\xff\xff\xff\xfc")))
        self.assertIn("has 2 of 40 cells without a height", self.refusal(with_image(geotiff(hills()), 8, 5, b"\1" * 38 + b"\0\0", bits=8)))
        # a row of 9 cells is two bytes
        self.assertIn("has 1 of 45 cells without a height", self.refusal(with_image(geotiff(hills(9)), 9, 5, b"\xff\x80" * 4 + b"\xff\0")))
        # a mask with all cells, an overview, and the mask of an overview leave nothing out
        whole = with_image(geotiff(hills()), 8, 5, b"\xff" * 5)
        self.assertEqual(self.heights(self.write("whole.tif", whole))[0], hills())
        seen = with_image(geotiff(hills()), 4, 3, b"\1" * 12, bits=8, kind=1)
        self.assertEqual(self.heights(self.write("seen.tif", seen))[0], hills())
        seen = with_image(geotiff(hills()), 4, 3, b"\0" * 3, kind=5)
        self.assertEqual(self.heights(self.write("seen.tif", seen))[0], hills())
        self.assertIn("has a mask of a kind that is not read. Write it without one: gdalwarp -dstnodata -9999",
                      self.refusal(with_image(geotiff(hills()), 4, 3, b"\xff" * 3)))
        self.assertIn("is damaged or cut short", self.refusal(whole[:-20]))
        # images in a circle
        start = struct.unpack_from("<I", whole, 4)[0]
        link = start + 2 + 12 * struct.unpack_from("<H", whole, start)[0]
        self.assertIn("is damaged or cut short", self.refusal(whole[:link] + struct.pack("<I", start) + whole[link + 4:]))

    def test_the_unit_of_the_band_must_be_the_metre(self) -> None:
        for unit in (b"", b" ", b"m", b"metre", b"meter", b"Metres"):
            items = b'<Item name="UNITTYPE" sample="0" role="unittype">' + unit + b"</Item>"
            self.assertEqual(self.heights(self.write("metres.tif", geotiff(hills(), items=items)))[0], hills())
        for unit in ("ft", "cm", "US survey foot", "mm"):
            items = b'<Item name="UNITTYPE" sample="0" role="unittype">' + unit.encode() + b"</Item>"
            self.assertIn(f"has heights in '{unit}', not in metres. If gdalwarp has converted them already, say so with gdal_edit.py -units m. "
                          "Else convert them, as with gdal_calc.py --calc=A*0.3048 for feet", self.refusal(geotiff(hills(), items=items)))
        odd = self.refusal(geotiff(hills(), items=b'<Item role="unittype">\x1b' + b"f" * 50 + b"</Item>"))
        self.assertIn("has heights in '?" + "f" * 39 + "', not", odd)

    def test_blocks_that_were_never_written_have_no_height(self) -> None:
        whole = geotiff(hills())
        for tag, value in ((273, 8), (279, 160)):
            whole = whole.replace(struct.pack("<HHII", tag, 4, 1, value), struct.pack("<HHII", tag, 4, 1, 0))
        self.assertIn("has 40 of 40 cells without a height. Fill them", self.refusal(whole))
        tiled = geotiff(hills(16, 16), tile=16)
        self.assertEqual(self.heights(self.write("tiled.tif", tiled))[0], hills(16, 16))
        for tag, value in ((324, 8), (325, 1024)):
            tiled = tiled.replace(struct.pack("<HHII", tag, 4, 1, value), struct.pack("<HHII", tag, 4, 1, 0))
        self.assertIn("has 256 of 256 cells without a height. Fill them", self.refusal(tiled))
        self.assertIn("has tiles that are too large (16384 x 16384): write it again with gdal_translate", self.refusal(geotiff(hills(), tile=16384)))

    @unittest.skipUnless(shutil.which("gdal_translate"), "gdal-bin is not installed")
    def test_gdal_writes_masks_and_sparse_files_so(self) -> None:
        holes = hills(70, 50)
        holes[3][5] = holes[40][69] = 0.0
        self.write("holes.tif", geotiff(holes))
        self.gdal("gdal_translate", "-q", "-mask", "1", "--config", "GDAL_TIFF_INTERNAL_MASK", "YES", "holes.tif", "masked.tif")
        self.assertIn("has 2 of 3500 cells without a height", self.refusal((self.folder / "masked.tif").read_bytes()))
        # as the advice says
        self.gdal("gdalwarp", "-q", "-dstnodata", "-9999", "masked.tif", "marked.tif")
        self.assertIn("has 2 of 3500 cells without a height", self.refusal((self.folder / "marked.tif").read_bytes()))
        self.write("north.tif", geotiff([[-9999.0] * 64] * 32 + hills(64, 32)))
        self.gdal("gdal_translate", "-q", "-a_nodata", "-9999", "-co", "TILED=YES", "-co", "BLOCKXSIZE=32", "-co", "BLOCKYSIZE=32", "-co", "SPARSE_OK=TRUE",
                  "north.tif", "sparse.tif")
        self.assertIn("has 2048 of 4096 cells without a height", self.refusal((self.folder / "sparse.tif").read_bytes()))

    def test_a_system_known_by_its_number_gives_the_unit(self) -> None:
        # UTM 33 N has metres; New York Long Island, alone or with heights of its own, has US survey feet
        self.assertEqual(self.heights(self.write("utm.tif", geotiff(hills(), ((1024, 1), (1025, 1), (3072, 32633)))))[1]["unit"], "m")
        # heights in metres above NAVD88; then in US survey feet
        self.assertEqual(self.heights(self.write("navd88.tif", geotiff(hills(), ((1024, 1), (3072, 32633), (4096, 5703)))))[1]["unit"], "m")
        for keys in (((1024, 1), (3072, 2263)), ((1024, 1), (3072, 2263), (4096, 6360)), ((1024, 1), (3072, 32633), (4096, 6360))):
            run = espalier("field", str(self.write("feet.tif", geotiff(hills(), keys))), status=1)
            self.assertIn("has lengths in US survey feet (unit 9003", run.stderr)

    @unittest.skipUnless(shutil.which("gdalinfo") and shutil.which("gdal_translate"), "gdal-bin is not installed")
    def test_gdal_agrees(self) -> None:
        file = self.write("hills.tif", geotiff(hills(70, 50)))
        told = json.loads(self.gdal("gdalinfo", "-json", "-stats", "hills.tif"))
        self.assertEqual(told["size"], [70, 50])
        found, header = self.heights(file)
        self.assertEqual([header["position"][0], header["position"][1] + 50 * STEP], told["cornerCoordinates"]["upperLeft"])
        flat = [height for row in found for height in row]
        self.assertEqual((min(flat), max(flat)), (told["bands"][0]["minimum"], told["bands"][0]["maximum"]))
        self.assertAlmostEqual(sum(flat) / len(flat), told["bands"][0]["mean"], 3)
        # other ways to write the same numbers; gdal writes each, and its list of heights is the judge
        for options in (("-co", "COMPRESS=DEFLATE", "-co", "PREDICTOR=3"), ("-co", "TILED=YES", "-co", "BLOCKXSIZE=32", "-co", "BLOCKYSIZE=16"),
                        ("-ot", "Float64", "-co", "COMPRESS=LZW"), ("-ot", "Int16"), ("-ot", "Byte"), ("-co", "ENDIANNESS=BIG"),
                        ("-ot", "UInt32", "-co", "TILED=YES", "-co", "BLOCKXSIZE=16", "-co", "BLOCKYSIZE=16", "-co", "COMPRESS=ZSTD"), ("-co", "BIGTIFF=YES")):
            self.gdal("gdal_translate", "-q", *options, "hills.tif", "other.tif")
            self.gdal("gdal_translate", "-q", "-of", "XYZ", "other.tif", "heights.xyz")
            rows = [tuple(float(word) for word in line.split()) for line in (self.folder / "heights.xyz").read_text().splitlines()]
            other, _ = self.heights(self.folder / "other.tif")
            self.assertEqual([height for row in other for height in row], [row[2] for row in rows], options)

    def test_the_ground_is_an_obstacle_where_it_lies(self) -> None:
        self.write("hills.tif", geotiff(hills()))
        ground = {"type": "obstacles", "terrainFile": "hills.tif", "terrainOrigin": [WEST, NORTH, 100]}
        south_first = [[height - 100 for height in row] for row in reversed(hills())]
        same = {"type": "obstacles", "heightField": south_first, "heightFieldExtent": [1, 1, 15, 9]}
        for place in ((1.0, 0.5, 1.0), (5.0, 3.0, 3.0), (6.3, 1.9, 7.7), (15.0, 8.0, 9.0), (5.0, -1.0, 5.0)):
            self.assertEqual(self.answer(ground, *place), self.answer(same, *place))
        # 5 above a flat ground of 20 m, in a world of half the size
        self.write("flat.tif", geotiff([[20.0] * 4] * 4))
        flat = {"type": "obstacles", "terrainFile": "flat.tif", "terrainOrigin": [WEST, NORTH, 0], "terrainScale": 0.5}
        self.assertEqual(self.answer(flat, 2.0, 15.0, 2.0)[1], 5.0)

    def test_wrong_files_are_refused_in_one_sentence(self) -> None:
        whole = geotiff(hills())
        for content, says in ((b"II*\0", "is no TIFF file, or is damaged"),
                              (b"text", "is no TIFF file, or is damaged"),
                              (whole[:len(whole) // 2], "is no TIFF file, or is damaged"),
                              (geotiff(hills(), ((1024, 2),)), "has coordinates in degrees. Convert it to a projection in metres: "
                               "gdalwarp -t_srs EPSG:NUMBER -dstnodata -9999"),
                              (geotiff(hills(), ((1024, 1), (3076, 9002))), "has lengths in feet (unit 9002"),
                              (geotiff(hills(), ((1024, 1), (4099, 9003))), "EPSG:NUMBER -dstnodata -9999, then gdal_edit.py -units m"),
                              (geotiff(hills(), items=b'<Item role="scale">inf</Item>'), "has a scale or an offset that is no finite number"),
                              (geotiff(hills(), items=b'<Item role="offset">many</Item>'), "has a scale or an offset that is no finite number"),
                              (geotiff(hills(), is_placed=False), "does not say where it lies"),
                              (geotiff([[1.0, 2.0]]), "has 2 x 1 heights. A ground needs at least 2 x 2"),
                              (geotiff([[1.0, 2.0], [3.0, float("nan")]]), "has 1 of 4 cells without a height. Fill them"),
                              (whole.replace(struct.pack("<HHI", 256, 4, 1) + struct.pack("<I", 8), struct.pack("<HHI", 256, 4, 1) + struct.pack("<I", 2 ** 31)),
                               "has 2147483648 x 5 heights, more than 1000000. Make it coarser"),
                              (whole.replace(struct.pack("<HHIH", 277, 3, 1, 1), struct.pack("<HHIH", 277, 3, 1, 3)), "has 3 bands"),
                              (whole.replace(struct.pack("<HHIH", 258, 3, 1, 32), struct.pack("<HHIH", 258, 3, 1, 24)), "has numbers of a kind that is not read"),
                              (whole.replace(struct.pack("<HHII", 273, 4, 1, 8), struct.pack("<HHII", 273, 4, 1, 2 ** 31)), "is damaged or cut short")):
            self.assertIn(says, self.refusal(content))
        # the keys are the last part of the file: without them the unit would be lost in silence
        for cut in (1, 16, 31, 33, 60):
            self.assertIn("is damaged or cut short: what it says of its place and unit is not there. Get a complete copy", self.refusal(whole[:-cut]))

    def test_wrong_configurations_are_refused_in_one_sentence(self) -> None:
        self.write("hills.tif", geotiff(hills()))
        model = self.write("probe.l", PROBE.replace("X", "0").replace("Y", "0").replace("Z", "0").encode())
        for keys, says in (({"terrainFile": "none.tif"}, "none.tif' of the environment 'obstacles': it cannot be read"),
                           ({"terrainFile": "hills.tif", "terrainOrigin": [1, 2]}, "'terrainOrigin' must be three numbers: east, north, height"),
                           ({"terrainFile": "hills.tif"}, "its middle is [400008, 5599995, 102]"),
                           ({"terainFile": "hills.tif"}, "Did you mean 'terrainFile'?"),
                           ({"terrainFile": "hills.tif", "terrainScale": 0}, "'terrainScale' must be a number above 0"),
                           ({"terrainFile": "hills.tif", "terrainOrigin": [WEST, NORTH, 0], "heightField": [[0, 0], [0, 0]]}, "the configuration has 'heightField' too"),
                           ({"type": "height", "terrainFile": "hills.tif"}, "the environment 'height' takes no ground")):
            file = self.write("world.json", json.dumps({"type": "obstacles", **keys}).encode())
            self.assertIn(says, espalier("derive", str(model), "--environment", str(file), status=1).stderr)


if __name__ == "__main__":
    unittest.main()
