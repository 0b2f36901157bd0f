"""Measured plants beside simulated ones: tables and MTG files, means with intervals over replicates, RMSE, likelihood.

>>> import json, os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     plan, output = os.path.join(folder, "plan.json"), os.path.join(folder, "results.sqlite")
...     measured = os.path.join(folder, "measured.csv")
...     with open(plan, "w") as file:
...         json.dump({"model": "stochastic-bush", "replicates": 5, "steps": 4,
...                    "measures": {"segments": {"count": "F"}}}, file)
...     with open(measured, "w") as file:
...         _ = file.write("tree,segments\\nA,300\\nB,420\\n")
...     espalier.sweep.run(plan, output)
...     found = espalier.measured.compare(espalier.sweep.results(output), espalier.measured.table(measured))
>>> found.measures, found.rmse.shape
(['segments'], (1, 1))
"""

from __future__ import annotations

import csv
import difflib
import functools
import math
import os
import re
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Union

from .model import require_numpy
from .sweep import Results

Path = Union[str, "os.PathLike[str]"]

# --- measured plants --------------------------------------------------------------------------------------------------


MOST_BYTES = 200_000_000  # of a file


def _text(file: Path) -> str:
    """The text of a file. Raises ValueError for what is no text, and for what has no end."""
    if os.path.exists(file) and not os.path.isfile(file):
        raise ValueError(f"'{os.fspath(file)}' is no file: give the name of a file, no pipe, device or folder.")
    if os.path.getsize(file) > MOST_BYTES:
        raise ValueError(f"'{os.fspath(file)}' has more than {MOST_BYTES} bytes: give a part of it.")
    with open(file, newline="", encoding="utf-8-sig") as opened:
        try:
            return opened.read()
        except UnicodeDecodeError as error:
            raise ValueError(f"'{os.fspath(file)}' is no text in UTF-8 ({error.reason} at byte {error.start}): convert it, or get a complete copy.") from None


def table(file: Path) -> Dict[str, Any]:
    """The columns of a CSV or TSV file by name, a row for each measured plant. An empty cell and NA are NaN. A column of
    text, such as the name of the tree, is left out; a column of numbers with another word in it is an error."""
    np = require_numpy()
    text = _text(file)
    first = text.partition("\n")[0]
    separator = max("\t;,", key=first.count)
    try:
        rows = [row for row in csv.reader(text.splitlines(), delimiter=separator) if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise ValueError(f"'{os.fspath(file)}' is no table ({error}): write it again with a line for each plant.") from None
    if len(rows) < 2:
        raise ValueError(f"'{os.fspath(file)}' has no measured plant: give a line of names, and a line for each plant.")
    names = [name.strip() for name in rows[0]]
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(names):
            raise ValueError(f"'{os.fspath(file)}': row {number} has {len(row)} cells, and the line of names {len(names)}.")
    columns = {}
    for i, name in enumerate(names):
        cells = ["" if row[i].strip() == "NA" else row[i].strip() for row in rows[1:]]
        # in a table with semicolons the comma may be the decimal sign
        values = [_number(cell.replace(",", ".") if separator == ";" else cell) for cell in cells]
        wrong = [j for j, value in enumerate(values) if value is None]
        if 2 * len(wrong) >= len([cell for cell in cells if cell]) > 0:
            continue
        if wrong:
            raise ValueError(f"'{os.fspath(file)}': '{name}' of row {wrong[0] + 2} is '{cells[wrong[0]]}', no finite number as in the other rows.")
        columns[name] = np.array(values, dtype=float)
    return columns


def _number(cell: str) -> Optional[float]:
    """The number of a cell, NaN for an empty one, and None for a word."""
    try:
        value = float(cell or "nan")
    except ValueError:
        return None
    return None if math.isinf(value) else value


@dataclass
class _Vertex:
    symbol: str
    parent: int  # -1: a root
    branches: bool  # the edge from the parent is `+`


_PROMISE = "# Espalier: the last line is"
_ENTITY = re.compile(r"(\^?)([/<+]*)([A-Za-z]+)\d*")


def _vertices(file: Path) -> List[_Vertex]:
    """The vertices of the finest scale of an MTG file."""
    lines = _text(file).splitlines()
    # a file that Espalier wrote ends with this comment, so that a copy that was cut is seen
    if any(line.startswith(_PROMISE) for line in lines[:5]) and next((line for line in reversed(lines) if line.strip()), "").strip() != "# end":
        raise ValueError(f"'{os.fspath(file)}' ends before its last line '# end': get a complete copy.")
    start = next((i for i, line in enumerate(lines) if line.strip().upper().startswith("MTG:")), None)
    head = next((i for i, line in enumerate(lines) if i > (start or 0) and line.strip()), None)
    if start is None or head is None:
        raise ValueError(f"'{os.fspath(file)}' is no MTG file: it has no section 'MTG:' with a line of columns.")
    scales = _scales(lines[:start])
    finest = max(scales.values(), default=0)
    width = next((i for i, name in enumerate(lines[head].split("\t")) if i > 0 and name.strip()), 10 ** 9)
    found: List[_Vertex] = []
    latest: Dict[int, int] = {}  # by column: the vertex that was written there last
    begun: Dict[int, bool] = {}  # by column: an axis was joined by `+` there, and its first vertex comes in a later line
    for number, line in enumerate(lines[head + 1:], head + 2):
        cells = line.partition("#")[0].split("\t")[:width]  # the rest is a comment
        column = next((i for i, cell in enumerate(cells) if cell.strip()), None)
        if column is None:
            continue
        code = cells[column].strip()
        parts = _ENTITY.findall(code)
        if not parts or "".join("".join(part) for part in parts) != re.sub(r"\d", "", code):
            raise ValueError(f"'{os.fspath(file)}', line {number}: '{code}' is no entity of an MTG.")
        # `^` continues the vertex of the same column, else the one to the left
        before = column if parts[0][0] else column - 1
        parent = next((latest[i] for i in range(before, -1, -1) if i in latest), -1)
        for k in [k for k in latest if k > column]:
            del latest[k]
            begun.pop(k, None)
        # the first vertex of an axis that is joined by `+`, as in `+A2/U1`, branches off itself
        branches = begun.pop(next((i for i in range(before, -1, -1) if i in latest), -1), False)
        for _, edge, symbol in parts:
            if symbol not in scales:
                raise ValueError(f"'{os.fspath(file)}', line {number}: the class '{symbol}' is not in the section CLASSES.")
            if scales[symbol] < finest:
                if edge == "/" and scales[symbol] == min(scales.values()):
                    parent = -1  # another plant
                branches = branches or "+" in edge
                continue
            found.append(_Vertex(symbol, parent, branches or "+" in edge))
            branches = False
            parent = len(found) - 1
        if found:
            latest[column] = parent
            begun[column] = branches
    return found


def _scales(lines: Sequence[str]) -> Dict[str, int]:
    scales = {}
    isInside = False
    for line in lines:
        word = line.strip()
        if word.upper().startswith("CLASSES"):
            isInside = True
        elif word.endswith(":") or word.upper().startswith(("DESCRIPTION", "FEATURES")):
            isInside = False
        elif isInside and len(word.split()) >= 2 and word.split()[1].isdigit() and not word.startswith("$"):
            scales[word.split()[0]] = int(word.split()[1])
    return scales


def _tree(vertices: Sequence[_Vertex], of: str) -> List[Dict[str, int]]:
    """Parent, order, depth and Strahler number of the vertices `of`; others are passed through."""
    kept: List[Dict[str, int]] = []
    above: List[int] = []  # for each vertex: itself, or the vertex `of` above it
    isBranch: List[bool] = []  # whether a `+` lies between
    for vertex in vertices:
        up = above[vertex.parent] if vertex.parent >= 0 else -1
        branches = vertex.branches or (vertex.parent >= 0 and isBranch[vertex.parent])
        if of and vertex.symbol != of:
            above.append(up)
            isBranch.append(branches)
            continue
        parent = kept[up] if up >= 0 else None
        kept.append({"parent": up, "starts": int(parent is None or branches), "tip": 1, "strahler": 1, "strongest": 0,
                     "order": 0 if parent is None else parent["order"] + int(branches),
                     "depth": 1 if parent is None else parent["depth"] + 1})
        if parent is not None:
            parent["tip"] = 0
        above.append(len(kept) - 1)
        isBranch.append(False)
    for vertex_ in reversed(kept):
        if vertex_["parent"] >= 0:
            parent = kept[vertex_["parent"]]
            if vertex_["strahler"] > parent["strongest"]:
                parent["strongest"] = vertex_["strahler"]
                parent["strahler"] = max(parent["strahler"], parent["strongest"])
            elif vertex_["strahler"] == parent["strongest"]:
                parent["strahler"] = parent["strongest"] + 1
    return kept


_STATISTICS: "Dict[str, Callable[[List[Dict[str, int]]], float]]" = {
    "vertices": lambda t: len(t),
    "axes": lambda t: sum(v["starts"] for v in t),
    "tips": lambda t: sum(v["tip"] for v in t),
    "verticesPerAxis": lambda t: len(t) / sum(v["starts"] for v in t) if any(v["starts"] for v in t) else math.nan,
    "maximumOrder": lambda t: max((v["order"] for v in t), default=math.nan),
    "depth": lambda t: max((v["depth"] for v in t), default=0),
    "strahler": lambda t: max((v["strahler"] for v in t), default=0),
}


def mtg(files: "Union[Path, Iterable[Path]]", measures: "Mapping[str, Mapping[str, Any]]") -> Dict[str, Any]:
    """The measures `mtg` and `count` of a plan for measured plants, each an MTG file. Other measures are left out: write
    those into a table. The vertices are those of the finest scale."""
    np = require_numpy()
    names = {}
    for name, measure in measures.items():
        if not ("mtg" in measure or "count" in measure) or "where" in measure or "at" in measure:
            continue
        if "mtg" in measure and measure["mtg"] not in _STATISTICS:
            raise ValueError(f"measures.{name}.mtg: there is no '{measure['mtg']}'. " + _nearest(measure["mtg"], _STATISTICS))
        names[name] = measure
    if not names:
        raise ValueError("No measure is 'mtg' or 'count' of the last step: those are what an MTG file has.")
    listed = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    columns: Dict[str, List[float]] = {name: [] for name in names}
    for file in listed:
        vertices = _vertices(file)
        for name, measure in names.items():
            of = str(measure.get("of", measure.get("count", ""))).partition("(")[0]
            tree = [v for v in _tree(vertices, "" if of == "*" else of)
                    if "order" not in measure or v["order"] == measure["order"]]
            columns[name].append(float(_STATISTICS[measure.get("mtg", "vertices")](tree)))
    return {name: np.array(values, dtype=float) for name, values in columns.items()}


# --- comparison -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Comparison:
    """Simulated plants beside measured ones: a row for each set of parameters, a column for each measure."""

    names: List[str]  # of the parameters
    parameters: Any  # (sets, parameters)
    replicates: Any  # (sets): runs that reached their end
    measures: List[str]
    mean: Any  # (sets, measures), over the replicates
    low: Any  # (sets, measures): the interval of Student's t about the mean
    high: Any
    deviation: Any  # (sets, measures), with n - 1; NaN: one replicate
    measured_mean: Any  # (measures)
    rmse: Any  # (sets, measures): of the mean against each measured plant
    log_likelihood: Any  # (sets): of all measured plants, see compare()

    @property
    def best(self) -> int:
        """The set with the greatest likelihood; without one, that with the least sum of RMSE by measured mean."""
        np = require_numpy()
        if np.isfinite(self.log_likelihood).any():
            return int(np.nanargmax(self.log_likelihood))
        scale = np.where(self.measured_mean == 0, 1, abs(self.measured_mean))
        return int(np.nanargmin((self.rmse / scale).sum(axis=1)))


def compare(results: Results, measured: Mapping[str, Any], *, measures: Optional[Sequence[str]] = None,
            error: Optional[Mapping[str, float]] = None, confidence: float = 0.95) -> Comparison:
    """Compares the results of a sweep with measured plants.

    `measures` are columns of both (default: all that both have). The runs with equal parameters are replicates. The
    likelihood takes each measure of a set as normal with the mean and the deviation of its replicates; `error` has
    standard deviations of the measuring itself, which are added to it."""
    np = require_numpy()
    if not 0 < confidence < 1:
        raise ValueError("The confidence is a number between 0 and 1.")
    chosen = _chosen(results.measures, measured, measures)
    for name in error or {}:
        if name not in chosen:
            raise ValueError(f"error: there is no measure '{name}'. " + _nearest(name, chosen))
    parameters = results.parameters
    inputs = results.array(parameters) if parameters else np.zeros((len(results["run"]), 1))
    sets, first, number = np.unique(inputs, axis=0, return_index=True, return_inverse=True)
    # in the order of the runs
    order = np.argsort(first, kind="stable")
    rank = np.empty(len(order), dtype=int)
    rank[order] = np.arange(len(order))
    number = rank[number.reshape(-1)]
    succeeded = np.array([not message for message in results.errors], dtype=bool)
    shape = (len(sets), len(chosen))
    mean, low, high, deviation, rmse = (np.full(shape, np.nan) for _ in range(5))
    likelihood = np.zeros(len(sets))
    for j, name in enumerate(chosen):
        observed = np.asarray(measured[name], dtype=float).reshape(-1)
        observed = observed[np.isfinite(observed)]
        if len(observed) == 0:
            raise ValueError(f"The measured '{name}' has no number.")
        for i in range(len(sets)):
            values = results[name][(number == i) & succeeded]
            values = values[np.isfinite(values)]
            if len(values) == 0:
                likelihood[i] = np.nan
                continue
            mean[i, j] = values.mean()
            rmse[i, j] = np.sqrt(((mean[i, j] - observed) ** 2).mean())
            if len(values) > 1:
                deviation[i, j] = values.std(ddof=1)
                half = _student(0.5 + confidence / 2, len(values) - 1) * deviation[i, j] / len(values) ** 0.5
                low[i, j], high[i, j] = mean[i, j] - half, mean[i, j] + half
            likelihood[i] += _log_likelihood(observed, mean[i, j], np.hypot(deviation[i, j], (error or {}).get(name, 0.0)))
    return Comparison(list(parameters), sets[order][:, :len(parameters)], np.bincount(number[succeeded], minlength=len(sets)), chosen, mean, low, high,
                      deviation, np.array([np.nanmean(measured[name]) for name in chosen]), rmse, likelihood)


def _chosen(simulated: Sequence[str], measured: Mapping[str, Any], measures: Optional[Sequence[str]]) -> List[str]:
    if measures is None:
        both = [name for name in simulated if name in measured]
        if not both:
            raise ValueError("No measured column has the name of a measure. Measured: " + ", ".join(measured) +
                             "; simulated: " + ", ".join(simulated) + ".")
        return both
    for name in measures:
        for names, what in ((simulated, "simulated"), (measured, "measured")):
            if name not in names:
                raise ValueError(f"There is no {what} column '{name}'. " + _nearest(name, names))
    return list(measures)


def _log_likelihood(observed: Any, mean: float, deviation: float) -> float:
    if math.isnan(deviation):
        return math.nan
    if deviation == 0.0:
        return 0.0 if (observed == mean).all() else -math.inf
    return float((-0.5 * ((observed - mean) / deviation) ** 2 - math.log(deviation * math.sqrt(2 * math.pi))).sum())


def _nearest(name: str, names: Iterable[str]) -> str:
    known = list(names)
    near = difflib.get_close_matches(name, known, 1)
    return f"Did you mean '{near[0]}'?" if near else "Available: " + ", ".join(known) + "."


@functools.lru_cache(maxsize=256)
def _student(probability: float, freedom: int) -> float:
    """The quantile of Student's t above 1/2. With t = sqrt(n) tan(a) the density is proportional to cos(a)^(n-1)."""
    np = require_numpy()
    angle = np.linspace(0.0, math.pi / 2, 200_001)
    density = np.cos(angle) ** (freedom - 1)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return float(freedom ** 0.5 * math.tan(np.interp((probability - 0.5) * 2 * area[-1], area, angle)))
