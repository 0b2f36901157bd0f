"""How fast the Python package is: an environment with NumPy over TCP, one of the standard library alone, a stream of a big plant.

    python3 tests/benchmark/python_benchmark.py --espalier build/release/bin/espalier

Times are those of whole calls of step(), in which the server derives, interprets, asks and applies.
"""

import argparse
import gc
import json
import sys
import time
from pathlib import Path
from typing import Any, Dict, List, Sequence

import results_page

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "clients" / "python"))

from espalier import Columns, Environment, Query, Simulation, local, wire  # noqa: E402
from espalier.blocks import numpy  # noqa: E402

MILLION = 1e6
TARGET = 1.0 * MILLION  # queries a second with NumPy
REPEATS = 5

# tips that double as long as the answer is positive, and stay as many once it is not
TIPS = ("Lsystem: 1\nderivation length: 100\nAxiom: FA?E(0)\nA?E(x) : x > 0 --> [+(20)FA?E(0)][-(20)FA?E(0)]\n"
        "A?E(x) : x <= 0 --> A?E(0)\nendlsystem\n")
# a plant of a million modules
PLANT = "Lsystem: 1\nderivation length: 30\nAxiom: F\nF --> F[+F]F[-F]\nendlsystem\n"


class ColumnLight(Environment):
    """Reads the positions and returns one column."""

    needs = ("position",)
    doublings = 17

    def step_columns(self, queries: Columns) -> Any:
        light = numpy.exp(-0.1 * queries.position[:, 1])
        return light if self.completed_steps < self.doublings else -light


class PlainLight(Environment):
    """The same, one query at a time."""

    needs = ("position",)
    doublings = 14

    def step(self, queries: Sequence[Query]) -> Any:
        sign = 1.0 if self.completed_steps < self.doublings else -1.0
        return [[sign / (1.0 + query.position[1] * query.position[1])] for query in queries]


def best(simulation: Simulation) -> float:
    """Queries a second of the best of several equal steps."""
    rates: List[float] = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        made = simulation.step()
        rates.append(made.statistics["queries"] / (time.perf_counter() - began))
    return max(rates)


def ask(program: str, environment: Any) -> Dict[str, float]:
    with local(program, arguments=["--log-level", "off"]) as client:
        plant = client.create(TIPS, environment=[client.attach(environment)], save=False)
        made = plant.step(environment.doublings + 1)
        return {"queries": 2.0 ** environment.doublings, "queries/s": best(plant), "modules": made.statistics["modules"]}


def stream(program: str) -> Dict[str, float]:
    with local(program, arguments=["--log-level", "off", "--limit", "outboxBytes=1000000000"]) as client:
        plant = client.create(PLANT, save=False)
        plant.step(8)
        while plant.history[-1].statistics["modules"] < MILLION:
            plant.step()
        with plant.stream("turtle", arrays=True, single=True, credits=1) as frames:
            first = frames.read()
            objects = len(gc.get_objects())
            times: List[float] = []
            for _ in range(REPEATS):
                began = time.perf_counter()
                plant.stream("turtle", arrays=True, single=True, credits=1).read()
                times.append(time.perf_counter() - began)
            made = len(gc.get_objects()) - objects
        size = sum(array.nbytes for array in first.columns.values())
        return {"modules": plant.history[-1].statistics["modules"], "records": first.count, "MB": size / MILLION,
                "ms": 1e3 * min(times), "modules/s": plant.history[-1].statistics["modules"] / min(times),
                "objects": made / REPEATS}


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--espalier", required=True, help="the program")
    parser.add_argument("--json", type=Path, help="file that receives the figures")
    parser.add_argument("--results", help="page that receives a table behind those of run_benchmarks.py")
    options = parser.parse_args()
    figures: Dict[str, Dict[str, float]] = {}
    if numpy is not None:
        found = figures["numpy/binary"] = ask(options.espalier, ColumnLight)
        verdict = "met" if found["queries/s"] >= TARGET else "NOT MET"
        print(f"NumPy columns over TCP, binary: {found['queries/s'] / MILLION:.2f} M queries/s "
              f"({found['queries']:,.0f} queries; target {TARGET / MILLION:.0f} M: {verdict})")
    wire.CAPABILITIES = ()
    found = figures["standard/text"] = ask(options.espalier, PlainLight)
    print(f"standard library over TCP, text, one object a query: {found['queries/s'] / MILLION:.3f} M queries/s")
    wire.CAPABILITIES = ("bin",)
    found = figures["stream/turtle"] = stream(options.espalier)
    print(f"turtle stream of {found['modules']:,.0f} modules ({found['MB']:.0f} MB in single precision): {found['ms']:.0f} ms a frame, "
          f"{found['modules/s'] / MILLION:.1f} M modules/s, {found['objects']:.0f} Python objects a frame")
    if options.results:
        rows = [["the Python package", "queries or modules", "M a second"]]
        for name, found in figures.items():
            rows.append([name, f"{found.get('queries', found['modules']):,.0f}",
                         f"{found.get('queries/s', found.get('modules/s', 0.0)) / MILLION:.2f}"])
        results_page.append_table(options.results, "The Python package", rows)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
