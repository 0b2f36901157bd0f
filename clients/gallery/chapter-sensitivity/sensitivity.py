"""Which factors of Morris' function matter, and how the tree of Borchert and Honda responds to two parameters.

    python3 sensitivity.py [--plot FOLDER]

Plots: effects.png (µ* and σ of each factor) and response.png (tips over ETA and LAMBDA)."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import espalier

HERE = Path(__file__).resolve().parent


def swept(plan: str) -> espalier.sweep.Results:
    with tempfile.TemporaryDirectory() as folder:
        espalier.sweep.run(HERE / plan, f"{folder}/results.sqlite")
        return espalier.sweep.results(f"{folder}/results.sqlite")


def effects() -> tuple[list[str], espalier.sweep.MorrisEffects]:
    """The factors and their elementary effects."""
    results = swept("effects.json")
    return results.parameters, espalier.sweep.morris_effects(results.array(results.parameters), results["y"], levels=4)


def response() -> tuple[Any, Any, Any]:
    """ETA (21), LAMBDA (21), and the tips by both (21, 21)."""
    results = swept("response.json")
    levels = json.loads((HERE / "response.json").read_text(encoding="utf-8"))["runs"]["levels"]
    # the last parameter changes fastest
    shape = (levels, levels)
    return results["ETA"].reshape(shape)[:, 0], results["LAMBDA"].reshape(shape)[0], results["tips"].reshape(shape)


def plot(folder: str) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    names, found = effects()
    figure, axis = pyplot.subplots(figsize=(5, 4))
    axis.plot(found.mu_star, found.sigma, "o", markersize=4)
    for name, x, y in zip(names, found.mu_star, found.sigma):
        if x > 0.2 * max(found.mu_star):
            axis.annotate(name, (x, y), xytext=(4, 2), textcoords="offset points")
    axis.set_xlabel("µ* (how much a factor matters)")
    axis.set_ylabel("σ (interactions and bends)")
    figure.tight_layout()
    figure.savefig(Path(folder, "effects.png"), dpi=80)

    eta, share, tips = response()
    figure, axis = pyplot.subplots(figsize=(5, 4))
    lines = axis.contourf(share, eta, tips, levels=12, cmap="YlGn")
    figure.colorbar(lines, label="tips after 120 steps")
    axis.set_xlabel("LAMBDA (share of the major branch)")
    axis.set_ylabel("ETA (how growth slows down)")
    figure.tight_layout()
    figure.savefig(Path(folder, "response.png"), dpi=80)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plot", metavar="FOLDER")
    options = parser.parse_args()
    names, found = effects()
    for i in np.argsort(-found.mu_star):
        print(f"{names[i]:>4}: µ* {found.mu_star[i]:6.1f}, σ {found.sigma[i]:6.1f}")
    if options.plot:
        plot(options.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
