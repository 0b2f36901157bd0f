"""The code blocks of a page, and how they are run: README.md of this folder, "How a page is written"."""

import ast
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import tomllib
import typing
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SECONDS = 300
# kinds that are data or text to look at: they need a remark that says what they are
REMARKS = ("file", "output", "messages", "background", "fails", "shown")
# files whose text is read when they are written
DATA: dict[str, typing.Callable[[str], object]] = {".json": json.loads, ".toml": tomllib.loads, ".py": ast.parse}
# addresses of pages; each page that runs gets free ports instead
PORTS = ("4321", "8080", "4000")
# what runs a block, by the word behind its fence
RUN = {"sh": ["bash", "-euo", "pipefail", "-c"], "python": ["python3", "-c"], "r": ["Rscript", "-e"]}


class Block(typing.NamedTuple):
    line: int
    language: str  # behind the fence; may be empty
    remark: str  # of the comment in front of the fence, its first word; may be empty
    value: str  # the rest of the comment
    text: str


class PageError(Exception):
    """What a page says is not what happens."""


def blocks(page: str) -> list[Block]:
    """All fenced blocks of a page, in order."""
    found = []
    # language -> reason
    shown = dict(re.findall(r"^<!-- every (\w+) is shown (.+) -->$", page, re.MULTILINE))
    pattern = re.compile(r"(?:^[ ]*<!-- (?P<remark>[a-z]+)(?: (?P<value>[^\n]*?))? -->\n)?"
                         r"^(?P<indent>[ ]*)```(?P<language>\w*)\n(?P<text>.*?)^[ ]*```$", re.MULTILINE | re.DOTALL)
    for match in pattern.finditer(page):
        remark = match["remark"] if match["remark"] in REMARKS else ""
        value = match["value"] or "" if remark else ""
        if not remark and match["language"] in shown:
            remark, value = "shown", shown[match["language"]]
        text = re.sub(rf"^{match['indent']}", "", match["text"], flags=re.MULTILINE)
        found.append(Block(page.count("\n", 0, match.start("language")) + 1, match["language"], remark, value, text))
    return found


def copies(page: str) -> list[tuple[str, str]]:
    """(name, path in the repository) of the comments `<!-- with NAME = PATH -->`."""
    return re.findall(r"^<!-- with (\S+) = (\S+) -->$", page, re.MULTILINE)


def missing(page: str) -> list[str]:
    """The programs of a comment `<!-- page needs PROGRAM... -->` that this machine does not have."""
    return [program for line in re.findall(r"^<!-- page needs (.+) -->$", page, re.MULTILINE) for program in line.split()
            if shutil.which(program) is None]


def problems(page: str) -> list[str]:
    """Blocks of which the page does not say what they are, or not why they do not run."""
    return [f"line {block.line}: say what the block is: a command (```sh), a program (```python), or a remark in front of it"
            for block in blocks(page) if not block.remark and block.language not in RUN] + [
            f"line {block.line}: say why the block is not run" for block in blocks(page) if block.remark == "shown" and not block.value]


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT)) if page.is_relative_to(ROOT) else page.name


def free_ports() -> dict[str, str]:
    taken = [socket.create_server(("127.0.0.1", 0)) for _ in PORTS]
    numbers = [str(each.getsockname()[1]) for each in taken]
    for each in taken:
        each.close()
    return dict(zip(PORTS, numbers))


def agrees(expected: str, actual: str) -> bool:
    """Whether the lines stand in the text, in order and next to each other. `…` stands for anything, also for lines."""
    lines = [re.escape(line.rstrip()).replace("…", ".*?") for line in expected.strip("\n").split("\n")]
    # a line of its own may stand for none
    pattern = "\n".join(lines).replace("\n.*?\n", "\n(?:.*\n)??")
    text = "\n".join(line.rstrip() for line in actual.split("\n"))
    return re.search(f"(?:^|\n){pattern}(?:\n|$)", text, re.DOTALL) is not None


class Run:
    """The blocks of one page in a folder of its own."""

    def __init__(self, page: Path, program: str, folder: Path) -> None:
        self.page = page
        self.folder = folder
        self.text = page.read_text(encoding="utf-8")
        self.ports = free_ports()
        self.output = self.messages = ""
        self.background: "list[subprocess.Popen[str]]" = []
        tools = folder / ".tools"
        tools.mkdir()
        (tools / "espalier").symlink_to(Path(program).resolve())
        # Debian's interpreter, for which NumPy is installed
        (tools / "python3").symlink_to(sys.executable)
        self.variables = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "HOME": str(folder), "LC_ALL": "C.UTF-8",
                          "PYTHONPATH": str(ROOT / "clients" / "python"), "PYTHONDONTWRITEBYTECODE": "1", "ESPALIER_PROGRAM": program}
        # where a build of the repository has it
        built = folder / "build" / "release" / "bin"
        built.mkdir(parents=True)
        (built / "espalier").symlink_to(Path(program).resolve())
        for path in ROOT.iterdir():
            if path.name in ("clients", "tests", "environment", "protocol", "docs"):
                (folder / path.name).symlink_to(path)
        # a page of models has its models beside it
        for path in page.parent.iterdir():
            if path.is_file() and path.suffix in (".l", ".v", ".json") and page.parent.name == "tutorial":
                shutil.copy(path, folder)
        for name, source in copies(self.text):
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            (shutil.copytree if (ROOT / source).is_dir() else shutil.copy)(ROOT / source, target)

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.background:
            os.killpg(process.pid, signal.SIGTERM)
        for process in self.background:
            process.communicate()

    def local(self, text: str) -> str:
        for port, free in self.ports.items():
            text = re.sub(rf"\b{port}\b", free, text)
        return text

    def all(self) -> None:
        for block in blocks(self.text):
            try:
                self.one(block)
            except PageError as error:
                raise PageError(f"{name_of(self.page)}:{block.line}: {error}") from None

    def one(self, block: Block) -> None:
        if block.remark == "file":
            self.write(block)
        elif block.remark in ("output", "messages"):
            actual = self.output if block.remark == "output" else self.messages
            if not agrees(self.local(block.text), actual):
                raise PageError(f"the page says\n{block.text}but the {block.remark} is\n{actual[-4000:]}")
        elif block.remark == "background":
            self.start(block)
        elif block.remark != "shown" and block.language in RUN:
            self.execute(block)

    def write(self, block: Block) -> None:
        target = self.folder / block.value
        if target.exists() and target.read_text(encoding="utf-8") != block.text:
            raise PageError(f"the file {block.value} beside the page has another text")
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(self.local(block.text), encoding="utf-8")
        if target.suffix in DATA:
            DATA[target.suffix](block.text)
        if target.suffix == ".l":
            # a page may give the model its environment later
            given = ["--environment", "constant"] if "?E" in block.text and not target.with_suffix(".json").exists() else []
            done = self.command(["espalier", "check", block.value, *given])
            if done.returncode != 0 or done.stderr:
                raise PageError(f"espalier check {block.value}:\n{done.stdout}{done.stderr}")

    def command(self, words: list[str]) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(words, cwd=self.folder, env=self.variables, capture_output=True, text=True, timeout=SECONDS,
                              stdin=subprocess.DEVNULL, check=False)

    def execute(self, block: Block) -> None:
        text = self.local(block.text)
        done = self.command([*RUN[block.language], text])
        self.output, self.messages = done.stdout, done.stderr
        if (done.returncode != 0) != (block.remark == "fails"):
            raise PageError(f"ended with {done.returncode}:\n{block.text}{done.stdout}{done.stderr}")

    def start(self, block: Block) -> None:
        """Starts a block and waits until it says that it is ready."""
        process = subprocess.Popen(["bash", "-euo", "pipefail", "-c", self.local(block.text)], cwd=self.folder, env=self.variables,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   start_new_session=True)
        self.background.append(process)
        assert process.stdout is not None
        watchdog = threading.Timer(SECONDS, os.killpg, (process.pid, signal.SIGKILL))
        watchdog.start()
        seen = ""
        try:
            for line in process.stdout:
                seen += line
                if re.search(block.value or "listening on", line):
                    return
        finally:
            watchdog.cancel()
        raise PageError(f"ended before it was ready:\n{block.text}{seen}")


def run_page(page: Path, program: str, keep: typing.Optional[Path] = None) -> None:
    """Runs all blocks of a page; its pictures go to `keep`. PageError: what does not hold."""
    with tempfile.TemporaryDirectory() as name, Run(page, program, Path(name)) as run:
        run.all()
        for picture in pictures(page):
            made = Path(name) / picture
            if not made.is_file():
                raise PageError(f"{name_of(page)}: no block makes {picture}")
            if keep is not None:
                keep.mkdir(parents=True, exist_ok=True)
                shutil.copy(made, keep / picture)


def pictures(page: Path) -> list[str]:
    """Pictures of a page that are not in the repository: the page's own commands make them."""
    names = re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    return [name for name in names if "/" not in name and not (page.parent / name).exists()]


def has_runs(page: Path) -> bool:
    """Whether anything happens when the page runs."""
    return any(block.remark != "shown" for block in blocks(page.read_text(encoding="utf-8")))


def pages() -> list[Path]:
    """The pages of the handbook."""
    return sorted((ROOT / "docs").rglob("*.md")) + [ROOT / "README.md"]


def folder_pages() -> list[Path]:
    """The other pages of the repository: of folders, clients and models of the gallery. Their blocks run, too."""
    found = []
    for folder, below, files in os.walk(ROOT):
        below[:] = sorted(each for each in below if each not in ("build", "out", "docs", "node_modules", ".git", "dist"))
        found += [Path(folder) / file for file in sorted(files) if file.endswith(".md")]
    return [each for each in found if each not in pages()]
