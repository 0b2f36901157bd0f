"""A second reader of root systems in RSML, for tests.

Written from the pages of the format, rootsystemml.github.io/format (metadata, scene, thesaurus), and Lobet et al., Plant
Physiology 167 (2015): plants hold roots, and roots hold roots; the polyline is the geometry; a function has its samples at the
points (`polyline`), spread evenly from 0 to 1 (`uniform`), or at lengths from the first point (`length`). Between samples this
reader interpolates linearly; before the first and behind the last it takes the nearest.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from typing import Dict, Iterator, List, Optional, Tuple

Point = Tuple[float, float, float]


def local(element: ElementTree.Element) -> str:
    """The name without its namespace."""
    return element.tag.rpartition("}")[2]


def children(element: Optional[ElementTree.Element], *path: str) -> List[ElementTree.Element]:
    found = [] if element is None else [element]
    for name in path:
        found = [each for parent in found for each in parent if local(each) == name]
    return found


@dataclass
class Function:
    domain: str
    samples: List[Tuple[Optional[float], float]]  # position, where there is one, and value


@dataclass
class Root:
    identifier: str
    plant: int  # place in `plants`
    parent: Optional[int]  # place in `roots`
    points: List[Point]
    label: str = ""
    functions: Dict[str, Function] = field(default_factory=dict)
    properties: Dict[str, str] = field(default_factory=dict)
    annotations: Dict[str, List[Point]] = field(default_factory=dict)

    def positions(self) -> List[float]:
        """The length along the polyline at each point."""
        found = [0.0]
        for before, point in zip(self.points, self.points[1:]):
            found.append(found[-1] + math.dist(before, point))
        return found

    def values(self, name: str) -> List[float]:
        """The values of a function at the points; a point behind the last sample of a polyline has none."""
        function, places = self.functions[name], self.positions()
        if function.domain == "polyline":
            return [value for _, value in function.samples][:len(places)]
        if function.domain == "uniform":
            most = max(len(function.samples) - 1, 1)
            samples = [(places[-1] * i / most, value) for i, (_, value) in enumerate(function.samples)]
        else:
            samples = sorted((at, value) for at, value in function.samples if at is not None)
        return [_between(samples, place) for place in places]


def _between(samples: List[Tuple[float, float]], place: float) -> float:
    for (low, first), (high, second) in zip(samples, samples[1:]):
        if low <= place <= high:
            return first if high == low else first + (second - first) * (place - low) / (high - low)
    return samples[0][1] if place < samples[0][0] else samples[-1][1]


def _point(element: ElementTree.Element) -> Point:
    return (float(element.attrib["x"]), float(element.attrib["y"]), float(element.get("z", "0")))


def _sample(element: ElementTree.Element) -> Tuple[Optional[float], float]:
    position = element.get("position")
    return (None if position is None else float(position), float(element.get("value") or element.text or ""))


class RsmlFile:
    """`unit`; `roots` in the order of the file, each behind its parent."""

    def __init__(self, text: str) -> None:
        top = ElementTree.fromstring(text)
        assert local(top) == "rsml", top.tag
        self.unit = "".join(each.text or "" for each in children(top, "metadata", "unit"))
        self.roots: List[Root] = []
        self.plants: List[Tuple[str, str]] = []  # identifier and label
        for number, plant in enumerate(children(top, "scene", "plant")):
            self.plants.append((plant.get("ID", ""), plant.get("label", "")))
            for root in children(plant, "root"):
                self._add(root, number, None)

    def _add(self, element: ElementTree.Element, plant: int, parent: Optional[int]) -> None:
        root = Root(element.get("ID", ""), plant, parent, [_point(point) for point in children(element, "geometry", "polyline", "point")],
                    label=element.get("label", ""))
        for each in children(element, "functions", "function"):
            root.functions[each.attrib["name"]] = Function(each.get("domain", "polyline"), [_sample(sample) for sample in children(each, "sample")])
        for holder in children(element, "properties"):
            root.properties.update({local(each): each.get("value") or each.text or "" for each in holder})
        for each in children(element, "annotations", "annotation"):
            root.annotations[each.get("name", "")] = [_point(point) for point in children(each, "point")]
        self.roots.append(root)
        here = len(self.roots) - 1
        for lateral in children(element, "root"):
            self._add(lateral, plant, here)

    def joint(self, root: Root) -> Optional[Point]:
        """The point of the parent at which a lateral begins: `parent-node`, counted from 0, or else the nearest."""
        if root.parent is None:
            return None
        points = self.roots[root.parent].points
        node = root.properties.get("parent-node")
        return min(points, key=lambda point: math.dist(point, root.points[0])) if node is None else points[int(node)]

    def segments(self) -> Iterator[Tuple[Point, Point, Optional[float]]]:
        """Begin, end and the diameter at the end of each piece, also of those that join a lateral to its parent."""
        for root in self.roots:
            diameters: List[Optional[float]] = [*root.values("diameter")] if "diameter" in root.functions else []
            diameters += [None] * (len(root.points) - len(diameters))
            joint = self.joint(root)
            points = root.points if joint is None or joint == root.points[0] else [joint, *root.points]
            diameters = diameters if len(points) == len(diameters) else [None, *diameters]
            yield from zip(points, points[1:], diameters[1:])
