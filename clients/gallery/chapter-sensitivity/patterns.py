"""Pattern-oriented modelling of the tree of Borchert and Honda, after Wang et al. 2020: of 10,000 sets of four parameters those
survive that agree with four patterns of a tree whose parameters we pretend not to know. Two more patterns, which have not
filtered, tell what the survivors are worth.

    python3 patterns.py [--plot FOLDER]"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import espalier

HERE = Path(__file__).resolve().parent
PLAN = json.loads((HERE / "patterns.json").read_text(encoding="utf-8"))
# the values of the published model, whose tree is the measured one
PLANTED = {"ETA": 0.89, "LAMBDA": 0.7, "THRESHOLD": 5.0, "SIGMA0": 7.0}
FILTERS = ["tips", "tips_60", "height", "order"]  # each within 10 %
HELD_OUT = ["woodVolume", "spread"]
TOLERANCE = 0.1


class Report(NamedTuple):
    sets: int
    filters: list[str]
    held_out: list[str]
    passes: dict[str, int]  # sets that agree with one pattern
    survivors: Any  # parameters of the sets that agree with all filters
    planted_survives: bool
    hit_rate: float  # share of the survivors that agree with all held-out patterns
    hit_rate_of_all: float  # the same share of all sets


def filtered() -> Report:
    names = list(PLAN["parameters"])
    with tempfile.TemporaryDirectory() as folder:
        espalier.sweep.run(HERE / "patterns.json", f"{folder}/sets.sqlite")
        results = espalier.sweep.results(f"{folder}/sets.sqlite")
    settings = {"measures": PLAN["measures"], "steps": PLAN["steps"]}
    # the measured tree is that of the model without parameters; the planted set has to find it again
    with espalier.Model(HERE / PLAN["model"], **settings) as model:
        measured = dict(zip(model.measures, model([])))
    with espalier.Model(HERE / PLAN["model"], parameters=names, **settings) as model:
        planted = dict(zip(model.measures, model([PLANTED[name] for name in names])))

    def agrees(values: Any, pattern: str) -> Any:
        return np.abs(values - measured[pattern]) <= TOLERANCE * abs(measured[pattern])

    hits = {pattern: agrees(results[pattern], pattern) for pattern in FILTERS + HELD_OUT}
    survives = np.all([hits[pattern] for pattern in FILTERS], axis=0)
    held = np.all([hits[pattern] for pattern in HELD_OUT], axis=0)
    return Report(len(survives), FILTERS, HELD_OUT, {name: int(hit.sum()) for name, hit in hits.items()},
                  results.array(names)[survives], bool(all(agrees(planted[name], name) for name in FILTERS)),
                  float(held[survives].mean()), float(held.mean()))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plot", metavar="FOLDER")
    options = parser.parse_args()
    report = filtered()
    for name, count in report.passes.items():
        print(f"{name}: {count} of {report.sets} sets agree" + (" (held out)" if name in HELD_OUT else ""))
    print(f"{len(report.survivors)} sets survive; {100 * report.hit_rate:.0f} % of them agree with the held-out patterns, "
          f"of all sets {100 * report.hit_rate_of_all:.1f} %")
    if options.plot:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axis = pyplot.subplots(figsize=(6, 3))
        ranges = [PLAN["parameters"][name]["uniform"] for name in PLAN["parameters"]]
        low, high = np.array(ranges, dtype=float).T
        axis.plot(((report.survivors - low) / (high - low)).T, color="tab:green", alpha=0.3)
        axis.plot((np.array([PLANTED[name] for name in PLAN["parameters"]]) - low) / (high - low), "k-o")
        axis.set_xticks(range(len(low)), list(PLAN["parameters"]))
        figure.tight_layout()
        figure.savefig(Path(options.plot, "survivors.png"), dpi=80)
    return 0


if __name__ == "__main__":
    sys.exit(main())
