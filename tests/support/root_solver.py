"""Water in a root system by finite differences, written from the equations alone: an independent solver for tests.

In each segment axial flow is -kx (dψ/ds + dz/ds) and the inflow of a unit of length 2πa kr (ψs − ψ) (Landsberg and Fowkes 1978). Each segment is
cut into equal parts with a node at each border; the balance of each node is one row of a dense system, solved by Gauss. The error falls with the
square of the parts' length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Sequence

import numpy


@dataclass
class Segment:
    parent: int  # index of the segment at whose end it begins; −1: the collar
    length: float
    rise: float  # height of the end above the beginning
    radius: float
    kr: float
    kx: float


def heads_and_uptakes(segments: Sequence[Segment], soil_head: float, collar_head: float, parts: int = 16) -> "tuple[List[float], List[float]]":
    """Heads at the ends of the segments, and what each takes up."""
    count = 1 + parts * len(segments)  # node 0 is the collar
    matrix, right = numpy.zeros((count, count)), numpy.zeros(count)
    last = [0] * len(segments)
    through: "List[List[tuple[int, int, float]]]" = []
    for number, segment in enumerate(segments):
        upper = 0 if segment.parent < 0 else last[segment.parent]
        step = segment.length / parts
        axial = segment.kx / step
        radial = 2.0 * numpy.pi * segment.radius * segment.kr * step
        pieces = []
        for part in range(parts):
            lower = 1 + number * parts + part
            gravity = axial * segment.rise / parts
            # from the lower to the upper node: axial (ψ lower − ψ upper) + gravity
            for node, sign in ((lower, 1.0), (upper, -1.0)):
                matrix[node, lower] += sign * axial
                matrix[node, upper] -= sign * axial
                right[node] -= sign * gravity
                matrix[node, node] += 0.5 * radial
                right[node] += 0.5 * radial * soil_head
            pieces.append((upper, lower, radial))
            upper = lower
        last[number] = upper
        through.append(pieces)
    matrix[0, :] = 0.0
    matrix[0, 0] = 1.0
    right[0] = collar_head
    heads = numpy.linalg.solve(matrix, right)
    uptakes = [float(sum(radial * (soil_head - 0.5 * (heads[a] + heads[b])) for a, b, radial in pieces)) for pieces in through]
    return [float(heads[node]) for node in last], uptakes
