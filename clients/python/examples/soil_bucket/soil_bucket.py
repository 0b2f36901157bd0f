"""A plant on a soil that is one bucket, through a season of daily weather from a CSV file.

    python3 clients/python/examples/soil_bucket/soil_bucket.py

Starts a server, attaches the soil, grows the plant one day a step and prints a line per week: rain, water in the bucket,
the supplied part of the demand, and the leaf area.
"""

from __future__ import annotations

import argparse
import csv
import sys
from math import exp
from pathlib import Path
from typing import Dict, List, Sequence

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

from espalier import Answer, Environment, Query, Variable, local  # noqa: E402

Day = Dict[str, float]


def read_weather(path: Path) -> List[Day]:
    """The days of a CSV file by column name; the date is left out."""
    with path.open(newline="", encoding="utf-8") as file:
        return [{name: float(value) for name, value in row.items() if name != "date"} for row in csv.DictReader(file)]


class Bucket(Environment):
    """The water that the roots reach, as one store (FAO Irrigation and Drainage Paper 56, chapters 7 and 8)."""

    needs = ("parameters",)
    inputs = (Variable("leafArea", "cm2"),)
    outputs = (Variable("waterSatisfaction"),)
    is_stateful = True

    weather: Sequence[Day] = ()
    capacity = 60.0  # total available water, mm
    fraction = 0.5  # of it that the plant takes up without stress
    ground = 500.0  # what one plant stands on, cm2

    def opened(self) -> None:
        self.water = 0.8 * self.capacity
        self.day = 0
        self.satisfaction = 1.0

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        weather = self.weather[min(self.day, len(self.weather) - 1)]
        # rain first; what the bucket cannot hold runs through
        self.water = min(self.capacity, self.water + weather["rain_mm"])
        # the canopy covers part of the ground (extinction 0.6); the rest of it evaporates, less as it dries
        leaf_area_index = sum(query.parameters[0] for query in queries) / self.ground
        cover = 1.0 - exp(-0.6 * leaf_area_index)
        wanted = weather["reference_evapotranspiration_mm"] * cover
        # below the readily available water the uptake falls linearly to nothing
        self.satisfaction = min(1.0, self.water / ((1.0 - self.fraction) * self.capacity))
        evaporated = weather["reference_evapotranspiration_mm"] * (1.0 - cover) * 0.3 * self.water / self.capacity
        self.water = max(0.0, self.water - wanted * self.satisfaction - evaporated)
        self.day += 1
        return [[self.satisfaction]] * len(queries)

    def save(self) -> List[float]:
        return [self.water, float(self.day), self.satisfaction]

    def restore(self, state: List[float]) -> None:
        self.water, self.day, self.satisfaction = state[0], int(state[1]), state[2]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--weather", type=Path, default=HERE / "weather.csv", help="CSV file (default: %(default)s)")
    parser.add_argument("--days", type=int, default=120, help="how many days to grow (default: %(default)s)")
    parser.add_argument("--snapshot", type=Path, help="write the grown plant, for espalier run --resume")
    options = parser.parse_args()

    soils: List[Bucket] = []

    class Soil(Bucket):
        """The soil of this run, which the loop below looks at."""

        weather = read_weather(options.weather)

        def opened(self) -> None:
            super().opened()
            soils.append(self)

    with local() as client:
        simulation = client.create((HERE / "plant.l").read_text(encoding="utf-8"), seed=1, name="soil bucket",
                                   environment=[client.attach(Soil)], derivation_length=options.days)
        print("  day  rain mm  water mm  got of wanted  leaves  leaf area cm2")
        rain = 0.0
        for day in range(options.days):
            simulation.step()
            rain += Soil.weather[min(day, len(Soil.weather) - 1)]["rain_mm"]
            if (day + 1) % 7 == 0 or day + 1 == options.days:
                leaves = [record.parameters[0] for record in simulation.turtle() if record.symbol == "L"]
                soil = soils[-1]
                print(f"{day + 1:5} {rain:8.1f} {soil.water:9.1f} {soil.satisfaction:14.2f} {len(leaves):7} {sum(leaves):14.0f}")
                rain = 0.0
        if options.snapshot:
            simulation.save_to(options.snapshot)
            print(f"wrote {options.snapshot}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
