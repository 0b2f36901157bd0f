"""Sweeps: run a plan, read its results, spread it over Dask, and the indices of a sensitivity analysis.

The program `espalier sweep` makes the runs; docs/sweeps.md explains plans. Arrays are NumPy's.

>>> import json, os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     plan, output = os.path.join(folder, "plan.json"), os.path.join(folder, "results.sqlite")
...     with open(plan, "w") as file:
...         json.dump({"model": "borchert-honda", "steps": 20, "parameters": {"ETA": {"uniform": [0.8, 0.9]}},
...                    "runs": {"design": "latin-hypercube", "count": 4}, "measures": {"tips": {"count": "A"}}}, file)
...     espalier.sweep.run(plan, output)
...     len(espalier.sweep.results(output)["tips"])
4
"""

from __future__ import annotations

import csv
import io
import json
import os
import pathlib
import sqlite3
import subprocess
import tempfile
import warnings
from dataclasses import dataclass
from typing import Any, Dict, List, NamedTuple, Optional, Union

from .errors import RunWarning, ServerFailed
from .model import require_numpy
from .program import find_program

Path = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class Results:
    """The results of a sweep by the number of the run. NaN: no value, or the run failed."""

    columns: Dict[str, Any]  # by name, in order: run, seed, the parameters, the measures; arrays (n)
    errors: List[str]  # of each run; empty: it reached its end
    parameters: List[str]  # names of columns
    measures: List[str]

    def __getitem__(self, name: str) -> Any:
        return self.columns[name]

    def array(self, names: "List[str]") -> Any:
        """Some columns as an array (n, len(names))."""
        return require_numpy().column_stack([self.columns[name] for name in names])


def call(*arguments: str, program: Optional[str] = None) -> str:
    """Standard output of the program with these arguments."""
    return finished(*arguments, program=program).stdout


def finished(*arguments: str, program: Optional[str] = None) -> "subprocess.CompletedProcess[str]":
    """The program with these arguments, after its end."""
    done = subprocess.run([find_program() if program is None else program, "sweep", *arguments], capture_output=True,
                          text=True)
    if done.returncode != 0:
        raise ServerFailed(done.stderr.strip() or f"espalier sweep ended with status {done.returncode}.")
    return done


def run(plan: Path, output: Path, *, workers: int = 0, slice: Optional[str] = None,
        program: Optional[str] = None) -> None:
    """Makes the runs that `output` (.sqlite) does not have yet. Runs that failed, and the first warning of a run, are Python
    warnings (RunWarning)."""
    more = [] if slice is None else ["--slice", slice]
    done = finished(os.fspath(plan), "-o", os.fspath(output), "--workers", str(workers), "--quiet", *more, program=program)
    if done.stderr.strip():
        warnings.warn(done.stderr.strip(), RunWarning, stacklevel=2)


def results(output: Path, *, partial: bool = False, program: Optional[str] = None) -> Results:
    """Reads results. `partial`: also when runs are missing."""
    np = require_numpy()
    text = call("export", os.fspath(output), *(["--partial"] if partial else []), program=program)
    rows = list(csv.reader(io.StringIO(text)))
    names = rows[0][:-1]
    table = np.array([[float(cell) if cell else np.nan for cell in row[:-1]] for row in rows[1:]], dtype=float)
    table = table.reshape(len(rows) - 1, len(names))
    columns = {name: table[:, i].copy() for i, name in enumerate(names)}
    for name in ("run", "seed"):
        columns[name] = columns[name].astype("int64")
    return Results(columns, [row[-1] for row in rows[1:]], *_names(output))


def _names(output: Path) -> "tuple[List[str], List[str]]":
    """The parameters and the measures of results that `export` has just read."""
    connection = sqlite3.connect(pathlib.Path(output).resolve().as_uri() + "?immutable=1", uri=True)
    try:
        known = dict(connection.execute("SELECT name, value FROM sweep"))
    finally:
        connection.close()
    return json.loads(known["parameters"]), json.loads(known["measures"])


def dataset(output: Path, *, partial: bool = False, program: Optional[str] = None) -> Any:
    """The same as an xarray Dataset with the dimension `run`; xarray must be installed."""
    import importlib

    xarray: Any = importlib.import_module("xarray")
    found = results(output, partial=partial, program=program)
    columns = {name: ("run", values) for name, values in found.columns.items() if name != "run"}
    columns["error"] = ("run", found.errors)
    return xarray.Dataset(columns, coords={"run": found["run"]})


def table(plan: Path, *, program: Optional[str] = None) -> Any:
    """The runs of a plan before they are made: an array with the names run, seed and the parameters."""
    np = require_numpy()
    return np.genfromtxt(io.StringIO(call(os.fspath(plan), "--table", program=program)), delimiter=",", names=True,
                         deletechars="")


# --- Dask -----------------------------------------------------------------------------------------------------------


def make_slice(plan: str, name: str, slice: str, workers: int, program: Optional[str]) -> bytes:
    """One slice of a plan, as the content of its file of results. A Dask worker calls it."""
    with tempfile.TemporaryDirectory(prefix="espalier-") as folder:
        output = os.path.join(folder, "part.sqlite")
        run(os.path.join(plan, name), output, workers=workers, slice=slice, program=program)
        with open(output, "rb") as file:
            return file.read()


def submit(plan: Path, client: Any, *, slices: int, workers: int = 1, program: Optional[str] = None) -> List[Any]:
    """Gives the slices of a plan to the workers of a Dask client; each future is the content of a file of results. The
    workers must reach the folder of the plan under the same name."""
    folder, name = os.path.split(os.path.abspath(plan))
    return [client.submit(make_slice, folder, name, f"{k}/{slices}", workers, program, pure=False)
            for k in range(1, slices + 1)]


def gather(futures: List[Any], output: Path, *, program: Optional[str] = None) -> None:
    """Waits for the futures of submit() and merges their results into one file."""
    with tempfile.TemporaryDirectory(prefix="espalier-") as folder:
        parts = []
        for k, future in enumerate(futures, 1):
            parts.append(os.path.join(folder, f"part-{k}.sqlite"))
            with open(parts[-1], "wb") as file:
                file.write(future.result())
        call("merge", *parts, "-o", os.fspath(output), program=program)


# --- sensitivity ----------------------------------------------------------------------------------------------------


class SobolIndices(NamedTuple):
    """Shares of the variance of a measure, one for each parameter, with the standard errors of the estimates."""

    first: Any
    total: Any
    first_error: Any
    total_error: Any


def sobol_indices(values: Any, parameter_count: int) -> SobolIndices:
    """The indices of Sobol' from the values of a measure over the design `saltelli`, in the order of its runs. First order:
    Saltelli et al. 2010, table 2 (b); total: Jansen 1999. Standard errors are those of the means."""
    np = require_numpy()
    d = parameter_count
    given = np.asarray(values, dtype=float)
    if given.ndim != 1 or len(given) % (d + 2) != 0:
        raise ValueError(f"Expected the values of all runs of the design saltelli: a multiple of {d + 2}.")
    blocks = given.reshape(-1, d + 2)
    blocks = blocks[np.isfinite(blocks).all(axis=1)]
    a, mixed, b = blocks[:, 0], blocks[:, 1:-1], blocks[:, -1]
    both = np.concatenate([a, b])
    variance = both.var()
    centre = both.mean()
    first = (b - centre)[:, None] * (mixed - a[:, None]) / variance
    total = (mixed - a[:, None]) ** 2 / (2.0 * variance)
    root = len(blocks) ** 0.5
    return SobolIndices(first.mean(axis=0), total.mean(axis=0), first.std(axis=0, ddof=1) / root,
                        total.std(axis=0, ddof=1) / root)


class MorrisEffects(NamedTuple):
    """Statistics of the elementary effects, one for each parameter."""

    mu: Any  # mean
    mu_star: Any  # mean of the absolute values (Campolongo, Cariboni & Saltelli 2007)
    sigma: Any  # standard deviation with n - 1
    effects: Any  # (trajectories, parameters)


def morris_effects(parameters: Any, values: Any, levels: int = 4) -> MorrisEffects:
    """The effects of Morris 1991 from the design `morris`: `parameters` (n, d) and `values` (n) in the order of its runs.
    An effect is the change of the value for a change of the parameter by its whole range (uniform distributions)."""
    np = require_numpy()
    x = np.asarray(parameters, dtype=float)
    y = np.asarray(values, dtype=float)
    d = x.shape[1]
    if len(x) != len(y) or len(x) % (d + 1) != 0:
        raise ValueError(f"Expected the values of all runs of the design morris: a multiple of {d + 1}.")
    x = x.reshape(-1, d + 1, d)
    y = y.reshape(-1, d + 1)
    jump = levels / (2.0 * (levels - 1.0))
    effects = np.full((len(x), d), np.nan)
    for walk in range(len(x)):
        for step in range(d):
            change = x[walk, step + 1] - x[walk, step]
            changed = int(np.flatnonzero(change)[0])
            effects[walk, changed] = (y[walk, step + 1] - y[walk, step]) / (np.sign(change[changed]) * jump)
    return MorrisEffects(np.nanmean(effects, axis=0), np.nanmean(abs(effects), axis=0), np.nanstd(effects, axis=0, ddof=1),
                         effects)
