"""The pages of the repository: links, anchors, citations, lengths, and the facts that a program can check."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Dict, Iterator, List, Set, Tuple

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "docs")]

import generated_pages  # noqa: E402
import page_blocks  # noqa: E402

SKIPPED_FOLDERS = {".git", "build", "out", "node_modules", "__pycache__", ".setup", ".mypy_cache"}
TEXT_SUFFIXES = {".md", ".h", ".cpp", ".c", ".py", ".txt", ".cmake", ".js", ".ts", ".R", ".def", ".json", ".html", ".l", ""}
LONGEST_README = 120
# the wire specification, pages of models, and the recorded suite may be longer
LONG_READMES = ("protocol/", "clients/gallery/", "tests/conformance/")
# pages that readers of the repository do not have
FOREIGN_PAGES = re.compile(r"\b(?:LANGUAGE|ENVIRONMENTS|FIDELITY|DIALECTS|PANELS|USERS)\b(?!_)|\b(?:FILES|PROTOCOL|STYLE|ARCHITECTURE) §"
                           r"|\bSTYLE\.md\b|\bPROTOCOL\.md\b|\bFILES\.md\b")
# the folders that other changes on their way bring; empty when they are here
UNFINISHED_FOLDERS: tuple[str, ...] = ()
SHARED_FOLDER = re.compile(r"\.\./shared\b")


def program() -> str:
    return os.environ.get("ESPALIER_PROGRAM", str(ROOT / "build" / "release" / "bin" / "espalier"))


def files() -> Iterator[Path]:
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in SKIPPED_FOLDERS]
        for name in names:
            yield Path(folder) / name


def pages() -> List[Path]:
    return sorted(path for path in files() if path.suffix == ".md")


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def read(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def without_blocks(text: str) -> str:
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def without_code(text: str) -> str:
    """Fenced blocks and code spans hold no links."""
    text = without_blocks(text)
    return re.sub(r"``[^\n]*?``|`[^`\n]*`", "", text)


def headings(text: str) -> List[str]:
    return [match.strip() for match in re.findall(r"^#{1,6} +(.+)$", without_blocks(text), re.MULTILINE)]


def anchor(heading: str) -> str:
    """As GitHub makes it."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
    return re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")


def anchors(text: str) -> List[str]:
    found: Dict[str, int] = {}
    result = []
    for heading in headings(text):
        slug = anchor(heading)
        count = found.get(slug, 0)
        found[slug] = count + 1
        result.append(slug if count == 0 else f"{slug}-{count}")
    return result


def links(text: str) -> List[str]:
    plain = without_code(text)
    targets = re.findall(r"\]\(([^)\s]+)\)", plain) + re.findall(r'\b(?:src|href)="([^"]+)"', plain)
    return [target for target in targets if not re.match(r"[a-z]+:", target)]


def broken_links(page: Path, text: str) -> List[str]:
    breaches = []
    # the commands of a page make its pictures: test_handbook_blocks.py
    made = page_blocks.pictures(page) if page.is_relative_to(ROOT / "docs") else []
    for target in links(text):
        if target in made:
            continue
        name, _, fragment = target.partition("#")
        path = (page.parent / name) if name else page
        if not path.exists():
            breaches.append(f"{relative(page)}: no such file: {target}")
        elif fragment and (path.suffix != ".md" or fragment not in anchors(read(path))):
            breaches.append(f"{relative(page)}: no such section: {target}")
    return breaches


CITATION = re.compile(r"\b((?:[\w-]+/)*[\w-]+\.md), (\d+(?:\.\d+)*)")


def broken_citations(name: str, text: str, base: Path) -> List[str]:
    """`docs/language.md, 1.5` in any file, and `language.md, 1.5` in a page beside it or below."""
    breaches = []
    for page, section in CITATION.findall(text):
        path = next((place / page for place in (ROOT, base, base.parent) if (place / page).exists()), None)
        if path is None:
            breaches.append(f"{name}: cites {page}, which does not exist")
        elif not any(re.match(rf"{re.escape(section)}(?![\d])\.?", heading) for heading in headings(read(path))):
            breaches.append(f"{name}: {page} has no section {section}")
    return breaches


# a file of source code in a code span: not `.h` alone, and no placeholder as NAME.cpp or x_test.cpp
NAMED_SOURCE = re.compile(r"`((?:[\w-]+/)*(?!x_)[a-z][a-z0-9_]+\.(?:h|cpp|def|tsx?))`")
# pages about files of other programs
PAGES_OF_OTHERS = ("engine/core/musl/README.md",)
# the build makes it
MADE_SOURCES = {"src/protocol.ts"}


def ends_of(names: List[str]) -> Set[str]:
    """Every end of a path that begins at a folder or at the file."""
    return {"/".join(parts[i:]) for parts in (name.split("/") for name in names) for i in range(len(parts))}


def missing_sources(page: Path, text: str, ends: Set[str]) -> List[str]:
    """Source files that a page names and the repository lacks. Files that the blocks of the page name are the reader's."""
    blocks = "".join(re.findall(r"^```.*?^```|^<!-- .* -->$", text, re.MULTILINE | re.DOTALL))
    return [f"{relative(page)}: no such source file: {name}" for name in NAMED_SOURCE.findall(without_blocks(text))
            if name not in ends and name not in MADE_SOURCES and name not in blocks]


def source_texts() -> Iterator[Tuple[Path, str]]:
    for path in files():
        if path.suffix in TEXT_SUFFIXES and path != Path(__file__).resolve() and path.stat().st_size < 1_000_000:
            yield path, read(path)


def linked_from_its_index(name: str) -> bool:
    """A page of a folder of the handbook: the folder's README.md names it."""
    folder, _, file = name.rpartition("/")
    return folder != "" and file in links(read(ROOT / "docs" / folder / "README.md"))


class Pages(unittest.TestCase):
    maxDiff = None

    def test_every_link_leads_somewhere(self) -> None:
        self.assertGreater(len(pages()), 40)
        self.assertEqual([breach for page in pages() for breach in broken_links(page, read(page))], [])

    def test_every_citation_of_a_section_leads_to_it(self) -> None:
        # the texts of a table stand in a page of the handbook
        self.assertEqual([breach for path, text in source_texts() for breach in
                          broken_citations(relative(path), text, ROOT / "docs" if path.suffix == ".def" else path.parent)], [])

    def test_every_source_file_that_a_page_names_is_there(self) -> None:
        ends = ends_of([relative(path) for path in files()])
        self.assertEqual([breach for page in pages() if relative(page) not in ("CHANGELOG.md", *PAGES_OF_OTHERS)
                          for breach in missing_sources(page, read(page), ends)], [])

    def test_nothing_cites_a_page_that_is_not_in_the_repository(self) -> None:
        breaches = []
        for path, text in source_texts():
            # the tests look for validation data that may not be published
            for pattern in (FOREIGN_PAGES, SHARED_FOLDER):
                if pattern is SHARED_FOLDER and relative(path).startswith("tests/"):
                    continue
                for match in pattern.finditer(text):
                    line = text.count("\n", 0, match.start()) + 1
                    breaches.append(f"{relative(path)}:{line}: {match.group()}")
        self.assertEqual(breaches, [])

    def test_readmes_are_short(self) -> None:
        lengths = {relative(page): read(page).count("\n") for page in pages()
                   if page.name == "README.md" and not relative(page).startswith((*LONG_READMES, *UNFINISHED_FOLDERS))}
        self.assertEqual({name: length for name, length in lengths.items() if length > LONGEST_README}, {})

    def test_the_handbook_s_index_names_every_page(self) -> None:
        index = links(read(ROOT / "docs" / "README.md"))
        self.assertEqual([name for name in (page.relative_to(ROOT / "docs").as_posix() for page in sorted((ROOT / "docs").rglob("*.md")))
                          if name != "README.md" and name not in index and not linked_from_its_index(name)], [])

    def test_every_library_folder_has_a_readme(self) -> None:
        libraries = [path.parent for path in files()
                     if path.name == "CMakeLists.txt" and path.parent != ROOT and "tests" not in path.relative_to(ROOT).parts]
        self.assertGreater(len(libraries), 10)
        # an example is described by its library's page
        without = [relative(folder) for folder in libraries
                   if folder.name != "example" and not (folder / "README.md").exists()]
        self.assertEqual(without, [])


class Rules(unittest.TestCase):
    """The rules see what they are there for."""

    def test_a_broken_link_is_seen(self) -> None:
        page = ROOT / "README.md"
        self.assertEqual(len(broken_links(page, "[a](nothing.md) [b](docs/language.md#nowhere) [c](CHANGELOG.md)")), 2)
        self.assertEqual(broken_links(page, "`[a](nothing.md)` [b](docs/language.md#2-turtle-interpretation)"), [])

    def test_a_broken_citation_is_seen(self) -> None:
        self.assertEqual(broken_citations("x", "docs/language.md, 1.5; docs/model-files.md, 4.3", ROOT), [])
        self.assertEqual(len(broken_citations("x", "docs/language.md, 7.5; docs/nothing.md, 1", ROOT)), 2)

    def test_a_source_file_that_is_missing_is_seen(self) -> None:
        text = "`server/log.h` `log.h` `NAME.h` `x_test.cpp` `.cpp` `gone.cpp` `session/log.h`"
        said = missing_sources(ROOT / "README.md", text, ends_of(["server/log.h"]))
        self.assertEqual([breach.rpartition(" ")[2] for breach in said], ["gone.cpp", "session/log.h"])

    def test_foreign_pages_are_seen(self) -> None:
        for text in ("LANG" "UAGE §1.3", "LANG" "UAGE: modes", "FIL" "ES §4"):
            self.assertIsNotNone(FOREIGN_PAGES.search(text))
        for text in ("project(a LANG" "UAGES CXX)", "FIL" "ES_MATCHING", "docs/language.md, 1.3"):
            self.assertIsNone(FOREIGN_PAGES.search(text))

    def test_anchors_are_those_of_github(self) -> None:
        self.assertEqual(anchor("4.3 `tropism:` and `torque:`"), "43-tropism-and-torque")


def shown_by(row: str) -> List[str]:
    """The tests that a row of the table of threats names, as FILE::Suite.name."""
    return re.findall(r"`((?:clients/python/)?tests/[\w/]+\.(?:py|cpp)::\w+\.\w+)`", row)


def is_test(name: str) -> bool:
    """FILE::Class.method of Python, or FILE::Suite.Name of GoogleTest."""
    file, _, test = name.partition("::")
    suite, _, claim = test.partition(".")
    if not (ROOT / file).exists():
        return False
    text = read(ROOT / file)
    if file.endswith(".cpp"):
        return re.search(rf"\bTEST(?:_F|_P)?\({suite}, {claim}\)", text) is not None
    body = re.search(rf"^class {suite}\(.*?(?=^class |\Z)", text, re.MULTILINE | re.DOTALL)
    return body is not None and re.search(rf"^    def {claim}\(self\)", body.group(), re.MULTILINE) is not None


class Facts(unittest.TestCase):
    maxDiff = None

    def test_each_threat_has_a_test(self) -> None:
        table = read(ROOT / "SECURITY.md").split("## Who may do what")[1].split("\n## ")[0]
        rows = [line for line in table.splitlines() if line.startswith("|")][2:]
        self.assertGreater(len(rows), 15)
        wanted = ("anonymous network peer", "authenticated viewer", "controller", "environment", "local user",
                  "author of a model file", "author of a snapshot")
        self.assertEqual([who for who in wanted if not any(row.startswith(f"| {who}") for row in rows)], [])
        self.assertEqual([row for row in rows if not shown_by(row) or not all(map(is_test, shown_by(row)))], [])
        # the rule sees a test that is not there
        for wrong in ("tests/integration/test_roles.py::Roles.test_nothing", "tests/nowhere.py::A.test_b",
                      "tests/integration/test_roles.py::Offers.test_every_method_asks_for_its_role"):
            self.assertFalse(is_test(wrong))

    def test_every_table_of_the_program_is_the_program_s(self) -> None:
        for page in {path for path, _, _ in generated_pages.TABLES}:
            self.assertEqual(read(page), generated_pages.with_tables(page, program()), f"{relative(page)}: run ./dev pages")

    def test_no_page_contradicts_a_limit(self) -> None:
        """As in: the limit `outboxBytes` (256 MB)."""
        limits = generated_pages.limits_of_server(program())
        factors = {"": 1, "KB": 1_000, "MB": 1_000_000, "GB": 1_000_000_000}
        breaches = []
        for page in pages():
            for name, number, unit in re.findall(r"`(\w+)` \((\d[\d,]*) ?(KB|MB|GB|)\)", read(page)):
                stated = int(number.replace(",", "")) * factors[unit]
                if name in limits and int(limits[name][0]) != stated:
                    breaches.append(f"{relative(page)}: {name} is {limits[name][0]}, not {stated}")
        self.assertEqual(breaches, [])

    def test_the_page_names_every_metric(self) -> None:
        metrics = set(re.findall(r'"(espalier_\w+)"', read(ROOT / "server" / "metrics.cpp")))
        self.assertGreater(len(metrics), 10)
        self.assertEqual(metrics, set(re.findall(r"`(espalier_\w+)`", read(generated_pages.PAGE))))

    def test_one_version_everywhere(self) -> None:
        version = re.search(r"project\(Espalier VERSION ([\d.]+)", read(ROOT / "CMakeLists.txt"))
        assert version is not None
        said = subprocess.run([program(), "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
        found = {"espalier --version": said}
        for name, pattern in (("protocol/version.h", r'kProgramVersion = "([^"]+)"'),
                              ("clients/python/espalier/version.py", r'VERSION = "([^"]+)"'),
                              ("clients/python/pyproject.toml", r'^version = "([^"]+)"'),
                              ("CITATION.cff", r"^version: (\S+)"), ("CHANGELOG.md", r"^## (\d[\d.]*)")):
            match = re.search(pattern, read(ROOT / name), re.MULTILINE)
            found[name] = match.group(1) if match else "none"
        found.update({"clients/cpp/client.h": other for other in re.findall(r'"(\d+\.\d+\.\d+)"', read(ROOT / "clients/cpp/client.h"))})
        self.assertEqual({name: other for name, other in found.items() if other != version.group(1)}, {})

    def test_the_newest_version_of_the_changelog_is_dated(self) -> None:
        self.assertRegex(read(ROOT / "CHANGELOG.md"), r"(?m)^## \d[\d.]* \(\d{4}-\d{2}-\d{2}\)")

    def test_the_models_of_the_handbook_are_models(self) -> None:
        checked = 0
        for page in sorted((ROOT / "docs").rglob("*.md")):
            for block in re.findall(r"^```\n(.*?)^```", read(page), re.MULTILINE | re.DOTALL):
                if re.match(r"(Lsystem|Module|Syntax):", block):
                    with tempfile.TemporaryDirectory() as folder:
                        model = Path(folder) / "model.l"
                        model.write_text(block, encoding="utf-8")
                        done = subprocess.run([program(), "check", str(model)], capture_output=True, text=True, check=False)
                    # a model that asks gets its environment later on its page
                    said = "" if "?E gets no answer" in done.stderr and done.stderr.count("warning:") == 1 else done.stderr
                    self.assertEqual((done.returncode, said), (0, ""), f"{relative(page)}: {block}")
                    checked += 1
        self.assertGreater(checked, 0)

    def test_the_page_of_integration_tests_names_each(self) -> None:
        folder = ROOT / "tests" / "integration"
        page = read(folder / "README.md")
        self.assertEqual([path.name for path in sorted(folder.glob("*test*")) if path.suffix in (".py", ".cpp")
                          and f"`{path.name}`" not in page], [])

    def test_the_page_of_the_command_line_names_the_file_of_every_command(self) -> None:
        folder = ROOT / "clients" / "espalier"
        page = read(folder / "README.md")
        self.assertEqual([path.name for path in sorted((folder / "commands").glob("*_command.cpp"))
                          if f"`{path.name}`" not in page], [])

    def test_the_reference_of_the_command_line_names_every_command(self) -> None:
        said = subprocess.run([program(), "--help"], capture_output=True, text=True, check=True).stdout
        commands = re.findall(r"^  ([a-z-]+)  ", said.split("Subcommands:")[1], re.MULTILINE)
        self.assertGreater(len(commands), 25)
        page = read(ROOT / "docs" / "command-line.md")
        self.assertEqual([name for name in commands if not re.search(rf"`(?:espalier )?{name}[` ]", page)], [])

    def test_the_page_for_contributors_names_every_verb(self) -> None:
        said = subprocess.run([str(ROOT / "dev"), "help"], capture_output=True, text=True, check=True).stdout
        verbs = re.findall(r"^  ([a-z]+)  ", said.split("Environment variables")[0], re.MULTILINE)
        self.assertGreater(len(verbs), 10)
        table = read(ROOT / "CONTRIBUTING.md")
        self.assertEqual([verb for verb in verbs if not re.search(rf"^\|.*`{verb}[` ]", table, re.MULTILINE)], [])

    def test_dev_help_names_every_stage_that_the_page_names(self) -> None:
        said = subprocess.run([str(ROOT / "dev"), "help"], capture_output=True, text=True, check=True).stdout
        stages = re.search(r"--all STAGE.*?stages?: ([\w, \n]+?)\.", said, re.DOTALL)
        assert stages is not None, "./dev help lists no stages"
        named = set(re.findall(r"\w+", stages.group(1)))
        page = set(re.findall(r"^\| `(\w+)` \|", read(ROOT / "tests" / "README.md").split("## Stages")[1], re.MULTILINE))
        self.assertEqual(named, page)

    def test_dev_follows_the_quota_of_the_control_group(self) -> None:
        code = read(ROOT / "dev")
        begin = code.index("\ncores() {")
        body = code[begin:code.index("\n}\n", begin) + 3]
        available = len(os.sched_getaffinity(0))
        cases = {"max 100000": available, "100000 100000": 1, "50000 100000": 1, "150000 100000": min(2, available),
                 "99900000 100000": available}
        with tempfile.TemporaryDirectory() as folder:
            script = body.replace("/sys/fs/cgroup", folder) + "cores"

            def cores() -> int:
                return int(subprocess.run(["bash", "-euo", "pipefail", "-c", script], capture_output=True, text=True,
                                          check=True).stdout)

            self.assertEqual(cores(), available)
            for quota, expected in cases.items():
                (Path(folder) / "cpu.max").write_text(quota + "\n", encoding="ascii")
                self.assertEqual(cores(), expected, quota)


if __name__ == "__main__":
    unittest.main()
