"""Quantities in space as data sets of the climate and forecast conventions (CF): netCDF and Zarr, in and out.

    python3 -m espalier.fields water-*.vti water.nc      # the files of `espalier run --every --field water.vti`
    python3 -m espalier.fields water.nc water.vti        # the last step, for "fieldFile" of an environment

A suffix chooses the format: .vti (one file for each step), .nc (netCDF 4) or .zarr (Zarr, version 2). All numbers keep their bits.
Needs xarray, and netCDF4 or zarr for the format (Debian: python3-xarray, python3-netcdf4, python3-zarr).
"""

from __future__ import annotations

import argparse
import base64
import binascii
import os
import re
import shutil
import struct
import sys
import tempfile
import warnings
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

from .version import VERSION

# a larger grid needs more memory than a description of a few bytes should cost
MOST_CELLS = 200_000_000
AXES = ("x", "y", "z")
# y is up in a model; the conventions call the vertical axis Z
CF_AXES = {"x": "X", "y": "Z", "z": "Y"}
# the numbers in cells that nobody wrote (netcdf.h, NC_FILL_)
NEVER_WRITTEN = {"f8": 9.969209968386869e36, "f4": 9.969209968386869e36, "i2": -32767, "i4": -2147483647, "u2": 65535, "u4": 4294967295}
STANDARD_NAMES = {"waterContent": "volume_fraction_of_condensed_water_in_soil"}


class FieldError(Exception):
    """A file that cannot be read or written: one sentence, with what to do."""


class FieldWarning(UserWarning):
    """What was left out of a file, or taken for granted: one sentence."""


class Grid(NamedTuple):
    """Equal cells in a box. Lengths are in the unit of the model."""

    cells: Tuple[int, int, int]
    position: Tuple[float, float, float]  # low corner
    spacing: Tuple[float, float, float]


class Fields(NamedTuple):
    """The quantities of one step."""

    grid: Grid
    quantities: Dict[str, Tuple[str, bytes]]  # unit, and little-endian doubles with x fastest, then y, then z


def _count(grid: Grid, where: str) -> int:
    count = grid.cells[0] * grid.cells[1] * grid.cells[2]
    if not 0 < count <= MOST_CELLS:
        raise FieldError(f"{where} has {count} cells, and from 1 to {MOST_CELLS} can be read: write a coarser grid.")
    if not all(abs(value) < float("inf") for value in (*grid.position, *grid.spacing)) or min(grid.spacing) <= 0:
        raise FieldError(f"{where} has cells without a size: write the file again.")
    return count


def read_vti(path: "str | os.PathLike[str]") -> Fields:
    """Reads a .vti file that Espalier wrote. Raises FieldError."""
    try:
        text = Path(path).read_text(encoding="utf-8")
        # entities could grow without bound
        if "<!" in text:
            raise FieldError(f"{path} has declarations, which a .vti file of Espalier has not: write the file again.")
        image = xml.fromstring(text).find("ImageData")
        if image is None:
            raise FieldError(f"{path} is no VTK image: give a .vti file that `espalier run --field` wrote.")
        extent = [int(number) for number in image.attrib["WholeExtent"].split()]
        low, high = extent[0::2], extent[1::2]
        origin, spacing = ([float(number) for number in image.attrib[key].split()] for key in ("Origin", "Spacing"))
        if not len(low) == len(high) == len(origin) == len(spacing) == 3:
            raise ValueError("three numbers for each axis")
        grid = Grid((high[0] - low[0], high[1] - low[1], high[2] - low[2]), (origin[0], origin[1], origin[2]),
                    (spacing[0], spacing[1], spacing[2]))
        size = 8 * _count(grid, str(path))
        quantities = {}
        for array in image.iter("DataArray"):
            raw = base64.b64decode("".join((array.text or "").split()), validate=True)
            if array.attrib["type"] != "Float64" or len(raw) != size + 8 or struct.unpack_from("<Q", raw)[0] != size:
                raise FieldError(f"{path}: '{array.attrib.get('Name')}' does not have {size} bytes of doubles: the file is not complete.")
            quantities[array.attrib["Name"]] = (array.attrib.get("Unit", "1"), raw[8:])
    except (OSError, KeyError, ValueError, binascii.Error, struct.error, xml.ParseError) as error:
        raise FieldError(f"{path} cannot be read as a .vti file ({error}): write it again with `espalier run --field`.") from None
    if not quantities:
        raise FieldError(f"{path} has no quantities: write it again with `espalier run --field`.")
    return Fields(grid, quantities)


def vti_text(fields: Fields) -> str:
    """The text of a .vti file, as Espalier writes it."""
    def numbers(values: Sequence[float]) -> str:
        return " ".join(repr(value)[:-2] if repr(value).endswith(".0") else repr(value) for value in values)

    extent = " ".join(f"0 {count}" for count in fields.grid.cells)
    lines = ['<?xml version="1.0"?>', '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
             f'<ImageData WholeExtent="{extent}" Origin="{numbers(fields.grid.position)}" Spacing="{numbers(fields.grid.spacing)}">',
             f'<Piece Extent="{extent}">', f'<CellData Scalars="{next(iter(fields.quantities))}">']
    for name, (unit, raw) in fields.quantities.items():
        data = base64.b64encode(struct.pack("<Q", len(raw)) + raw).decode()
        lines += [f'<DataArray type="Float64" Name="{name}" Unit="{unit}" format="binary">', data, "</DataArray>"]
    return "\n".join([*lines, "</CellData>", "</Piece>", "</ImageData>", "</VTKFile>", ""])


def _xarray() -> Any:
    try:
        import numpy  # noqa: F401
        import xarray
    except ImportError:
        raise FieldError("xarray is not installed: install it (Debian: python3-xarray), then try again.") from None
    return xarray


def dataset(steps: Sequence[Fields], numbers: "Sequence[int] | None" = None) -> Any:
    """An xarray.Dataset of the steps, with coordinates in the middle of the cells, their bounds, and units. `numbers` are those
    of the steps (0, 1, …). Raises FieldError when the steps have different grids or quantities."""
    xarray = _xarray()
    import numpy

    first = steps[0]
    _count(first.grid, "the grid")
    for step in steps:
        if step.grid != first.grid or {n: u for n, (u, _) in step.quantities.items()} != {n: u for n, (u, _) in first.quantities.items()}:
            raise FieldError("the files have different grids or quantities: give files of one run.")
    variables: Dict[str, Any] = {}
    coordinates: Dict[str, Any] = {"step": ("step", numpy.asarray(range(len(steps)) if numbers is None else numbers, dtype="i4"),
                                            {"long_name": "number of the step", "units": "1"})}
    for axis, (name, count) in enumerate(zip(AXES, first.grid.cells)):
        low, size = first.grid.position[axis], first.grid.spacing[axis]
        edges = low + size * numpy.arange(count + 1)
        attributes = {"long_name": "height" if name == "y" else f"distance along {name}", "units": "m", "axis": CF_AXES[name],
                      "bounds": f"{name}_bnds", **({"positive": "up", "standard_name": "height"} if name == "y" else {})}
        coordinates[name] = (name, low + size * (numpy.arange(count) + 0.5), attributes)
        variables[f"{name}_bnds"] = ((name, "bnds"), numpy.stack([edges[:-1], edges[1:]], axis=1))
    shape = tuple(reversed(first.grid.cells))
    for name, (unit, _) in first.quantities.items():
        values = numpy.stack([numpy.frombuffer(step.quantities[name][1], dtype="<f8").reshape(shape) for step in steps])
        words = re.sub(r"([a-z])([A-Z])", lambda match: f"{match[1]} {match[2].lower()}", name).replace(".", " ")
        variables[name] = (("step", "z", "y", "x"), values,
                           {"long_name": words, "units": unit, "cell_methods": "x: y: z: mean",
                            **({"standard_name": STANDARD_NAMES[name]} if name in STANDARD_NAMES else {})})
    described: Dict[str, Any] = {"Conventions": "CF-1.8", "title": "Quantities in space of an environment of Espalier", "source": f"Espalier {VERSION}",
                                 "espalier_position": list(first.grid.position), "espalier_cell_size": list(first.grid.spacing),
                                 "espalier_quantities": " ".join(first.quantities)}
    return xarray.Dataset(variables, coordinates, described)


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {str(error).splitlines()[0].rstrip('.') if str(error) else 'no reason'}"


def _note(text: str) -> None:
    warnings.warn(text, FieldWarning, stacklevel=2)


def _numbers(variable: Any, name: str, hasMissing: bool = True) -> Any:
    """The values of a variable of a file, unpacked as section 8.1 of the conventions says. Missing values raise FieldError."""
    try:
        stored = variable.values
    except Exception as error:  # whatever the libraries raise on damaged bytes
        raise FieldError(f"{name} cannot be read ({_said(error)}): the file is damaged, so copy it or write it again.") from None
    if stored.dtype.kind not in "iuf":
        raise FieldError(f"{name} holds {stored.dtype} and not numbers: remove it, or write it as numbers.")
    try:
        return _unpacked(stored, variable.attrs, name, hasMissing)
    except (TypeError, ValueError) as error:
        raise FieldError(f"the attributes of {name} for missing or packed values are not numbers ({_said(error)}): mend them.") from None


def _unpacked(stored: Any, attributes: Any, name: str, hasMissing: bool) -> Any:
    import numpy

    isUnsigned = stored.dtype.kind == "i" and str(attributes.get("_Unsigned", "")).lower() == "true"
    kind = numpy.dtype(stored.dtype.str.replace("i", "u")) if isUnsigned else stored.dtype
    stored = stored.view(kind)
    if hasMissing:
        # a cell that was never written holds the number that netCDF has for its type
        marks = [NEVER_WRITTEN[kind.str[1:]]] if kind.str[1:] in NEVER_WRITTEN and "_FillValue" not in attributes else []
        marks += [attributes[key] for key in ("_FillValue", "missing_value") if key in attributes]
        isMissing = ~numpy.isfinite(stored)
        for mark in marks:
            isMissing |= numpy.isin(stored, numpy.atleast_1d(mark).astype(kind.str.replace("u", "i")).astype(kind))
        low, high = attributes.get("valid_range", (attributes.get("valid_min"), attributes.get("valid_max")))
        isMissing |= (False if low is None else stored < low) | (False if high is None else stored > high)
        if isMissing.any():
            raise FieldError(f"{name} has values that are missing or not finite: fill them first.")
    packing = [numpy.asarray(attributes[key]).reshape(()) for key in ("scale_factor", "add_offset") if key in attributes]
    if packing:
        isSingle = all(number.dtype == "f4" for number in packing) and (kind.itemsize <= 2 or kind == "f4")
        unpacked = numpy.dtype("f4" if isSingle else "f8").type
        stored = stored.astype(unpacked) * unpacked(attributes.get("scale_factor", 1)) + unpacked(attributes.get("add_offset", 0))
    return stored


def _turned(data: Any) -> List[Tuple[str, int]]:
    """The coordinate along x, y and z of a model, and its sign. Where z is declared vertical, the axes are turned as those of LAS
    files: x stays, up is y, and -y is z."""
    roles, ways = "", {}
    for name in AXES:
        said = {key: str(value) for key, value in data[name].attrs.items()}
        standard = re.fullmatch(r"(altitude|height|(depth))(_.+)?|projection_([xy])_coordinate", said.get("standard_name", "")) or [""] * 5
        way = {said.get("positive", "").lower(), "down" if standard[2] else "up" if standard[1] else ""} - {""}
        role = {said.get("axis", "").upper(), (standard[4] or "").upper(), "Z" if way else ""} - {""}
        if len(role) > 1 or len(way) > 1 or not way <= {"up", "down"}:
            raise FieldError(f"the attributes axis, positive and standard_name of {name} contradict each other: mend or remove them.")
        roles += "".join(role) or "?"
        ways[name] = "".join(way)
    if re.fullmatch("[X?][Y?]Z", roles):
        if not ways["z"]:
            raise FieldError("the axis z is vertical without a direction: add its attribute positive, 'up' or 'down'.")
        return [("x", 1), ("z", 1 if ways["z"] == "up" else -1), ("y", -1)]
    if not re.fullmatch("[X?][Z?][Y?]", roles):
        raise FieldError(f"x, y and z are declared as the axes {', '.join(roles)}: y or z must be Z, with the attribute positive, 'up' or 'down'.")
    if "Z" not in roles:
        _note("no axis is declared vertical, and y is taken as up: declare it with the attributes axis = 'Z' and positive.")
    return [("x", 1), ("y", -1 if ways["y"] == "down" else 1), ("z", 1)]


def _cells(data: Any, name: str, sign: int, own: "Tuple[float, float] | None") -> Tuple[float, float, int]:
    """Low edge and size of equal cells along an axis, and -1 where it descends. `own` is what Espalier wrote of it."""
    import numpy

    found = _numbers(data[name], name, hasMissing=False)
    count, middles = len(found), sign * found.astype("f8")
    step = -1 if middles[-1] < middles[0] else 1
    middles = middles[::step]
    rounding = 4 * float(numpy.finfo(found.dtype if found.dtype.kind == "f" else "f8").eps) * abs(middles).max()

    def areNear(values: Any, place: float, low: float, size: float) -> bool:
        return bool(abs(values - low - size * (numpy.arange(count) + place)).max() <= max(1e-6 * size, min(rounding, 0.01 * size)))

    if own is not None and sign == 1 and abs(middles - own[0] - own[1] * (numpy.arange(count) + 0.5)).max() <= rounding:
        return (*own, step)
    named = str(data[name].attrs.get("bounds", data[name].encoding.get("bounds", f"{name}_bnds")))
    if named in data.variables:
        edges = sign * _numbers(data[named], named, hasMissing=False).astype("f8")
        if edges.shape != (count, 2):
            raise FieldError(f"the bounds {named} have the shape {edges.shape}: {count} cells along {name} need {count} × 2.")
        edges = numpy.sort(edges[::step], axis=1)
        low, size = float(edges[0, 0]), float(edges[-1, 1] - edges[0, 0]) / count
        join = areNear(edges[:, 0], 0, low, size) and areNear(edges[:, 1], 1, low, size)
        if join and (areNear(middles, 0.5, low, size) or (own is None and (edges[:, 0] <= middles).all() and (middles <= edges[:, 1]).all())):
            # cells that were joined to one look like one that was cut out
            if own is not None and count == 1:
                raise FieldError(f"the size of the one cell along {name} is not sure, because the data set was changed: make {named} right, "
                                 "then remove the attribute espalier_cell_size.")
            return low, size, step
        if own is None:
            raise FieldError(f"the bounds {named} are not those of equal cells side by side around {name}: interpolate to equal cells first.")
        # functions that join, thin or move cells leave the bounds that Espalier wrote as they were, or take their mean
        _note(f"{named} does not fit {name} any more, and is not used: the cells are taken to fill the space between the middles.")
    if count < 2:
        raise FieldError(f"the axis {name} has one cell and no bounds around it: its size is not known. Add {name}_bnds.")
    size = float(middles[-1] - middles[0]) / (count - 1)
    low = float(middles[0]) - size / 2
    if not areNear(middles, 0.5, low, size):
        raise FieldError(f"the cells along {name} are not equal and rising or falling: interpolate them to equal cells first.")
    return low, size, step


def _grid(data: Any) -> Tuple[Grid, List[str], Tuple[int, ...]]:
    """The cells of a data set, its axes that are x, y and z of a model, and -1 for each that descends."""
    missing = [name for name in AXES if name not in data.coords or data[name].dims != (name,)]
    if missing:
        raise FieldError(f"the data set has no axis {missing[0]}: it needs the coordinates x, y and z in metres.")
    for name in AXES:
        if data[name].attrs.get("units", "m") not in ("m", "metre", "meter", "metres", "meters"):
            raise FieldError(f"the axis {name} is in {data[name].attrs['units']!r}: convert it to metres, or remove its units if "
                             "the lengths are those of the model.")
    sources = _turned(data)
    counts: Any = tuple(int(data.sizes[name]) for name, _ in sources)
    _count(Grid(counts, (0, 0, 0), (1, 1, 1)), "the data set")
    try:
        own: Any = [tuple(map(float, data.attrs[key])) for key in ("espalier_position", "espalier_cell_size")]
        owns = dict(zip(AXES, zip(*own)))
    except (KeyError, TypeError, ValueError):
        owns = {}
    found: Any = [_cells(data, name, sign, owns.get(name)) for name, sign in sources]
    lows, sizes, ways = zip(*found)
    grid = Grid(counts, lows, sizes)
    _count(grid, "the data set")
    return grid, [name for name, _ in sources], ways


def fields_of(data: Any, step: int = -1) -> Fields:
    """The quantities of a step (the last) of a data set with the dimensions x, y, z and perhaps one more, its times. Raises
    FieldError."""
    _xarray()
    import numpy

    grid, names, ways = _grid(data)
    quantities = {}
    # a Zarr folder has no order of its own
    order = str(data.attrs.get("espalier_quantities", "")).split()
    for name, variable in sorted(data.data_vars.items(), key=lambda item: order.index(item[0]) if item[0] in order else len(order)):
        times = [dimension for dimension in variable.dims if dimension not in AXES]
        if name.endswith("_bnds") or not set(AXES) <= set(variable.dims) or len(times) > 1:
            continue
        chosen = variable.isel({times[0]: step}) if times else variable
        if not re.fullmatch(r"[\w.-]+", name):
            raise FieldError(f"the quantity {name!r} has a name that no file can hold: use letters, digits and points.")
        values = numpy.ascontiguousarray(_numbers(chosen.transpose(*names[::-1]), name)[::ways[2], ::ways[1], ::ways[0]], dtype="<f8")
        quantities[name] = (re.sub(r'[<>&"]', "", str(variable.attrs.get("units", "1"))), values.tobytes())
    if not quantities:
        raise FieldError("the data set has no quantity over x, y and z: its variables need these three dimensions.")
    return Fields(grid, quantities)


def open_dataset(path: "str | os.PathLike[str]") -> Any:
    """Opens a .nc file or .zarr folder. The numbers are as they are stored: times are not dates, and `fields_of` unpacks. Raises
    FieldError."""
    xarray = _xarray()
    asStored = {"decode_times": False, "decode_timedelta": False, "mask_and_scale": False}
    try:
        if not str(path).rstrip("/").endswith(".zarr"):
            return xarray.open_dataset(path, **asStored)
        import zarr  # type: ignore[import]

        data = xarray.open_zarr(path, chunks=None, consolidated=(Path(path) / ".zmetadata").is_file(), **asStored)
        arrays = dict(zarr.open_group(str(path), mode="r").arrays())
    except Exception as error:  # whatever the libraries raise on a stranger's file
        raise FieldError(f"{path} cannot be opened ({_said(error)}): give a .nc file or a .zarr folder that is complete.") from None
    for name, variable in data.variables.items():
        array = arrays[name]
        if array.fill_value is None and array.nchunks_initialized < array.nchunks:
            raise FieldError(f"{path} has {array.nchunks_initialized} of {array.nchunks} parts of {name}: copy it again.")
        # xarray takes every fill value for a mark of missing data, but 0 is what zarr writes when nobody chose
        if "_FillValue" in array.attrs:
            variable.attrs["_FillValue"] = array.attrs["_FillValue"]
        elif name in data.dims or array.fill_value == 0:
            variable.attrs.pop("_FillValue", None)
    return data


def _save(data: Any, path: Path) -> None:
    """Writes a data set beside its place and moves it there when it is complete."""
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".espalier-") as folder:
        part = Path(folder) / path.name
        try:
            if path.suffix == ".zarr":
                data.to_zarr(part, consolidated=True)
            else:
                data.to_netcdf(part, engine="netcdf4", encoding={name: {"_FillValue": None} for name in data.variables})
        except ImportError as error:
            raise FieldError(f"{error}: install it (Debian: python3-netcdf4, python3-zarr), then try again.") from None
        if path.suffix == ".zarr" and path.is_dir():
            shutil.rmtree(path)
        os.replace(part, path)


def convert(sources: Sequence["str | os.PathLike[str]"], target: "str | os.PathLike[str]", step: int = -1) -> None:
    """Converts files by their suffixes. Several .vti files become the steps of one data set, in the order given. Raises
    FieldError; the target is then as it was."""
    into = Path(target)
    if Path(sources[0]).suffix == ".vti":
        steps = [read_vti(source) for source in sources]
        found = [re.search(r"(\d+)\.vti$", str(source)) for source in sources]
        numbers = [int(match[1]) for match in found if match]
        data = dataset(steps, numbers if len(numbers) == len(steps) else None)
    else:
        if len(sources) > 1:
            raise FieldError("several sources must be .vti files of one run.")
        data = open_dataset(sources[0])
    if into.suffix in (".nc", ".zarr"):
        _save(data, into)
    elif into.suffix == ".vti":
        try:
            fields = fields_of(data, step)
        except IndexError:
            raise FieldError(f"the data set has no step {step}: choose another with --step.") from None
        part = into.with_name(f".{into.name}.part")
        part.write_text(vti_text(fields), encoding="utf-8")
        os.replace(part, into)
    else:
        raise FieldError(f"'{into.suffix}' is not a format: the target ends in .nc, .zarr or .vti.")


def main(arguments: "List[str] | None" = None) -> int:
    parser = argparse.ArgumentParser(prog="python3 -m espalier.fields", formatter_class=argparse.RawDescriptionHelpFormatter,
                                     description=__doc__)
    parser.add_argument("source", nargs="+", help=".vti files of one run, or one .nc or .zarr")
    parser.add_argument("target", help=".nc, .zarr or .vti")
    parser.add_argument("--step", type=int, default=-1, help="for a .vti: the place of the step in the data set, from 0 (the last)")
    options = parser.parse_args(arguments)
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        try:
            convert(options.source, options.target, options.step)
        except FieldError as error:
            print(f"error: {error}", file=sys.stderr)
            return 1
    # warnings of the libraries are about their own code
    for text in dict.fromkeys(str(note.message) for note in notes if isinstance(note.message, FieldWarning)):
        print(f"note: {text}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
