"""The common parts of the tests of the gallery's chapters: strings, lines and rows of a chapter's model."""

import csv
import re
import tempfile
from pathlib import Path
from typing import Dict, List, Tuple

from support import GALLERY, espalier

Point = Tuple[float, float]


def chapter(name: str) -> str:
    return str(GALLERY / f"chapter-{name}")


def derived(model: str, *arguments: str) -> List[str]:
    """The strings of all steps of a chapter's model."""
    lines = espalier("derive", chapter(model), "--every", "--quiet", *arguments).stdout.splitlines()
    return [line.split("\t")[1] for line in lines]


def rewritten(axiom: str, productions: Dict[str, str], steps: int) -> List[str]:
    """The strings of a context-free L-system of one-character symbols, independently of the program."""
    found = [axiom]
    for _ in range(steps):
        found.append("".join(productions.get(symbol, symbol) for symbol in found[-1]))
    return found


def lines_of(model: str, *arguments: str) -> List[List[Point]]:
    """The lines that a model draws, as the points of its SVG with y upwards; units of the page."""
    with tempfile.TemporaryDirectory() as folder:
        espalier("run", chapter(model), "--quiet", "-o", f"{folder}/a.svg", *arguments)
        text = Path(folder, "a.svg").read_text(encoding="utf-8")
    lines: List[List[Point]] = []
    for path in re.findall(r' d="([^"]+)"', text):
        for piece in path.split("M")[1:]:
            lines.append([(float(x), -float(y)) for x, y in re.findall(r"(-?[\d.]+)[ ,](-?[\d.]+)", piece)])
    return lines


def rows_of(model: str, *arguments: str) -> List[Dict[str, str]]:
    """The actions of the turtle in a model, a row for each module."""
    with tempfile.TemporaryDirectory() as folder:
        espalier("run", model, "--quiet", "-o", f"{folder}/a.csv", *arguments)
        with open(f"{folder}/a.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


def vector(row: Dict[str, str], names: str) -> Tuple[float, ...]:
    return tuple(float(row[name]) for name in names.split(" "))


def edges_of(model: str, *arguments: str) -> List[Tuple[Tuple[float, ...], Tuple[float, ...]]]:
    """The steps that F draws, from where to where, in the model's unit. The turtle starts at the origin."""
    rows = rows_of(chapter(model), *arguments)
    edges = []
    for row in rows:
        if row["symbol"] == "F":
            start = vector(rows[int(row["parent"])], "x y z") if row["parent"] else (0.0, 0.0, 0.0)
            edges.append((start, vector(row, "x y z")))
    return edges


def lattice(point: Tuple[float, ...], unit: float) -> Tuple[int, ...]:
    return tuple(round(coordinate / unit) for coordinate in point)
