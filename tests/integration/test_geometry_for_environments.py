"""Geometry over the wire: a Python environment that puts differences together sees what one sees that is sent all."""

import unittest
from typing import Any, ClassVar, Dict, List, Sequence

from support import program

from espalier import Answer, Environment, Geometry, Query, blocks, local

# leaves that grow, turn and fall while the stem goes on
MODEL = """Lsystem: 1
derivation length: 6
Axiom: A(1)
A(l) --> !(l*0.1);(3)F(l)[+(31.7)?E(0)L(l,0)]/(77.3)A(l*0.93)
L(s,n) : n < 3 --> L(s*1.1,n+1)
L(s,n) : n >= 3 --> *
homomorphism
L(s,n) --> ,(s*10){.f(s)-(70+n)f(s)-(60)f(s)}
endlsystem
"""


class Whole(Environment):
    needs = ("parameters", "geometry")
    seen: ClassVar[List[Geometry]] = []

    @classmethod
    def description(cls) -> Dict[str, Any]:
        return {**super().description(), "geometry": "whole"}

    def step(self, queries: Sequence[Query]) -> Sequence[Answer]:
        assert self.geometry is not None
        self.seen.append(self.geometry)
        organs = self.geometry.organ_module.tolist()
        return [[1.0 + organs.count(query.module + 1)] for query in queries]


class Difference(Whole):
    seen: ClassVar[List[Geometry]] = []

    @classmethod
    def description(cls) -> Dict[str, Any]:
        return {**super().description(), "geometry": "difference"}


class GeometryOverTheWire(unittest.TestCase):
    @unittest.skipIf(blocks.numpy is None, "NumPy is not installed")
    def test_differences_make_the_whole(self) -> None:
        with local(program(), arguments=["--log-level", "off"]) as client:
            strings = []
            for kind in (Whole, Difference):
                kind.seen.clear()
                simulation = client.create(source=MODEL, environment=[client.attach(kind)], seed=1)
                simulation.run()
                strings.append(simulation.string())
        self.assertEqual(strings[0], strings[1])
        # also before anything asks: a step without queries
        self.assertEqual([len(one.segment_plant) for one in Whole.seen], [0, 1, 2, 3, 4, 5])
        self.assertEqual([len(one.organ_plant) for one in Whole.seen], [0, 1, 2, 3, 4, 4])
        self.assertEqual(Difference.seen, Whole.seen)


if __name__ == "__main__":
    unittest.main()
