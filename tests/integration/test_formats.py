"""The files that run writes, read back by parsers that share nothing with the writers: the same model in every format agrees."""

from __future__ import annotations

import csv
import math
import os
import pty
import struct
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

from mtg_reader import MtgFile
from support import REPOSITORY, espalier, program

STRINGS_OF_THE_REFERENCE = [
    "005-branches-plain",
    "007-symbols-odd-characters",
    "010-arity-selects-rule",
    "071-ctx-left-parameters",
    "146-turtle-yaw",
    "174-sub-lsystem-created",
]

MODEL = """Lsystem: 1
derivation length: 5
Axiom: A(1)
A(l) --> F(l)[+(30)A(l*0.7)@O(0.1)]/(90)F(l*0.5)[-(40)A(l*0.6)]
endlsystem
"""
VIEW = "line style: pixel\ninitial line width: 2 p\nviewpoint: 0,0,1\n"


def read_png(data: bytes) -> tuple[int, int, list[bytes]]:
    """Width, height and rows of an RGB or RGBA PNG, by the standard's own words."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, body, head = 8, b"", b""
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0] == zlib.crc32(kind + content)
        head = content if kind == b"IHDR" else head
        body += content if kind == b"IDAT" else b""
        at += 12 + length
    width, height, depth, colour = struct.unpack(">IIBB", head[:10])
    assert depth == 8 and colour in (2, 6)
    size = 3 if colour == 2 else 4
    raw, rows, before = zlib.decompress(body), [], bytes(width * size)
    for y in range(height):
        line = raw[y * (width * size + 1) : (y + 1) * (width * size + 1)]
        row = bytearray(line[1:])
        for i in range(len(row)):
            left = row[i - size] if i >= size else 0
            corner = before[i - size] if i >= size else 0
            up = before[i]
            p = left + up - corner
            paeth = min((abs(p - left), 0, left), (abs(p - up), 1, up), (abs(p - corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[line[0]]) % 256
        before = bytes(row)
        rows.append(before)
    return width, height, rows


class Formats(unittest.TestCase):
    def setUp(self) -> None:
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)
        (self.folder / "tree.l").write_text(MODEL, encoding="utf-8")
        (self.folder / "tree.v").write_text(VIEW, encoding="utf-8")

    def write(self, *arguments: str) -> None:
        outputs = [word for name in arguments for word in ("-o", str(self.folder / name))]
        run = espalier("run", str(self.folder / "tree.l"), *outputs, "--quiet", "--size", "400x300")
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_all_formats_agree_on_counts_and_bounds(self) -> None:
        self.write("a.csv", "a.mtg", "a.svg", "a.eps", "a.string", "a.obj")
        with (self.folder / "a.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        segments = [row for row in rows if row["symbol"] == "F"]
        balls = [row for row in rows if row["symbol"] == "O"]
        self.assertGreater(len(segments), 60)
        # the string has the modules of the table
        text = (self.folder / "a.string").read_text(encoding="utf-8").strip()
        modules = "".join(
            row["symbol"] + (f"({row['parameters'].replace(';', ',')})" if row["parameters"] else "") for row in rows
        )
        self.assertEqual(modules, text)

        mtg = MtgFile((self.folder / "a.mtg").read_text(encoding="utf-8"))
        entities = [entity for _, entity in mtg.finest() if entity.name == "F"]
        self.assertEqual(len(entities), len(segments))
        for entity, row in zip(entities, segments):
            self.assertEqual((entity.features["XX"], entity.features["YY"], entity.features["ZZ"]), (row["x"], row["y"], row["z"]))
            self.assertEqual(entity.features["Order"], row["order"])
            self.assertEqual(entity.features["P1"], row["parameters"])
            self.assertEqual(entity.features["Time"], mtg.entities[-1].features["Time"])
        # an entity that is joined by + begins a branch of the next order; lengths are from the end of the entity before
        for _, entity in mtg.finest():
            if entity.parent is not None:
                before = mtg.entities[entity.parent].features
                self.assertEqual(int(entity.features["Order"]) - int(before["Order"]), 1 if entity.edge == "+" else 0)
                self.assertEqual(entity.features.get("Parent"), before.get("Module", before.get("Parent")))
                ends = [[float(features[name]) for name in ("XX", "YY", "ZZ")] for features in (before, entity.features)]
                self.assertAlmostEqual(float(entity.features["Length"]), math.dist(*ends), 12)
        self.assertEqual({entity.scale for entity in mtg.entities}, {1, 2, 3})
        self.assertEqual(mtg.strings(), [text])

        name = "{http://www.w3.org/2000/svg}"
        svg = ElementTree.parse(self.folder / "a.svg").getroot()
        paths = [path for path in svg.iter(name + "path") if path.get("class")]
        orders = {row["order"] for row in segments}
        self.assertEqual(sorted(path.get("class", "") for path in paths), sorted(f"order-{n}" for n in orders))
        self.assertEqual(sum(path.get("d", "").count("L") for path in paths), len(segments))
        self.assertEqual(len(list(svg.iter(name + "circle"))), len(balls))
        # width to height as the turtle's way, seen along -z; the margin is 20 and balls reach 0.05 beyond their centres
        _, _, width, height = map(float, svg.get("viewBox", "").split())
        tops = [float(row["y"]) for row in segments] + [float(row["y"]) + 0.05 for row in balls]
        lefts = [float(row["x"]) for row in segments] + [float(row["x"]) - 0.05 for row in balls]
        rights = [float(row["x"]) for row in segments] + [float(row["x"]) + 0.05 for row in balls]
        bottoms = [0.0] + [float(row["y"]) - 0.05 for row in balls]
        ratio = (max(rights) - min(lefts)) / (max(tops) - min(bottoms))
        self.assertAlmostEqual((width - 40) / (height - 40), ratio, places=3)

        eps = (self.folder / "a.eps").read_text(encoding="ascii").split("gsave")[1].split()
        self.assertEqual(eps.count("l"), len(segments))
        self.assertEqual(eps.count("d"), len(balls))

        vertices = [line.split() for line in (self.folder / "a.obj").read_text(encoding="ascii").splitlines()]
        heights = [float(words[2]) for words in vertices if words and words[0] == "v"]
        self.assertAlmostEqual(max(heights), max(tops), delta=0.05)

    def test_a_picture_shows_the_plant_where_it_is(self) -> None:
        self.write("a.png")
        width, height, rows = read_png((self.folder / "a.png").read_bytes())
        self.assertEqual((width, height), (400, 300))
        page = rows[0][:3]
        drawn = [
            (x, y) for y, row in enumerate(rows) for x in range(width) if row[x * 3 : x * 3 + 3] != page
        ]
        # fitted with a margin of a twentieth: the height decides
        self.assertAlmostEqual(min(y for _, y in drawn), 15, delta=2)
        self.assertAlmostEqual(max(y for _, y in drawn), 285, delta=3)
        left, right = min(x for x, _ in drawn), max(x for x, _ in drawn)
        # the shade on the ground fades a little beyond the frame
        self.assertAlmostEqual(left, width - 1 - right, delta=8)
        self.assertGreater(len(drawn), 2000)

    def test_strings_that_the_reference_program_wrote_are_gone_on_from(self) -> None:
        # recorded runs of models without variables, draws and long numbers: each string is read and gives the next one
        for name in STRINGS_OF_THE_REFERENCE:
            case = REPOSITORY / "tests" / "conformance" / "cases" / name
            recorded = [line.split("\t", 1) for line in (case / "expected.txt").read_text(encoding="utf-8").splitlines()]
            self.assertGreater(len(recorded), 1, name)
            for (step, text), (_, following) in zip(recorded, recorded[1:]):
                (self.folder / "start.string").write_text(text + "\n", encoding="utf-8")
                derived = espalier("derive", str(case / "model.l"), "--from", str(self.folder / "start.string"), "--steps", "1",
                                   "--compat", "cpfg", "--quiet")
                self.assertEqual(derived.stdout.strip(), following.strip(), f"{name}, from step {step}")

    def test_a_terminal_sees_a_bar_while_a_large_file_is_written(self) -> None:
        (self.folder / "wide.l").write_text(
            "Lsystem: 1\nderivation length: 12\nAxiom: A\nA --> F[+A][-A]\nendlsystem\n", encoding="utf-8")
        leader, follower = pty.openpty()
        process = subprocess.Popen([program(), "run", str(self.folder / "wide.l"), "-o", str(self.folder / "wide.obj")],
                                   stderr=follower, stdout=subprocess.DEVNULL)
        os.close(follower)
        # a terminal holds little: it is read while the program runs
        seen = b""
        while True:
            try:
                piece = os.read(leader, 65536)
            except OSError:  # the end, once nobody holds the other side
                break
            if not piece:
                break
            seen += piece
        os.close(leader)
        self.assertEqual(process.wait(timeout=60), 0)
        self.assertRegex(seen, rb"\r\[#+ *\] writing [^ ]*wide\.obj, 100 %")
        # the bar is gone when the note is written
        self.assertRegex(seen, rb"\r\x1b\[Kwrote [^ ]*wide\.obj")

    def test_a_hundred_plants_are_read_back_from_mtg(self) -> None:
        model = str(REPOSITORY / "clients" / "gallery" / "stochastic-bush")
        names = [str(self.folder / name) for name in ("plant%03d.mtg", "plant%03d.string")]
        run = espalier("run", model, "--variants", "100", "--seed", "3", "--steps", "4", "-o", names[0], "-o", names[1], "--quiet")
        self.assertEqual(run.returncode, 0, run.stderr)
        different = set()
        for file in sorted(self.folder.glob("plant*.mtg")):
            text = file.with_suffix(".string").read_text(encoding="utf-8").strip()
            self.assertEqual(MtgFile(file.read_text(encoding="utf-8")).strings(), [text], file.name)
            different.add(text)
        self.assertEqual(len(list(self.folder.glob("plant*.mtg"))), 100)
        self.assertGreater(len(different), 50)
        # and Espalier starts from such a file with the same string
        again = espalier("derive", model, "--from", str(file), "--steps", "0", "--quiet")
        self.assertEqual(again.stdout.strip(), text)


if __name__ == "__main__":
    unittest.main()
