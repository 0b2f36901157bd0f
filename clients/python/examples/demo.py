"""Grows three plants on a server, one of them against an environment in another process, and draws them.

    ./dev demo

Starts `espalier serve`, attaches canopy_light.py over TCP, creates three simulations of the gallery, steps them while a second
client receives their turtle streams, and writes a page with the growth, SVG and OBJ of each plant under out/.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence

HERE = Path(__file__).resolve().parent
PACKAGE_FOLDER = HERE.parent
REPOSITORY = HERE.parents[2]
# the package is used from the source tree, installed or not
sys.path.insert(0, str(PACKAGE_FOLDER))

from espalier import Client, EspalierError, Server, Simulation, Stream, View  # noqa: E402

ANSWER_SECONDS = 120.0


@dataclass(frozen=True)
class Plant:
    model: str  # folder of the gallery
    environment: Sequence[Mapping[str, Any]]
    described: str
    command_line: str  # the same environment as a command line names it


CANOPY_COMMAND = f"{shlex.quote(sys.executable)} {shlex.quote(str(HERE / 'canopy_light.py'))}"
PLANTS = (
    Plant("light-tree", [{"type": "offered", "name": "canopy"}], "canopy_light.py, in another process over TCP",
          f"stdio:{CANOPY_COMMAND}"),
    Plant("branch-tiers", [{"type": "honda", "radius": 0.5}], "honda, built in", "honda"),
    Plant("shadow-trees", [{"type": "shadow", "gridSize": 101, "gridSpan": 50}], "shadow, built in", "shadow"),
)


class DemoFailed(Exception):
    """The failure, in a sentence that says what to do."""


def python_variables() -> Dict[str, str]:
    """The variables of a process in which Python finds the package."""
    paths = [str(PACKAGE_FOLDER), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path)}


class CanopyProcess:
    """The Python environment as a process of its own that offers itself to the server."""

    def __init__(self, address: str) -> None:
        self._process = subprocess.Popen(shlex.split(CANOPY_COMMAND) + ["--offer", address],
                                         stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, env=python_variables(),
                                         text=True)
        assert self._process.stderr is not None
        first = self._process.stderr.readline().strip()
        if "is offered to" not in first:
            self.stop()
            raise DemoFailed(f"The environment canopy_light.py could not offer itself: {first or 'it ended at once'}")

    def stop(self) -> None:
        if self._process.poll() is None:
            self._process.terminate()
        self._process.communicate()


@dataclass
class Growing:
    """One plant while it grows: the controller's simulation and the viewer's stream of it."""

    plant: Plant
    simulation: Simulation
    stream: Stream
    modules: int = 0
    records: int = 0
    steps: int = 0
    frames: int = 0
    is_finished: bool = False
    drawn: List[bytes] = field(default_factory=list)  # binary glTF of every step


def start(plant: Plant, controller: Client, viewer: Client) -> Growing:
    simulation = controller.create(gallery=plant.model, environment=plant.environment, seed=7, name=plant.model)
    stream = viewer.simulation(simulation.identifier).stream("turtle")
    growing = Growing(plant, simulation, stream)
    receive(growing, 0)
    return growing


def receive(growing: Growing, step: int) -> None:
    """Reads the turtle stream up to the frame of a step."""
    while True:
        frame = growing.stream.read(ANSWER_SECONDS)
        growing.frames += 1
        growing.records = len(frame.records)
        if frame.step >= step:
            return


def grow(plants: Sequence[Growing]) -> None:
    """Steps all plants to their ends, in turn, with a line for every step."""
    width = max(len(growing.plant.model) for growing in plants)
    print(f"\n{'plant':{width}}  step  modules  queries  answers       ms  turtle records")
    while any(not growing.is_finished for growing in plants):
        for growing in plants:
            if growing.is_finished:
                continue
            made = growing.simulation.step()
            receive(growing, made.step)
            growing.drawn.append(growing.simulation.geometry())
            figures = made.statistics
            print(f"{growing.plant.model:{width}}  {made.step:4}  {figures['modules']:7}  {figures['queries']:7}  "
                  f"{figures['answers']:7}  {figures['milliseconds']:7.1f}  {growing.records:14}", flush=True)
            growing.modules = int(figures["modules"])
            growing.steps = made.step
            growing.is_finished = made.finished or made.truncated


def draw(growing: Growing, program: str, out: Path) -> List[Path]:
    """Writes pictures of this very plant: the server's snapshot of it is drawn, nothing is grown again."""
    files = [out / f"{growing.plant.model}.svg", out / f"{growing.plant.model}.obj"]
    with tempfile.TemporaryDirectory() as folder:
        snapshot = Path(folder) / f"{growing.plant.model}.snapshot"
        growing.simulation.save_to(snapshot)
        # a snapshot names its environment; as the plant is finished, it is not asked anything any more
        command = [program, "run", "--resume", str(snapshot), "--environment", growing.plant.command_line, "--quiet"]
        for file in files:
            command += ["-o", str(file)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=python_variables())
    if done.returncode != 0:
        raise DemoFailed(f"The picture of {growing.plant.model} could not be drawn: {done.stderr.strip()}")
    page = out / f"{growing.plant.model}.html"
    try:
        View(growing.drawn, growing.plant.model).save(page)
    except EspalierError as error:
        # a program that was built without Node.js
        print(f"{shown(page)} is not written. {error}", file=sys.stderr)
        return files
    return [page, *files]


def demonstrate(program: str, out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    gallery = REPOSITORY / "clients" / "gallery"
    canopy: Optional[CanopyProcess] = None
    with Server(program, arguments=["--gallery", str(gallery), "--log-level", "warn"]) as server:
        print(f"espalier serve listens on {server.address}")
        try:
            canopy = CanopyProcess(server.address)
            print(f"canopy_light.py offers the environment 'canopy' to {server.address}")
            with server.connect(name="demo", timeout=ANSWER_SECONDS) as controller, \
                    server.connect(name="demo viewer", timeout=ANSWER_SECONDS) as viewer:
                plants = [start(plant, controller, viewer) for plant in PLANTS]
                for growing in plants:
                    print(f"simulation {growing.simulation.identifier}: {growing.plant.model} against "
                          f"{growing.plant.described}")
                grow(plants)
                print()
                for growing in plants:
                    files = draw(growing, program, out)
                    print(f"{growing.plant.model}: {growing.modules} modules after {growing.steps} steps, "
                          f"{growing.frames} frames received -> {', '.join(map(shown, files))}")
                print(f"\nThree plants grew; open {shown(out / 'light-tree.html')} in a browser to see one of them grow, or grow your own there:\n"
                      f"{shown(Path(program))} serve --http 127.0.0.1:8080   and then http://127.0.0.1:8080/")
        finally:
            if canopy is not None:
                canopy.stop()


def shown(path: Path) -> str:
    """A path as a person would type it from here."""
    return os.path.relpath(path)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--program", default=str(REPOSITORY / "build" / "release" / "bin" / "espalier"),
                        help="the program espalier (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=REPOSITORY / "out", help="folder for the pictures")
    options = parser.parse_args()
    try:
        demonstrate(options.program, options.out)
    except KeyboardInterrupt:
        return 130
    except (DemoFailed, EspalierError, OSError) as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
