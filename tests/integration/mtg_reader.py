"""A second reader of multiscale tree graphs in FORM-A, for tests.

Written from the description of the format in Godin & Caraglio, J. theor. Biol. 191 (1998), and in the manual of AMAPmod:
columns are separated by tabs; `^` goes on from the last entity of its own column, another code from the last entity of the
column to its left; `#` begins a comment; `/` begins a part of the entity before it, `<` follows and `+` branches off at the scale of the class.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Tuple


@dataclass
class Entity:
    """A vertex: its class and scale, its edge from the entity before it at its scale, and the entity that it is a part of."""

    name: str
    scale: int
    edge: str  # "<", "+", or "/" for one that begins its whole
    parent: Optional[int]
    whole: Optional[int]
    features: Dict[str, str] = field(default_factory=dict)


class MtgFile:
    """The sections of a file; `entities` in their order."""

    def __init__(self, text: str) -> None:
        # a comment may stand anywhere
        lines = [line.split("#")[0] for line in text.split("\n")]
        assert lines[0].split("\t") == ["CODE:", "FORM-A"], lines[0]
        self.scales = {row[0]: int(row[1]) for row in self._table(lines, "CLASSES:")}
        self.edges = {(row[0], row[1], row[2]) for row in self._table(lines, "DESCRIPTION:")}
        self.types = {row[0]: row[1] for row in self._table(lines, "FEATURES:")}
        self.entities: List[Entity] = []
        start = lines.index("MTG:")
        header = lines[start + 1].split("\t")
        assert header[0] == "ENTITY-CODE", header
        first = next(i for i, name in enumerate(header) if i > 0 and name)
        assert set(header[first:]) == set(self.types), "the columns are the features"
        last: Dict[int, int] = {}
        for line in lines[start + 2:]:
            if not line:
                continue
            columns = line.split("\t")
            column = next(i for i, text in enumerate(columns) if text)
            assert column < first, line
            code = columns[column]
            at = last[column] if code.startswith("^") else last[max(i for i in last if i < column)] if column else None
            for edge, name in re.findall(r"([/<+])([A-Za-z]+)[0-9]*", code.lstrip("^")):
                at = self._add(edge, name, at)
            assert at is not None, line
            self.entities[at].features = {k: v for k, v in zip(header[first:], columns[first:]) if v}
            last = {i: entity for i, entity in last.items() if i < column}
            last[column] = at

    @staticmethod
    def _table(lines: List[str], section: str) -> List[List[str]]:
        begin = lines.index(section) + 2
        end = next(i for i in range(begin, len(lines)) if not lines[i])
        return [line.split("\t") for line in lines[begin:end]]

    def _above(self, at: Optional[int], scale: int) -> Optional[int]:
        while at is not None and self.entities[at].scale > scale:
            at = self.entities[at].whole
        return at

    def _add(self, edge: str, name: str, at: Optional[int]) -> int:
        scale = self.scales[name]
        if edge == "/":
            whole = self._above(at, scale - 1)
            assert scale == 1 or whole is not None, name
            made = Entity(name, scale, "/", None, whole)
            # the first part of a branch grows where its whole grows
            if whole is not None and self.entities[whole].edge != "/" and not any(e.whole == whole for e in self.entities[whole:]):
                made.edge, made.parent = self.entities[whole].edge, self._bearer.get(whole)
        else:
            before = self._above(at, scale)
            assert before is not None and self.entities[before].scale == scale, name
            assert (self.entities[before].name, name, edge) in self.edges, (self.entities[before].name, name, edge)
            made = Entity(name, scale, edge, before, self.entities[before].whole)
            assert at is not None
            self._bearer[len(self.entities)] = at
        self.entities.append(made)
        return len(self.entities) - 1

    @property
    def _bearer(self) -> Dict[int, int]:
        return self.__dict__.setdefault("_bearers", {})

    def finest(self) -> List[Tuple[int, Entity]]:
        """The entities of the finest scale, with their numbers."""
        scale = max(self.scales.values())
        return [(i, entity) for i, entity in enumerate(self.entities) if entity.scale == scale]

    def strings(self) -> List[str]:
        """The string of each plant, from the feature `Text` and the edges."""
        below: Dict[int, List[int]] = {}
        starts = []
        for i, entity in self.finest():
            if entity.parent is None:
                starts.append(i)
            else:
                below.setdefault(entity.parent, []).append(i)
        texts = []
        for start in starts:
            text = ""
            stack: List[object] = [start]
            while stack:
                item = stack.pop()
                if isinstance(item, str):
                    text += item
                    continue
                assert isinstance(item, int)
                text += re.sub(r"\\x([0-9a-f]{2})", lambda m: chr(int(m.group(1), 16)), self.entities[item].features.get("Text", ""))
                later: List[object] = []
                # a branch stands before what follows
                for child in sorted(below.get(item, []), key=lambda i: self.entities[i].edge == "<"):
                    later += ["[", child, "]"] if self.entities[child].edge == "+" else [child]
                stack.extend(reversed(later))
            texts.append(text)
        return texts
