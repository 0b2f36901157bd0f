"""Data sets of other programs as fields: what xarray changed, packed and missing numbers, axes, groups, damage."""

import contextlib
import importlib.util
import io
import os
import shutil
import signal
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
        """What Espalier reads from a data set that xarray wrote, without a warning of a library."""
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


if __name__ == "__main__":
    unittest.main()
