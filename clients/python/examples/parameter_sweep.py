"""A thousand small simulations: a table of results as CSV, and a plot of it.

    python3 clients/python/examples/parameter_sweep.py --table sweep.csv --plot sweep.svg

How many leaf clusters do two tiers of branches carry? Varies the branching angle of the gallery's branch-tiers and the radius in
which a cluster allows no other cluster (a question of Honda, Tomlinson & Fisher 1981).
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from pathlib import Path
from statistics import mean
from typing import Dict, List, Tuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from espalier import Client, local  # noqa: E402

Row = Dict[str, float]


def run(client: Client, angle: float, radius: float, steps: int) -> Row:
    """One simulation: grown, measured, deleted."""
    simulation = client.create(gallery="branch-tiers", environment=[{"type": "honda", "radius": radius, "threeDimensional": True}],
                               parameters={"ALPHA2": angle}, derivation_length=steps, seed=1, save=False)
    simulation.step(steps)
    clusters = [record.position for record in simulation.turtle() if record.symbol == "K"]
    simulation.delete()
    return {"angle": angle, "radius": radius, "clusters": float(len(clusters)),
            "reach": max((x * x + z * z) ** 0.5 for x, _, z in clusters)}


def plot(rows: List[Row], path: Path) -> None:
    """Clusters over angle, a curve for each radius, as an SVG file."""
    curves: Dict[float, List[Tuple[float, float]]] = {}
    for row in rows:
        curves.setdefault(row["radius"], []).append((row["angle"], row["clusters"]))
    angles = [row["angle"] for row in rows]
    top = max(row["clusters"] for row in rows) * 1.05
    left, width, height = min(angles), 640.0, 400.0
    span = max(angles) - left or 1.0
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-50 -20 {width + 130:g} {height + 70:g}" font-family="sans-serif" '
             'font-size="13">', f'<path d="M0 0V{height:g}H{width:g}" fill="none" stroke="black"/>',
             f'<text x="{width / 2:g}" y="{height + 40:g}" text-anchor="middle">branching angle, degrees</text>',
             '<text x="-40" y="-6">leaf clusters</text>', f'<text x="{width + 8:g}" y="-6">radius</text>']
    for number in range(6):
        angle, level = left + span * number / 5, top * number / 5
        lines.append(f'<text x="{width * number / 5:g}" y="{height + 18:g}" text-anchor="middle">{angle:.0f}</text>')
        lines.append(f'<text x="-6" y="{height - height * number / 5 + 4:g}" text-anchor="end">{level:.0f}</text>')
    for index, (radius, points) in enumerate(sorted(curves.items())):
        path_text = " ".join(f"{(x - left) / span * width:.1f},{height - y / top * height:.1f}" for x, y in sorted(points))
        colour = f"hsl({index * 320 / max(1, len(curves)):.0f},70%,42%)"
        lines.append(f'<polyline points="{path_text}" fill="none" stroke="{colour}" stroke-width="1.6"/>')
        lines.append(f'<text x="{width + 8:g}" y="{14 + 15 * index}" fill="{colour}">{radius:.2f}</text>')
    path.write_text("\n".join([*lines, "</svg>\n"]), encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--angles", type=int, default=50, help="how many angles from 10 to 70 degrees (default: %(default)s)")
    parser.add_argument("--radii", type=int, default=20, help="how many radii from 0.1 to 0.9 (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=5, help="steps of each simulation (default: %(default)s)")
    parser.add_argument("--table", type=Path, default=Path("sweep.csv"), help="(default: %(default)s)")
    parser.add_argument("--plot", type=Path, default=Path("sweep.svg"), help="(default: %(default)s)")
    options = parser.parse_args()

    def spread(least: float, most: float, count: int) -> List[float]:
        return [least + (most - least) * number / max(1, count - 1) for number in range(count)]

    began = time.perf_counter()
    with local() as client:
        rows = [run(client, angle, radius, options.steps)
                for radius in spread(0.1, 0.9, options.radii) for angle in spread(10.0, 70.0, options.angles)]
    seconds = time.perf_counter() - began
    with options.table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    plot(rows, options.plot)
    print(f"{len(rows)} simulations in {seconds:.1f} s; mean {mean(row['clusters'] for row in rows):.1f} clusters; "
          f"wrote {options.table} and {options.plot}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
