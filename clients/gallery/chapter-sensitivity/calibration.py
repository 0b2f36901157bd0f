"""Recovers the five parameters of random trees from measures of their branching: approximate Bayesian computation.

    python3 calibration.py [--plot FOLDER]

Each of 20 trees with hidden parameters is compared with 16,384 simulated ones (calibration.json). The measures become five
summaries by regression (Fearnhead & Prangle 2012). The nearest 2 % are kept and adjusted by local linear regression
(Beaumont, Zhang & Balding 2002). The program prints how many of the 100 hidden values lie in their 90 % credible intervals."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy as np

import espalier

HERE = Path(__file__).resolve().parent
PLAN = json.loads((HERE / "calibration.json").read_text(encoding="utf-8"))
NAMES = list(PLAN["parameters"])
TREES = 20
FIRST_SEED = 1_000_000  # of the hidden trees; the simulated ones have seeds from 1


def unit(values: np.ndarray) -> np.ndarray:
    """Parameters as probabilities of their prior distributions."""
    columns = []
    for i, name in enumerate(NAMES):
        prior = PLAN["parameters"][name]
        if "log" in prior:
            low, high = np.log(prior["log"])
            columns.append((np.log(values[:, i]) - low) / (high - low))
        else:
            low, high = prior["uniform"]
            columns.append((values[:, i] - low) / (high - low))
    return np.column_stack(columns)


def from_unit(u: np.ndarray) -> np.ndarray:
    columns = []
    for i, name in enumerate(NAMES):
        prior = PLAN["parameters"][name]
        if "log" in prior:
            low, high = np.log(prior["log"])
            columns.append(np.exp(low + u[:, i] * (high - low)))
        else:
            low, high = prior["uniform"]
            columns.append(low + u[:, i] * (high - low))
    return np.column_stack(columns)


def features(measures: np.ndarray, count: int = 6) -> np.ndarray:
    """Numbers for the regression: logarithms of the counts, the others, their squares and products, and which are missing."""
    x = np.column_stack([np.log1p(measures[:, :count]), measures[:, count:]])
    missing = np.isnan(x)
    x = np.where(missing, 0.0, x)
    pairs = [x[:, i] * x[:, j] for i in range(x.shape[1]) for j in range(i, x.shape[1])]
    return np.column_stack([x, missing[:, count:].astype(float), *pairs])


def logit(u: np.ndarray) -> np.ndarray:
    u = np.clip(u, 1e-6, 1 - 1e-6)
    return np.log(u / (1 - u))


class Posterior:
    """Samples of the parameters for one observed tree."""

    def __init__(self, parameters: np.ndarray, measures: np.ndarray, share: float = 0.02) -> None:
        self.unit = unit(parameters)
        raw = features(measures)
        self.mean, self.scale = raw.mean(axis=0), raw.std(axis=0) + 1e-9
        x = self.design(measures)
        self.weights, *_ = np.linalg.lstsq(x, logit(self.unit), rcond=None)
        self.summaries = x @ self.weights
        self.spread = self.summaries.std(axis=0)
        self.kept = int(share * len(x))

    def design(self, measures: np.ndarray) -> np.ndarray:
        x = (features(measures) - self.mean) / self.scale
        return np.column_stack([np.ones(len(x)), x])

    def sample(self, observed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Samples as probabilities of the priors, and their weights."""
        summary = (self.design(observed[None, :]) @ self.weights)[0]
        difference = (self.summaries - summary) / self.spread
        distance = np.sqrt((difference ** 2).sum(axis=1))
        nearest = np.argsort(distance, kind="stable")[:self.kept]
        weight = 1.0 - (distance[nearest] / (distance[nearest].max() + 1e-12)) ** 2
        x = np.column_stack([np.ones(self.kept), difference[nearest]])
        target = logit(self.unit[nearest])
        root = np.sqrt(weight)[:, None]
        slope, *_ = np.linalg.lstsq(x * root, target * root, rcond=None)
        adjusted = target - difference[nearest] @ slope[1:]
        return 1.0 / (1.0 + np.exp(-adjusted)), weight


def weighted_quantile(values: np.ndarray, weights: np.ndarray, probability: float) -> float:
    order = np.argsort(values, kind="stable")
    sums = np.cumsum(weights[order])
    return float(np.interp(probability * sums[-1], sums, values[order]))


def calibrate(trees: int = TREES) -> tuple[int, float, list[tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """The hidden values inside their intervals, the median width (1: the prior's), and samples of each tree."""
    with tempfile.TemporaryDirectory() as folder:
        espalier.sweep.run(HERE / "calibration.json", f"{folder}/prior.sqlite")
        prior = espalier.sweep.results(f"{folder}/prior.sqlite")
    measures = list(PLAN["measures"])
    posterior = Posterior(prior.array(NAMES), prior.array(measures))
    # trees of at least 30 internodes: of a tree that died as a seedling nothing can be learned
    hidden = from_unit(np.random.default_rng(2026).uniform(0.05, 0.95, size=(10 * trees, len(NAMES))))
    with espalier.Model(HERE / "tree.l", parameters=NAMES, measures=PLAN["measures"]) as model:
        observed = model.run(hidden, seeds=np.arange(FIRST_SEED, FIRST_SEED + len(hidden)))
    large = np.flatnonzero(observed[:, measures.index("all")] >= 30)[:trees]
    inside = 0
    widths = []
    samples = []
    for i in large:
        sample, weight = posterior.sample(observed[i])
        truth = unit(hidden[i][None, :])[0]
        for k in range(len(NAMES)):
            low, high = (weighted_quantile(sample[:, k], weight, p) for p in (0.05, 0.95))
            inside += low <= truth[k] <= high
            widths.append((high - low) / 0.9)
        samples.append((truth, sample, weight))
    return inside, float(np.median(widths)), samples


def plot(samples: list[tuple[np.ndarray, np.ndarray, np.ndarray]], folder: str) -> None:
    """Hidden and estimated values, and the kept sets of the first tree as parallel coordinates."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, len(NAMES), figsize=(13, 3))
    for k, (axis, name) in enumerate(zip(axes, NAMES)):
        middle = [weighted_quantile(sample[:, k], weight, 0.5) for _, sample, weight in samples]
        low = [weighted_quantile(sample[:, k], weight, 0.05) for _, sample, weight in samples]
        high = [weighted_quantile(sample[:, k], weight, 0.95) for _, sample, weight in samples]
        truth = [hidden[k] for hidden, _, _ in samples]
        axis.vlines(truth, low, high, color="0.7")
        axis.plot(truth, middle, "o", markersize=3)
        axis.plot([0, 1], [0, 1], "k:", linewidth=1)
        axis.set_title(name)
        axis.set_xlabel("hidden (quantile of the prior)")
    figure.tight_layout()
    figure.savefig(Path(folder, "recovered.png"), dpi=80)
    truth, sample, _ = samples[0]
    figure, axis = pyplot.subplots(figsize=(6, 3))
    axis.plot(sample[:100].T, color="tab:blue", alpha=0.15)
    axis.plot(truth, "k-o")
    axis.set_xticks(range(len(NAMES)), NAMES)
    figure.tight_layout()
    figure.savefig(Path(folder, "parallel-coordinates.png"), dpi=80)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plot", metavar="FOLDER")
    options = parser.parse_args()
    inside, width, samples = calibrate()
    print(f"{inside} of {TREES * len(NAMES)} hidden values lie in their 90 % credible intervals; "
          f"the median width is {width:.3f} of the prior's")
    if options.plot:
        plot(samples, options.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
