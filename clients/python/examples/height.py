"""The process `height` in Python: the height of the queried point along the world's up.

    espalier derive clients/gallery/growth-to-a-height/growth-to-a-height.l \
        --environment 'stdio:python3 clients/python/examples/height.py'
"""

from __future__ import annotations

from espalier import Answer, Environment, Query, Variable


class Height(Environment):
    """Answers the height of the queried point above the origin."""

    needs = ("position",)
    outputs = (Variable("height", "m"),)

    def opened(self) -> None:
        x, y, z = self.opening.world.get("up", [0.0, 1.0, 0.0])
        length = (x * x + y * y + z * z) ** 0.5
        self._up = (x / length, y / length, z / length)
        self.outputs = (Variable("height", self.opening.world.get("lengthUnit", "m")),)

    def answer(self, query: Query) -> Answer:
        return [sum(along * unit for along, unit in zip(query.position, self._up))]


if __name__ == "__main__":
    Height.serve()
