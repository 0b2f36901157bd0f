"""Water in a column of soil by finite volumes, written from the equations alone: an independent solver for tests.

Richards' equation in its mixed form, ∂θ/∂t = ∂/∂z (K (∂h/∂z + 1)), with the functions of van Genuchten (1980) and Mualem (1976). Each time step is
implicit (Euler) and solved by Newton's method with the exact derivatives; the difference of a whole step and two half steps bounds its error.
Conductivities between cells are arithmetic means, which let less than Ks through a surface under water when n is below 1.2: not for wet clay. Cells
are counted from the surface. Lengths in cm, times in days.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy
import numpy.typing

Array = "numpy.typing.NDArray[numpy.float64]"


@dataclass(frozen=True)
class Soil:
    residual: float
    saturated: float
    alpha: float  # 1/cm
    n: float
    conductivity: float  # cm/day

    def content(self, head: "Array") -> "Array":
        return self.residual + (self.saturated - self.residual) * self._saturation(head)

    def capacity(self, head: "Array") -> "Array":
        """dθ/dh."""
        dry = numpy.minimum(head, -1e-12)
        m, u = 1.0 - 1.0 / self.n, (-self.alpha * dry) ** self.n
        slope = (self.saturated - self.residual) * m * self.n * u / -dry * (1.0 + u) ** (-m - 1.0)
        return numpy.where(head < 0.0, slope, 0.0)

    def conductivities(self, head: "Array") -> "Tuple[Array, Array]":
        """K, and dK/dh. Near saturation K is linear over the last 0.001 cm, where its slope would have no end."""
        edge = -1e-3
        dry = numpy.minimum(head, edge)
        m, u = 1.0 - 1.0 / self.n, (-self.alpha * dry) ** self.n
        part = -numpy.expm1(m * (numpy.log(u) - numpy.log1p(u)))  # 1 − (1 − S^(1/m))^m
        values = self.conductivity * (1.0 + u) ** (-0.5 * m) * part * part
        # d ln K/du = −m/2/(1 + u) − 2 (1 − part) m/(u (1 + u) part)
        slopes = values * (-0.5 * m / (1.0 + u) - 2.0 * (1.0 - part) * m / (u * (1.0 + u) * part)) * self.n * u / dry
        near = head > edge
        line = (self.conductivity - values) / -edge
        wet = numpy.minimum(self.conductivity, values + line * (head - edge))
        return numpy.where(near, wet, values), numpy.where(near, numpy.where(head < 0.0, line, 0.0), slopes)

    def _saturation(self, head: "Array") -> "Array":
        dry = numpy.minimum(head, 0.0)
        return (1.0 + (-self.alpha * dry) ** self.n) ** (1.0 / self.n - 1.0)


@dataclass
class Column:
    soil: Soil
    heights: "Array"  # of the cells, from the surface down
    heads: "Array"
    rain: float = 0.0  # cm/day, as long as the surface is not under water
    evaporation: float = 0.0  # cm/day, as long as the surface is above `driest`
    driest: float = -10000.0
    drains: bool = False  # at the bottom by its weight, else closed
    entered: float = 0.0  # through the surface since the beginning, cm
    drained: float = 0.0
    surface_flow: float = 0.0  # downwards, at the last time

    def stored(self) -> float:
        return float(numpy.sum(self.soil.content(self.heads) * self.heights))

    def pass_until(self, days: float, tolerance: float = 1e-4) -> None:
        """Lets time pass; `tolerance` is the error of a water content in one time step."""
        step = min(1e-6, days)
        left = days
        while left > 1e-13:
            step = min(step, left)
            whole = self._step(self.heads, step)
            first = self._step(self.heads, step / 2)
            second = self._step(first[0], step / 2) if first else None
            if whole is None or first is None or second is None:
                step /= 4
                continue
            error = float(numpy.max(numpy.abs(self.soil.content(second[0]) - self.soil.content(whole[0]))))
            if error > tolerance and step > 1e-12:
                step *= max(0.2, 0.8 * (tolerance / error) ** 0.5)
                continue
            self.heads = second[0]
            self.surface_flow = second[1]
            self.entered += step / 2 * (first[1] + second[1])
            self.drained += step / 2 * (first[2] + second[2])
            left -= step
            step *= min(2.0, 0.8 * (tolerance / max(error, 1e-14)) ** 0.5)

    def _surface(self, head: float) -> "Tuple[float, float]":
        """Flow into the first cell, and its derivative by the cell's head."""
        half = 0.5 * float(self.heights[0])
        k, slope = (float(x[0]) for x in self.soil.conductivities(numpy.array([head])))
        if self.rain > 0.0:
            # no more than gets in under a surface at 0
            mean = 0.5 * (k + self.soil.conductivity)
            most = mean * (1.0 - head / half)
            return (self.rain, 0.0) if most > self.rain else (most, 0.5 * slope * (1.0 - head / half) - mean / half)
        if self.evaporation > 0.0:
            dry = float(self.soil.conductivities(numpy.array([self.driest]))[0][0])
            mean = 0.5 * (k + dry)
            gradient = (head - self.driest) / half - 1.0  # upwards
            most = mean * gradient
            return (-self.evaporation, 0.0) if most > self.evaporation else (-most, -0.5 * slope * gradient - mean / half)
        return 0.0, 0.0

    def _step(self, before: "Array", days: float) -> "Optional[Tuple[Array, float, float]]":
        """Heads after a time step, flow through the surface and out of the bottom; nothing when it does not converge."""
        heads, old = before.copy(), self.soil.content(before)
        apart = 0.5 * (self.heights[:-1] + self.heights[1:])
        for iteration in range(100):
            k, slope = self.soil.conductivities(heads)
            if iteration >= 15:
                slope = numpy.zeros_like(slope)  # Picard's method: at saturation slopes jump
            capacity = self.soil.capacity(heads)
            between = 0.5 * (k[:-1] + k[1:])
            gradient = (heads[:-1] - heads[1:]) / apart + 1.0
            down = between * gradient
            by_upper = 0.5 * slope[:-1] * gradient + between / apart
            by_lower = 0.5 * slope[1:] * gradient - between / apart
            inflow, by_first = self._surface(float(heads[0]))
            outflow, by_last = (float(k[-1]), float(slope[-1])) if self.drains else (0.0, 0.0)
            entering = numpy.concatenate(([inflow], down))
            leaving = numpy.concatenate((down, [outflow]))
            residual = (self.soil.content(heads) - old) * self.heights / days - entering + leaving
            diagonal = capacity * self.heights / days
            diagonal[:-1] += by_upper
            diagonal[1:] -= by_lower
            diagonal[0] -= by_first
            diagonal[-1] += by_last
            change = _tridiagonal(-by_upper, diagonal, by_lower, -residual)
            if not numpy.all(numpy.isfinite(change)):
                return None
            # a dry cell that becomes wet would overshoot
            heads = heads + numpy.clip(change, -0.5 * numpy.abs(heads) - 1.0, 0.5 * numpy.abs(heads) + 1.0)
            if float(numpy.max(numpy.abs(change) / (1e-3 + numpy.abs(heads)))) < 1e-9:
                return heads, self._surface(float(heads[0]))[0], float(self.soil.conductivities(heads)[0][-1]) if self.drains else 0.0
        return None


def _tridiagonal(below: "Array", diagonal: "Array", above: "Array", right: "Array") -> "Array":
    """Thomas' algorithm."""
    count = len(diagonal)
    lower, middle, upper, result = below.tolist(), diagonal.tolist(), above.tolist(), right.tolist()
    for i in range(1, count):
        if middle[i - 1] == 0.0:
            return numpy.full(count, numpy.nan)
        factor = lower[i - 1] / middle[i - 1]
        middle[i] -= factor * upper[i - 1]
        result[i] -= factor * result[i - 1]
    if middle[-1] == 0.0:
        return numpy.full(count, numpy.nan)
    result[-1] /= middle[-1]
    for i in range(count - 2, -1, -1):
        result[i] = (result[i] - upper[i] * result[i + 1]) / middle[i]
    return numpy.array(result)


def graded(depth: float, first: float, growth: float, largest: float) -> "Array":
    """Heights of cells that grow from the surface down."""
    heights: List[float] = []
    height = first
    while sum(heights) < depth - 1e-12:
        heights.append(min(height, depth - sum(heights)))
        height = min(height * growth, largest)
    return numpy.array(heights)


def depth_of(column: Column, content: float) -> float:
    """Depth at which the water content falls below a value, linear between the middles of cells."""
    depths = numpy.cumsum(column.heights) - 0.5 * column.heights
    contents = column.soil.content(column.heads)
    for i in range(1, len(depths)):
        if contents[i - 1] >= content > contents[i]:
            return float(depths[i - 1] + (contents[i - 1] - content) / (contents[i - 1] - contents[i]) * (depths[i] - depths[i - 1]))
    return float("nan")
