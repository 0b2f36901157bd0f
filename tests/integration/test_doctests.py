"""The examples in the docstrings of the Python package, with a server behind them."""

import doctest
import importlib
import pkgutil
import unittest
from typing import Any
from unittest import mock

from support import program

import espalier


def load_tests(loader: unittest.TestLoader, tests: unittest.TestSuite, pattern: Any) -> unittest.TestSuite:
    def start(test: doctest.DocTest) -> None:
        with mock.patch.dict("os.environ", {"ESPALIER_PROGRAM": program()}):
            client = espalier.local(arguments=["--log-level", "off"])
        test.globs.update({"client": client, "espalier": espalier})

    def stop(test: doctest.DocTest) -> None:
        test.globs["client"].close()

    for module in pkgutil.iter_modules(espalier.__path__):
        if module.name != "__main__":
            tests.addTests(doctest.DocTestSuite(importlib.import_module(f"espalier.{module.name}"), setUp=start, tearDown=stop))
    return tests


class Documentation(unittest.TestCase):
    def test_every_public_name_has_an_example(self) -> None:
        for name in espalier.__all__:
            item = getattr(espalier, name)
            # Answer is a type, __version__ a text
            if name in ("Answer", "__version__"):
                continue
            texts = [item.__doc__ or ""]
            texts += [member.__doc__ or "" for member in vars(item).values() if callable(member)] if isinstance(item, type) else []
            self.assertTrue(any(">>>" in text for text in texts), name)

    def test_every_public_class_and_method_is_described(self) -> None:
        for name in espalier.__all__:
            item = getattr(espalier, name)
            if not isinstance(item, type):
                continue
            self.assertTrue(item.__doc__, name)
            for member, value in vars(item).items():
                if callable(value) and not member.startswith("_"):
                    self.assertTrue(value.__doc__, f"{name}.{member}")
