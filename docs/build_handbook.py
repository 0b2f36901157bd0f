"""Builds the handbook: `./dev docs` calls `build_handbook.py PROGRAM FOLDER`; the pages are in FOLDER/site.

Pages stand where they stand in the repository, so that their links stay as they are. mkdocs (Debian's) makes the site.
"""

import os
import re
import shutil
import subprocess
import sys
import typing
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import page_blocks
import reference_pages

ROOT = Path(__file__).resolve().parents[1]
LINK = re.compile(r'(\]\()([^)\s]+)(\))|(\b(?:src|href)=")([^"]+)(")')


def without_code(text: str) -> list[tuple[str, bool]]:
    """The text in parts, each with whether it is code."""
    parts = re.split(r"(^```.*?^```|``[^\n]*?``|`[^`\n]*`)", text, flags=re.MULTILINE | re.DOTALL)
    return [(part, number % 2 == 1) for number, part in enumerate(parts)]


def for_mkdocs(page: str) -> str:
    """GitHub wants `\\|` for a bar in the code of a cell, and mkdocs shows the backslash."""
    def row(match: "re.Match[str]") -> str:
        return re.sub(r"`[^`\n]*`", lambda code: code[0].replace("\\|", "|"), match[0])

    return re.sub(r"^\|.*$", row, page, flags=re.MULTILINE)


def target_of(page: Path, link: str) -> typing.Optional[Path]:
    """The file or folder in the repository that a link leads to; none: another site, or a place in the page."""
    name = link.partition("#")[0]
    if not name or re.match(r"[a-z]+:", link):
        return None
    return Path(os.path.normpath(page.parent / name))


class Handbook:
    def __init__(self, program: str, folder: Path) -> None:
        self.program = program
        self.folder = folder
        self.source = folder / "source"
        self.site = folder / "site"

    def build(self) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)
        self.source.mkdir(parents=True)
        self.make_pictures()
        self.copy_pages()
        for name, text in reference_pages.all_pages(self.program).items():
            page = self.source / "reference" / name
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(for_mkdocs(text), encoding="utf-8")
        self.run_mkdocs()

    def make_pictures(self) -> None:
        """Runs the pages whose commands make their pictures."""
        def make(page: Path) -> None:
            page_blocks.run_page(page, self.program, self.source / page.parent.relative_to(ROOT))

        made = [page for page in page_blocks.pages() if page_blocks.pictures(page)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(make, made))

    def copy_pages(self) -> None:
        """The pages, and all that they link to, step by step."""
        waiting = [*page_blocks.pages()]
        seen = set(waiting)
        while waiting:
            page = waiting.pop()
            copy = self.source / page.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            if page.suffix != ".md":
                shutil.copyfile(page, copy)
                continue
            text, linked = self.with_links(page)
            copy.write_text(for_mkdocs(text), encoding="utf-8")
            waiting += [each for each in linked if each not in seen]
            seen.update(linked)

    def with_links(self, page: Path) -> tuple[str, list[Path]]:
        """The text of a page, with links to folders mended, and the files that it links to."""
        linked: list[Path] = []

        def mended(match: "re.Match[str]") -> str:
            before, link, after = (match[1], match[2], match[3]) if match[1] else (match[4], match[5], match[6])
            target = target_of(page, link)
            if target is None or (self.source / target.relative_to(ROOT)).exists():
                return match.group()
            if target.is_dir():
                # a folder: its page, else its place in the list of the tests
                link = link.rstrip("/") + "/README.md" if (target / "README.md").exists() else self.way(page, ROOT / "tests" / "README.md")
                target = target_of(page, link)
                assert target is not None
            elif target.suffix == "":
                # a file without a suffix would be taken for a folder
                shutil.copyfile(target, self.source / f"{target.relative_to(ROOT)}.txt")
                return f"{before}{link}.txt{after}"
            linked.append(target)
            # mkdocs mends the links of Markdown only
            if match[4] and target.suffix == ".md":
                link = re.sub(r"README\.md(?=#|$)", "index.html", link)
                link = re.sub(r"\.md(?=#|$)", ".html", link)
            return f"{before}{link}{after}"

        text = page.read_text(encoding="utf-8")
        parts = [part if is_code else LINK.sub(mended, part) for part, is_code in without_code(text)]
        return "".join(parts), linked

    def way(self, page: Path, target: Path) -> str:
        return os.path.relpath(target, page.parent)

    def run_mkdocs(self) -> None:
        configuration = (ROOT / "docs" / "mkdocs.yml").read_text(encoding="utf-8")
        shutil.copy(ROOT / "docs" / "handbook_hooks.py", self.folder)
        (self.source / "search").mkdir()
        shutil.copy(ROOT / "docs" / "search_from_disk.js", self.source / "search" / "from_disk.js")
        (self.folder / "mkdocs.yml").write_text(f"{configuration}\ndocs_dir: source\nsite_dir: site\n", encoding="utf-8")
        # one hash for two builds: dates of pages come from the sources, not from the clock
        date = subprocess.run(["git", "-C", str(ROOT), "log", "-1", "--format=%ct"], capture_output=True, text=True, check=False).stdout.strip()
        done = subprocess.run(["/usr/bin/mkdocs", "build", "--strict", "--quiet", "--config-file", str(self.folder / "mkdocs.yml")],
                              env={"SOURCE_DATE_EPOCH": date or "0", **os.environ}, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"mkdocs could not build the handbook:\n{done.stdout}{done.stderr}")


def main() -> None:
    program, folder = sys.argv[1:]
    try:
        handbook = Handbook(str(Path(program).resolve()), Path(folder).resolve())
        handbook.build()
    except page_blocks.PageError as error:
        raise SystemExit(f"a page says what does not hold: {error}") from None
    print(f"wrote {handbook.site.relative_to(Path.cwd())}/index.html" if handbook.site.is_relative_to(Path.cwd())
          else f"wrote {handbook.site}/index.html")


if __name__ == "__main__":
    main()
