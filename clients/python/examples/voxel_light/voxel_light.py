"""Two trees share the light of a voxel grid: leaves absorb, what is below them gets less (Beer-Lambert). Needs NumPy.

    python3 clients/python/examples/voxel_light/voxel_light.py

Grows the gallery's light-tree twice, alone and beside a neighbour, and prints how far each crown reaches in every direction.
"""

from __future__ import annotations

import argparse
import sys
from math import hypot
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

try:
    import numpy as np
except ImportError:
    sys.exit("voxel_light: this example needs NumPy (Debian: python3-numpy).")

from espalier import Answer, Environment, Query, TurtleRecord, Variable, local  # noqa: E402


class VoxelLight(Environment):
    """Answers the light that reaches a point, from 0 to 1, through the leaf area above it and around."""

    needs = ("position",)
    outputs = (Variable("light"),)

    size = 0.5  # edge of a voxel, m
    leaf_area = 0.06  # of one bud with its leaves, m2
    extinction = 0.5

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        if not queries:
            return []
        voxels = np.floor(np.array([query.position for query in queries]) / self.size).astype(int)
        voxels -= voxels.min(axis=0) - 1
        density = np.zeros(voxels.max(axis=0) + 2)
        # integer counts: the sum does not depend on the order of the queries
        np.add.at(density, tuple(voxels.T), 1)
        # leaf area index above each voxel, smoothed over the nine columns around because light comes from the sky, not a point
        above = density[:, ::-1, :].cumsum(axis=1)[:, ::-1, :] - density
        padded = np.pad(above, ((1, 1), (0, 0), (1, 1)))
        around = sum(padded[i:i + above.shape[0], :, k:k + above.shape[2]] for i in range(3) for k in range(3)) / 9.0
        light = np.exp(-self.extinction * around * self.leaf_area / self.size**2)
        return [[float(value)] for value in light[tuple(voxels.T)]]


def reach(records: Sequence[TurtleRecord], plant: int, foot: Tuple[float, float]) -> Dict[str, float]:
    """How far the crown of a plant reaches from its foot to either side along x, and its greatest spread, m."""
    points = [(record.position[0] - foot[0], record.position[2] - foot[1]) for record in records if record.plant == plant]
    return {"towards -x": -min(x for x, _ in points), "towards +x": max(x for x, _ in points),
            "greatest": max(hypot(x, z) for x, z in points)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--distance", type=float, default=2.5, help="between the two trees, m (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=8, help="(default: %(default)s)")
    options = parser.parse_args()
    feet: List[Tuple[float, float, float]] = [(0.0, 0.0, 0.0), (options.distance, 0.0, 0.0)]

    with local() as client:
        light = client.attach(VoxelLight)
        for title, plants in (("alone", feet[:1]), ("beside a neighbour", feet)):
            simulation = client.create(gallery="light-tree", environment=[light], plants=plants, seed=7,
                                       derivation_length=options.steps)
            made = simulation.step(options.steps)
            records = simulation.turtle()
            print(f"{title}: {made.statistics['modules']} modules")
            for plant, foot in enumerate(plants):
                sides = reach(records, plant, (foot[0], foot[2]))
                shoots = [r for r in records if r.plant == plant and r.symbol == "F"]
                middle = sum(r.position[0] - foot[0] for r in shoots) / len(shoots)
                print(f"  tree {plant}: " + ", ".join(f"{name} {value:.2f} m" for name, value in sides.items()) +
                      f"; {len(shoots)} shoots, centred {middle:+.2f} m along x")
    return 0


if __name__ == "__main__":
    sys.exit(main())
