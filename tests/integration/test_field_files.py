"""Fields as netCDF and Zarr: the same bits, coordinates, units; back into an environment; bad files."""

import importlib.util
import json
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, List

from support import GALLERY, SECONDS, espalier, variables

from espalier import fields

HAS_LIBRARIES = all(importlib.util.find_spec(name) for name in ("xarray", "netCDF4", "zarr"))


def tool(*arguments: str, status: int = 0) -> "subprocess.CompletedProcess[str]":
    done = subprocess.run([sys.executable, "-m", "espalier.fields", *arguments], capture_output=True, text=True, timeout=SECONDS,
                          check=False, env=variables())
    if done.returncode != status:
        raise AssertionError(f"{arguments} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done


@unittest.skipUnless(HAS_LIBRARIES, "xarray, netCDF4 or zarr is not installed (Debian: python3-xarray python3-netcdf4 python3-zarr)")
class Files(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        espalier("run", str(GALLERY / "roots-in-soil"), "--steps", "2", "--every", "--quiet", "-o", f"{folder.name}/r.string",
                 "--field", f"{folder.name}/water.vti", "--field", f"waterContent={folder.name}/water.raw")
        self.sources = [str(path) for path in sorted(self.folder.glob("water-*.vti"))]

    def doubles(self, step: int) -> List[float]:
        raw = (self.folder / f"water-000{step}.raw").read_bytes()
        return list(struct.unpack(f"<{len(raw) // 8}d", raw))

    def opened(self, name: str) -> Any:
        tool(*self.sources, str(self.folder / name))
        data = fields.open_dataset(self.folder / name)
        self.addCleanup(data.close)
        return data

    def test_netcdf_and_zarr_hold_the_bits_with_coordinates_and_units(self) -> None:
        header = json.loads((self.folder / "water-0002.raw.json").read_text(encoding="utf-8"))
        for name in ("water.nc", "water.zarr"):
            with self.subTest(name):
                data = self.opened(name)
                self.assertEqual(data["waterContent"].dims, ("step", "z", "y", "x"))
                self.assertEqual([data["waterContent"].values[k].ravel().tolist() for k in range(3)], [self.doubles(k) for k in range(3)])
                self.assertEqual(data["step"].values.tolist(), [0, 1, 2])
                self.assertEqual([data.sizes[axis] for axis in "xyz"], header["cells"])
                for axis, low, size in zip("xyz", header["position"], header["cellSize"]):
                    self.assertEqual(data[axis].attrs["units"], "m")
                    self.assertAlmostEqual(float(data[axis][0]), low + size / 2, places=12)
                    self.assertAlmostEqual(float(data[f"{axis}_bnds"][0, 0]), low, places=12)
                self.assertEqual((data["y"].attrs["positive"], data["y"].attrs["axis"]), ("up", "Z"))
                self.assertEqual(data["pressureHead"].attrs["units"], "m")
                self.assertEqual(data["waterContent"].attrs["long_name"], "water content")
                self.assertEqual(data.attrs["Conventions"], "CF-1.8")
        self.assertTrue((self.folder / "water.zarr" / ".zgroup").is_file())
        self.assertEqual([path.name for path in self.folder.iterdir() if path.name.startswith(".espalier")], [])

    @unittest.skipUnless(shutil.which("ncdump"), "ncdump is not installed (Debian: netcdf-bin)")
    def test_the_unit_of_length_is_that_of_the_world(self) -> None:
        (self.folder / "world.json").write_text('{"lengthUnit": "cm"}', encoding="utf-8")
        (self.folder / "e.json").write_text('{"type": "emission", "gridSize": [3, 4, 2], "cellSize": 0.5}', encoding="utf-8")
        vti = self.folder / "cm.vti"
        espalier("run", str(GALLERY / "litter-ring"), "--environment", str(self.folder / "e.json"), "--world", str(self.folder / "world.json"),
                 "--steps", "1", "--quiet", "-o", str(self.folder / "r.string"), "--field", str(vti))
        self.assertIn(' LengthUnit="cm">', vti.read_text(encoding="utf-8"))
        for name in ("cm.nc", "cm.zarr"):
            tool(str(vti), str(self.folder / name))
            data = fields.open_dataset(self.folder / name)
            self.addCleanup(data.close)
            self.assertEqual({data[axis].attrs["units"] for axis in "xyz"}, {"cm"})
            tool(str(self.folder / name), str(self.folder / "again.vti"))
            self.assertEqual((self.folder / "again.vti").read_bytes(), vti.read_bytes())

    def test_ncdump_reads_like_a_data_set(self) -> None:
        self.opened("water.nc")
        said = subprocess.run(["ncdump", "-h", str(self.folder / "water.nc")], capture_output=True, text=True, check=True).stdout
        for wanted in ("double waterContent(step, z, y, x)", 'waterContent:units = "1"', 'y:positive = "up"', 'x:bounds = "x_bnds"',
                       ':Conventions = "CF-1.8"', 'waterContent:cell_methods = "x: y: z: mean"'):
            self.assertIn(wanted, said)
        self.assertNotIn("_FillValue", said)

    def test_back_to_vti_is_the_same_file_and_an_environment_begins_with_it(self) -> None:
        for name in ("water.nc", "water.zarr"):
            self.opened(name)
            tool(str(self.folder / name), str(self.folder / "back.vti"))
            self.assertEqual((self.folder / "back.vti").read_bytes(), (self.folder / "water-0002.vti").read_bytes(), name)
        tool(str(self.folder / "water.nc"), str(self.folder / "first.vti"), "--step", "0")
        self.assertEqual((self.folder / "first.vti").read_bytes(), (self.folder / "water-0000.vti").read_bytes())
        (self.folder / "soil.json").write_text('{"type": "soil-water", "fieldFile": "back.vti"}', encoding="utf-8")
        (self.folder / "m.l").write_text("Lsystem: 1\nderivation length: 1\nAxiom: @M(0,-0.5,0)?E(0,0,0)\nendlsystem\n", encoding="utf-8")
        said = espalier("derive", str(self.folder / "m.l"), "--environment", str(self.folder / "soil.json"), "--every", "--answered",
                        "--quiet").stdout
        head = float(said.strip().split(",")[-2])
        raw = fields.read_vti(self.sources[2]).quantities["pressureHead"][1]
        self.assertIn(head, struct.unpack(f"<{len(raw) // 8}d", raw))

    def test_a_foreign_data_set_becomes_cells(self) -> None:
        import numpy
        import xarray

        axis = [0.5, 1.5, 2.5]
        values = numpy.arange(27.0).reshape(3, 3, 3)
        data = xarray.Dataset({"density": (("x", "y", "z"), values, {"units": "m-1"})}, {name: axis for name in "xyz"})
        found = fields.fields_of(data)
        self.assertEqual(found.grid, fields.Grid((3, 3, 3), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
        unit, raw = found.quantities["density"]
        # x fastest
        self.assertEqual((unit, struct.unpack("<27d", raw)[:4]), ("m-1", (0.0, 9.0, 18.0, 3.0)))
        for change, said in ((lambda d: d.assign_coords(x=[0, 1, 3]), "not equal and rising"),
                             (lambda d: d.assign_coords(x=("x", axis, {"units": "km"})), "are in 'km' and 'm'"),
                             (lambda d: d.rename(x="lon"), "no axis x"),
                             (lambda d: d.where(d.density > 3), "missing or not finite"),
                             (lambda d: d.isel(x=slice(0, 1)), "one cell and no bounds"),
                             (lambda d: d.drop_vars("density"), "no quantity")):
            with self.subTest(said), self.assertRaisesRegex(fields.FieldError, said):
                fields.fields_of(change(data))

    def test_bad_files_are_one_sentence_and_leave_nothing(self) -> None:
        good = Path(self.sources[0]).read_text(encoding="utf-8")
        bad = {"truncated.vti": good[:2000], "empty.vti": "", "html.vti": "<html></html>",
               "huge.vti": good.replace("0 40 0 25 0 1", "0 400000 0 250000 0 1000000"),
               "negative.vti": good.replace('Spacing="0.05', 'Spacing="-0.05'), "nan.vti": good.replace('Origin="-1', 'Origin="nan'),
               "entities.vti": '<!DOCTYPE a [<!ENTITY b "c">]>' + good, "other.vti": good.replace("Float64", "Float32"),
               "short.vti": good.replace("0 40 0 25 0 1", "0 40 0 26 0 1"), "truncated.nc": "CDF", "binary.nc": "\x89HDF\r\n\x1a\n" + "x" * 100}
        self.opened("water.nc")
        whole = (self.folder / "water.nc").read_bytes()
        (self.folder / "half.nc").write_bytes(whole[:len(whole) // 2])
        for name, text in bad.items():
            (self.folder / name).write_text(text, encoding="utf-8")
        for name in (*bad, "half.nc", "nothing.nc", "nothing.zarr"):
            with self.subTest(name):
                target = self.folder / ("out.vti" if not name.endswith(".vti") else "out.nc")
                said = tool(str(self.folder / name), str(target), status=1).stderr
                self.assertRegex(said, r"^error: .+\.\n$")
                self.assertEqual(said.count("\n"), 1)
                self.assertFalse(target.exists())
        self.assertIn("not a format", tool(self.sources[0], str(self.folder / "a.xyz"), status=1).stderr)
        self.assertIn("no step 7", tool(str(self.folder / "water.nc"), str(self.folder / "a.vti"), "--step", "7", status=1).stderr)


if __name__ == "__main__":
    unittest.main()
