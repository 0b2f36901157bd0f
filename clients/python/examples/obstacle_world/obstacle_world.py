"""A bush grows around obstacles that come from an OBJ file: every tip gets the distance and direction of the nearest surface.

    python3 clients/python/examples/obstacle_world/obstacle_world.py --snapshot bush.snapshot
    espalier run --resume bush.snapshot -o bush.svg

Pure Python, brute force over all triangles: O(tips · triangles). Fine for a garden; a model for big scenes is `obstacles`.
"""

from __future__ import annotations

import argparse
import sys
from math import sqrt
from pathlib import Path
from typing import List, Sequence, Tuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

from espalier import Answer, Environment, Query, Variable, local  # noqa: E402

Vector = Tuple[float, float, float]
Triangle = Tuple[Vector, Vector, Vector]


def minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def along(a: Vector, direction: Vector, t: float) -> Vector:
    return (a[0] + t * direction[0], a[1] + t * direction[1], a[2] + t * direction[2])


def read_obj(path: Path) -> List[Triangle]:
    """The triangles of a Wavefront OBJ file; a face of more corners becomes a fan."""
    vertices: List[Vector] = []
    triangles: List[Triangle] = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append((float(words[1]), float(words[2]), float(words[3])))
        elif words[:1] == ["f"]:
            try:
                # indices count from 1, or from the end when negative; `7/1/3` names texture and normal too
                corners = [int(word.split("/")[0]) for word in words[1:]]
                points = [vertices[corner - 1 if corner > 0 else corner] for corner in corners]
            except (ValueError, IndexError):
                raise ValueError(f"{path}:{number}: a face names a vertex that is not there") from None
            triangles += [(points[0], points[i], points[i + 1]) for i in range(1, len(points) - 1)]
    if not triangles:
        raise ValueError(f"{path}: no faces")
    return triangles


def nearest_on_triangle(p: Vector, triangle: Triangle) -> Vector:
    """The point of a triangle that is nearest to p (Ericson 2005, Real-Time Collision Detection, section 5.1.5)."""
    a, b, c = triangle
    ab, ac, ap = minus(b, a), minus(c, a), minus(p, a)
    d1, d2 = dot(ab, ap), dot(ac, ap)
    if d1 <= 0.0 and d2 <= 0.0:
        return a
    bp = minus(p, b)
    d3, d4 = dot(ab, bp), dot(ac, bp)
    if d3 >= 0.0 and d4 <= d3:
        return b
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return along(a, ab, d1 / (d1 - d3))
    cp = minus(p, c)
    d5, d6 = dot(ab, cp), dot(ac, cp)
    if d6 >= 0.0 and d5 <= d6:
        return c
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return along(a, ac, d2 / (d2 - d6))
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        return along(b, minus(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)))
    whole = 1.0 / (va + vb + vc)
    return along(along(a, ab, vb * whole), ac, vc * whole)


class Obstacles(Environment):
    """Answers the distance to the nearest surface and the direction in which it lies."""

    needs = ("position",)
    outputs = (Variable("distance", "m"), Variable("directionX"), Variable("directionY"), Variable("directionZ"))

    def opened(self) -> None:
        self.triangles = read_obj(Path(str(self.opening.configuration.get("file", HERE / "garden.obj"))))

    def answer(self, query: Query) -> Answer:
        offsets = [minus(nearest_on_triangle(query.position, triangle), query.position) for triangle in self.triangles]
        nearest = min(offsets, key=lambda offset: dot(offset, offset))
        distance = sqrt(dot(nearest, nearest))
        if distance == 0.0:
            return [0.0, 0.0, 0.0, 0.0]
        return [distance, nearest[0] / distance, nearest[1] / distance, nearest[2] / distance]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--obstacles", type=Path, default=HERE / "garden.obj", help="OBJ file (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=8, help="(default: %(default)s)")
    parser.add_argument("--snapshot", type=Path, help="write the grown bush, for espalier run --resume")
    options = parser.parse_args()

    try:
        triangles = read_obj(options.obstacles)
    except (OSError, ValueError) as error:
        sys.exit(f"obstacle_world: {error}")
    with local() as client:
        obstacles = {**client.attach(Obstacles), "configuration": {"file": str(options.obstacles)}}
        simulation = client.create((HERE / "plant.l").read_text(encoding="utf-8"), seed=1, name="obstacle world",
                                   environment=[obstacles], derivation_length=options.steps)
        print(" step  shoots  nearest to an obstacle, m")
        for _ in range(options.steps):
            made = simulation.step()
            shoots = [record.position for record in simulation.turtle() if record.symbol == "F"]
            nearest = min(sqrt(min(dot(offset, offset) for offset in
                                   (minus(nearest_on_triangle(point, triangle), point) for triangle in triangles)))
                          for point in shoots)
            print(f"{made.step:5} {len(shoots):7} {nearest:10.3f}")
        if options.snapshot:
            simulation.save_to(options.snapshot)
            print(f"wrote {options.snapshot}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
