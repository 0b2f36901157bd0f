"""A shoot through a season: thermal time from daily temperatures, photosynthesis of every leaf by its response to light.

    python3 clients/python/examples/thermal_time/thermal_time.py --series leaves.csv

Writes a table with a line for every leaf and day: its area and what it has assimilated so far.
"""

from __future__ import annotations

import argparse
import csv
import sys
from math import exp, pi, sin, sqrt
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

from espalier import Answer, Environment, Query, Variable, local  # noqa: E402

BASE_TEMPERATURE = 6.0  # below it nothing develops, degrees C
GROUND = 600.0  # that one plant stands on, cm2
EXTINCTION = 0.65  # of light in the canopy, by leaf area index
DAYLIGHT = 14.0 * 3600.0  # s
PAR_PHOTONS = 0.5 * 4.57  # half of the radiation is photosynthetically active; 4.57 umol of photons per J


def assimilation(light: float, *, maximum: float = 28.0, yield_: float = 0.05, curvature: float = 0.8,
                 respiration: float = 1.2) -> float:
    """Net assimilation of a leaf, umol CO2 m-2 s-1, in the light `light` (umol photons m-2 s-1): the non-rectangular
    hyperbola (Thornley 1976, Mathematical Models in Plant Physiology, chapter 4)."""
    sum_ = yield_ * light + maximum
    return (sum_ - sqrt(sum_ * sum_ - 4.0 * curvature * yield_ * light * maximum)) / (2.0 * curvature) - respiration


class Season(Environment):
    """Answers with the day's thermal time and, for a leaf that tells its area, what it assimilates in the day."""

    needs = ("position", "parameters")
    inputs = (Variable("leaf"), Variable("area", "cm2"))
    outputs = (Variable("thermalTime", "degC d"), Variable("assimilated", "mg"))
    is_stateful = True

    weather: Sequence[Dict[str, float]] = ()

    def opened(self) -> None:
        self.day = 0

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        weather = self.weather[min(self.day, len(self.weather) - 1)]
        self.day += 1
        mean = 0.5 * (weather["temperature_min_C"] + weather["temperature_max_C"])
        thermal = max(0.0, mean - BASE_TEMPERATURE)
        # the light at noon of a day whose light is a half sine
        noon = weather["radiation_MJ_m2"] * 1e6 * PAR_PHOTONS / DAYLIGHT * pi / 2.0
        # leaves from the top down; each stands in the shade of the area above it
        order = sorted(range(len(queries)), key=lambda i: (-queries[i].position[1], queries[i].parameters[0]))
        answers: List[Answer] = [None] * len(queries)
        above = 0.0
        for index in order:
            area = queries[index].parameters[1]
            transmitted = EXTINCTION * exp(-EXTINCTION * above / GROUND)
            answers[index] = [thermal, self.day_total(noon * transmitted) * area]
            above += area
        return answers

    @staticmethod
    def day_total(noon: float) -> float:
        """Assimilated in a day by a cm2 of leaf, mg CO2: the light response summed over the half sine in 24 parts."""
        mean = sum(assimilation(noon * sin(pi * (part + 0.5) / 24.0)) for part in range(24)) / 24.0
        return mean * DAYLIGHT * 44e-6 * 1e3 * 1e-4

    def save(self) -> int:
        return self.day

    def restore(self, state: Any) -> None:
        self.day = int(state)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--weather", type=Path, default=HERE / "weather.csv", help="CSV file (default: %(default)s)")
    parser.add_argument("--days", type=int, default=120, help="(default: %(default)s)")
    parser.add_argument("--series", type=Path, default=Path("leaves.csv"), help="table to write (default: %(default)s)")
    options = parser.parse_args()
    with options.weather.open(newline="", encoding="utf-8") as file:
        Season.weather = [{name: float(value) for name, value in row.items() if name != "date"}
                          for row in csv.DictReader(file)]

    series: List[Tuple[int, int, float, float]] = []
    with local() as client:
        simulation = client.create((HERE / "plant.l").read_text(encoding="utf-8"), seed=1, name="thermal time",
                                   environment=[client.attach(Season)], derivation_length=options.days)
        for day in range(1, options.days + 1):
            simulation.step()
            # a leaf L(n, age, made) and behind it its query E(n, area)
            records = simulation.turtle()
            for leaf, query in zip(records, records[1:]):
                if leaf.symbol == "L":
                    series.append((day, int(leaf.parameters[0]), query.parameters[1], leaf.parameters[2]))
    with options.series.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["day", "leaf", "area_cm2", "assimilated_mg_CO2"])
        writer.writerows((day, leaf, f"{area:.3f}", f"{made:.2f}") for day, leaf, area, made in series)

    print(" leaf  unfolds on day  lives days  area cm2  assimilated g CO2")
    leaves = sorted({leaf for _, leaf, _, _ in series})
    for number in leaves:
        own = [row for row in series if row[1] == number]
        print(f"{number:5} {own[0][0]:15} {len(own):11} {max(row[2] for row in own):9.1f} {own[-1][3] / 1000:18.2f}")
    print(f"{len(leaves)} leaves, {sum(max(r[3] for r in series if r[1] == n) for n in leaves) / 1000:.1f} g CO2 in all; "
          f"wrote {options.series}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
