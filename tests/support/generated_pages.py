"""Parts of files that the program writes: tables of pages (limits, functions, turtle symbols, errors, methods), and the hashes of
`espalier self-test`. `./dev pages` calls this as a script."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Callable

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs"))

import reference_pages  # noqa: E402

PAGE = ROOT / "docs" / "operating.md"
HASHES = ROOT / "clients" / "espalier" / "installation" / "self_test.def"


def grouped(number: str) -> str:
    return f"{int(number):,}"


def limits_of_server(program: str) -> dict[str, tuple[str, str]]:
    """Name -> (default, meaning), in the program's order."""
    text = subprocess.run([program, "serve", "--print-config"], capture_output=True, text=True, check=True).stdout
    lines = re.findall(r"^(\w+) = (\d+) +# (.+)$", text.split("[limits]")[1], re.MULTILINE)
    return {name: (default, meaning) for name, default, meaning in lines}


def limits_of_run(program: str) -> dict[str, tuple[str, str]]:
    """The same for commands that grow a model."""
    text = subprocess.run([program, "run", "--help"], capture_output=True, text=True, check=True).stdout
    entries = re.search(r"--limit NAME=NUMBER(.*?)\n  -", text, re.DOTALL)
    assert entries is not None, "run --help has no --limit"
    joined = " ".join(entries.group(1).split())
    return {name: (default, meaning) for name, meaning, default in re.findall(r"(\w+) \(([^();]+); (\d+)\)", joined)}


def limits_table(program: str) -> "list[str]":
    server, run = limits_of_server(program), limits_of_run(program)
    rows = ["| limit | meaning | `serve` | `run` |", "|---|---|---:|---:|"]
    for name in [*server, *(name for name in run if name not in server)]:
        meaning = (server.get(name) or run[name])[1]
        defaults = [grouped(table[name][0]) if name in table else "" for table in (server, run)]
        rows.append(f"| `{name}` | {meaning} | {defaults[0]} | {defaults[1]} |")
    return rows


# (page, name of the table in its comments, what writes it)
TABLES: list[tuple[Path, str, Callable[[str], "list[str]"]]] = [
    (PAGE, "limits", limits_table),
    (ROOT / "docs" / "language.md", "functions", reference_pages.function_table),
    (ROOT / "docs" / "language.md", "symbols", reference_pages.symbol_table),
    (ROOT / "docs" / "messages.md", "errors", reference_pages.error_table),
    (ROOT / "protocol" / "README.md", "methods", reference_pages.method_table),
    (ROOT / "protocol" / "README.md", "errors", reference_pages.error_data_table),
]


def with_table(page: str, name: str, table: "list[str]") -> str:
    """The page with the table between its comments."""
    begin, end = f"<!-- {name}: `./dev pages` writes this table from the program -->\n", f"<!-- /{name} -->"
    before, rest = page.split(begin)
    return before + begin + "\n".join(table) + "\n" + end + rest.split(end)[1]


def with_tables(path: Path, program: str) -> str:
    """The text of a page with all of its tables as the program has them."""
    page = path.read_text(encoding="utf-8")
    for each, name, table in TABLES:
        if each == path:
            page = with_table(page, name, table(program))
    return page


def with_hashes(text: str, program: str) -> str:
    """The table of state hashes with those of this program."""
    def row(match: "re.Match[str]") -> str:
        model, steps = match[1], match[2]
        done = subprocess.run([program, "derive", str(ROOT / "clients" / "gallery" / model), "--seed", "1", "--steps", steps,
                               "--hash", "--quiet"], capture_output=True, text=True, check=True)
        return f'ESPALIER_SELF_TEST_HASH("{model}", {steps}, "{done.stdout.strip()}")'

    return re.sub(r'^ESPALIER_SELF_TEST_HASH\("([\w-]+)", (\d+), "\w+"\)', row, text, flags=re.MULTILINE)


if __name__ == "__main__":
    written = sorted({path for path, _, _ in TABLES})
    for each in written:
        each.write_text(with_tables(each, sys.argv[1]), encoding="utf-8")
    HASHES.write_text(with_hashes(HASHES.read_text(encoding="utf-8"), sys.argv[1]), encoding="utf-8")
    print(f"wrote {', '.join(str(path.relative_to(ROOT)) for path in [*written, HASHES])}")
