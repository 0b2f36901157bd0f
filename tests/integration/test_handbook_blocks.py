"""Every code block of the handbook and of the README of each folder: commands and programs run, files are written, outputs are compared.
Those of the gallery, which grow every model, run in the stage `long`."""

import os
import re
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Callable

from support import REPOSITORY, program

sys.path.insert(0, str(REPOSITORY / "docs"))

import page_blocks  # noqa: E402


class Rules(unittest.TestCase):
    """The runner sees what is wrong."""

    def run_text(self, text: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "page.md"
            page.write_text(text, encoding="utf-8")
            page_blocks.run_page(page, program())

    def test_blocks_have_a_language_or_a_remark(self) -> None:
        shown = page_blocks.blocks("<!-- every json is shown as data -->\n\n```json\n{}\n```\n```sh\ntrue\n```\n")
        self.assertEqual([(block.remark, block.value) for block in shown], [("shown", "as data"), ("", "")])
        self.assertEqual([problem.split(": ")[1] for problem in page_blocks.problems("<!-- shown -->\n```\na\n```\n")],
                         ["say why the block is not run"])
        text = "```sh\ntrue\n```\n<!-- shown grammar -->\n```\na\n```\n\n```\nb\n```\n<!-- with a = b -->\n```json\n{}\n```\n"
        self.assertEqual([(block.language, block.remark, block.text) for block in page_blocks.blocks(text)],
                         [("sh", "", "true\n"), ("", "shown", "a\n"), ("", "", "b\n"), ("json", "", "{}\n")])
        self.assertEqual([problem.split(":")[0] for problem in page_blocks.problems(text)], ["line 9", "line 13"])

    def test_a_page_that_tells_the_truth_passes(self) -> None:
        self.run_text("<!-- file a.l -->\n```\nLsystem: 1\nderivation length: 2\nAxiom: A\nA --> AB\nendlsystem\n```\n"
                      "```sh\nespalier derive a.l --every\n```\n<!-- output -->\n```\n0\tA\n…\n2\tABB\n```\n"
                      "<!-- fails -->\n```sh\nespalier check nowhere.l\n```\n<!-- messages -->\n```\n…nowhere.l…\n```\n"
                      "```python\nimport espalier\n```\n")

    def test_what_does_not_hold_is_seen(self) -> None:
        for text, said in (("```sh\nfalse\n```\n", "ended with 1"),
                           ("<!-- fails -->\n```sh\ntrue\n```\n", "ended with 0"),
                           ("```sh\necho a\n```\n<!-- output -->\n```\nb\n```\n", "the page says"),
                           ("<!-- file a.l -->\n```\nLsystem: 1\nAxiom: A\nA --> (\nendlsystem\n```\n", "espalier check a.l"),
                           ("```python\nimport nothing_like_it\n```\n", "ModuleNotFoundError"),
                           ("<!-- background -->\n```sh\necho no\n```\n", "ended before it was ready"),
                           ("![a](a.png)\n", "no block makes a.png")):
            with self.subTest(said), self.assertRaisesRegex(page_blocks.PageError, re.escape(said)):
                self.run_text(text)

    def test_dots_stand_for_text_and_for_lines(self) -> None:
        self.assertTrue(page_blocks.agrees("a…c\n", "x\nabbc\n"))
        self.assertTrue(page_blocks.agrees("a\n…\nc\n", "a\nb\nb\nc\n"))
        self.assertTrue(page_blocks.agrees("a\n…\nc\n", "a\nc\n"))
        self.assertFalse(page_blocks.agrees("a\nc\n", "a\nb\nc\n"))
        self.assertFalse(page_blocks.agrees("a\n", "ab\n"))


class EveryBlock(unittest.TestCase):
    maxDiff = None

    def test_is_run_or_says_why_not(self) -> None:
        self.assertEqual([f"{page.relative_to(REPOSITORY)}: {problem}" for page in [*page_blocks.pages(), *page_blocks.folder_pages()]
                          for problem in page_blocks.problems(page.read_text(encoding="utf-8"))], [])


def running(page: Path) -> Callable[[unittest.TestCase], None]:
    def test(self: unittest.TestCase) -> None:
        lacking = page_blocks.missing(page.read_text(encoding="utf-8"))
        if lacking:
            self.skipTest(f"not installed: {', '.join(lacking)}")
        page_blocks.run_page(page, program())
    return test


# a class for each page with blocks that run, so that pages run side by side
for each in [*page_blocks.pages(), *page_blocks.folder_pages()]:
    if page_blocks.has_runs(each):
        name = "Page_" + re.sub(r"\W", "_", str(each.relative_to(REPOSITORY))[:-3])
        is_long = each.is_relative_to(REPOSITORY / "clients" / "gallery")
        case = type(name, (unittest.TestCase,), {"test_long_what_it_says_happens" if is_long else "test_what_it_says_happens": running(each)})
        globals()[name] = unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "grows models: ./dev test --all long")(case) \
            if is_long else case


if __name__ == "__main__":
    unittest.main()
