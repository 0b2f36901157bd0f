"""Errors of a Python environment: messages for its author and for the user of the simulation, and continuing after a fix."""

import contextlib
import importlib.util
import io
import unittest
from typing import Any, List, Sequence, Type

from support import program

import espalier
from espalier import Columns, Environment, Query, ServerError

# a tip asks at every step and grows by what it hears
MODEL = "Lsystem: 1\nderivation length: 9\nAxiom: A?E(0)A?E(0)\nA?E(x) : x > 0 --> FA?E(0)\nendlsystem\n"


class Growing(Environment):
    """Answers 1 to everything; what is wrong begins at the third step."""

    @classmethod
    def name(cls) -> str:
        return "sky"

    def step(self, queries: Sequence[Query]) -> Any:
        return self.wrong(queries) if self.completed_steps == 2 else [[1] for _ in queries]

    def wrong(self, queries: Sequence[Query]) -> Any:
        return [[1] for _ in queries]


class GrowingColumns(Environment):
    """The same in columns."""

    name = Growing.name

    def step_columns(self, queries: Columns) -> Any:
        return self.wrong(queries) if self.completed_steps == 2 else [1.0] * queries.count

    def wrong(self, queries: Columns) -> Any:
        return [1.0] * queries.count


class BadInput(unittest.TestCase):
    def setUp(self) -> None:
        self.client = espalier.local(program(), arguments=["--log-level", "off"], timeout=60)
        self.addCleanup(self.client.close)

    def failure(self, mistaken: Type[Environment], mended: Type[Environment]) -> "tuple[ServerError, str]":
        """The error of the server and the messages to the author of an environment; the plant then goes on with the mended one."""
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            plant = self.client.create(MODEL, environment=[self.client.attach(mistaken)])
            with self.assertRaises(ServerError) as caught:
                plant.step(4)
            # the same again, as long as nothing is mended
            with self.assertRaises(ServerError) as again:
                plant.step()
        self.assertEqual((caught.exception.step, again.exception.step), (2, 2))
        self.assertEqual(str(again.exception), str(caught.exception))
        self.assertEqual(plant.string(), "FFA?E(0)FFA?E(0)")
        # as a notebook's cell that is run again: the latest offer of a name is the one that is asked
        self.client.attach(mended)
        self.assertEqual((plant.step().step, plant.string()), (3, "FFFA?E(0)FFFA?E(0)"))
        return caught.exception, said.getvalue()

    def row_failure(self, answers: Any) -> "tuple[str, str]":
        mistaken = type("Mistaken", (Growing,), {"wrong": lambda self, queries: answers})
        error, said = self.failure(mistaken, Growing)
        self.assertIn("'sky'", str(error))
        return str(error), said

    def column_failure(self, answer: Any) -> "tuple[str, str]":
        mistaken = type("Mistaken", (GrowingColumns,), {"wrong": lambda self, queries: answer})
        error, said = self.failure(mistaken, GrowingColumns)
        self.assertIn("'sky'", str(error))
        return str(error), said

    def test_an_exception_shows_its_own_traceback(self) -> None:
        class Mistaken(Growing):
            def wrong(self, queries: Sequence[Query]) -> Any:
                return [[1 / (query.id - 1)] for query in queries]  # the second query divides by zero

        error, said = self.failure(Mistaken, Growing)
        self.assertRegex(str(error), r"ZeroDivisionError in step\(\) at test_bad_input\.py:\d+: .*division by zero")
        # from the author's own code on: how it is called is no concern of theirs
        self.assertRegex(said, r"^Traceback \(most recent call last\):\n  File \".*test_bad_input\.py\"")
        self.assertIn("return [[1 / (query.id - 1)] for query in queries]", said)

    def test_a_missing_return_is_noted_once(self) -> None:
        class Silent(espalier.Environment):
            def answer(self, query: Query) -> None:  # type: ignore[override]
                del query

        with contextlib.redirect_stderr(io.StringIO()) as said:
            plant = self.client.create(MODEL, environment=Silent)
            plant.step(2)
            self.client.create(MODEL, environment=Growing).step(2)
        self.assertEqual(said.getvalue().count("Is a 'return' missing?"), 1, said.getvalue())

    def test_too_few_answers(self) -> None:
        for error in self.row_failure([[1]]):
            self.assertIn("step() gave 1 answers to 2 queries. Return one answer for every query, or None.", error)

    def test_no_list_at_all(self) -> None:
        for error in self.row_failure(7):
            self.assertIn("step() returned the number 7; expected a list with one answer for every query", error)

    def test_numbers_instead_of_lists(self) -> None:
        for error in self.row_failure([1, 1]):
            self.assertIn("query 0 was answered with the number 1; expected a list of the module's values, as in [0.5]", error)

    def test_a_text_instead_of_a_number(self) -> None:
        for error in self.row_failure([["dark"], [1]]):
            self.assertIn("query 0 was answered with 'dark' (str) as value 1; expected a number or None.", error)

    def test_a_text_of_digits_is_no_number_either(self) -> None:
        for text in ("0", b"0"):
            for error in self.row_failure([[text], [1]]):
                self.assertIn(f"query 0 was answered with {text!r} ({type(text).__name__}) as value 1; expected a number or None.", error)

    def test_not_a_number(self) -> None:
        for error in self.row_failure([[1], [float("nan")]]):
            self.assertIn("query 1 was answered with nan as value 1. Only finite numbers can be sent.", error)

    def test_columns_of_the_wrong_length(self) -> None:
        for error in self.column_failure([1.0, 1.0, 1.0]):
            self.assertIn("step_columns() returned 3 rows for 2 queries. Return one for every query.", error)

    def test_columns_of_the_wrong_type(self) -> None:
        for error in self.column_failure(["dark", "light"]):
            self.assertIn("step_columns() returned ['dark', 'light'] (list); expected one number for every query", error)

    def test_columns_that_are_not_finite(self) -> None:
        for error in self.column_failure([1.0, float("inf")]):
            self.assertIn("query 1 was answered with inf as value 1. Only finite numbers can be sent.", error)

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
    def test_arrays_of_the_wrong_shape_and_type(self) -> None:
        import numpy

        wrong: List[Any] = [(numpy.ones((2, 1, 1)), r"an array of float64 with the shape \[2, 1, 1\]"),
                            (numpy.ones(2, dtype=complex), r"an array of complex128 with the shape \[2\]"),
                            (numpy.ones((1, 2)), r"step_columns\(\) returned 1 rows for 2 queries"),
                            (numpy.array([1.0, numpy.nan]), "query 1 was answered with nan as value 1")]
        for answer, expected in wrong:
            with self.subTest(expected):
                for error in self.column_failure(answer):
                    self.assertRegex(error, expected)

    def test_an_environment_that_is_gone_is_named_and_may_come_back(self) -> None:
        plant = self.client.create(MODEL, environment=[self.client.attach(Growing)])
        plant.step()
        self.client._offers.pop().close()
        with self.assertRaisesRegex(ServerError, "'sky'") as caught:
            plant.step()
        self.assertEqual((caught.exception.step, caught.exception.is_retryable), (1, True))
        self.client.attach(Growing)
        self.assertEqual(plant.step().step, 2)


if __name__ == "__main__":
    unittest.main()
