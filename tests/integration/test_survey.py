"""Plants and fields as files of surveyors (espalier.survey), read by gdal, VTK, @loaders.gl, and by Espalier again."""

import base64
import importlib.util
import itertools
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path
from typing import Any, Callable, Dict, List

from las_reader import las_points
from mesh_readers import READERS
from support import REPOSITORY, espalier, model, variables
from test_terrain import LIBRARY, geotiff, hills

from espalier import survey
from espalier.fields import Fields, Grid, read_vti

READER = REPOSITORY / "tests" / "points"
ORIGIN = (400_000.0, 5_600_000.0, 100.0)
PROBE = "Lsystem: 1\nderivation length: 1\nAxiom: @M({})?E(0.01,0.001,0)\nendlsystem\n"


class Survey(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def convert(self, source: str, target: str, *more: str, said: str = "") -> Path:
        """Converts a file of the folder; with `said` it must fail with that sentence and leave nothing."""
        before = sorted(self.folder.iterdir())
        done = subprocess.run([sys.executable, "-m", "espalier.survey", str(self.folder / source), str(self.folder / target), *more],
                              capture_output=True, text=True, timeout=120, check=False, env=variables())
        if said:
            self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (1, "", 1), done.stderr)
            self.assertRegex(done.stderr, f"^error: .*{said}")
            self.assertEqual(sorted(self.folder.iterdir()), before)
        else:
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        return self.folder / target

    def plant(self) -> Path:
        espalier("run", model("parametric-tree"), "--steps", "4", "--quiet", "-o", str(self.folder / "plant.vtp"))
        return self.folder / "plant.vtp"

    @unittest.skipUnless(LIBRARY, "libgeotiff is not installed (Debian: libgeotiff5)")
    def test_heights_that_are_read_and_written_are_the_same(self) -> None:
        (self.folder / "hill.tif").write_bytes(geotiff(hills()))
        espalier("field", str(self.folder / "hill.tif"), "--field", str(self.folder / "hill.vti"))
        again = self.convert("hill.vti", "again.tif", "--epsg", "25832")
        espalier("field", str(again), "--field", str(self.folder / "again.vti"))
        self.assertEqual((self.folder / "hill.vti").read_bytes(), (self.folder / "again.vti").read_bytes())
        if shutil.which("gdalinfo"):
            first, second = (json.loads(subprocess.run(["gdalinfo", "-json", "-checksum", str(self.folder / name)], capture_output=True, text=True,
                                                       check=True, timeout=60).stdout) for name in ("hill.tif", "again.tif"))
            for key in ("size", "geoTransform", "cornerCoordinates"):
                self.assertEqual(first[key], second[key])
            self.assertEqual((second["bands"][0]["type"], second["bands"][0]["unit"]), ("Float64", "m"))
            self.assertIn("ETRS89 / UTM zone 32N", second["coordinateSystem"]["wkt"])

    @unittest.skipUnless(shutil.which("gdal_translate"), "gdal is not installed (Debian: gdal-bin)")
    def test_gdal_reads_the_map_of_a_field_of_a_run(self) -> None:
        espalier("run", model("roots-in-soil"), "--steps", "4", "--quiet", "--field", str(self.folder / "water.vti"), "-o", str(self.folder / "r.csv"))
        fields = read_vti(self.folder / "water.vti")
        ways: Dict[str, Callable[[List[float]], float]] = {"mean": lambda some: math.fsum(some) / len(some), "least": min, "sum": math.fsum}
        for over, way in ways.items():
            tif = self.convert("water.vti", "water.tif", "--quantity", "waterContent", "--over", over, "--origin", "400000,5600000,0")
            subprocess.run(["gdal_translate", "-q", "-of", "ENVI", str(tif), str(self.folder / "water.img")], check=True, timeout=60)
            read = memoryview((self.folder / "water.img").read_bytes()).cast("d").tolist()
            columns, layers, depths = fields.grid.cells
            values = memoryview(fields.quantities["waterContent"][1]).cast("d")
            expected = [way([values[x + columns * (y + layers * z)] for y in range(layers)]) for z in range(depths) for x in range(columns)]
            self.assertEqual(read, expected)
            info = json.loads(subprocess.run(["gdalinfo", "-json", str(tif)], capture_output=True, text=True, check=True, timeout=60).stdout)
            low, step = fields.grid.position, fields.grid.spacing
            self.assertEqual((info["size"], info["geoTransform"]), ([columns, depths], [400000 + low[0], step[0], 0, 5600000 - low[2], 0, -step[2]]))

    def test_points_of_a_plant_lie_on_it_and_other_readers_find_them(self) -> None:
        plant = self.plant()
        las = self.convert("plant.vtp", "plant.las", "--spacing", "0.5", "--origin", ",".join(map(str, ORIGIN)))
        found = list(las_points(las.read_bytes()))
        mesh = survey.read_vtp(plant)
        expected = [(x + ORIGIN[0], ORIGIN[1] - z, y + ORIGIN[2]) for (x, y, z), _, _ in survey.surface_points(mesh, 0.5)]
        self.assertEqual(len(found), len(expected))
        for point, place in zip(found, expected):
            self.assertEqual((point.kind, point.isWithheld), (5, False))
            for one, other in zip(point.place, place):
                self.assertAlmostEqual(one, other, delta=0.000501)
        said = dict(line.split("\t", 1) for line in espalier("points", str(las)).stdout.splitlines())
        self.assertEqual((said["points"], said["class 5"]), (str(len(expected)),) * 2)
        if (READER / "node_modules").is_dir() and shutil.which("node"):
            theirs: Dict[str, Any] = json.loads(subprocess.run(["node", str(READER / "count.js"), str(las), "1"], capture_output=True, text=True,
                                                               check=True, timeout=60).stdout)
            self.assertEqual(theirs["points"], len(expected))
            for axis in range(3):
                self.assertAlmostEqual(theirs["minimum"][axis], min(point.place[axis] for point in found), 6)
                self.assertAlmostEqual(theirs["maximum"][axis], max(point.place[axis] for point in found), 6)

    def test_points_lie_evenly_on_a_triangle(self) -> None:
        mesh = survey.VtpMesh([(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 4.0, 0.0)], [(0, 1, 2)], {"plant": [7.0], "organ": [2.0]})
        for spacing, parts in ((10.0, 1), (2.5, 2), (1.0, 5)):
            points = list(survey.surface_points(mesh, spacing))
            self.assertEqual(len(points), parts * parts)
            self.assertEqual(len({point.place for point in points}), len(points))
            # their middle is that of the triangle, as of every partition in equal parts, and all are inside
            for axis, middle in enumerate((1.0, 4 / 3, 0.0)):
                self.assertAlmostEqual(math.fsum(point.place[axis] for point in points) / len(points), middle, 12)
            self.assertTrue(all(x > 0 and y > 0 and x / 3 + y / 4 < 1 for (x, y, _), _, _ in points))
            self.assertEqual({(point.plant, point.organ) for point in points}, {(7, 2)})

    def test_a_mesh_that_is_read_back_is_an_obstacle(self) -> None:
        plant = self.plant()
        self.convert("plant.vtp", "plant.obj")
        triangles = READERS["vtp"](plant).triangles
        corners = [len(line.split()) - 1 for line in (self.folder / "plant.obj").read_text(encoding="ascii").splitlines() if line.startswith("f ")]
        self.assertEqual(sum(corners) - 2 * len(corners), len(triangles))
        mesh = survey.read_vtp(plant)
        self.assertEqual(len(list(mesh.triangles())), len(triangles))
        (self.folder / "e.json").write_text('{"type": "obstacles", "meshFile": "plant.obj"}', encoding="utf-8")
        x, y, z = mesh.points[0]
        answers = []
        for place in ((x, y, z), (x + 500, y, z)):
            (self.folder / "m.l").write_text(PROBE.format(",".join(map(repr, place))), encoding="utf-8")
            answers.append(espalier("derive", str(self.folder / "m.l"), "--environment", str(self.folder / "e.json"), "--quiet").stdout)
        # one segment touches the plant, the other is far from it
        self.assertEqual([answer[answer.index("?E"):][:5] for answer in answers], ["?E(0,", "?E(1,"])

    @unittest.skipUnless(importlib.util.find_spec("vtk"), "VTK is not installed (Debian: python3-vtk9)")
    def test_meshes_of_vtk_are_read(self) -> None:
        import vtk

        ball = vtk.vtkSphereSource()
        ball.Update()
        data = ball.GetOutput()
        plants = vtk.vtkIntArray()
        plants.SetName("plant")
        for i in range(data.GetNumberOfCells()):
            plants.InsertNextValue(i % 3)
        data.GetCellData().AddArray(plants)
        writer = vtk.vtkXMLPolyDataWriter()
        writer.SetFileName(str(self.folder / "ball.vtp"))
        writer.SetInputData(data)
        expected = [tuple(data.GetCell(i).GetPointId(k) for k in range(3)) for i in range(data.GetNumberOfCells())]
        writer.SetBlockSize(512)  # several blocks for each array
        for mode, isCompressed, isEncoded, isLong in itertools.product(("Ascii", "Binary", "Appended"), (False, True), (False, True), (False, True)):
            getattr(writer, f"SetDataModeTo{mode}")()
            (writer.SetCompressorTypeToZLib if isCompressed else writer.SetCompressorTypeToNone)()
            (writer.SetHeaderTypeToUInt64 if isLong else writer.SetHeaderTypeToUInt32)()
            writer.SetEncodeAppendedData(isEncoded)
            writer.Write()
            mesh = survey.read_vtp(self.folder / "ball.vtp")
            self.assertEqual(len(mesh.points), data.GetNumberOfPoints())
            if mode != "Ascii":  # VTK writes eight digits as text
                self.assertEqual(mesh.points, [data.GetPoint(i) for i in range(data.GetNumberOfPoints())])
            self.assertEqual(mesh.polygons, expected)
            self.assertEqual(mesh.cells["plant"], [float(i % 3) for i in range(data.GetNumberOfCells())])
            # cut in the middle of its data: refused
            whole = (self.folder / "ball.vtp").read_bytes()
            (self.folder / "cut.vtp").write_bytes(whole[:len(whole) // 2])
            with self.assertRaises(survey.SurveyError):
                survey.read_vtp(self.folder / "cut.vtp")
        writer.SetCompressorTypeToLZ4()
        writer.Write()
        with self.assertRaisesRegex(survey.SurveyError, "compressed by vtkLZ4DataCompressor: write it with SetCompressorTypeToZLib"):
            survey.read_vtp(self.folder / "ball.vtp")

    def test_a_small_file_does_not_become_large(self) -> None:
        blocks = [zlib.compress(bytes(2**24)) for _ in range(12)]
        for claims in (2**24, 2**20):
            head = struct.pack(f"<{3 + len(blocks)}I", len(blocks), claims, 0, *map(len, blocks))
            packed = base64.b64encode(head).decode() + base64.b64encode(b"".join(blocks)).decode()
            array = '<DataArray type="{}" Name="{}" format="binary">' + packed + "</DataArray>"
            (self.folder / "bomb.vtp").write_text(
                '<VTKFile type="PolyData" compressor="vtkZLibDataCompressor"><PolyData><Piece><Points>' + array.format("Float64", "p") +
                "</Points><Polys>" + array.format("UInt8", "connectivity") + array.format("UInt8", "offsets") + "</Polys></Piece></PolyData></VTKFile>",
                encoding="ascii")
            self.convert("bomb.vtp", "out.obj", said="more than 20000000 numbers" if claims == 2**24 else "'p' is damaged")

    def test_pieces_need_not_have_the_same_arrays(self) -> None:
        piece = ('<Piece NumberOfPoints="3" NumberOfPolys="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">'
                 '0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2</DataArray>'
                 '<DataArray type="Int32" Name="offsets" format="ascii">3</DataArray></Polys><CellData>{}</CellData></Piece>')
        plant = '<DataArray type="Float64" Name="plant" format="ascii">{}</DataArray>'
        for first, second, expected in (("", plant.format(7), {0, 7}), (plant.format(7), "", {0, 7}), (plant.format("inf"), plant.format("nan"), {0})):
            source = self.folder / "two.vtp"
            source.write_text('<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64"><PolyData>'
                              f"{piece.format(first)}{piece.format(second)}</PolyData></VTKFile>", encoding="utf-8")
            self.assertEqual({point.plant for point in survey.surface_points(survey.read_vtp(source), 0.5)}, expected)

    def test_what_cannot_be_done_is_one_sentence_and_nothing_is_written(self) -> None:
        good = self.plant().read_text(encoding="utf-8")
        bad: List[Any] = [(good[:5000], "cannot be read"), (good.replace("PolyData", "Grid"), "no little-endian PolyData"),
                          ("<!DOCTYPE a [<!ENTITY b 'c'>]>" + good, "declarations"), (good.replace('Name="connectivity" NumberOfComponents="1" format="binary">',
                          'Name="connectivity" NumberOfComponents="1" format="binary">AAAA'), "'connectivity'"), ("", "cannot be read")]
        for text, said in bad:
            (self.folder / "bad.vtp").write_text(text, encoding="utf-8")
            self.convert("bad.vtp", "out.las", said=said)
        self.convert("none.vtp", "out.las", said="cannot be read")
        self.convert("plant.vtp", "out.las", "--spacing", "0", said="spacing 0.0 is no number above 0")
        self.convert("plant.vtp", "out.las", "--spacing", "1e-7", said="more than 100000000 points")
        for origin in ("nan,0,0", "0,inf,0", "0,0,-1e300"):
            for target in ("out.las", "out.obj"):
                self.convert("plant.vtp", target, f"--origin={origin}", said="the origin .* is no place")
        for name in ("pipe.vtp", "pipe.vti"):
            os.mkfifo(self.folder / name)
            self.convert(name, "out.obj", said="pipe.vt. is no file")
        nothing = re.sub(r"(?s)(<Piece.*?</Piece>\s*)+", "", good)
        self.assertIn("PolyData", nothing)
        (self.folder / "nothing.vtp").write_text(nothing, encoding="utf-8")
        self.convert("nothing.vtp", "out.obj", said="no polygons")
        self.convert("nothing.vtp", "out.las", said="no points")
        self.convert("plant.vtp", "out.tif", said="no way from '.vtp' to '.tif'")
        grid = Fields(Grid((2, 1, 1), (0, 0, 0), (1, 1, 1)), {"a": ("1", bytes(16)), "b": ("1", bytes(16))})
        for call, expected in ((lambda: survey.heights_of(grid), "quantities a, b"), (lambda: survey.heights_of(grid, "c"), "no quantity 'c'"),
                               (lambda: survey.heights_of(grid, "a", "median"), "'median' is no way")):
            with self.assertRaisesRegex(survey.SurveyError, expected):
                call()
        with self.assertRaisesRegex(survey.SurveyError, "is no place"):
            survey.write_geotiff(survey.heights_of(grid, "a"), self.folder / "x.tif", 25832, (math.nan, 0.0))
        with self.assertRaisesRegex(survey.SurveyError, "not from 1 to 65535"):
            survey.write_geotiff(survey.heights_of(grid, "a"), self.folder / "x.tif", 70000)


if __name__ == "__main__":
    unittest.main()
