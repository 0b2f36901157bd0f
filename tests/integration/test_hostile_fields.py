"""Data sets that strangers made to do harm: code in them, small files of many cells, links; and files with bytes at random."""

import importlib.util
import json
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

from support import variables

HAS_LIBRARIES = all(importlib.util.find_spec(name) for name in ("xarray", "netCDF4", "zarr"))
MISSING = "xarray, netCDF4 or zarr is not installed (Debian: python3-xarray python3-netcdf4 python3-zarr)"
# of one conversion: the libraries take about 0.5 GB of addresses before they read anything
ADDRESSES = 3 * 2 ** 30
SECONDS_EACH = 20
# converts each source that it is told, in one process; memory and seconds are limited, and all but a FieldError ends it
READER = """
import resource, signal, sys, warnings
import netCDF4, xarray, zarr
from espalier import fields
resource.setrlimit(resource.RLIMIT_AS, ({addresses}, {addresses}))
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
warnings.simplefilter("ignore")
for line in sys.stdin:
    source, target = line.rstrip("\\n").split("\\t")
    signal.alarm({seconds})
    try:
        fields.convert([source], target)
        said = "read"
    except fields.FieldError as error:
        said = "refused " + repr(str(error))
    signal.alarm(0)
    print(said, flush=True)
"""


class Reader:
    """A child process that converts files."""

    def __init__(self) -> None:
        self.process = subprocess.Popen([sys.executable, "-c", READER.format(addresses=ADDRESSES, seconds=SECONDS_EACH)], env=variables(),
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def convert(self, source: Path, target: Path) -> str:
        """`read`, or the sentence with which the file was refused. Raises AssertionError for everything else."""
        assert self.process.stdin and self.process.stdout and self.process.stderr
        self.process.stdin.write(f"{source}\t{target}\n")
        self.process.stdin.flush()
        said = self.process.stdout.readline()
        if not said:
            self.process.wait()
            raise AssertionError(f"the reader ended with {self.process.returncode}: {self.process.stderr.read()[-2000:]}")
        return said.rstrip("\n")

    def close(self) -> None:
        self.process.communicate()


@unittest.skipUnless(HAS_LIBRARIES, MISSING)
class Hostile(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.reader = Reader()
        self.addCleanup(self.reader.close)

    def zarr(self, group: str = "", name: str = "bad.zarr", **changes: Any) -> Path:
        """A folder of 2 × 2 × 2 cells, written by hand; `changes` are those of the array q."""
        root = self.folder / name
        shutil.rmtree(root, ignore_errors=True)
        place = root / group
        place.mkdir(parents=True)
        for each in {root, place}:
            (each / ".zgroup").write_text('{"zarr_format": 2}', encoding="utf-8")
        for array, axes in (("x", ["x"]), ("y", ["y"]), ("z", ["z"]), ("q", ["z", "y", "x"])):
            said: Dict[str, Any] = {"zarr_format": 2, "shape": [2] * len(axes), "chunks": [2] * len(axes), "dtype": "<f8", "compressor": None,
                                    "fill_value": None, "order": "C", "filters": None}
            said.update(changes if array == "q" else {})
            (place / array).mkdir()
            (place / array / ".zarray").write_text(json.dumps(said), encoding="utf-8")
            (place / array / ".zattrs").write_text(json.dumps({"_ARRAY_DIMENSIONS": axes}), encoding="utf-8")
            count = 2 ** len(axes)
            (place / array / ".".join("0" * len(axes))).write_bytes(struct.pack(f"<{count}d", *range(count)))
        return root

    def assertRefused(self, source: Path, said: str) -> None:
        began = time.monotonic()
        for target in ("out.vti", "out.nc"):
            with self.subTest(source=source.name, target=target):
                found = self.reader.convert(source, self.folder / target)
                self.assertRegex(found, f"^refused .*{said}")
                self.assertNotIn("\\n", found)
                self.assertFalse((self.folder / target).exists())
        self.assertLess(time.monotonic() - began, 10)

    def test_the_folder_of_these_tests_is_read(self) -> None:
        self.assertEqual(self.reader.convert(self.zarr(), self.folder / "out.vti"), "read")

    def test_objects_in_a_zarr_folder_run_no_code(self) -> None:
        marker = self.folder / "marker"
        # protocol 0: posix.system("touch …"), which needs no library to be written
        pickled = f"cposix\nsystem\n(Vtouch {marker}\ntR.".encode()
        # the codec reads the items of a list and the shape at its end
        hostile = b"(lp0\n" + pickled[:-1] + b"a(I1\nta."
        for group in ("", "soil/top"):
            for consolidated in (False, True):
                for filters, compressor in (([{"id": "pickle", "protocol": 4}], None), (None, {"id": "pickle", "protocol": 4}),
                                            ([{"id": "zlib", "level": 1}, {"id": "pickle"}], None)):
                    root = self.zarr(group, dtype="|O", filters=filters, compressor=compressor)
                    for array in ("q", "x"):
                        shape = [2] if array == "x" else [2, 2, 2]
                        said = {"zarr_format": 2, "shape": shape, "chunks": shape, "dtype": "|O", "compressor": compressor,
                                "fill_value": None, "order": "C", "filters": filters}
                        (root / group / array / ".zarray").write_text(json.dumps(said), encoding="utf-8")
                        for part in (root / group / array).glob("0*"):
                            part.write_bytes(zlib.compress(hostile) if filters and len(filters) == 2 else hostile)
                    if consolidated:
                        names = [path for path in root.rglob(".z*") if path.is_file()]
                        metadata = {str(path.relative_to(root)): json.loads(path.read_text(encoding="utf-8")) for path in names}
                        (root / ".zmetadata").write_text(json.dumps({"zarr_consolidated_format": 1, "metadata": metadata}), encoding="utf-8")
                    self.assertRefused(root, "holds .*O.* and not plain numbers or text")
                    self.assertFalse(marker.exists())

    def test_the_folder_does_run_code_without_the_checks(self) -> None:
        # or the test above could not fail
        marker = self.folder / "marker"
        root = self.zarr(dtype="|O", filters=[{"id": "pickle", "protocol": 4}])
        (root / "q" / "0.0.0").write_bytes(f"(lp0\ncposix\nsystem\n(Vtouch {marker}\ntRa(I1\nta.".encode())
        code = "import sys, zarr\ntry:\n    zarr.open_group(sys.argv[1], mode='r')['q'][:]\nexcept Exception:\n    pass\n"
        subprocess.run([sys.executable, "-c", code, str(root)], check=True, env=variables(), capture_output=True, timeout=60)
        self.assertTrue(marker.exists())

    def test_an_object_that_only_the_consolidated_metadata_name_is_refused(self) -> None:
        root = self.zarr()
        said = json.loads((root / "q" / ".zarray").read_text(encoding="utf-8"))
        for change in ({"dtype": "|O", "filters": [{"id": "pickle"}]}, {"dtype": [["a", "|O"]]}, {"dtype": "O"}, {"dtype": "|b1"},
                       {"filters": [{"id": "json2"}]}, {"compressor": {"id": "lzma"}}, {"filters": ["delta"]},
                       {"filters": [{"id": "delta", "dtype": "|O"}]}, {"filters": {"id": "delta"}}, {"shape": [2, 2, -2]}, {"chunks": "2"}):
            metadata = {".zgroup": {"zarr_format": 2}, "q/.zarray": {**said, **change}}
            (root / ".zmetadata").write_text(json.dumps({"zarr_consolidated_format": 1, "metadata": metadata}), encoding="utf-8")
            self.assertRefused(root, "q ")
        # a text in the place of an object would be read as JSON by zarr
        metadata["q/.zarray"] = json.dumps(said)
        (root / ".zmetadata").write_text(json.dumps({"zarr_consolidated_format": 1, "metadata": metadata}), encoding="utf-8")
        self.assertRefused(root, "cannot be read as metadata")

    def test_attributes_and_fill_values_are_plain(self) -> None:
        self.assertRefused(self.zarr(fill_value=[1, 2]), "the fill value of q is not one number")
        root = self.zarr()
        (root / "q" / ".zattrs").write_text(json.dumps({"_ARRAY_DIMENSIONS": ["z", "y", "x"], "dtype": "object"}), encoding="utf-8")
        self.assertRefused(root, "the attribute dtype of q holds")
        (root / "q" / ".zattrs").write_text(json.dumps({"_ARRAY_DIMENSIONS": ["z", "y", 3]}), encoding="utf-8")
        self.assertRefused(root, "the attribute _ARRAY_DIMENSIONS of q is not a list of names")
        # zarr reads ASCII, and beside consolidated metadata only when the attributes are asked for
        import zarr  # type: ignore[import]
        root = self.zarr()
        zarr.consolidate_metadata(str(root))
        (root / "q" / ".zattrs").write_bytes(json.dumps({"_ARRAY_DIMENSIONS": ["z", "y", "x"], "about": "\u00e9"}, ensure_ascii=False).encode())
        self.assertRefused(root, "cannot be opened .UnicodeDecodeError")

    def test_links_out_of_a_zarr_folder_are_refused(self) -> None:
        secret = self.folder / "secret"
        secret.write_bytes(struct.pack("<8d", *range(8)))
        root = self.zarr()
        (root / "q" / "0.0.0").unlink()
        (root / "q" / "0.0.0").symlink_to(secret)
        self.assertRefused(root, "is a link out of")
        root = self.zarr()
        shutil.move(str(root / "q"), str(self.folder / "q"))
        (root / "q").symlink_to(self.folder / "q")
        self.assertRefused(root, "is a link out of")
        # a part that would never end
        root = self.zarr()
        (root / "q" / "0.0.0").unlink()
        os.mkfifo(root / "q" / "0.0.0")
        self.assertRefused(root, "is neither a file nor a folder")

    def test_huge_parts_of_a_zarr_folder_are_refused_at_once(self) -> None:
        for changes, said in (({"chunks": [500, 500, 1000]}, "q has parts of 250000000 cells, and at most 20000000"),
                              ({"dtype": "<U999999", "chunks": [2, 2, 20]}, "q has parts of 80 cells"),
                              ({"shape": [2, 2, 10 ** 9], "chunks": [1, 1, 1]}, "q has 4000000000 parts, and at most 1000000")):
            self.assertRefused(self.zarr(**changes), said)
            self.assertRefused(self.zarr("soil", **changes), said)

    def test_a_part_that_unpacks_to_more_than_its_cells_is_refused(self) -> None:
        import numcodecs

        zeros = bytes(100_000_000)
        for codec in (numcodecs.Zlib(1), numcodecs.GZip(1), numcodecs.BZ2(1), numcodecs.Blosc(), numcodecs.Zstd(1), numcodecs.LZ4()):
            root = self.zarr(compressor=codec.get_config(), fill_value=0.0)
            for path in root.rglob("0*"):
                if path.parent.name == "q":
                    path.write_bytes(codec.encode(zeros))
            self.assertRefused(root, "q cannot be read .a part unpacks to more than 64 bytes")
            # and one that is right
            (root / "q" / "0.0.0").write_bytes(codec.encode(struct.pack("<8d", *range(8))))
            self.assertEqual(self.reader.convert(root, self.folder / "out.vti"), "read")
            (self.folder / "out.vti").unlink()

    def netcdf(self, name: str, *, chunks: "Tuple[int, ...] | None" = None, group: str = "") -> Path:
        import netCDF4
        import numpy

        with netCDF4.Dataset(self.folder / name, "w") as file:
            place = file.createGroup(group) if group else file
            for axis in "xyz":
                # the parts of an axis without a limit may be larger than the axis
                place.createDimension(axis, None if chunks else 2)
                place.createVariable(axis, "f8", (axis,), chunksizes=(2,))[:] = [0, 1]
            place.createVariable("q", "f8", ("z", "y", "x"), zlib=True, chunksizes=chunks or (2, 2, 2))
            if not chunks:
                place["q"][:] = numpy.arange(8.0).reshape(2, 2, 2)
        return self.folder / name

    def test_huge_parts_of_a_netcdf_file_are_refused_at_once(self) -> None:
        for group in ("", "soil"):
            bomb = self.netcdf("bomb.nc", chunks=(500, 500, 1000), group=group)
            self.assertLess(bomb.stat().st_size, 100_000)
            self.assertRefused(bomb, "q has parts of 250000000 cells, and at most 20000000")

    def test_a_variable_that_nobody_wrote_takes_no_memory(self) -> None:
        import netCDF4

        with netCDF4.Dataset(self.netcdf("wide.nc"), "a") as file:
            file.createDimension("a", 10_000)
            file.createDimension("b", 1_000_000)
            file.createVariable("w", "f8", ("a", "b"), contiguous=True)
        self.assertLess((self.folder / "wide.nc").stat().st_size, 100_000)
        wide = self.zarr(name="wide.zarr")
        (wide / "w").mkdir()
        (wide / "w" / ".zarray").write_text(json.dumps({"zarr_format": 2, "shape": [10_000, 1_000_000], "chunks": [10, 1_000_000], "dtype": "<f8",
                                                        "compressor": None, "fill_value": 0.0, "order": "C", "filters": None}), encoding="utf-8")
        (wide / "w" / ".zattrs").write_text('{"_ARRAY_DIMENSIONS": ["a", "b"]}', encoding="utf-8")
        for name in ("wide.nc", "wide.zarr"):
            self.assertIn("w has 10000000000 numbers, and at most 400000000 are read at once", self.reader.convert(self.folder / name, self.folder / "out.nc"))
            # numbers that are not read cost nothing
            self.assertEqual(self.reader.convert(self.folder / name, self.folder / f"{name}.vti"), "read")

    def test_kinds_of_netcdf_that_are_no_numbers_are_refused(self) -> None:
        import netCDF4
        import numpy

        for kind in ("compound", "vlen"):
            with netCDF4.Dataset(self.netcdf(f"{kind}.nc"), "a") as file:
                if kind == "compound":
                    made: Any = file.createCompoundType(numpy.dtype([("a", "f8"), ("b", "i4")]), "pair")
                else:
                    made = file.createVLType(numpy.int32, "list")
                file.createVariable("odd", made, ("x",))
            self.assertRegex(self.reader.convert(self.folder / f"{kind}.nc", self.folder / "out.nc"), r"^refused .*\.['\"]$")
            self.assertFalse((self.folder / "out.nc").exists())

    # mutations: each outcome is a result or one sentence

    def mutated_bytes(self, raw: bytes, chance: random.Random) -> bytes:
        changed = bytearray(raw)
        for _ in range(chance.choice((1, 1, 2, 8, 64))):
            at = chance.randrange(len(changed))
            kind = chance.randrange(5)
            if kind == 0:
                changed[at] ^= 1 << chance.randrange(8)
            elif kind == 1:
                changed[at] = chance.choice((0, 1, 127, 128, 255))
            elif kind == 2:
                changed[at:at + 8] = struct.pack("<Q", chance.choice((0, 1, 2 ** 31 - 1, 2 ** 32, 2 ** 63 - 1, 2 ** 64 - 1)))[:len(changed) - at]
            elif kind == 3 and len(changed) > 16:
                del changed[at:at + chance.randrange(1, 8)]
            else:
                changed[at:at] = bytes(chance.randrange(256) for _ in range(4))
            if not changed:
                break
        return bytes(changed[:chance.randrange(len(changed) + 1)]) if chance.random() < 0.1 else bytes(changed)

    def mutated_json(self, text: str, chance: random.Random) -> str:
        whole = json.loads(text)
        members: List[Tuple[Any, Any]] = []

        def visit(value: Any) -> None:
            for key in (list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()):
                members.append((value, key))
                visit(value[key])

        visit(whole)
        place, key = chance.choice(members)
        values: List[Any] = [None, True, -1, 0, 1, 3, 2 ** 31, 10 ** 30, 0.5, "", "O", "|O", "<f4", "<i2", "<U9", "|S3", "M8[s]", [], {}, [1], [2, 2], "NaN",
                             [10 ** 9] * 3, [["a", "<f8"]], {"id": "pickle"}, [{"id": "pickle"}], {"id": "zlib"}, {"id": "bz2", "level": 99},
                             [{"id": "delta", "dtype": "<f8"}], [{"id": "shuffle", "elementsize": 0}], ["x"], "x", "../x", "F"]
        if chance.random() < 0.2:
            del place[key]
        else:
            place[key] = chance.choice(values)
        return json.dumps(whole)

    def assertSurvives(self, seconds: float, seed: int, least: int) -> None:
        import xarray

        print(f"seed {seed}", file=sys.stderr)
        chance = random.Random(seed)
        good = self.folder / "good.zarr"
        data = xarray.open_dataset(self.netcdf("good.nc")).load()
        data.to_zarr(good, consolidated=True)
        plain = self.zarr(name="plain.zarr")
        outcomes = {"read": 0, "refused": 0}
        makers: List[Callable[[], Path]] = [lambda: self.folder / "m.nc", lambda: self.folder / "m.zarr", lambda: self.folder / "m.zarr"]
        end = time.monotonic() + seconds
        for turn in range(10 ** 9):
            if time.monotonic() > end and turn >= least:
                break
            source = makers[turn % 3]()
            if source.suffix == ".nc":
                source.write_bytes(self.mutated_bytes((self.folder / "good.nc").read_bytes(), chance))
            else:
                shutil.rmtree(source, ignore_errors=True)
                shutil.copytree(chance.choice((good, plain)), source)
                for _ in range(chance.choice((1, 1, 2, 4))):
                    path = chance.choice(sorted(path for path in source.rglob("*") if path.is_file()))
                    if path.name.startswith(".") and chance.random() < 0.7:
                        try:
                            path.write_text(self.mutated_json(path.read_text(encoding="utf-8"), chance), encoding="utf-8")
                            continue
                        except (ValueError, IndexError):
                            pass
                    path.write_bytes(self.mutated_bytes(path.read_bytes() or b"0", chance))
            target = self.folder / chance.choice(("m.vti", "out.nc"))
            try:
                said = self.reader.convert(source, target)
            except AssertionError as error:
                raise AssertionError(f"seed {seed}, turn {turn}, {source.name} to {target.name}: {error}") from None
            word = said.partition(" ")[0]
            outcomes[word] += 1
            if word == "refused":
                self.assertNotIn("\\n", said)
                self.assertRegex(said, r"""\.["']$""")
        # both happen, or nothing was tried
        self.assertGreater(min(outcomes.values()), 0, outcomes)

    def test_bytes_and_members_at_random_are_a_result_or_a_sentence(self) -> None:
        self.assertSurvives(4, 1, least=30)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes minutes: ./dev test --all long")
    def test_long_bytes_and_members_at_random(self) -> None:
        self.assertSurvives(180, int(os.environ.get("ESPALIER_SEED", "2")), least=500)


if __name__ == "__main__":
    unittest.main()
