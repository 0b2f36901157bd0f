"""Geometry over the wire: a Python environment that puts differences together sees what one sees that is sent all."""

import tempfile
import unittest
from pathlib import Path
from typing import Any, ClassVar, Dict, List, Sequence

from support import espalier, program, python

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

    def test_an_author_can_check_such_an_environment_also_with_a_trace(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "canopy.py"
            script.write_text("from collections import Counter\n\nfrom espalier import Environment, Variable\n\n\nclass Canopy(Environment):\n"
                              "    needs = ('parameters', 'geometry')\n    outputs = (Variable('organs'),)\n\n"
                              "    seen = None\n\n    def answer(self, query):\n"
                              "        if self.seen is not self.geometry:\n"
                              "            self.seen = self.geometry\n"
                              "            self.organs = Counter(self.geometry.organ_module.tolist())\n"
                              "        return [1.0 + self.organs[query.module + 1]]\n\n\nCanopy.serve()\n",
                              encoding="utf-8")
            address = "stdio:" + " ".join(f"'{word}'" for word in python(script))
            model = Path(folder) / "leaves.l"
            model.write_text(MODEL, encoding="utf-8")
            trace = str(Path(folder) / "leaves.trace")
            espalier("derive", str(model), "--environment", address, "--trace", trace)
            self.assertIn("the same as recorded", espalier("replay", trace).stdout)
            found = espalier("environment", "check", address, "--trace", trace).stdout
            self.assertIn("needs parameters geometry", found)
            self.assertIn("trace: the same replies to", found)
            self.assertIn("all is right", found)


if __name__ == "__main__":
    unittest.main()
