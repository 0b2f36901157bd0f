"""Data sets of other programs as fields: what xarray changed, packed and missing numbers, axes, groups, damage."""

import contextlib
import importlib.util
import io
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path
from typing import Any, Dict, List, Tuple

from support import SECONDS, variables

from espalier import fields

HAS_LIBRARIES = all(importlib.util.find_spec(name) for name in ("xarray", "netCDF4", "zarr"))


def said_by(*arguments: str) -> Tuple[int, str]:
    """The status of the tool in this process, and what it wrote to standard error."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        return fields.main(list(arguments)), said.getvalue()


class Foreign(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def base(self, nx: int = 4, ny: int = 3, nz: int = 2) -> Any:
        """0, 1, 2, … with x fastest, in cells of 0.1 × 0.1 × 0.5, the first around 0."""
        import numpy
        import xarray

        axes = {"x": ("x", numpy.arange(nx) * 0.1, {"units": "m"}), "y": ("y", numpy.arange(ny) * 0.1, {"units": "m"}),
                "z": ("z", numpy.arange(nz) * 0.5, {"units": "m"})}
        return xarray.Dataset({"swc": (("z", "y", "x"), numpy.arange(nx * ny * nz, dtype="f8").reshape(nz, ny, nx))}, axes)

    def converted(self, data: Any, name: str = "foreign.nc", **options: Any) -> fields.Fields:
        """The fields that Espalier reads from a data set that xarray wrote, without a warning of a library."""
        path = self.folder / name
        data.to_zarr(path, **options) if name.endswith(".zarr") else data.to_netcdf(path, **options)
        return self.read(name)

    def read(self, name: str) -> fields.Fields:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", getattr(fields, "FieldWarning", UserWarning))
            warnings.filterwarnings("ignore", "numpy.ndarray size changed")
            fields.convert([self.folder / name], self.folder / "out.vti")
        return fields.read_vti(self.folder / "out.vti")

    def refused(self, data: Any, said: str, name: str = "foreign.nc") -> None:
        with self.assertRaisesRegex(fields.FieldError, said) as raised:
            self.converted(data, name) if data is not None else self.read(name)
        self.assertRegex(str(raised.exception), r"^[^\n]+\.$")

    def values(self, found: fields.Fields, name: str = "swc") -> List[float]:
        raw = found.quantities[name][1]
        return list(struct.unpack(f"<{len(raw) // 8}d", raw))

    def assertCells(self, found: fields.Fields, axis: str, count: int, low: float, size: float) -> None:
        k = "xyz".index(axis)
        self.assertEqual(found.grid.cells[k], count)
        self.assertAlmostEqual(found.grid.position[k], low, places=9)
        self.assertAlmostEqual(found.grid.spacing[k], size, places=9)


@unittest.skipUnless(HAS_LIBRARIES, "xarray, netCDF4 or zarr is not installed (Debian: python3-xarray python3-netcdf4 python3-zarr)")
class Numbers(Foreign):
    def test_units_of_time_do_not_change_numbers(self) -> None:
        data = self.base()
        data["age"] = data.swc + 5
        for unit in ("days", "seconds"):
            data["age"].attrs["units"] = unit
            found = self.converted(data)
            self.assertEqual((found.quantities["age"][0], self.values(found, "age")[:2]), (unit, [5.0, 6.0]))

    def test_a_step_axis_needs_no_dates(self) -> None:
        data = self.base().expand_dims(time=[0.0, 1.0]).copy()
        data.time.attrs.update(units="months since 2000-01-01", calendar="standard")
        self.assertEqual(self.values(self.converted(data))[:3], [0, 1, 2])

    def test_packed_numbers_are_unpacked_in_the_type_of_their_scale(self) -> None:
        import numpy

        data = self.base()
        # 0.01 · 7 in double is 0.07 and in single 0.0699999984…
        stored = data.swc.astype("i2")
        for kind, offset, wanted in (("f8", None, 7 * 0.01), ("f8", 0.5, 7 * 0.01 + 0.5),
                                     ("f4", None, float(numpy.float32(7) * numpy.float32(0.01)))):
            data["swc"] = stored.copy()
            data.swc.attrs.update(scale_factor=numpy.dtype(kind).type(0.01), **({"add_offset": offset} if offset else {}))
            self.assertEqual(self.values(self.converted(data))[7], wanted)
        data["swc"] = (stored - 1).astype("i1").assign_attrs(_Unsigned="true")
        self.assertEqual(self.values(self.converted(data))[:3], [255, 0, 1])

    def test_packed_numbers_stay_packed_from_netcdf_to_zarr_and_back(self) -> None:
        import numpy

        data = self.base()
        data["swc"] = data.swc.astype("i2").assign_attrs(scale_factor=0.01, _FillValue=numpy.int16(-9))
        first = self.converted(data)
        fields.convert([self.folder / "foreign.nc"], self.folder / "a.zarr")
        fields.convert([self.folder / "a.zarr"], self.folder / "b.nc")
        self.assertEqual(self.read("a.zarr"), first)
        self.assertEqual(self.read("b.nc"), first)
        data.swc[0, 0, 0] = -9
        self.refused(data, "swc has values that are missing")
        fields.convert([self.folder / "foreign.nc"], self.folder / "a.zarr")
        self.refused(None, "swc has values that are missing", "a.zarr")

    def test_missing_numbers_are_named_by_attributes_and_by_netcdf(self) -> None:
        import netCDF4
        import numpy

        for attributes in ({"missing_value": 5.0}, {"_FillValue": 5.0}, {"valid_max": 22.0}, {"valid_range": numpy.array([1.0, 99.0])}):
            data = self.base()
            data.swc.attrs.update(attributes)
            self.refused(data, "swc has values that are missing or not finite")
        self.refused(self.base().assign(swc=self.base().swc.assign_attrs(missing_value="none")), "attributes of swc .* are not numbers")
        for kind in ("f8", "f4", "i2", "i4"):
            with netCDF4.Dataset(self.folder / "unwritten.nc", "w") as file:
                for axis in "xyz":
                    file.createDimension(axis, 2)
                    file.createVariable(axis, "f8", (axis,))[:] = [0, 1]
                file.createVariable("q", kind, ("z", "y", "x"))
            self.refused(None, "q has values that are missing", "unwritten.nc")

    def zarr(self, **options: Any) -> Any:
        """A folder as zarr itself writes it: no consolidated metadata, and the fill value 0."""
        import zarr

        shutil.rmtree(self.folder / "f.zarr", ignore_errors=True)
        group = zarr.open_group(str(self.folder / "f.zarr"), mode="w")
        for name, variable in self.base().variables.items():
            array = group.create_dataset(name, data=variable.values, chunks=tuple(max(1, n // 2) for n in variable.shape), **options)
            array.attrs.update(variable.attrs, _ARRAY_DIMENSIONS=list(variable.dims))
        return group

    def test_zero_is_a_number_in_a_zarr_folder(self) -> None:
        group = self.zarr()
        found = self.read("f.zarr")
        self.assertCells(found, "x", 4, -0.05, 0.1)
        self.assertEqual(self.values(found), list(range(24)))
        fields.convert([self.folder / "f.zarr"], self.folder / "f.nc")
        self.assertEqual(self.read("f.nc"), found)
        group["swc"].attrs["_FillValue"] = 3.0
        self.refused(None, "swc has values that are missing", "f.zarr")

    def test_damaged_parts_of_a_zarr_folder_are_named(self) -> None:
        self.zarr(fill_value=None)
        (self.folder / "f.zarr" / "swc" / "0.0.0").write_bytes(b"garbage")
        self.refused(None, "swc cannot be read .*damaged", "f.zarr")
        (self.folder / "f.zarr" / "swc" / "0.0.0").unlink()
        self.refused(None, "has 11 of 12 parts of swc", "f.zarr")


@unittest.skipUnless(HAS_LIBRARIES, "xarray, netCDF4 or zarr is not installed (Debian: python3-xarray python3-netcdf4 python3-zarr)")
class Axes(Foreign):
    def own(self) -> Any:
        """A data set that Espalier wrote: cells of 0.1 × 0.2 × 0.5 from 1, 2 and 3."""
        raw = struct.pack("<48d", *range(48))
        grid = fields.Grid((6, 4, 2), (1.0, 2.0, 3.0), (0.1, 0.2, 0.5))
        return fields.dataset([fields.Fields(grid, {"swc": ("1", raw)})])

    def noted(self, data: Any) -> Tuple[fields.Fields, str]:
        data.to_netcdf(self.folder / "foreign.nc")
        status, said = said_by(str(self.folder / "foreign.nc"), str(self.folder / "out.vti"))
        self.assertEqual(status, 0, said)
        return fields.read_vti(self.folder / "out.vti"), said

    def test_what_xarray_cut_thinned_or_joined_has_new_cells(self) -> None:
        own = self.own()
        for data, count, low, size, note in (
                (own, 6, 1, 0.1, ""), (own.isel(x=slice(2, 4)), 2, 1.2, 0.1, ""), (own.isel(x=slice(0, 3)), 3, 1, 0.1, ""),
                (own.isel(x=slice(0, 1)), 1, 1, 0.1, ""),
                # cells of 0.1 around 1.05, 1.25 and 1.45: those in between are not there
                (own.isel(x=slice(0, 6, 2)), 3, 0.95, 0.2, "x_bnds does not fit x"),
                (own.coarsen(x=2).mean(), 3, 1, 0.2, "x_bnds does not fit x"),
                (own.assign_coords(x=own.x + 0.03), 6, 1.03, 0.1, "x_bnds does not fit x"),
                (own.isel(x=slice(None, None, -1)), 6, 1, 0.1, "")):
            with self.subTest(low=low, size=size):
                # arithmetic with coordinates loses their attributes
                data.x.attrs.update(own.x.attrs)
                found, said = self.noted(data)
                self.assertCells(found, "x", count, low, size)
                self.assertCells(found, "y", 4, 2, 0.2)
                self.assertRegex(said, f"^note: .*{note}.*\\.\n$" if note else "^$")
        self.assertEqual(self.values(self.noted(own.isel(x=slice(2, 4)))[0])[:3], [2, 3, 8])
        # one cell of six that were joined, or one that was cut out
        for one in (own.coarsen(x=3).mean().isel(x=slice(1, 2)), own.isel(x=slice(4, 5))):
            self.refused(one, "x has one cell and no bounds that are sure")
        del one.attrs["espalier_cell_size"]
        self.assertCells(self.converted(one), "x", 1, 1.4, 0.1)

    def vertical(self, name: str, **attributes: str) -> Any:
        data = self.base()
        data[name].attrs.update(attributes)
        return data

    def test_a_vertical_z_becomes_y(self) -> None:
        # the value at (x, y, z) is x + 4 y + 12 z, in numbers of cells
        up = self.vertical("z", axis="Z", positive="up", standard_name="height")
        up.x.attrs["axis"], up.y.attrs["axis"] = "X", "Y"
        found, said = self.noted(up)
        self.assertEqual(said, "")
        self.assertCells(found, "x", 4, -0.05, 0.1)
        # up is y, and south (-y) is z
        self.assertCells(found, "y", 2, -0.25, 0.5)
        self.assertCells(found, "z", 3, -0.25, 0.1)
        self.assertEqual(self.values(found), [x + 4 * (2 - z) + 12 * y for z in range(3) for y in range(2) for x in range(4)])
        for attributes in ({"positive": "down"}, {"standard_name": "depth"}, {"axis": "Z", "positive": "down", "standard_name": "depth_below_geoid"}):
            found = self.converted(self.vertical("z", **attributes))
            self.assertCells(found, "y", 2, -0.75, 0.5)
            self.assertEqual(self.values(found), [x + 4 * (2 - z) + 12 * (1 - y) for z in range(3) for y in range(2) for x in range(4)])

    def test_a_vertical_y_stays_y(self) -> None:
        data = self.vertical("y", axis="Z", positive="up")
        found, said = self.noted(data)
        self.assertEqual((said, self.values(found)), ("", list(range(24))))
        found = self.converted(self.vertical("y", positive="down"))
        self.assertCells(found, "y", 3, -0.25, 0.1)
        self.assertEqual(self.values(found)[:5], [8, 9, 10, 11, 4])
        self.assertRegex(self.noted(self.base())[1], "^note: .*y is taken as up")

    def test_axes_that_contradict_are_refused(self) -> None:
        for name, attributes, said in (
                ("z", {"axis": "Z"}, "declared as the axes ., ., Z: y or z must be Z, with the attribute positive"), ("z", {"axis": "Y", "positive": "up"}, "of z contradict"),
                ("z", {"standard_name": "depth", "positive": "up"}, "of z contradict"), ("y", {"axis": "Y"}, r"declared as the axes \?, Y, \?"),
                ("x", {"positive": "up"}, "declared as the axes Z"), ("x", {"standard_name": "projection_y_coordinate"}, "the axes Y"),
                ("z", {"positive": "sideways"}, "of z contradict")):
            with self.subTest(attributes):
                self.refused(self.vertical(name, **attributes), said)
        data = self.vertical("z", positive="up")
        data.y.attrs["positive"] = "up"
        self.refused(data, r"declared as the axes \?, Z, Z")

    def bounded(self, middles: List[float], bounds: List[List[float]], name: str = "x_bounds") -> Any:
        data = self.base(nx=len(middles))
        data = data.assign_coords(x=("x", middles, {"units": "m", "bounds": name}))
        data[name] = (("x", "nv"), bounds)
        return data

    def test_bounds_are_found_by_their_attribute_and_checked(self) -> None:
        self.assertCells(self.converted(self.bounded([0.1], [[0.0, 0.3]])), "x", 1, 0, 0.3)
        # a coordinate need not be in the middle of its cell
        self.assertCells(self.converted(self.bounded([0.2, 0.4], [[0.0, 0.2], [0.2, 0.4]])), "x", 2, 0, 0.2)
        found = self.converted(self.bounded([0.3, 0.1], [[0.4, 0.2], [0.2, 0.0]]))
        self.assertCells(found, "x", 2, 0, 0.2)
        self.assertEqual(self.values(found)[:2], [1, 0])
        for middles, bounds in (([0, 0.1, 0.5, 1.5], [[-0.05, 0.05], [0.05, 0.2], [0.2, 1], [1, 2]]),
                                ([0.05, 0.25], [[0, 0.1], [0.2, 0.3]]), ([5.0, 6.0], [[0, 1], [1, 2]]), ([0.5, 1.5], [[0, 1.5], [0.5, 2]])):
            with self.subTest(bounds):
                self.refused(self.bounded(middles, bounds), "bounds x_bounds are not those of equal cells side by side")
        self.refused(self.bounded([0.5, 1.5], [[0, 0.5, 1], [1, 1.5, 2]]), r"have the shape \(2, 3\): 2 cells along x need 2 × 2")

    def test_axes_in_single_precision_and_descending_axes_are_read(self) -> None:
        import numpy
        import xarray

        axis = numpy.arange(100, dtype="f4") * numpy.float32(0.01) + numpy.float32(4.5)
        found = self.converted(xarray.Dataset({"swc": (("z", "y", "x"), numpy.zeros((2, 2, 100)))}, {"x": axis, "y": [0.0, 1], "z": [0.0, 1]}))
        self.assertEqual(found.grid.cells[0], 100)
        self.assertAlmostEqual(found.grid.spacing[0], 0.01, places=7)
        self.assertAlmostEqual(found.grid.position[0], 4.495, places=5)
        self.assertEqual(self.converted(self.base().isel(y=slice(None, None, -1), z=[1, 0])), self.converted(self.base()))
        # places that single precision cannot tell apart
        axis = numpy.arange(9, dtype="f4") * numpy.float32(0.3) + numpy.float32(4e6)
        self.refused(xarray.Dataset({"swc": (("z", "y", "x"), numpy.zeros((2, 2, 9)))}, {"x": axis, "y": [0.0, 1], "z": [0.0, 1]}), "not equal")


@unittest.skipUnless(HAS_LIBRARIES, "xarray, netCDF4 or zarr is not installed (Debian: python3-xarray python3-netcdf4 python3-zarr)")
class Files(Foreign):
    def test_variables_that_are_left_out_are_named(self) -> None:
        data = self.base()
        data["swc2"] = data.swc.expand_dims(time=2, member=3)
        data["total"] = data.swc.sum()
        data.to_netcdf(self.folder / "a.nc")
        status, said = said_by(str(self.folder / "a.nc"), str(self.folder / "out.vti"))
        self.assertEqual(status, 0)
        self.assertRegex(said, r"note: swc2\(time, member, z, y, x\), total\(\) cannot be read: a quantity has .*\.\n")
        self.assertEqual(list(fields.read_vti(self.folder / "out.vti").quantities), ["swc"])
        self.refused(data.drop_vars("swc"), r"has no quantity, and swc2\(time, member, z, y, x\), total\(\) cannot be read")

    def test_groups_are_listed_and_chosen(self) -> None:
        for name in ("a.nc", "a.zarr"):
            with self.subTest(name):
                source, target = str(self.folder / name), str(self.folder / "out.vti")
                write = self.base().to_zarr if name.endswith("zarr") else self.base().to_netcdf
                write(source, group="soil/top", mode="w")
                self.assertIn("are in groups (soil): choose one with --group", said_by(source, target)[1])
                self.assertIn("are in groups (soil/top): choose", said_by(source, target, "--group", "soil")[1])
                self.assertEqual(said_by(source, target, "--group", "soil/top")[0], 0)
                self.assertEqual(self.values(fields.read_vti(target)), list(range(24)))
                self.assertRegex(said_by(source, target, "--group", "rock")[1], r"^error: .* cannot be opened .*\.\n$")
                self.assertEqual(said_by(source, str(self.folder / "b.nc"), "--group", "soil/top")[0], 0)
                self.assertEqual(self.values(self.read("b.nc")), list(range(24)))

    def test_damaged_values_are_refused_by_name(self) -> None:
        data = self.base(40, 30, 20)
        data.to_netcdf(self.folder / "good.nc", encoding={"swc": {"zlib": True, "chunksizes": (5, 10, 10)}})
        raw = (self.folder / "good.nc").read_bytes()
        half = len(raw) // 2
        (self.folder / "flip.nc").write_bytes(raw[:half] + b"\xff" * 2000 + raw[half + 2000:])
        for target in ("out.vti", "out.nc", "out.zarr"):
            status, said = said_by(str(self.folder / "flip.nc"), str(self.folder / target))
            self.assertEqual(status, 1)
            self.assertRegex(said, r"^error: swc cannot be read \(RuntimeError: .*\): the file is damaged, so copy it or write it again\.\n$")
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["flip.nc", "good.nc"])

    def test_a_target_that_cannot_be_written_is_refused(self) -> None:
        self.base().to_netcdf(self.folder / "a.nc")
        (self.folder / "file").touch()
        for target in ("nowhere/out.vti", "nowhere/out.nc", "nowhere/out.zarr", "file/out.vti"):
            status, said = said_by(str(self.folder / "a.nc"), str(self.folder / target))
            self.assertEqual(status, 1)
            self.assertNotIn(".espalier-", said)
            self.assertRegex(said, r"^error: .* cannot be written \(.*\): give a path in a folder that exists, that you may write to and that has room\.\n$")

    def test_a_source_that_is_not_there_is_a_name_to_check(self) -> None:
        for name, remedy in (("č.nc", "check the name"), ("č.vti", "check its name")):
            said = said_by(str(self.folder / name), str(self.folder / "out.vti" if name == "č.nc" else self.folder / "out.nc"))[1]
            self.assertRegex(said, rf"^error: .*{name} cannot be .*No such file or directory.*: {remedy}")
            self.assertNotIn("\\xc4", said)

    def test_steps_that_are_not_there_are_refused(self) -> None:
        self.base().expand_dims(time=[0.0, 1.0]).to_netcdf(self.folder / "a.nc")
        for step in ("2", "-3"):
            self.assertIn(f"has no step {step}", said_by(str(self.folder / "a.nc"), str(self.folder / "out.vti"), "--step", step)[1])

    def grid(self, name: str, counts: Dict[str, int], more: int = 1) -> str:
        """A small file of many cells that nobody wrote."""
        import netCDF4
        import numpy

        with netCDF4.Dataset(self.folder / name, "w") as file:
            for axis, count in counts.items():
                file.createDimension(axis, count)
                file.createVariable(axis, "f8", (axis,))[:] = numpy.arange(count)
            file.createVariable("q", "f8", ("z", "y", "x"), zlib=True, chunksizes=(2, counts["y"], counts["x"]))
            file.createDimension("t", more)
            file.createVariable("t", "f8", ("t",), zlib=True, chunksizes=(min(more, 10 ** 6),))
        return str(self.folder / name)

    def test_a_small_file_of_many_cells_is_refused_at_once(self) -> None:
        bomb = self.grid("bomb.nc", {"x": 1000, "y": 1000, "z": 190})
        self.assertLess(os.path.getsize(bomb), 100_000)
        for target in ("out.vti", "out.zarr", "out.nc"):
            self.assertIn("has 190000000 cells, and from 1 to 20000000 can be read", said_by(bomb, str(self.folder / target))[1])
        self.assertEqual([path.name for path in self.folder.iterdir()], ["bomb.nc"])
        axis = self.grid("axis.nc", {"x": 2, "y": 2, "z": 2}, more=30_000_000)
        self.assertIn("an axis of 30000000, and at most 20000000 can be read", said_by(axis, str(self.folder / "out.vti"))[1])
        self.base().to_netcdf(self.folder / "a.nc")
        command = [sys.executable, "-m", "espalier.fields", str(self.folder / "a.nc"), str(self.folder / "out.vti")]
        for most, status in (("23", 1), ("24", 0), ("many", 0)):
            done = subprocess.run(command, env=variables(ESPALIER_FIELD_CELLS=most), check=False, capture_output=True, timeout=SECONDS)
            self.assertEqual(done.returncode, status, done.stderr)

    def test_pieces_of_a_file_are_the_file(self) -> None:
        # more than two pieces of 3 MiB, and a last one that needs padding
        count = 2 * 3 * 2**20 // 8 + 5
        raw = os.urandom(8 * count)
        found = fields.Fields(fields.Grid((count, 1, 1), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), {"q": ("1", raw), "r": ("m", raw[::-1])})
        (self.folder / "big.vti").write_text("".join(fields.vti_text(found)), encoding="utf-8")
        self.assertEqual(fields.read_vti(self.folder / "big.vti"), found)

    def test_an_ended_conversion_leaves_nothing(self) -> None:
        self.base().to_netcdf(self.folder / "a.nc")
        # the program ends itself while it writes
        code = ("import base64, os, runpy, signal\n"
                "base64.b64encode = lambda data: [print(os.listdir(folder), flush=True), os.kill(os.getpid(), signal.SIGTERM)] and b''\n"
                "import sys; folder = os.path.dirname(sys.argv[1]); runpy.run_module('espalier.fields', run_name='__main__')")
        done = subprocess.run([sys.executable, "-c", code, str(self.folder / "a.nc"), str(self.folder / "out.vti")], env=variables(),
                              capture_output=True, text=True, timeout=SECONDS, check=False)
        self.assertEqual(done.returncode, 143, done.stderr)
        self.assertIn(".espalier-", done.stdout)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["a.nc"])


if __name__ == "__main__":
    unittest.main()
