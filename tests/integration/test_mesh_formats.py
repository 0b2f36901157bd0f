"""One tree with bark, leaves with holes and forks in seven mesh formats: read back, they are the same triangles."""

from __future__ import annotations

import csv
import importlib.util
import math
import re
import shutil
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import List, Tuple

from mesh_readers import READERS, vtp_pieces
from support import REPOSITORY, espalier

GALLERY = REPOSITORY / "clients" / "gallery"
Corner = Tuple[float, float, float]


class MeshFormats(unittest.TestCase):
    def compare(self, model: Path, triangles: int, backward: int, corners: Tuple[Corner, Corner], *arguments: str) -> None:
        """All files of the model have so many triangles, within a box between two corners."""
        with tempfile.TemporaryDirectory() as folder:
            files = {suffix: Path(folder) / f"plant.{suffix}" for suffix in READERS}
            outputs = [word for file in files.values() for word in ("-o", str(file))]
            run = espalier("run", str(model), "--seed", "5", *arguments, *outputs, "--quiet")
            self.assertEqual(run.returncode, 0, run.stderr)
            meshes = {suffix: READERS[suffix](file) for suffix, file in files.items()}
        # which has no triangles without an area
        self.assertLessEqual(len(meshes["stl"].triangles), len(meshes["glb"].triangles))
        first = meshes["stl"].without_slivers()
        low, high = corners
        size = max(b - a for a, b in zip(low, high))
        for suffix, mesh in meshes.items():
            with self.subTest(model=model.name, format=suffix):
                if suffix != "stl":
                    self.assertEqual(len(mesh.triangles), len(meshes["glb"].triangles))
                mesh = mesh.without_slivers()
                self.assertEqual(len(mesh.triangles), triangles)
                for found, expected in zip(mesh.bounds(), corners):
                    self.assertEqual(len(found), 3)
                    for a, b in zip(found, expected):
                        self.assertAlmostEqual(a, b, delta=1e-5 * size)
                self.assertAlmostEqual(mesh.area() / first.area(), 1.0, delta=1e-4)
                self.assertAlmostEqual(mesh.volume() / first.volume(), 1.0, delta=1e-3)
                # those of an .stl are of its triangles; of others the inner side of a sharp bend, within the tube, looks back
                self.assertEqual(mesh.backward_normals(), 0 if suffix == "stl" else backward)

    def test_a_textured_tree_is_the_same_in_every_format(self) -> None:
        corners = ((-3.728303, 0.0, -5.599810), (4.311015, 9.791170, 3.647262))
        self.compare(GALLERY / "textured-tree", 7152, 0, corners, "--detail", "0.4")

    def test_a_plant_with_every_kind_of_organ_is_the_same_in_every_format(self) -> None:
        corners = ((-4.417216, -0.303705, -2.668117), (1.472719, 4.021339, 2.024975))
        self.compare(REPOSITORY / "tests" / "gltf" / "organs", 3979, 408, corners)


class ForParaView(unittest.TestCase):
    """The cells of a .vtp know where they come from."""

    MODEL = "Lsystem: 1\nderivation length: 2\nAxiom: A(1,2)\nA(l,w) --> F(l,w)[+(40)A(l/2,w/2)]A(l*0.9,w)\nendlsystem\n"

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "m.l").write_text(self.MODEL, encoding="utf-8")
        (self.folder / "m.v").write_text("line style: cylinder\n", encoding="utf-8")
        espalier("run", str(self.folder / "m.l"), "-o", str(self.folder / "m.vtp"), "-o", str(self.folder / "m.csv"), "--quiet")
        with (self.folder / "m.csv").open(newline="", encoding="utf-8") as file:
            self.rows = {int(row["module"]): row for row in csv.DictReader(file)}

    def check(self, modules: List[int], orders: List[int], lengths: List[float], symbols: List[str]) -> None:
        drawn = {number for number, row in self.rows.items() if row["symbol"] == "F"}
        self.assertEqual(set(modules), drawn)
        for module, order, length, symbol in zip(modules, orders, lengths, symbols):
            row = self.rows[module]
            self.assertEqual((order, symbol), (int(row["order"]), row["symbol"]))
            self.assertEqual(length, float(re.split(r"[ ,;]+", row["parameters"])[0]))

    def test_the_arrays_agree_with_the_table_of_modules(self) -> None:
        names = self.symbols()
        for arrays in vtp_pieces(self.folder / "m.vtp"):
            self.check(arrays["module"], arrays["order"], arrays["parameter1"], [names[number] for number in arrays["symbol"]])
            # F(l,w) has two parameters
            self.assertTrue(all(math.isnan(value) for value in arrays["parameter3"]))

    def test_cells_have_the_age_of_their_module(self) -> None:
        (self.folder / "age.l").write_text("Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> I(1)[+(40)A]A\nI(l) --> I(l+1)\nhomomorphism\n"
                                           "I(l) --> F(l)\nendlsystem\n", encoding="utf-8")
        for more, ages in (((), lambda length, step: length - 1.0), (("--resume", str(self.folder / "rest.snapshot")), lambda length, step: math.nan)):
            call = more or (str(self.folder / "age.l"), "-o", str(self.folder / "rest.snapshot"), "--every")
            espalier("run", *call, "-o", str(self.folder / "age.vtp"), "--quiet")
            for step in (1, 2, 3) if not more else (3,):
                lengths = set()
                for arrays in vtp_pieces(self.folder / ("age.vtp" if more else f"age-000{step}.vtp")):
                    for age, length in zip(arrays["age"], arrays["parameter1"]):
                        expected = ages(length, step)
                        self.assertTrue(age == expected or math.isnan(age) and math.isnan(expected), (age, length))
                        lengths.add(length)
                self.assertEqual(lengths, set(range(1, step + 1)))
            if not more:
                shutil.copy(self.folder / "rest-0003.snapshot", self.folder / "rest.snapshot")

    def symbols(self) -> List[str]:
        text = (self.folder / "m.vtp").read_text(encoding="utf-8")
        found = re.search(r'Name="symbols"[^>]*>([^<]*)<', text)
        assert found is not None
        return "".join(chr(int(number)) for number in found.group(1).split()).rstrip("\0").split("\0")

    @unittest.skipUnless(importlib.util.find_spec("vtk"), "VTK is not installed (Debian: python3-vtk9)")
    def test_vtk_reads_the_same(self) -> None:
        import vtk

        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(self.folder / "m.vtp"))
        reader.Update()
        data = reader.GetOutput()
        cells = data.GetCellData()

        def values(name: str) -> List[float]:
            array = cells.GetArray(name)
            return [array.GetTuple1(i) for i in range(data.GetNumberOfCells())]

        names = data.GetFieldData().GetAbstractArray("symbols")
        self.assertEqual(data.GetNumberOfCells(), sum(len(arrays["module"]) for arrays in vtp_pieces(self.folder / "m.vtp")))
        self.check([int(value) for value in values("module")], [int(value) for value in values("order")], values("parameter1"),
                   [names.GetValue(int(value)) for value in values("symbol")])
        self.assertEqual(data.GetPointData().GetNormals().GetNumberOfTuples(), data.GetNumberOfPoints())

    @unittest.skipUnless(importlib.util.find_spec("vtk"), "VTK is not installed (Debian: python3-vtk9)")
    def test_a_grid_has_the_same_cells(self) -> None:
        import vtk

        espalier("run", str(self.folder / "m.l"), "-o", str(self.folder / "m.vtu"), "--quiet")
        grids = []
        for reader, name in ((vtk.vtkXMLUnstructuredGridReader(), "m.vtu"), (vtk.vtkXMLPolyDataReader(), "m.vtp")):
            reader.SetFileName(str(self.folder / name))
            reader.Update()
            grids.append(reader.GetOutput())
        self.assertGreater(grids[0].GetNumberOfCells(), 0)
        self.assertEqual(grids[0].GetNumberOfCells(), grids[1].GetNumberOfCells())
        for cell in range(grids[0].GetNumberOfCells()):
            self.assertEqual(*(grid.GetCellType(cell) for grid in grids))
            self.assertEqual(*([grid.GetCell(cell).GetPointId(k) for k in range(grid.GetCell(cell).GetNumberOfPoints())] for grid in grids))
        self.assertEqual({grids[0].GetCellData().GetArray("age").GetTuple1(i) for i in range(grids[0].GetNumberOfCells())}, {0.0, 1.0})
        for name in ("module", "order", "age", "parameter1"):
            self.assertEqual(*([grid.GetCellData().GetArray(name).GetTuple1(i) for i in range(grid.GetNumberOfCells())] for grid in grids))

    def test_a_series_lists_every_step_of_the_plant_and_of_the_soil(self) -> None:
        espalier("run", str(GALLERY / "roots-in-soil"), "--steps", "3", "--every", "-o", str(self.folder / "a & b.vtp"), "--field",
                 str(self.folder / "a & b.vti"), "--field", str(self.folder / "w%02d.vti"), "--quiet")
        self.assertEqual(sorted(file.name for file in self.folder.glob("*.pvd")), ["a & b.pvd", "w.pvd"])
        for name, suffixes, pattern in (("a & b", (".vtp", ".vti"), "a & b-{:04d}"), ("w", (".vti",), "w{:02d}")):
            sets = ElementTree.parse(self.folder / f"{name}.pvd").getroot().findall("Collection/DataSet")
            self.assertEqual([(entry.get("timestep"), entry.get("part"), entry.get("file")) for entry in sets],
                             [(str(step), str(part), pattern.format(step) + suffix)
                              for step in range(4) for part, suffix in enumerate(suffixes)])
            for entry in sets:
                self.assertTrue((self.folder / str(entry.get("file"))).is_file())

    @unittest.skipUnless(importlib.util.find_spec("vtk"), "VTK is not installed (Debian: python3-vtk9)")
    def test_vtk_reads_every_file_of_a_series(self) -> None:
        # the reader of .pvd files is ParaView's own; the library VTK reads what they list
        import vtk

        espalier("run", str(GALLERY / "roots-in-soil"), "--steps", "3", "--every", "-o", str(self.folder / "r.vtp"), "--field",
                 str(self.folder / "r.vti"), "--quiet")
        cells: "dict[str, list[int]]" = {}
        for entry in ElementTree.parse(self.folder / "r.pvd").getroot().findall("Collection/DataSet"):
            file = str(entry.get("file"))
            reader = vtk.vtkXMLGenericDataObjectReader()
            reader.SetFileName(str(self.folder / file))
            reader.Update()
            cells.setdefault(reader.GetOutput().GetClassName(), []).append(reader.GetOutput().GetNumberOfCells())
            number = int(file[2:6])
            self.assertEqual(str(number), entry.get("timestep"))
        self.assertEqual([(kind, len(numbers)) for kind, numbers in cells.items()], [("vtkPolyData", 4), ("vtkImageData", 4)])
        self.assertEqual(len(set(cells["vtkImageData"])), 1)
        # the plant grows
        self.assertEqual(cells["vtkPolyData"], sorted(cells["vtkPolyData"]))
        self.assertLess(cells["vtkPolyData"][0], cells["vtkPolyData"][-1])

    def test_a_large_plant_is_several_pieces(self) -> None:
        espalier("run", str(GALLERY / "textured-tree"), "-o", str(self.folder / "tree.vtp"), "-o", str(self.folder / "tree.ply"), "--detail",
                 "4", "--quiet")
        self.assertGreater(len(vtp_pieces(self.folder / "tree.vtp")), 1)
        self.assertEqual(len(READERS["vtp"](self.folder / "tree.vtp").triangles), len(READERS["ply"](self.folder / "tree.ply").triangles))


if __name__ == "__main__":
    unittest.main()
