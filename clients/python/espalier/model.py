"""A model as a function of its parameters: many runs at once, in a process of this machine."""

from __future__ import annotations

import json
import os
import shlex
import struct
import subprocess
import tempfile
import threading
import warnings
from typing import Any, Dict, List, Mapping, Optional, Sequence, Set, Tuple, Union

from .blocks import numpy
from .errors import EspalierError, RunWarning, ServerFailed
from .program import find_program

HEAD = struct.Struct("<QQ")
LENGTH = struct.Struct("<Q")

Names = Union[Sequence[str], Mapping[str, Mapping[str, Any]]]


def require_numpy() -> Any:
    if numpy is None:
        raise EspalierError("NumPy is missing: install it (Debian: python3-numpy). Sweeps have their numbers in its arrays.")
    return numpy


class Model:
    """Runs a model with many sets of parameters:

        model = espalier.Model("clients/gallery/borchert-honda", parameters=["ETA", "LAMBDA"],
                               measures={"tips": {"count": "A"}})
        tips = model.run([[0.8, 0.7], [0.9, 0.6]])          # an array (2, 1)

    `model`: a folder, a file or the name of a gallery model. `parameters`: names, or a mapping from names to what they
    change, as in a plan of `espalier sweep` (docs/sweeps.md). `measures`, and `settings` such as environment, steps, defines
    and answered, are the plan's members. `workers`: runs at the same time; 0: as many as the process may use processors.

    `client`: a Dask client. Its workers, which have the package and the program and reach the model under the same name, then
    make the runs. `host`: a machine that `ssh` reaches without a password; the program there makes the runs. The model is
    a file or folder there, or of the gallery.

    >>> with espalier.Model("borchert-honda", parameters=["ETA"], steps=20, measures={"tips": {"count": "A"}}) as model:
    ...     model.run([[0.8], [0.9]]).shape
    (2, 1)

    Warnings are Python warnings (RunWarning), each given once: those of the model with their line, a measure without a value,
    and that runs have failed. `warnings` lists the model's.

    The process that makes the runs stays until close() or the end of the `with` block. Several threads may call run(): one
    runs, the others wait."""

    def __init__(self, model: Union[str, "os.PathLike[str]"], *, measures: Mapping[str, Mapping[str, Any]],
                 parameters: Names = (), workers: int = 0, program: Optional[str] = None, client: Any = None,
                 host: Optional[str] = None, **settings: Any) -> None:
        require_numpy()
        name = os.fspath(model)
        plan: Dict[str, Any] = dict(settings)
        plan["model"] = os.path.abspath(name) if host is None and os.path.exists(name) else name
        if host is None and isinstance(settings.get("environment"), str) and os.path.exists(settings["environment"]):
            plan["environment"] = os.path.abspath(settings["environment"])
        plan["parameters"] = ({key: dict(value) for key, value in parameters.items()} if isinstance(parameters, Mapping)
                              else {key: {} for key in parameters})
        plan["measures"] = {key: dict(value) for key, value in measures.items()}
        self._open(json.dumps(plan), workers, program, client, host)

    @classmethod
    def of_plan(cls, plan: str, *, workers: int = 0, program: Optional[str] = None) -> "Model":
        """A model of the text of a plan without runs, as the attribute `plan` of another model."""
        made = cls.__new__(cls)
        made._open(plan, workers, program)
        return made

    def _open(self, plan: str, workers: int, program: Optional[str], client: Any = None, host: Optional[str] = None) -> None:
        self.plan = plan
        self.workers = workers
        self._client = client
        self.failures: List[Tuple[int, str]] = []
        self.warnings: List[str] = []
        self._remarks: List[Tuple[int, str]] = []  # (row, warning) of the last call
        self._told: Set[str] = set()
        self._lock = threading.Lock()
        arguments = ["sweep", "-", "--pipe", "--workers", str(workers)]
        if host is None:
            self._start([find_program() if program is None else program, *arguments])
        else:
            self._start(["ssh", "-T", "-o", "BatchMode=yes", "--", host, shlex.join([program or "espalier", *arguments])])

    def _start(self, command: List[str]) -> None:
        self._errors = tempfile.TemporaryFile()
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors)
        except OSError as error:
            self._errors.close()
            raise ServerFailed(f"The program '{command[0]}' could not be started: {error.strerror}.") from error
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(self.plan.encode("utf-8") + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # it has ended, and says why
        first = self._process.stdout.readline()
        if not first:
            raise self._ended()
        header = json.loads(first)
        self.parameters: List[str] = header["parameters"]
        self.measures: List[str] = header["measures"]
        self.seed: int = header["seed"]
        # the compiler's messages about the model; a read that moves no position, which the process shares
        said = os.pread(self._errors.fileno(), 1 << 20, 0).decode("utf-8", "replace").strip()
        if said:
            self._warn(said, said, 5)
            self.warnings.append(said)

    def _ended(self) -> ServerFailed:
        self._process.wait()
        self._errors.seek(0)
        text = self._errors.read().decode("utf-8", "replace").strip()
        self.close()
        return ServerFailed(text.replace("error: ", "", 1) or "The program that makes the runs has ended.")

    def run(self, parameters: Any, seeds: Any = None) -> Any:
        """The measures, an array (n, m), of n sets of parameters, an array (n, p). `seeds`: a whole number for each set;
        without them all sets have the plan's seed. A measure without a value, and every measure of a run that failed, is
        NaN; `failures` then lists (row, message) of the last call."""
        np = require_numpy()
        rows = np.ascontiguousarray(parameters, dtype="<f8")
        if rows.ndim != 2 or rows.shape[1] != len(self.parameters):
            raise ValueError(f"Expected an array (n, {len(self.parameters)}) with the parameters {self.parameters}, "
                             f"found the shape {rows.shape}.")
        if not np.isfinite(rows).all():
            raise ValueError("A parameter is not finite: give numbers only.")
        keys = b""
        given = None
        if seeds is not None:
            given = np.asarray(seeds)
            if given.shape != (len(rows),) or not np.issubdtype(given.dtype, np.integer) or (given < 0).any():
                raise ValueError(f"Expected {len(rows)} seeds, whole numbers from 0.")
            keys = given.astype("<u8").tobytes()
        if self._client is not None:
            return self._spread(rows, given)
        with self._lock:
            values, failures, remarks = self._exchange(rows, keys)
            self._report(values, failures, remarks)
        return values

    def _warn(self, key: str, text: str, level: int = 4) -> None:
        """Gives a Python warning, once for each key, of the line of the user's program that is `level` calls above."""
        if key not in self._told:
            self._told.add(key)
            warnings.warn(text, RunWarning, stacklevel=level)

    def _report(self, values: Any, failures: List[Tuple[int, str]], remarks: List[Tuple[int, str]]) -> None:
        """Keeps and tells what has gone wrong in the rows of a call."""
        np = require_numpy()
        self.failures = failures
        self._remarks = remarks
        for row, message in remarks:
            if message not in self.warnings:
                self.warnings.append(message)
                self._warn(message, f"Row {row}, and perhaps others: {message}")
        if failures:
            self._warn("failures", f"{len(failures)} of {len(values)} runs failed; their measures are NaN, and `failures` has "
                                   f"their messages. The first is row {failures[0][0]}: {failures[0][1]}")
        missing = np.isnan(values)
        missing[[row for row, _ in failures]] = False
        for k in np.flatnonzero(missing.any(axis=0)):
            name = self.measures[k]
            self._warn(f"measure {name}", f"The measure '{name}' has no value in {int(missing[:, k].sum())} of {len(values)} "
                                          f"runs; it is NaN there. The first is row {int(missing[:, k].argmax())}.")

    def _spread(self, rows: Any, seeds: Any) -> Any:
        np = require_numpy()
        count = max(1, len(rows) // (4 * max(1, len(self._client.scheduler_info()["workers"]))))
        starts = range(0, len(rows), count)
        parts = [(rows[i:i + count], None if seeds is None else seeds[i:i + count]) for i in starts]
        answers = self._client.gather([self._client.submit(run_on_worker, self.plan, *part, pure=False) for part in parts])
        failures, remarks = ([(start + row, message) for start, answer in zip(starts, answers) for row, message in answer[k]]
                             for k in (1, 2))
        values = np.concatenate([answer[0] for answer in answers] or [np.empty((0, len(self.measures)))])
        self._report(values, failures, remarks)
        return values

    def _exchange(self, rows: Any, keys: bytes) -> Tuple[Any, List[Tuple[int, str]], List[Tuple[int, str]]]:
        """Values, failures and warnings of rows; `keys`: the bytes of their seeds, or none."""
        np = require_numpy()
        count = len(rows)
        if self._process.stdin is None or self._process.stdin.closed or self._process.stdout is None:
            raise EspalierError("The model is closed: make a new one.")
        try:
            self._process.stdin.write(HEAD.pack(count, 1 if keys else 0) + rows.tobytes() + keys)
            self._process.stdin.flush()
            size = count * len(self.measures) * 8
            values = self._process.stdout.read(size)
            length = self._process.stdout.read(LENGTH.size)
            if len(values) != size or len(length) != LENGTH.size:
                raise self._ended()
            text = self._process.stdout.read(LENGTH.unpack(length)[0])
        except BrokenPipeError:
            raise self._ended() from None
        told = json.loads(text)
        failures, remarks = ([(int(row), str(message)) for row, message in told[key]] for key in ("failures", "warnings"))
        return np.frombuffer(values, dtype="<f8").reshape(count, len(self.measures)).copy(), failures, remarks

    def __call__(self, parameters: Any) -> Any:
        """For optimizers: the measures of one set, an array (m), or the number itself when there is one measure. With an
        array (n, p) as run()."""
        np = require_numpy()
        given = np.asarray(parameters, dtype=float)
        if given.ndim == 2:
            return self.run(given)
        values = self.run(given.reshape(1, -1))[0]
        return float(values[0]) if len(values) == 1 else values

    def close(self) -> None:
        """Ends the process."""
        if self._process.stdin is not None and not self._process.stdin.closed:
            try:
                self._process.stdin.close()
            except BrokenPipeError:
                pass
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._errors.close()

    def __enter__(self) -> "Model":
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_process") and self._process.poll() is None:
            self._process.kill()
            self.close()


worker_models: Dict[str, Model] = {}


def run_on_worker(plan: str, rows: Any, seeds: Any) -> Tuple[Any, List[Tuple[int, str]], List[Tuple[int, str]]]:
    """Values, failures and warnings of some rows. A Dask worker calls it; it keeps the model of the plan for the next call."""
    if plan not in worker_models:
        for other in worker_models.values():
            other.close()
        worker_models.clear()
        worker_models[plan] = Model.of_plan(plan, workers=1)
    model = worker_models[plan]
    # the client tells its user about them
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        values = model.run(rows, seeds)
    return values, model.failures, model._remarks
