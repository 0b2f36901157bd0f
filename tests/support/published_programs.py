"""The published environment programs, written a second time from the description of what they compute, in 32-bit floats,
pair by pair and cell by cell. A test compares the compatible processes with them on random inputs.

Each program is a class. `answers(queries)` takes the queries of a step and returns what it sets of each, by index."""

import itertools
import math
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy

F = numpy.float32
Answers = List[Dict[int, float]]
Vector = Tuple[numpy.float32, numpy.float32, numpy.float32]


class Query(NamedTuple):
    place: Sequence[float]
    heading: Sequence[float]
    sent: Sequence[float]


def vector(numbers: Sequence[float]) -> Vector:
    return F(numbers[0]), F(numbers[1]), F(numbers[2])


def minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def times(a: Vector, factor: numpy.float32) -> Vector:
    return a[0] * factor, a[1] * factor, a[2] * factor


def dot(a: Vector, b: Vector) -> numpy.float32:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def root(x: numpy.float32) -> numpy.float32:
    return F(math.sqrt(float(x))) if x >= 0 else F(math.nan)


def unit(a: Vector) -> Vector:
    size = root(dot(a, a))
    return (a[0] / size, a[1] / size, a[2] / size) if size > 0 else a


class Honda81:
    def __init__(self, radius: float, in_space: bool) -> None:
        self.radius, self.in_space = F(radius), in_space

    def answers(self, queries: Sequence[Query]) -> Answers:
        result: Answers = []
        for i, one in enumerate(queries):
            p, vigor, group = vector(one.place), one.sent[0], one.sent[1] if len(one.sent) > 1 else 0
            grows = 1.0
            for j, other in enumerate(queries):
                x, y, z = minus(vector(other.place), p)
                squared = x * x + y * y + z * z if self.in_space else x * x + z * z
                same = group == (other.sent[1] if len(other.sent) > 1 else 0)
                if i != j and same and vigor <= other.sent[0] and squared <= self.radius * self.radius:
                    grows = 0.0
            result.append({0: grows})
        return result


class Ecosystem:
    def __init__(self, vigor: bool, in_space: bool) -> None:
        self.vigor, self.in_space = vigor, in_space

    def overlap(self, a: Query, b: Query) -> bool:
        x, y, z = minus(vector(b.place), vector(a.place))
        squared = x * x + y * y + z * z if self.in_space else x * x + z * z
        reach = F(a.sent[0]) + F(b.sent[0])
        return bool(squared <= reach * reach)

    def answers(self, queries: Sequence[Query]) -> Answers:
        second = [q.sent[1] if len(q.sent) > 1 else 0.0 for q in queries]
        radius = [q.sent[0] for q in queries]
        alive = [True] * len(queries)
        for i, one in enumerate(queries):
            for j, other in enumerate(queries):
                if i == j or not self.overlap(one, other):
                    continue
                if not self.vigor:
                    if second[i] == second[j] and radius[j] >= radius[i]:
                        alive[i] = False
                elif alive[j] and (second[i] < second[j] or (second[i] == second[j] and radius[i] < radius[j])):
                    alive[i] = False
        return [{0: 1.0 if free else 0.0} for free in alive]


class Raster:
    """Cells of `position` and `size`, with rows of pixels (green, red) from the top."""

    def __init__(self, cells: Sequence[int], size: Sequence[float], position: Sequence[float],
                 pixels: Sequence[Sequence[Tuple[int, int]]], z_is_up: bool = True) -> None:
        self.cells, self.size, self.position, self.up = cells, size, position, 1 if z_is_up else 2
        self.maps = [[(255, 0)] * cells[0] for _ in range(cells[1])]
        if pixels:
            x_step = F(len(pixels[0]) - 1) / F(cells[0] - 1)
            y_step = F(len(pixels) - 1) / F(cells[1] - 1)
            self.maps = [[pixels[len(pixels) - 1 - int(F(y) * y_step)][int(F(x) * x_step)] for x in range(cells[0])]
                         for y in range(cells[1])]

    def cell(self, place: Sequence[float]) -> Tuple[int, int]:
        found = [math.floor((F(place[axis]) - F(self.position[k])) * F(self.cells[k]) / F(self.size[k]))
                 for k, axis in ((0, 0), (1, self.up))]
        return found[0], found[1]

    def holds(self, cell: Tuple[int, int]) -> bool:
        return 0 <= cell[0] < self.cells[0] and 0 <= cell[1] < self.cells[1]

    def disc(self, place: Sequence[float], radius: numpy.float32) -> List[Tuple[int, int]]:
        x, y = self.cell(place)
        a, b = (int(radius * F(self.cells[k]) / F(self.size[k]) + F(1)) for k in (0, 1))
        found = []
        for at in itertools.product(range(self.cells[0]), range(self.cells[1])):
            i, j = at[0] - x, at[1] - y
            if -a <= i < a and -b <= j < b and i * i * b * b + j * j * a * a <= a * a * b * b:
                found.append(at)
        return found


class Clover:
    def __init__(self, raster: Raster, transmittance: float) -> None:
        self.raster, self.t = raster, transmittance if transmittance != 0 else 0.0001
        self.leaves: Dict[Tuple[int, int], int] = {}

    def answers(self, queries: Sequence[Query]) -> Answers:
        for q in queries:
            if len(q.sent) > 1 and q.sent[0] != 0 and F(q.sent[1]) >= F(1e-7):
                for cell in self.raster.disc(q.place, F(math.sqrt(q.sent[1] / math.pi))):
                    more = self.leaves.get(cell, 0) + (1 if q.sent[0] == 1 else -1)
                    self.leaves[cell] = min(max(more, 0), 255)
        result: Answers = []
        for q in queries:
            if len(q.sent) > 1 and q.sent[0] != 0:
                result.append({})
                continue
            cell = self.raster.cell(q.place)
            light, second = 0.0, 0.0
            if self.raster.holds(cell):
                green, red = self.raster.maps[cell[1]][cell[0]]
                light, second = green / 255 * self.t ** self.leaves.get(cell, 0), red / 128
            result.append({0: light, 1: second} if len(q.sent) > 1 else {0: light})
        return result


class Ornament:
    def __init__(self, raster: Raster) -> None:
        self.raster = raster

    def answers(self, queries: Sequence[Query]) -> Answers:
        counts: Dict[Tuple[int, int], int] = {}
        for q in queries:
            if len(q.sent) == 2:
                for cell in self.raster.disc(q.place, F(q.sent[1])):
                    counts[cell] = min(counts.get(cell, 0) + 1, 255)
        result: Answers = []
        for q in queries:
            cell = self.raster.cell(q.place)
            inside = self.raster.holds(cell)
            result.append({} if len(q.sent) != 2 else
                          {0: counts.get(cell, 0) if inside else 0, 1: self.raster.maps[cell[1]][cell[0]][0] if inside else 0})
        return result


class Voxels:
    """The grid and the rays of chiba and takenaka."""

    def __init__(self, spheres: Sequence[Tuple[Vector, numpy.float32]], cells: Sequence[int], beam: numpy.float32) -> None:
        self.spheres, self.cells = spheres, cells
        self.low, self.side = [], []
        for c in range(3):
            low = min((p[c] - r for p, r in spheres), default=F(0))
            high = max((p[c] + r for p, r in spheres), default=F(0))
            self.low.append(low)
            self.side.append((high - low) / F(cells[c]))
        half = F(0.5) * root(dot(vector(self.side), vector(self.side)))
        most = max((r for _, r in spheres), default=F(0))
        self.entered: Dict[Tuple[int, int, int], List[int]] = {}
        for number, (p, r) in enumerate(spheres):
            reach = r + most * beam
            span = [(int(math.floor((p[c] - reach - self.low[c]) / self.side[c])) - 1,
                     int(math.floor((p[c] + reach - self.low[c]) / self.side[c])) + 1) for c in range(3)]
            for x in range(max(span[0][0], 0), min(span[0][1], cells[0] - 1) + 1):
                for y in range(max(span[1][0], 0), min(span[1][1], cells[1] - 1) + 1):
                    for z in range(max(span[2][0], 0), min(span[2][1], cells[2] - 1) + 1):
                        at = (x, y, z)
                        middle = vector([self.low[c] + (F(at[c]) + F(0.5)) * self.side[c] for c in range(3)])
                        way = minus(middle, p)
                        if root(dot(way, way)) <= reach + half:
                            self.entered.setdefault(at, []).append(number)

    def met(self, own: int, direction: Vector) -> List[int]:
        """The other spheres in the voxels of a ray, in the order of the tests."""
        p = self.spheres[own][0]
        at = [min(int((p[c] - self.low[c]) / self.side[c]), self.cells[c] - 1) for c in range(3)]
        found: List[int] = []
        while True:
            for number in reversed(self.entered.get((at[0], at[1], at[2]), [])):
                if number != own and number not in found:
                    found.append(number)
            best: Optional[int] = None
            for c in range(3):
                if direction[c] == 0:
                    continue
                if best is None or self.way(at, p, direction, c) * abs(direction[best]) < \
                        self.way(at, p, direction, best) * abs(direction[c]):
                    best = c
            if best is None:
                return found
            at[best] += -1 if direction[best] < 0 else 1
            if not 0 <= at[best] < self.cells[best]:
                return found

    def way(self, at: Sequence[int], p: Vector, direction: Vector, c: int) -> numpy.float32:
        middle, half = (F(at[c]) + F(0.5)) * self.side[c], F(0.5) * self.side[c]
        return abs((middle - half if direction[c] < 0 else middle + half) - p[c])


class Chiba:
    def __init__(self, cells: Sequence[int], sources: Sequence[Sequence[float]], *, samples: int = 20, ratio: float = 0.7,
                 overcast: bool = False, transmittance: float = 0.6, radius: float = 25, beam: float = 0,
                 area: bool = False) -> None:
        self.cells, self.t, self.radius, self.beam, self.area = cells, F(transmittance), F(radius), F(beam), area
        if sources:
            total = F(0)
            for source in sources:
                total += F(source[3])
            self.lights = [(unit(vector(s)), F(s[3]) / total) for s in sources]
        else:
            self.lights = self.sky(samples, F(ratio), overcast)

    @staticmethod
    def sky(samples: int, ratio: numpy.float32, overcast: bool) -> List[Tuple[Vector, numpy.float32]]:
        triangles = [(vector([x, 0, 0]), vector([0, y, 0]), vector([0, 0, z]))
                     for z in (1, -1) for y in (1, -1) for x in (1, -1)]
        while len(triangles) < samples:
            finer = []
            for a, b, c in triangles:
                ab, bc, ca = unit(plus(a, b)), unit(plus(b, c)), unit(plus(c, a))
                finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
            triangles = finer
        sums = [plus(plus(a, b), c) for a, b, c in triangles]
        directions = [unit((x / F(3), y / F(3), z / F(3))) for x, y, z in sums]
        if overcast:
            weights = []
            for x, y, _ in directions:
                cosine = float(y) / math.sqrt(x * x + y * y)
                weights.append((1 + cosine) / 3 * (8.6 * cosine + 0.123) / 0.203 if y > 0 else 0)
            return [(d, F(w / sum(weights))) for d, w in zip(directions, weights)]
        upper = sum(d[1] >= 0 for d in directions)
        lower = len(directions) - upper
        return [(d, F(1 / (upper * (1 + ratio)) if d[1] >= 0 else ratio / (lower * (1 + ratio)))) for d in directions]

    def answers(self, queries: Sequence[Query]) -> Answers:
        taking = [i for i, q in enumerate(queries) if len(q.sent) == 1 or len(q.sent) > 3]
        spheres = [(vector(queries[i].place), F(queries[i].sent[0]) if queries[i].sent[0] > 0 else self.radius)
                   for i in taking]
        voxels = Voxels(spheres, self.cells, F(1) if self.area else self.beam)
        result: Answers = [{} for _ in queries]
        for own, i in enumerate(taking):
            light, mean = F(0), vector([0, 0, 0])
            for direction, weight in self.lights:
                left = F(1)
                for other in voxels.met(own, direction):
                    left *= (self.by_area if self.area else self.by_chord)(spheres[own], spheres[other], direction)
                light += weight * left
                mean = plus(mean, times(direction, weight * left))
            result[i] = dict(enumerate([float(light), *map(float, unit(mean))][:min(len(queries[i].sent), 4)]))
        return result

    def by_chord(self, own: Tuple[Vector, numpy.float32], other: Tuple[Vector, numpy.float32],
                 direction: Vector) -> numpy.float32:
        v = minus(own[0], other[0])
        wide = other[1] + self.beam * own[1]
        a = dot(direction, v)
        squared = a * a - (dot(v, v) - wide * wide)
        if squared <= 0:
            return F(1)
        first, last = -a - root(squared), -a + root(squared)
        if last <= 0:
            return F(1)
        return F(float(self.t) ** float((last - max(first, F(0))) / (F(2) * wide)))

    def by_area(self, own: Tuple[Vector, numpy.float32], other: Tuple[Vector, numpy.float32],
                direction: Vector) -> numpy.float32:
        v = minus(own[0], other[0])
        a = dot(direction, v)
        q = dot(v, v) - a * a
        if a > 0 or not q < (other[1] + own[1]) * (other[1] + own[1]):
            return F(1)
        r1, r2 = max(own[1], other[1]), min(own[1], other[1])
        distance = root(q)
        if distance + r2 <= r1:
            area = F(math.pi) * r2 * r2
        else:
            q = distance * distance
            x1, x2 = (r1 * r1 + q - r2 * r2) / (F(2) * distance), (r2 * r2 + q - r1 * r1) / (F(2) * distance)
            y = root(r2 * r2 - x2 * x2)
            if math.isnan(y) or abs(x1) > r1 or abs(x2) > r2:
                return F(1)
            area = r1 * r1 * F(math.acos(x1 / r1)) + r2 * r2 * F(math.acos(x2 / r2)) - y * distance
        return F(1) - (F(1) - self.t) * area / (F(math.pi) * own[1] * own[1])


class Takenaka:
    def __init__(self, cells: Sequence[int], sources: Sequence[Sequence[float]], disk: Optional[Sequence[float]], *,
                 s: float = 1.5, transmittance: float = 0.1, efficiency: float = 0.015, beam: float = 0) -> None:
        self.cells, self.disk, self.s, self.efficiency, self.beam = cells, disk, F(s), F(efficiency), F(beam)
        self.sources = sources or [(10000, 0, 0, 1)]
        gap = F(1) - (F(1) - F(transmittance)) / (self.s * self.s)
        self.passing = gap * gap

    def answers(self, queries: Sequence[Query]) -> Answers:
        taking = [i for i, q in enumerate(queries) if len(q.sent) > 1]
        balls = [(vector(queries[i].place), self.s * F(0.5) * F(math.sqrt(max(queries[i].sent[0], 0) / math.pi)))
                 for i in taking]
        voxels = Voxels(balls, self.cells, F(1))
        result: Answers = [{} for _ in queries]
        for own, i in enumerate(taking):
            area, upkeep = queries[i].sent[:2]
            x, y, z = balls[own][0]
            if self.disk:
                lit = y <= F(self.disk[2]) and x * x + z * z <= F(self.disk[0]) * F(self.disk[0])
                light = self.along(voxels, own, vector([0, 1, 0])) if lit else 0.0
            else:
                total = sum(source[3] for source in self.sources)
                light = sum(source[3] / total * self.along(voxels, own, unit(minus(vector(source), (x, y, z))))
                            for source in self.sources)
            made = self.efficiency * area / 4 * self.s * self.s * (1 - self.passing) * light * 8.64 - upkeep
            result[i] = {0: area, 1: float(made)}
        return result

    def along(self, voxels: Voxels, own: int, direction: Vector) -> float:
        left = 1.0
        for other in voxels.met(own, direction):
            v = minus(voxels.spheres[own][0], voxels.spheres[other][0])
            wide = voxels.spheres[other][1] + self.beam * voxels.spheres[own][1]
            a = dot(direction, v)
            squared = a * a - (dot(v, v) - wide * wide)
            left *= float(self.passing) if squared >= 0 and root(squared) - a > 0 else 1.0
        return left


class Soil:
    """A field by slices along z, rows along y upwards, columns along x. Kinds: 0 soil, 1 obstacle, 2 source."""

    def __init__(self, box: Sequence[float], corner: Sequence[float], values: List[List[List[float]]],
                 span: Sequence[float], *, kinds: bool = False, sweeps: int = 0, tolerance: float = 0, omega: float = 0.5,
                 depletes: bool = True, layers: Sequence[float] = (2.0,), angles: Sequence[float] = ()) -> None:
        self.box, self.corner, self.span = box, corner, span
        self.cells = (len(values[0][0]), len(values[0]), len(values))
        self.kind = {(x, y, z): 0 for z in range(self.cells[2]) for y in range(self.cells[1]) for x in range(self.cells[0])}
        self.value = {(x, y, z): F(values[z][y][x]) for x, y, z in self.kind}
        if kinds:
            for cell, value in self.value.items():
                self.kind[cell] = 1 if value <= span[0] else 2 if value >= span[1] else 0
                self.value[cell] = F(0) if value <= span[0] else value
        self.sweeps, self.tolerance, self.omega, self.depletes = sweeps, F(tolerance), F(omega), depletes
        self.layers, self.angles = layers, list(angles) + [0] * len(layers)
        self.gone = False

    def neighbours(self, cell: Tuple[int, int, int]) -> List[Tuple[int, int, int]]:
        x, y, z = cell
        return [at for at in ((x - 1, y, z), (x + 1, y, z), (x, y - 1, z), (x, y + 1, z), (x, y, z - 1), (x, y, z + 1))
                if at in self.kind]

    def answers(self, queries: Sequence[Query]) -> Answers:
        result = [self.answer(q) for q in queries]
        for cell, kind in self.kind.items():
            if kind == 2 and not self.gone:
                self.value[cell] = F(self.span[1])
        sweep = 0
        while sweep != self.sweeps:
            new = dict(self.value)
            for cell, kind in self.kind.items():
                if kind == 1 or (self.gone and kind == 2):
                    continue
                around = [self.value[at] for at in self.neighbours(cell) if self.kind[at] != 1 or self.gone]
                if sweep > 0 and cell[2] == 0:
                    around.append(self.value[cell])
                if around:
                    moved = (F(1) - self.omega) * self.value[cell] + self.omega * F(sum(around, F(0)) / F(len(around)))
                    if self.sweeps >= 0 or abs(moved - self.value[cell]) > self.tolerance:
                        new[cell] = moved
            changed = new != self.value
            self.value = new
            sweep += 1
            if self.sweeps < 0 and not changed:
                break
        self.gone ^= self.sweeps != 0
        return result

    def answer(self, q: Query) -> Dict[int, float]:
        part = [(F(q.place[c]) - F(self.corner[c])) / F(self.box[c]) * F(self.cells[c]) for c in range(3)]
        if not all(0 <= part[c] < self.cells[c] for c in range(3)):
            return {0: 0.0, **{k: 0.0 for k in range(4, len(q.sent))}}
        cell = (int(part[0]), int(part[1]), int(part[2]))
        here = self.value[cell]
        got = F(q.sent[0]) if self.gone and self.kind[cell] else min(F(q.sent[0]), here) if self.depletes else here
        if self.depletes and not (self.gone and self.kind[cell]):
            self.value[cell] = here - got
        result = {0: float(got)}
        if len(q.sent) > 2:
            pull = self.gravity(q)
            for c in range(3):
                ends = [self.value.get(tuple(cell[k] + (d if k == c else 0) for k in range(3)), self.value[cell])  # type: ignore
                        for d in (-1, 1)]
                slope = (ends[1] - ends[0]) / (F(2) * (F(self.span[1]) - F(self.span[0])))
                if c + 1 < len(q.sent):
                    result[c + 1] = q.sent[1] * pull[c] + q.sent[2] * float(slope)
        return result

    def gravity(self, q: Query) -> Sequence[float]:
        depth = F(self.corner[1]) + F(self.box[1]) - F(q.place[1])
        bottom = F(0)
        for thickness, angle in zip(self.layers, self.angles):
            bottom += F(thickness)
            if bottom > depth:
                if angle == 0:
                    return (0.0, -1.0, 0.0)
                x, z = q.heading[0], q.heading[2]
                length = math.hypot(x, z)
                side = (x / length, z / length) if length > 1e-6 else (-1.0, 0.0)
                turn = math.radians(2 * angle)
                return (side[0] * math.sin(turn), -math.cos(turn), side[1] * math.sin(turn))
        return (0.0, 0.0, 0.0)


class ShadowPyramid:
    def __init__(self, n: int, span: float, *, spread: float = 1, depth: int = 6, c1: float = 0.58, c2: float = 6.9,
                 randomness: float = 0, bias: float = 0, radius: float = 1.6) -> None:
        self.n, self.span, self.w = n, F(span), F(n - 1) / (F(2) * F(span))
        self.spread, self.depth, self.c1, self.c2 = spread, depth, c1, c2
        self.randomness, self.bias, self.radius = randomness, bias, F(radius)
        self.x48 = 0
        self.field = numpy.ones((n, n, n), dtype=F)

    def draw(self) -> float:
        self.x48 = (0x5DEECE66D * self.x48 + 0xB) % 2 ** 48
        return self.x48 / 2 ** 48

    def answers(self, queries: Sequence[Query]) -> Answers:
        n = self.n
        self.field = numpy.ones((n, n, n), dtype=F)  # z, x, y
        for z, x, y in itertools.product(range(n), range(n), range(1, n - 1)):
            drawn = self.draw() if self.randomness else 0.0
            self.field[z, x, y] = 1 - (self.randomness + self.bias) + self.randomness * drawn + self.bias * y / n
        for q in queries:
            if q.sent[0] > 0:
                self.cast(q.place)
        return [{0: float(self.light(vector(q.place))), **(self.gradient(q.place) if len(q.sent) > 3 else {})}
                for q in queries]

    def cast(self, place: Sequence[float]) -> None:
        n = self.n
        x, z = (min(max(int(F(place[c]) * self.w + F(n) / F(2)), 0), n - 1) for c in (0, 2))
        y = min(max(int(F(place[1]) * self.w), 0), n - 1)
        for tier in range(self.depth):
            wide = int(tier * self.spread)
            for i in range(-wide, wide + 1):
                for k in range(-wide, wide + 1):
                    if 0 <= x + i < n and 0 <= z + k < n and 0 <= y - tier < n:
                        d = math.sqrt(i * i + k * k + tier * tier)
                        self.field[z + k, x + i, y - tier] *= F(1 - min(1, self.c1 * self.c2 ** -d))

    def light(self, place: Vector) -> float:
        at, part = [], []
        for c, offset in ((0, F(self.n - 1) / F(2)), (1, F(0)), (2, F(self.n - 1) / F(2))):
            voxel = place[c] * self.w
            at.append(min(max(int(voxel + offset), 0), self.n - 2))
            part.append(float(voxel - F(math.floor(voxel))))
        total = 0.0
        for i in (0, 1):
            for j in (0, 1):
                for k in (0, 1):
                    weight = (part[0] if i else 1 - part[0]) * (part[1] if j else 1 - part[1]) * (part[2] if k else 1 - part[2])
                    total += weight * float(self.field[at[2] + k, at[0] + i, at[1] + j])
        return total

    def gradient(self, place: Sequence[float]) -> Dict[int, float]:
        p = self.inside(vector(place))
        result = {}
        for c in range(3):
            step = vector([self.radius if k == c else 0 for k in range(3)])
            result[c + 1] = self.light(self.inside(plus(p, step))) - self.light(self.inside(minus(p, step)))
        return result

    def inside(self, p: Vector) -> Vector:
        most = F(0.9999) * self.span
        return (min(max(p[0], -most), most), min(max(p[1], F(0.0001)), F(1.9999) * self.span),
                min(max(p[2], -most), most))
