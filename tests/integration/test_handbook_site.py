"""The built handbook: every link leads somewhere, nothing comes from other hosts, the search index has the pages."""

import html.parser
import json
import re
import shutil
import sys
import tempfile
import unittest
import urllib.parse
from pathlib import Path
from typing import ClassVar, Dict, List, Optional, Set, Tuple

from support import REPOSITORY, espalier, program

sys.path.insert(0, str(REPOSITORY / "docs"))

import build_handbook  # noqa: E402
import handbook_hooks  # noqa: E402
import reference_pages  # noqa: E402


class Page(html.parser.HTMLParser):
    """The links, anchors and inline scripts of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: List[Tuple[str, str]] = []
        self.anchors: Set[str] = set()
        self.handlers: List[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: List[Tuple[str, Optional[str]]]) -> None:
        for name, value in attributes:
            if name == "id" and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append((tag, value))
            elif name.startswith("on"):
                self.handlers.append(f"{tag} {name}")


@unittest.skipUnless(shutil.which("mkdocs"), "mkdocs is not installed (Debian: mkdocs)")
class Site(unittest.TestCase):
    maxDiff = None
    temporary: "ClassVar[tempfile.TemporaryDirectory[str]]"
    site: ClassVar[Path]
    pages: ClassVar[Dict[Path, Page]]

    @classmethod
    def setUpClass(cls) -> None:
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        handbook = build_handbook.Handbook(program(), Path(cls.temporary.name) / "handbook")
        handbook.build()
        cls.site = handbook.site
        cls.pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(cls.site.rglob("*.html"))}

    def test_every_link_leads_to_a_file_and_a_place_in_it(self) -> None:
        self.assertGreater(len(self.pages), 100)
        broken = []
        for path, page in self.pages.items():
            for _, link in page.links:
                place, fragment = urllib.parse.urldefrag(link)
                if re.match(r"[a-z]+:", place):
                    continue
                target = (path.parent / urllib.parse.unquote(place.partition("?")[0])).resolve() if place else path
                if not target.is_file():
                    broken.append(f"{path.relative_to(self.site)}: {link}")
                elif fragment and target in self.pages and urllib.parse.unquote(fragment) not in self.pages[target].anchors:
                    broken.append(f"{path.relative_to(self.site)}: no place {link}")
        self.assertEqual(broken, [])

    def test_nothing_comes_from_other_hosts(self) -> None:
        foreign = [f"{path.relative_to(self.site)}: {link}" for path, page in self.pages.items() for tag, link in page.links
                   if tag != "a" and re.match(r"(?:[a-z]+:)?//", link)]
        self.assertEqual(foreign, [])
        for path in self.site.rglob("*.css"):
            self.assertEqual(re.findall(r"(?:@import|url\()\s*['\"]?(?:https?:)?//", path.read_text(encoding="utf-8")), [], path.name)

    def test_each_page_has_a_policy_with_the_hashes_of_its_scripts(self) -> None:
        for path, page in self.pages.items():
            text = path.read_text(encoding="utf-8")
            said = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', text)
            self.assertIsNotNone(said, path.name)
            assert said is not None
            self.assertEqual(said.group(1), handbook_hooks.policy(text), path.name)
            self.assertNotIn("script-src 'unsafe", said.group(1))
            self.assertEqual(page.handlers, [], path.name)

    def test_the_search_finds_pages_of_every_part(self) -> None:
        index = json.loads((self.site / "search" / "search_index.json").read_text(encoding="utf-8"))
        places = {entry["location"].partition("#")[0] for entry in index["docs"]}
        for wanted in ("docs/tutorial/9-light.html", "docs/howto/in-a-class.html", "reference/processes/soil-water.html",
                       "reference/commands.html", "docs/explanation/validation.html", "protocol/index.html"):
            self.assertIn(wanted, places)

    def test_the_pictures_are_there(self) -> None:
        made = {path.name for path in (self.site / "docs" / "tutorial").glob("*.png")}
        self.assertEqual(len(made), 10)
        for path in (self.site / "docs" / "tutorial").glob("*.png"):
            self.assertEqual(path.read_bytes()[:4], b"\x89PNG")

    def test_the_handbook_names_every_command_function_and_process(self) -> None:
        commands = (self.site / "reference" / "commands.html").read_text(encoding="utf-8")
        for command, _ in reference_pages.helps(program()):
            self.assertIn(f">{' '.join(('espalier', *command))}</h2>", commands)
        functions = (self.site / "reference" / "functions.html").read_text(encoding="utf-8")
        language = (REPOSITORY / "docs" / "language.md").read_text(encoding="utf-8")
        names = re.findall(r"<code>(\w+)</code>", functions)
        self.assertGreater(len(names), 40)
        self.assertEqual([name for name in names if not re.search(rf"\b{name}\b", language) and not name.startswith("vv")], [])
        for name in reference_pages.process_names(program()):
            self.assertIn("How to cite", (self.site / "reference" / "processes" / f"{name}.html").read_text(encoding="utf-8"))


class Parts(unittest.TestCase):
    def test_subcommands_of_a_help_text(self) -> None:
        self.assertIn("derive", reference_pages.subcommands(espalier("--help").stdout))
        self.assertEqual(reference_pages.subcommands(espalier("derive", "--help").stdout), [])

    def test_a_process_page_has_units_keys_and_a_citation(self) -> None:
        description = json.loads(espalier("environment", "honda", "--describe", "--json").stdout)
        page = reference_pages.process_page(description)
        for wanted in ("# honda", "`radius`", "| length |", "Cite the source of the model", "`honda81`"):
            self.assertIn(wanted, page)

    def test_the_tables_are_read(self) -> None:
        self.assertIn("| `sin` | 1 | yes |", reference_pages.functions())
        page = reference_pages.protocol()
        for wanted in ("| 1006 | EnvironmentFailed |", "| -32700 | Parse |", "| `simulation.create` |", "| `hello` | agree"):
            self.assertIn(wanted, page)


if __name__ == "__main__":
    unittest.main()
