"""Light under a canopy: every querying bud and leaf shades the space below it (Beer-Lambert).

    python3 clients/python/examples/canopy_light.py --offer 127.0.0.1:4321

A simulation uses it with "environment": [{"type": "offered", "name": "canopy"}].
"""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from math import exp, floor
from typing import DefaultDict, Dict, List, Sequence, Tuple

from espalier import Answer, Environment, Query, Variable

Column = Tuple[int, int]


class Canopy(Environment):
    """Answers the light at the queried point: 1 above the canopy, less under every leaf. O(n log n)."""

    needs = ("position",)
    outputs = (Variable("light"),)
    # half the width of the column of air in which a leaf casts shadow, and what one leaf takes of the light
    column_width = 0.6
    extinction = 0.09

    @classmethod
    def name(cls) -> str:
        return "canopy"

    def opened(self) -> None:
        self.column_width = float(self.opening.configuration.get("columnWidth", self.column_width))
        self.extinction = float(self.opening.configuration.get("extinction", self.extinction))

    def column(self, query: Query) -> Column:
        return floor(query.position[0] / self.column_width), floor(query.position[2] / self.column_width)

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        columns: DefaultDict[Column, List[float]] = defaultdict(list)
        for query in queries:
            columns[self.column(query)].append(query.position[1])
        heights: Dict[Column, List[float]] = {column: sorted(values) for column, values in columns.items()}
        return [[exp(-self.extinction * self.leaves_above(query, heights))] for query in queries]

    def leaves_above(self, query: Query, heights: Dict[Column, List[float]]) -> int:
        """Leaves higher than the query in its column and the eight around it."""
        i, k = self.column(query)
        count = 0
        for column in ((i + di, k + dk) for di in (-1, 0, 1) for dk in (-1, 0, 1)):
            found = heights.get(column, [])
            count += len(found) - bisect_right(found, query.position[1])
        return count


if __name__ == "__main__":
    Canopy.serve()
