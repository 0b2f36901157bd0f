"""Quantities in space as data sets of the climate and forecast conventions (CF): netCDF and Zarr, in and out.

    python3 -m espalier.fields water-*.vti water.nc      # the files of `espalier run --every --field water.vti`
    python3 -m espalier.fields water.nc water.vti        # the last step, for "fieldFile" of an environment

A suffix chooses the format: .vti (one file for each step), .nc (netCDF 4) or .zarr (Zarr, version 2). All numbers keep their bits.
Needs xarray, and netCDF4 or zarr for the format (Debian: python3-xarray, python3-netcdf4, python3-zarr).
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import os
import re
import shutil
import signal
import struct
import sys
import tempfile
import warnings
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Sequence, Tuple, cast

from .fields_checks import LENGTH_UNITS, MOST_CELLS, MOST_READ, FieldError as FieldError, FieldWarning as FieldWarning, Grid as Grid
from .fields_checks import check_netcdf, check_zarr, checked_store
from .version import VERSION

AXES = ("x", "y", "z")
# y is up in a model; the conventions call the vertical axis Z
CF_AXES = {"x": "X", "y": "Z", "z": "Y"}
# the numbers in cells that nobody wrote (netcdf.h, NC_FILL_)
NEVER_WRITTEN = {"f8": 9.969209968386869e36, "f4": 9.969209968386869e36, "i2": -32767, "i4": -2147483647, "u2": 65535, "u4": 4294967295}
STANDARD_NAMES = {"waterContent": "volume_fraction_of_condensed_water_in_soil"}


class Fields(NamedTuple):
    """The quantities of one step."""
    grid: Grid
    quantities: Dict[str, Tuple[str, bytes]]  # unit, and little-endian doubles with x fastest, then y, then z
    length_unit: str = "m"  # of the grid


def _count(grid: Grid, where: str) -> int:
    count = grid.cells[0] * grid.cells[1] * grid.cells[2]
    if not 0 < count <= MOST_CELLS:
        raise FieldError(f"{where} has {count} cells, and from 1 to {MOST_CELLS} can be read: write a coarser grid, or set ESPALIER_FIELD_CELLS.")
    if not all(abs(value) < float("inf") for value in (*grid.position, *grid.spacing)) or min(grid.spacing) <= 0:
        raise FieldError(f"{where} has cells without a size: write the file again.")
    return count


def read_vti(path: "str | os.PathLike[str]") -> Fields:
    """Reads a .vti file that Espalier wrote. Raises FieldError."""
    try:
        text = Path(path).read_text(encoding="utf-8")
        if "<!" in text:  # entities could grow without bound
            raise FieldError(f"{path} has declarations, which a .vti file of Espalier has not: write the file again.")
        image = xml.fromstring(text).find("ImageData")
        if image is None:
            raise FieldError(f"{path} is no VTK image: give a .vti file that `espalier run --field` wrote.")
        extent = [int(number) for number in image.attrib["WholeExtent"].split()]
        low, high = extent[0::2], extent[1::2]
        origin, spacing = ([float(number) for number in image.attrib[key].split()] for key in ("Origin", "Spacing"))
        if not len(low) == len(high) == len(origin) == len(spacing) == 3:
            raise ValueError("three numbers for each axis")
        grid = Grid((high[0] - low[0], high[1] - low[1], high[2] - low[2]), (origin[0], origin[1], origin[2]), (spacing[0], spacing[1], spacing[2]))
        size = 8 * _count(grid, str(path))
        quantities = {}
        for array in image.iter("DataArray"):
            raw = base64.b64decode("".join((array.text or "").split()), validate=True)
            if array.attrib["type"] != "Float64" or len(raw) != size + 8 or struct.unpack_from("<Q", raw)[0] != size:
                raise FieldError(f"{path}: '{array.attrib.get('Name')}' does not have {size} bytes of doubles: the file is not complete.")
            quantities[array.attrib["Name"]] = (array.attrib.get("Unit", "1"), raw[8:])
    except (OSError, KeyError, ValueError, struct.error, xml.ParseError) as error:
        raise FieldError(f"{path} cannot be read as a .vti file ({error}): check its name, or write it again with `espalier run --field`.") from None
    if not quantities:
        raise FieldError(f"{path} has no quantities: write it again with `espalier run --field`.")
    return Fields(grid, quantities, image.attrib.get("LengthUnit", "m"))


def vti_text(fields: Fields) -> Iterator[str]:
    """The text of a .vti file, as Espalier writes it, in pieces."""
    def numbers(values: Sequence[float]) -> str:
        return " ".join(repr(value)[:-2] if repr(value).endswith(".0") else repr(value) for value in values)

    extent = " ".join(f"0 {count}" for count in fields.grid.cells)
    yield ('<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
           f'<ImageData WholeExtent="{extent}" Origin="{numbers(fields.grid.position)}" Spacing="{numbers(fields.grid.spacing)}"'
           + ("" if fields.length_unit == "m" else f' LengthUnit="{fields.length_unit}"') + ">\n"
           f'<Piece Extent="{extent}">\n<CellData Scalars="{next(iter(fields.quantities))}">\n')
    for name, (unit, raw) in fields.quantities.items():
        yield f'<DataArray type="Float64" Name="{name}" Unit="{unit}" format="binary">\n'
        # a multiple of three bytes has no padding at its end, so the pieces join
        for at in range(-8, len(raw), 3 * 2**20):
            yield base64.b64encode((struct.pack("<Q", len(raw)) if at < 0 else b"") + raw[max(at, 0):at + 3 * 2**20]).decode()
        yield "\n</DataArray>\n"
    yield "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n"


def _libraries() -> Any:
    try:
        import numpy
        import xarray
    except ImportError:
        raise FieldError("xarray is not installed: install it (Debian: python3-xarray), then try again.") from None
    return numpy, xarray


def dataset(steps: Sequence[Fields], numbers: "Sequence[int] | None" = None) -> Any:
    """An xarray.Dataset of the steps, with coordinates in the middle of the cells, their bounds, and units. `numbers` are those
    of the steps (0, 1, …). Raises FieldError when the steps have different grids or quantities."""
    numpy, xarray = _libraries()
    first = steps[0]
    _count(first.grid, "the grid")
    for step in steps:
        if (step.grid, step.length_unit) != (first.grid, first.length_unit) or {n: u for n, (u, _) in step.quantities.items()} != {n: u for n, (u, _) in first.quantities.items()}:
            raise FieldError("the files have different grids or quantities: give files of one run.")
    variables: Dict[str, Any] = {}
    coordinates: Dict[str, Any] = {"step": ("step", numpy.asarray(range(len(steps)) if numbers is None else numbers, dtype="i4"),
                                            {"long_name": "number of the step", "units": "1"})}
    for name, count, low, size in zip(AXES, *first.grid):
        edges = low + size * numpy.arange(count + 1)
        attributes = {"long_name": "height" if name == "y" else f"distance along {name}", "units": first.length_unit, "axis": CF_AXES[name],
                      "bounds": f"{name}_bnds", **({"positive": "up", "standard_name": "height"} if name == "y" else {})}
        coordinates[name] = (name, low + size * (numpy.arange(count) + 0.5), attributes)
        variables[f"{name}_bnds"] = ((name, "bnds"), numpy.stack([edges[:-1], edges[1:]], axis=1))
    for name, (unit, _) in first.quantities.items():
        values = numpy.stack([numpy.frombuffer(step.quantities[name][1], dtype="<f8").reshape(first.grid.cells[::-1]) for step in steps])
        words = re.sub(r"([a-z])([A-Z])", lambda match: f"{match[1]} {match[2].lower()}", name).replace(".", " ")
        standard = {"standard_name": STANDARD_NAMES[name]} if name in STANDARD_NAMES else {}
        variables[name] = (("step", "z", "y", "x"), values, {"long_name": words, "units": unit, "cell_methods": "x: y: z: mean", **standard})
    return xarray.Dataset(variables, coordinates, {
        "Conventions": "CF-1.8", "title": "Quantities in space of an environment of Espalier", "source": f"Espalier {VERSION}",
        "espalier_position": [*first.grid.position], "espalier_cell_size": [*first.grid.spacing], "espalier_quantities": " ".join(first.quantities)})


def _said(error: Exception) -> str:
    # the reason of the system without the name of a file beside the target
    reason = getattr(error, "strerror", None) or str(error) or "no reason"
    return f"{type(error).__name__}: {reason.splitlines()[0].rstrip('.')}"


def _note(text: str) -> None:
    warnings.warn(text, FieldWarning, stacklevel=3)


def _stored(variable: Any, name: str) -> Any:
    if variable.size > MOST_READ:
        raise FieldError(f"{name} has {variable.size} numbers, and at most {MOST_READ} are read at once: choose fewer steps, or set ESPALIER_FIELD_CELLS.")
    try:
        return variable.load().values
    except FieldError:
        raise
    except Exception as error:  # whatever the libraries raise on damaged bytes
        raise FieldError(f"{name} cannot be read ({_said(error)}): the file is damaged, so copy it or write it again.") from None


def _numbers(variable: Any, name: str, hasMissing: bool = True) -> Any:
    """The values of a variable of a file, unpacked as section 8.1 of the conventions says. Missing values raise FieldError."""
    numpy, _ = _libraries()
    stored, said = _stored(variable, name), variable.attrs
    if stored.dtype.kind not in "iuf":
        raise FieldError(f"{name} holds {stored.dtype} and not numbers: remove it, or write it as numbers.")
    kind = numpy.dtype(stored.dtype.str.replace("i", "u")) if str(said.get("_Unsigned")).lower() == "true" else stored.dtype
    stored = stored.view(kind)
    try:
        if hasMissing:
            marks = [said.get("_FillValue", NEVER_WRITTEN.get(kind.str[1:], [])), said.get("missing_value", [])]
            known = numpy.concatenate([numpy.atleast_1d(mark).astype(kind.str.replace("u", "i")).astype(kind) for mark in marks])
            isMissing = ~numpy.isfinite(stored) | numpy.isin(stored, known)
            low, high = said.get("valid_range", (said.get("valid_min"), said.get("valid_max")))
            if isMissing.any() or (low is not None and (stored < low).any()) or (high is not None and (stored > high).any()):
                raise FieldError(f"{name} has values that are missing or not finite: fill them first.")
        packing = [numpy.asarray(said[key]).reshape(()) for key in ("scale_factor", "add_offset") if key in said]
        if packing:
            isSingle = all(number.dtype == "f4" for number in packing) and (kind.itemsize <= 2 or kind == "f4")
            number = numpy.dtype("f4" if isSingle else "f8").type
            stored = stored.astype(number) * number(said.get("scale_factor", 1)) + number(said.get("add_offset", 0))
    except (TypeError, ValueError) as error:
        raise FieldError(f"the attributes of {name} for missing or packed values are not numbers ({_said(error)}): mend them.") from None
    return stored


def _turned(data: Any) -> List[Tuple[str, int]]:
    """The coordinate along x, y and z of a model, and its sign. A vertical z is turned as in LAS files: x stays, up is y, -y is z."""
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
    if re.fullmatch("[X?][Y?]Z", roles) and ways["z"]:
        return [("x", 1), ("z", 1 if ways["z"] == "up" else -1), ("y", -1)]
    if not re.fullmatch("[X?][Z?][Y?]", roles):
        raise FieldError(f"x, y and z are declared as the axes {', '.join(roles)}: y or z must be Z, with the attribute positive, 'up' or 'down'.")
    if "Z" not in roles:
        _note("no axis is declared vertical, and y is taken as up: declare it with the attributes axis = 'Z' and positive.")
    return [("x", 1), ("y", -1 if ways["y"] == "down" else 1), ("z", 1)]


def _cells(data: Any, name: str, sign: int, own: "Tuple[float, float] | None") -> Tuple[float, float, int]:
    """Low edge and size of equal cells along an axis, and -1 where it descends. `own` is what Espalier wrote of it."""
    numpy, _ = _libraries()
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
        # a coordinate need not be the middle, but Espalier wrote the middle; one cell that is left of its cells may be many that were joined
        if join and (areNear(middles, 0.5, low, size) and count > 1 if own else ((edges[:, 0] <= middles) & (middles <= edges[:, 1])).all()):
            return low, size, step
        if own is None:
            raise FieldError(f"the bounds {named} are not those of equal cells side by side around {name}: interpolate to equal cells first.")
        # functions that join, thin or move cells leave the bounds that Espalier wrote as they were, or take their mean
        _note(f"{named} does not fit {name} any more, and is not used: the cells are taken to fill the space between the middles.")
    if count < 2:
        raise FieldError(f"the axis {name} has one cell and no bounds that are sure: make {named} right, and remove the attribute espalier_cell_size.")
    size = float(middles[-1] - middles[0]) / (count - 1)
    if not areNear(middles, 0, middles[0], size):
        raise FieldError(f"the cells along {name} are not equal and rising or falling: interpolate them to equal cells first.")
    return float(middles[0]) - size / 2, size, step


def _grid(data: Any) -> Tuple[Grid, List[str], Tuple[int, ...], str]:
    """The cells of a data set, its axes that are x, y and z of a model, -1 for each that descends, and the unit of length."""
    units = set()
    for name in AXES:
        if name not in data.coords or data[name].dims != (name,):
            raise FieldError(f"the data set has no axis {name}: it needs the coordinates x, y and z in metres.")
        units.add(LENGTH_UNITS.get(unit := str(data[name].attrs.get("units", "m")).lower(), unit))
    if len(units) != 1 or not units <= set(LENGTH_UNITS.values()):
        raise FieldError(f"the axes are in {' and '.join(map(repr, sorted(units)))}: convert all to m, dm, cm or mm, the unit of the model's world.")
    sources, own = _turned(data), {}
    counts: Any = tuple(int(data.sizes[name]) for name, _ in sources)
    _count(Grid(counts, (0, 0, 0), (1, 1, 1)), "the data set")
    with contextlib.suppress(KeyError, TypeError, ValueError):
        own = dict(zip(AXES, zip(*[tuple(map(float, data.attrs[key])) for key in ("espalier_position", "espalier_cell_size")])))
    lows, sizes, ways = cast(Any, zip(*[_cells(data, name, sign, own.get(name)) for name, sign in sources]))  # type: ignore[arg-type]
    _count(grid := Grid(counts, lows, sizes), "the data set")
    return grid, [name for name, _ in sources], ways, units.pop()


def fields_of(data: Any, step: int = -1) -> Fields:
    """The quantities of a step (the last) of a data set over x, y, z and perhaps one more dimension, its times. Raises FieldError."""
    numpy, _ = _libraries()
    grid, names, ways, length_unit = _grid(data)
    quantities, others = {}, []
    helpers = {str(value) for variable in data.variables.values() for key, value in variable.attrs.items() if key in ("bounds", "grid_mapping")}
    # a Zarr folder has no order of its own
    order = str(data.attrs.get("espalier_quantities", "")).split()
    for name, variable in sorted(data.data_vars.items(), key=lambda item: order.index(item[0]) if item[0] in order else len(order)):
        times = [dimension for dimension in variable.dims if dimension not in AXES]
        if not set(AXES) <= set(variable.dims) or len(times) > 1:
            others += [] if name.endswith("_bnds") or name in helpers else [f"{name}({', '.join(variable.dims)})"]
            continue
        if times and not -variable.sizes[times[0]] <= step < variable.sizes[times[0]]:
            raise FieldError(f"the data set has no step {step}: choose another with --step.")
        chosen = variable.isel({times[0]: step}) if times else variable
        if not re.fullmatch(r"[\w.-]+", name):
            raise FieldError(f"the quantity {name!r} has a name that no file can hold: use letters, digits and points.")
        values = numpy.ascontiguousarray(_numbers(chosen.transpose(*names[::-1]), name)[::ways[2], ::ways[1], ::ways[0]], dtype="<f8")
        quantities[name] = (re.sub(r'[<>&"]', "", str(variable.attrs.get("units", "1"))), values.tobytes())
    rule = f"{', '.join(others)} cannot be read: a quantity has the dimensions x, y, z and at most one more, so choose a part of it first."
    if not quantities:
        raise FieldError(f"the data set has no quantity, and {rule if others else 'no variables over x, y and z: give another data set.'}")
    if others:
        _note(rule)
    return Fields(grid, quantities, length_unit)


def open_dataset(path: "str | os.PathLike[str]", group: "str | None" = None) -> Any:
    """Opens a .nc file or .zarr folder, or a group in it, with numbers as they are stored: `fields_of` unpacks. Raises FieldError."""
    _, xarray = _libraries()
    asStored: Dict[str, Any] = {"decode_times": False, "decode_timedelta": False, "mask_and_scale": False, "group": group}
    source: Any = path
    try:
        if str(path).rstrip("/").endswith(".zarr"):
            import zarr  # type: ignore[import]
            source = checked_store(str(path), check_zarr(str(path)))
            opened = zarr.open_group(source, mode="r", path=group)
            arrays, groups = dict(opened.arrays()), list(opened.group_keys())
            lengths = [length for array in arrays.values() for length in array.shape]
            asStored.update(engine="zarr", consolidated=(Path(path) / ".zmetadata").is_file())
        else:
            import netCDF4  # type: ignore[import]
            with netCDF4.Dataset(path) as file:
                check_netcdf(file)
                opened = file[group] if group else file
                arrays, groups, lengths = {}, list(opened.groups), [len(dimension) for dimension in opened.dimensions.values()]
        # xarray reads coordinates at once
        if max(lengths, default=0) > MOST_CELLS:
            raise MemoryError(f"an axis of {max(lengths)}, and at most {MOST_CELLS} can be read")
        attributes = {name: dict(array.attrs) for name, array in arrays.items()}
        data = xarray.open_dataset(source, **asStored)
    except FieldError:
        raise
    except Exception as error:  # whatever the libraries raise on a stranger's file
        raise FieldError(f"{path} cannot be opened ({_said(error)}): check the name, and give a .nc file or a .zarr folder that is complete.") from None
    listed = ", ".join(f"{group}/{name}" if group else name for name in groups)
    if groups and not set(AXES) <= set(data.variables):
        raise FieldError(f"the quantities of {path} are in groups ({listed}): choose one with --group.")
    if groups:
        _note(f"the groups {listed} are left out: choose one with --group.")
    for name, array in arrays.items():
        if array.fill_value is None and array.nchunks_initialized < array.nchunks:
            raise FieldError(f"{path} has {array.nchunks_initialized} of {array.nchunks} parts of {name}: copy it again.")
        # xarray takes every fill value for a mark of missing data, but 0 is what zarr writes when nobody chose
        if name in data.dims or array.fill_value == 0:
            data[name].attrs.pop("_FillValue", None)
        data[name].attrs.update({key: value for key, value in attributes[name].items() if key == "_FillValue"})
    return data


def _save(content: Any, path: Path) -> None:
    """Writes a data set or `Fields` beside its place and moves it there when it is complete."""
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".espalier-") as folder:
            part = Path(folder) / path.name
            if isinstance(content, Fields):
                with part.open("w", encoding="utf-8") as file:
                    file.writelines(vti_text(content))
            elif path.suffix == ".zarr":
                content.to_zarr(part, consolidated=True)
            else:
                content.to_netcdf(part, engine="netcdf4", encoding={name: {"_FillValue": None} for name in content.variables})
            if path.suffix == ".zarr" and path.is_dir():
                shutil.rmtree(path)
            os.replace(part, path)
    except ImportError as error:
        raise FieldError(f"{error}: install it (Debian: python3-netcdf4, python3-zarr), then try again.") from None
    except Exception as error:  # whatever the libraries raise
        raise FieldError(f"{path} cannot be written ({_said(error)}): give a path in a folder that exists, that you may write to and that has room.") from None


def convert(sources: "Sequence[str | os.PathLike[str]]", target: "str | os.PathLike[str]", step: int = -1, group: "str | None" = None) -> None:
    """Converts files by their suffixes. Several .vti files are the steps of a data set. After a FieldError the target is as it was."""
    into = Path(target)
    if Path(sources[0]).suffix == ".vti":
        steps = [read_vti(source) for source in sources]
        numbers = [int(match[1]) for source in sources for match in re.finditer(r"(\d+)\.vti$", str(source))]
        data = dataset(steps, numbers if len(numbers) == len(steps) else None)
    elif len(sources) > 1:
        raise FieldError("several sources must be .vti files of one run.")
    else:
        data = open_dataset(sources[0], group)
    if into.suffix in (".nc", ".zarr"):
        _count(Grid((data.sizes.get("x", 1), data.sizes.get("y", 1), data.sizes.get("z", 1)), (0, 0, 0), (1, 1, 1)), "the data set")
        for name in data.variables:
            _stored(data[name], name)
        _save(data, into)
    elif into.suffix == ".vti":
        _save(fields_of(data, step), into)
    else:
        raise FieldError(f"'{into.suffix}' is not a format: the target ends in .nc, .zarr or .vti.")


def main(arguments: "List[str] | None" = None) -> int:
    parser = argparse.ArgumentParser("python3 -m espalier.fields", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", nargs="+", help=".vti files of one run, or one .nc or .zarr")
    parser.add_argument("target", help=".nc, .zarr or .vti")
    parser.add_argument("--step", type=int, default=-1, help="for a .vti: the place of the step in the data set, from 0 (the last)")
    parser.add_argument("--group", help="of the source, where its quantities are in groups")
    options = parser.parse_args(arguments)
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        try:
            convert(options.source, options.target, options.step, options.group)
        except FieldError as error:
            print(f"error: {error}", file=sys.stderr)
            return 1
    # warnings of the libraries are about their own code
    for text in dict.fromkeys(str(note.message) for note in notes if isinstance(note.message, FieldWarning)):
        print(f"note: {text}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that a file that is not complete is removed
    sys.exit(main())
