"""Measured trees beside simulated ones: which of 81 sets of parameters made trees like those of measured.csv?

    python3 measured.py [--plot FOLDER]

measured.csv stands for a table from the field. Its 15 trees come from the model with branch 0.35 and length 1.7, so that the
outcome can be checked. Plot: measured.png (the likelihood over both parameters, and means with intervals)."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import espalier

HERE = Path(__file__).resolve().parent
TRUE = {"branch": 0.35, "length": 1.7}


def compared() -> espalier.measured.Comparison:
    with tempfile.TemporaryDirectory() as folder:
        espalier.sweep.run(HERE / "measured.json", f"{folder}/results.sqlite")
        results = espalier.sweep.results(f"{folder}/results.sqlite")
    return espalier.measured.compare(results, espalier.measured.table(HERE / "measured.csv"))


def plot(found: espalier.measured.Comparison, folder: str) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.6))
    branch, length = (np.unique(found.parameters[:, k]) for k in range(2))
    surface = (found.log_likelihood - found.log_likelihood.max()).reshape(len(branch), len(length))
    colours = left.pcolormesh(length, branch, surface, shading="nearest", vmin=-60, vmax=0, cmap="YlGn")
    figure.colorbar(colours, label="log likelihood, greatest 0")
    left.plot(TRUE["length"], TRUE["branch"], "k*", markersize=10)
    left.set_xscale("log")
    left.set_xticks([0.5, 1, 2, 4], ["0.5", "1", "2", "4"])
    left.set_xticks([], minor=True)
    left.set_xlabel("length")
    left.set_ylabel("branch")
    best = found.best
    place = np.arange(len(found.measures))
    scale = found.measured_mean
    right.errorbar(place, found.mean[best] / scale, [(found.mean[best] - found.low[best]) / scale,
                                                     (found.high[best] - found.mean[best]) / scale],
                   fmt="o", capsize=4, label="best set, 95 % interval of the mean")
    right.axhline(1.0, color="k", linestyle=":", label="mean of the measured trees")
    right.set_xticks(place, found.measures)
    right.set_ylabel("simulated / measured")
    right.legend()
    figure.tight_layout()
    figure.savefig(Path(folder, "measured.png"), dpi=80)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plot", metavar="FOLDER")
    options = parser.parse_args()
    found = compared()
    best = found.best
    print("best set: " + ", ".join(f"{name} {value:.3g}" for name, value in zip(found.names, found.parameters[best])))
    for j, name in enumerate(found.measures):
        print(f"{name}: measured {found.measured_mean[j]:.3g}, simulated {found.mean[best, j]:.3g} "
              f"({found.low[best, j]:.3g} to {found.high[best, j]:.3g}), RMSE {found.rmse[best, j]:.3g}")
    if options.plot:
        plot(found, options.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
