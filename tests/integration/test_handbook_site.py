"""The built handbook: every link leads somewhere, nothing comes from other hosts, the search index has the pages."""

import html
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

from browser import PROGRAM, Browser
from support import REPOSITORY, Server, espalier, program

sys.path[:0] = [str(REPOSITORY / each) for each in ("docs", "clients/packaging", "tests/support")]

import build_handbook  # noqa: E402
import command_table  # noqa: E402
import generated_pages  # noqa: E402
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

    @unittest.skipUnless(PROGRAM, "Chromium is not installed (Debian: chromium)")
    def test_the_search_works_in_a_browser_from_a_disk_without_a_network_and_from_a_server(self) -> None:
        server = Server("--handbook", str(self.site))
        self.addCleanup(server.stop)
        for address, more in ((f"file://{self.site}/docs/howto", ["--proxy-server=127.0.0.1:1"]), (f"http://{server.http}/handbook/docs/howto", [])):
            with self.subTest(address), Browser(f"{address}/cite.html", *more) as page:
                # a worker builds its index before it listens, and so does the page itself
                found = page.wait_for("""(() => {
                    const input = document.getElementById("mkdocs-search-query");
                    input.value = "evaporation from bare soil";
                    input.dispatchEvent(new Event("keyup"));
                    return [...document.querySelectorAll("#mkdocs-search-results a")].map((link) => link.href);
                })().find((link) => link.includes("explanation/validation.html"))""")
                self.assertTrue(found.startswith(address.partition("docs/")[0]), found)

    def test_the_pictures_are_there(self) -> None:
        made = {path.name for path in (self.site / "docs" / "tutorial").glob("*.png")}
        self.assertEqual(len(made), 10)
        for path in (self.site / "docs" / "tutorial").glob("*.png"):
            self.assertEqual(path.read_bytes()[:4], b"\x89PNG")
        figures = {path.name: path.read_text(encoding="utf-8") for path in (self.site / "docs" / "explanation").glob("*.svg")}
        self.assertEqual(sorted(figures), ["m2.1-sand.svg", "m3.1.svg", "self-thinning.svg"])
        for name, figure in figures.items():
            self.assertGreater(figure.count("<path"), 2, name)

    def test_the_handbook_names_every_command_function_and_process(self) -> None:
        commands = (self.site / "reference" / "commands.html").read_text(encoding="utf-8")
        for command in command_table.commands(program()):
            self.assertIn(f">{' '.join(('espalier', *command.words))}</h2>", commands)
        for table, file, least in (("functions", "functions.html", 40), ("symbols", "symbols.html", 60)):
            page = html.unescape((self.site / "reference" / file).read_text(encoding="utf-8"))
            shown = [usage for row in reference_pages.rows(program(), table) for usage in row["usage"].split(" or ")]
            self.assertGreater(len(shown), least)
            self.assertEqual([usage for usage in shown if f"<code>{usage}</code>" not in page], [])
        for name in reference_pages.process_names(program()):
            self.assertIn("How to cite", (self.site / "reference" / "processes" / f"{name}.html").read_text(encoding="utf-8"))


class Parts(unittest.TestCase):
    def test_a_process_page_has_units_keys_and_a_citation(self) -> None:
        description = json.loads(espalier("environment", "honda", "--describe", "--json").stdout)
        page = reference_pages.process_page(description)
        for wanted in ("# honda", "`radius`", "| length |", "Cite the source of the model", "`honda81`"):
            self.assertIn(wanted, page)

    def test_the_tables_are_read(self) -> None:
        self.assertRegex(reference_pages.functions(program()), r"(?m)^\| `sin\(a\)`.* \| 1 \| yes \| .*degrees")
        page = reference_pages.protocol(program())
        for wanted in ("| 1006 | environment failed | ", "| -32700 | parse |", "| `simulation.create` |", "| `hello` | both sides | | agree"):
            self.assertIn(wanted, page)

    def test_a_new_function_symbol_method_or_error_is_on_its_pages_by_itself(self) -> None:
        new = {"functions": {"name": "newf", "usage": "newf(x|y)", "meaning": "[!] new (" "model-files" ".md, 5)", "least": 1, "most": 2, "isPure": True},
               "symbols": {"name": "@Q", "usage": "@Q(n) or @Q", "meaning": "a new body"},
               "methods": {"name": "plant.new", "answeredBy": "the server", "role": "", "meaning": "makes one"},
               "errors": {"code": 1999, "name": "newest", "meaning": "never was", "data": "`x`", "remedy": "wait (operating.md, Limits)"}}
        with tempfile.TemporaryDirectory() as folder:
            newer = Path(folder) / "espalier"
            newer.write_text(f"#!{sys.executable}\nimport json, subprocess, sys\n"
                             f"out = subprocess.run([{program()!r}, *sys.argv[1:]], capture_output=True, text=True, check=True).stdout\n"
                             f"rows = {new!r}\n"
                             "print(json.dumps(json.loads(out) + [rows[sys.argv[2]]]) if sys.argv[1] == 'reference' else out)\n", encoding="utf-8")
            newer.chmod(0o755)
            pages = {"functions": reference_pages.functions(str(newer)), "symbols": reference_pages.symbols(str(newer)),
                     "protocol": reference_pages.protocol(str(newer)),
                     **{str(path): generated_pages.with_tables(path, str(newer)) for path, name, _ in generated_pages.TABLES if name != "limits"}}
        row = r"| `newf(x\|y)` | 1 or 2 | yes | **[!]** new ([" "model-files" ".md, 5](../docs/model-files.md#5-functions)) |"
        self.assertIn(row, pages["functions"])
        self.assertIn("| `@Q(n)` or `@Q` | a new body |", pages["symbols"])
        self.assertIn("| 1999 | newest | never was | wait ([operating.md, Limits](../docs/operating.md#limits)) |", pages["protocol"])
        self.assertIn("| 1999 | newest | `x` |", pages["protocol"])
        self.assertIn("| `plant.new` | the server | | makes one |", pages["protocol"])
        for page, wanted in (("docs/language.md", "a new body"), ("docs/language.md", r"newf(x\|y)"), ("docs/messages.md", "| 1999 |"),
                             ("protocol/README.md", "| 1999 |"), ("protocol/README.md", "plant.new")):
            self.assertIn(wanted, pages[str(REPOSITORY / page)])


if __name__ == "__main__":
    unittest.main()
