"""The bounds of a file of quantities before a library reads it: kinds of numbers, codecs, sizes of parts, links.

Zarr decodes a part of an array with the codecs that the folder itself names, and some of them run code or make objects. So the
metadata of all arrays are read here first, and each part is measured when it is read.
"""

from __future__ import annotations

import bz2
import gzip
import io
import json
import math
import os
import re
import stat
import zlib
from typing import Any, Dict, Iterator, List, NamedTuple, Tuple

# a larger grid needs more memory than a description of a few bytes should cost
MOST_CELLS = int(os.environ["ESPALIER_FIELD_CELLS"]) if os.environ.get("ESPALIER_FIELD_CELLS", "").isdigit() else 20_000_000
# of a variable with all of its steps, which is read at once: 3.2 GB of doubles
MOST_READ = 20 * MOST_CELLS
# each part costs a search, also where it is not there
MOST_PARTS = 1_000_000
MOST_METADATA = 2 ** 26
# integers, floating point numbers and text of a fixed length (NumPy's array protocol)
PLAIN_NUMBERS = re.compile(r"[<>|=]?(?:[iuf](?:1|2|4|8|16)|[SU][0-9]{1,6})")
COMPRESSORS = ("zlib", "gzip", "bz2", "blosc", "zstd", "lz4")
FILTERS = ("delta", "fixedscaleoffset", "shuffle")
# names of the units of length that a world may have
LENGTH_UNITS = {word: unit for unit, name in (("m", ""), ("dm", "deci"), ("cm", "centi"), ("mm", "milli"))
                for word in (unit, *(f"{name}{word}" for word in ("metre", "meter", "metres", "meters")))}


class Grid(NamedTuple):
    """Equal cells in a box. Lengths are in the unit of the model."""
    cells: Tuple[int, int, int]
    position: Tuple[float, float, float]  # low corner
    spacing: Tuple[float, float, float]


class FieldError(Exception):
    """A file that cannot be read or written: one sentence, with what to do."""


class FieldWarning(UserWarning):
    """A part of a file that was left out, or an assumption about it: one sentence."""


def _itemsize(kind: Any, name: str) -> int:
    """The bytes of a number. Raises FieldError for every other kind."""
    if not isinstance(kind, str) or not PLAIN_NUMBERS.fullmatch(kind):
        raise FieldError(f"{name} holds {str(kind)[:40]!r} and not plain numbers or text, so it is not read: remove it, or write it as numbers.")
    letters = kind.lstrip("<>|=")
    return int(letters[1:]) * (4 if letters[0] == "U" else 1)


def _check_parts(shape: Any, parts: Any, itemsize: int, name: str) -> int:
    """The bytes of one part of an array. Raises FieldError where one part, or their number, costs too much."""
    isPlain = isinstance(shape, (list, tuple)) and isinstance(parts, (list, tuple)) and len(shape) == len(parts) <= 32 and all(
        isinstance(number, int) and not isinstance(number, bool) and number >= 0 for number in (*shape, *parts)) and min(parts, default=1) > 0
    if not isPlain:
        raise FieldError(f"{name} has no whole numbers of cells and parts: the file is damaged, so copy it or write it again.")
    cells = math.prod(parts)
    if cells > MOST_CELLS or cells * itemsize > 8 * MOST_CELLS:
        raise FieldError(f"{name} has parts of {cells} cells, and at most {MOST_CELLS} can be read at once: write it with smaller chunks.")
    count = math.prod(-(-length // part) for length, part in zip(shape, parts))
    if count > MOST_PARTS:
        raise FieldError(f"{name} has {count} parts, and at most {MOST_PARTS} can be read: write it with larger chunks.")
    return int(cells * max(itemsize, 8))


def _check_array(said: Any, name: str) -> Tuple[str, int]:
    """The compressor of an array of Zarr, and the bytes of a part when it is decoded. Raises FieldError."""
    if not isinstance(said, dict):
        raise FieldError(f"the metadata of {name} are not those of an array: the file is damaged, so copy it or write it again.")
    if isinstance(said.get("fill_value"), (list, dict)):
        raise FieldError(f"the fill value of {name} is not one number: mend it.")
    size = _check_parts(said.get("shape"), said.get("chunks"), _itemsize(said.get("dtype"), name), name)
    filters = [] if said.get("filters") is None else said["filters"]
    codecs: List[Tuple[Any, Tuple[str, ...]]] = [(codec, FILTERS) for codec in (filters if isinstance(filters, list) else ["?"])]
    codecs += [] if said.get("compressor") is None else [(said["compressor"], COMPRESSORS)]
    for codec, known in codecs:
        word = codec.get("id") if isinstance(codec, dict) else codec
        if not isinstance(word, str) or not isinstance(codec, dict) or word not in known:
            raise FieldError(f"{name} is packed with {str(word)[:40]!r}, which Espalier does not unpack: write it with zlib, blosc or zstd and no filters.")
        for key in ("dtype", "astype"):
            if key in codec:
                _itemsize(codec[key], name)
    return ("" if said.get("compressor") is None else str(said["compressor"]["id"])), size


def _check_attributes(said: Dict[str, Any], name: str) -> None:
    # a library may take it for the kind of the numbers
    if said.get("dtype", "bool") != "bool":
        _itemsize(said["dtype"], f"the attribute dtype of {name}")
    axes = said.get("_ARRAY_DIMENSIONS", [])
    if not isinstance(axes, list) or not all(isinstance(axis, str) for axis in axes):
        raise FieldError(f"the attribute _ARRAY_DIMENSIONS of {name} is not a list of names: mend it.")


def _check_metadata(path: str, within: str) -> Iterator[Tuple[str, Tuple[str, int]]]:
    """Reads one file of metadata: the name, the compressor and the size of a part of each array in it."""
    kind = os.path.basename(path).lower()
    try:
        if not stat.S_ISREG(os.stat(path).st_mode) or os.path.getsize(path) > MOST_METADATA:
            raise ValueError("no file, or too large")
        with open(path, "rb") as file:
            said = json.loads(file.read().decode("utf-8"))
        found = said["metadata"] if kind == ".zmetadata" else {kind: said}
        if not all(isinstance(value, dict) for value in found.values()):
            raise ValueError("the members are no objects")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise FieldError(f"{path} cannot be read as metadata ({type(error).__name__}): copy it or write it again.") from None
    for member, value in found.items():
        folder, _, last = member.rpartition("/")
        name = "/".join(part for part in (within, folder) if part)
        if last == ".zarray":
            yield name, _check_array(value, name or path)
        elif last == ".zattrs":
            _check_attributes(value, name or "the data set")


def check_zarr(folder: str) -> Dict[str, Tuple[str, int]]:
    """Checks all arrays of a folder, also those in groups, and all links, without decoding a part. Raises FieldError."""
    arrays: Dict[str, Tuple[str, int]] = {}
    root = os.path.realpath(folder)
    for place, folders, names in os.walk(root):
        for name in (*folders, *names):
            path = os.path.join(place, name)
            mode = os.lstat(path).st_mode
            if stat.S_ISLNK(mode) and os.path.commonpath([root, os.path.realpath(path)]) != root:
                raise FieldError(f"{path} is a link out of {folder}: copy the file itself into the folder.")
            # a pipe would never end
            if not (stat.S_ISLNK(mode) or stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
                raise FieldError(f"{path} is neither a file nor a folder: copy {folder} again.")
            if name.lower() in (".zarray", ".zattrs", ".zmetadata"):
                within = "" if place == root else os.path.relpath(place, root).replace(os.sep, "/")
                for array, known in _check_metadata(path, within):
                    # each of the two may be the one that zarr reads
                    if arrays.setdefault(array, known) != known:
                        raise FieldError(f"{path} describes {array} otherwise than its own metadata: copy it or write it again.")
    return arrays


def _unpacked_length(raw: bytes, compressor: str, most: int) -> int:
    """The length of a part when it is unpacked, or a larger one than `most`."""
    if compressor == "zlib":
        return len(zlib.decompressobj().decompress(raw, most + 1))
    if compressor in ("gzip", "bz2"):
        source: Any = io.BytesIO(raw)
        opened: Any = gzip.GzipFile(fileobj=source) if compressor == "gzip" else bz2.BZ2File(source)
        return len(opened.read(most + 1))
    if compressor in ("blosc", "lz4"):
        # the library allocates what the header announces
        return int.from_bytes(raw[4:8] if compressor == "blosc" else raw[:4], "little")
    if compressor == "zstd" and len(raw) > 5:
        # RFC 8878, section 3.1.1.1: the window and the dictionary stand before the length of the content
        isSingle, width = bool(raw[4] & 32), (1 if raw[4] & 32 else 0, 2, 4, 8)[raw[4] >> 6]
        start = 5 + (not isSingle) + (0, 1, 2, 4)[raw[4] & 3]
        return int.from_bytes(raw[start:start + width], "little")
    return len(raw)


def _check_unpacked(raw: bytes, compressor: str, size: int, name: str) -> None:
    try:
        length = _unpacked_length(raw, compressor, size)
    except (zlib.error, OSError, EOFError):
        return  # the library says what is wrong
    if length > size:
        raise FieldError(f"{name} cannot be read (a part unpacks to more than {size} bytes): the file is damaged, so copy it or write it again.")


def checked_store(folder: str, arrays: Dict[str, Tuple[str, int]]) -> Any:
    """A folder for zarr that measures each part before zarr decodes it."""
    import zarr  # type: ignore[import]

    class Checked(zarr.DirectoryStore):  # type: ignore[misc]
        def __getitem__(self, key: str) -> bytes:
            raw: bytes = super().__getitem__(key)
            name, _, last = key.rpartition("/")
            if not last.startswith("."):
                # parts may be in folders of their own
                while name and name not in arrays:
                    name = name.rpartition("/")[0]
                if name in arrays:
                    _check_unpacked(raw, *arrays[name], name)
            return raw

    return Checked(folder)


def check_netcdf(group: Any) -> None:
    """Checks the variables of a file that netCDF4 opened, also those in groups. Raises FieldError."""
    for variable in group.variables.values():
        kind = getattr(variable.dtype, "str", variable.dtype)
        # text of any length has no parts that are larger than the file
        if kind is not str:
            size = _itemsize(kind, variable.name)
            parts = variable.chunking()
            if isinstance(parts, list):
                _check_parts(list(map(int, variable.shape)), list(map(int, parts)), size, variable.name)
    for each in group.groups.values():
        check_netcdf(each)
