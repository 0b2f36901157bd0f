"""What a model or an environment warns of while a server makes its steps comes with the answer, and is a warning in Python."""

import asyncio
import tempfile
import unittest
import warnings
from pathlib import Path
from typing import List, Sequence

from support import program

from espalier import AsyncClient, Environment, Query, RunWarning, ServerError, local

MODEL = ("Lsystem: 1\n#define GROWTH 1\nderivation length: 4\nAxiom: A(0)?E(0)\n"
         "A(x) > ?E(h) --> F(GROWTH)A(1/x)\nendlsystem\n")
DIVISION = "model.l:5:29: warning: division by 0; the divisor counts as 1"
DRY = "the well is dry"


class Well(Environment):
    """Dry in every step."""

    def answer(self, query: Query) -> Sequence[float]:
        self.note(DRY)
        return [1]


class RunWarnings(unittest.TestCase):
    def setUp(self) -> None:
        self.client = local(program())
        self.addCleanup(self.client.close)

    def said(self, sentences: Sequence[str]) -> List[str]:
        return [sentence.split("\n")[0] for sentence in sentences]

    def test_each_comes_once_with_the_answer_of_its_step(self) -> None:
        plant = self.client.create(MODEL, environment=[self.client.attach(Well)])
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            first = plant.step()
            self.assertEqual(plant.step().warnings, ())
            self.assertEqual(plant.run().warnings, ())
        self.assertEqual(self.said(first.warnings), [DRY, DIVISION])
        self.assertEqual([(one.category, one.filename) for one in caught], [(RunWarning, __file__)] * 2)
        # compiled anew: another run
        plant.set({"GROWTH": 2})
        plant.reset()
        with warnings.catch_warnings(record=True):
            warnings.simplefilter("always")
            self.assertEqual(self.said(plant.run(lambda frame: None).warnings), [DRY, DIVISION])

    def test_what_the_model_prints_comes_with_the_next_answer(self) -> None:
        plant = self.client.create('Lsystem: 1\nderivation length: 3\nStart: { printf("begun\\n"); }\nAxiom: A(1)\n'
                                   'A(x) : 1 { printf("x is %g\\n", x); } --> A(x+1)\nendlsystem\n')
        self.assertEqual([plant.step().printed for _ in range(2)], ["begun\nx is 1\n", "x is 2\n"])
        self.assertEqual(plant.run().printed, "x is 3\n")
        talker = self.client.create('Lsystem: 1\nderivation length: 2\nAxiom: A\n'
                                    'A : { n = 0; while (n < 20000) { printf("line %f\\n", n); n = n+1; } } 1 --> A\nendlsystem\n')
        first = talker.step().printed
        self.assertEqual(len(first[:first.index("[")].encode()), 64_001)
        self.assertRegex(first, r"\n\[[0-9]+ bytes more were printed\]\n$")
        self.assertTrue(talker.step().printed.startswith("line 0.000000\n"))

    def test_what_it_prints_before_a_step_fails_comes_with_the_error(self) -> None:
        plant = self.client.create('Lsystem: 1\nderivation length: 3\nAxiom: A(1)\n'
                                   'A(x) : { printf("x is %g\\n", x); } 1 --> F(sqrt(2-x))A(x+1)\nendlsystem\n')
        with self.assertRaises(ServerError) as caught:
            plant.run()
        self.assertEqual((caught.exception.step, caught.exception.printed), (2, "x is 1\nx is 2\nx is 3\n"))

    def test_a_reset_simulation_warns_again(self) -> None:
        plant = self.client.create(MODEL, environment=[self.client.attach(Well)])
        with warnings.catch_warnings(record=True):
            warnings.simplefilter("always")
            first = plant.run().warnings
            self.assertEqual(self.said(first), [DRY, DIVISION])
            plant.reset()
            self.assertEqual(plant.run().warnings, first)

    def test_where_the_gallery_is_stays_unknown(self) -> None:
        with tempfile.TemporaryDirectory() as gallery:
            for name, condition in (("warns", "1"), ("fails", "{ y=1; while (y > 0) { y = y+1; } } 1")):
                (Path(gallery) / name).mkdir()
                (Path(gallery) / name / f"{name}.l").write_text(
                    "Lsystem: 1\nderivation length: 2\nAxiom: A(0)\nA(x) : " + condition + " --> F(1)A(1/x)\nendlsystem\n",
                    encoding="utf-8")
            with local(program(), arguments=["--gallery", gallery]) as client, warnings.catch_warnings(record=True):
                warnings.simplefilter("always")
                said = client.create(gallery="warns").step().warnings
                self.assertTrue(said[0].startswith("warns/warns.l:4:20: warning: division by 0"), said)
                with self.assertRaises(ServerError) as caught:
                    client.create(gallery="fails").step()
                self.assertIn("('A', fails/fails.l:4:15): a loop ran more than", str(caught.exception))

    def test_an_environment_file_warns_too(self) -> None:
        plant = self.client.create(MODEL.replace("1/x", "1"), environment=[
            {"type": "field", "main": "room.e", "files": {"room.e": "executable: height -e room.e\ngrid spice: 3\n"}}])
        with warnings.catch_warnings(record=True):
            said = plant.step().warnings
        self.assertEqual(self.said(said), ["room.e:2:1: warning: unknown keyword 'grid spice' is ignored"])

    def test_they_come_to_an_asynchronous_client(self) -> None:
        async def growing() -> Sequence[str]:
            async with AsyncClient(self.client.address, token=self.client.token) as client:
                plant = await client.create(MODEL, environment=[{"type": "height"}])
                return (await plant.run()).warnings

        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            self.assertEqual(self.said(asyncio.run(growing())), [DIVISION])
        self.assertEqual([one.category for one in caught], [RunWarning])

    def test_a_model_that_warns_in_each_step_fills_nothing(self) -> None:
        """A different sentence in every step of a run: the first 50 come."""
        class Chatty(Environment):
            """Another sentence in every step."""

            def answer(self, query: Query) -> Sequence[float]:
                self.note(f"step {self.completed_steps} " + "x" * 5000)
                return [1]

        plant = self.client.create(MODEL.replace("length: 4", "length: 80").replace("1/x", "1"),
                                   environment=[self.client.attach(Chatty)])
        with warnings.catch_warnings(record=True):
            said = plant.run().warnings
        self.assertEqual([sentence.split(" ")[1] for sentence in said], [str(step) for step in range(50)])
        self.assertEqual({len(sentence) for sentence in said}, {1000})


if __name__ == "__main__":
    unittest.main()
