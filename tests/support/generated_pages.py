"""Parts of files that the program writes: the table of limits in docs/operating.md, the hashes of `espalier self-test`.
`./dev pages` calls this as a script."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "operating.md"
BEGIN = "<!-- limits: `./dev pages` writes this table from the program -->\n"
END = "<!-- /limits -->"
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


def limits_table(program: str) -> str:
    server, run = limits_of_server(program), limits_of_run(program)
    rows = ["| limit | meaning | `serve` | `run` |", "|---|---|---:|---:|"]
    for name in [*server, *(name for name in run if name not in server)]:
        meaning = (server.get(name) or run[name])[1]
        defaults = [grouped(table[name][0]) if name in table else "" for table in (server, run)]
        rows.append(f"| `{name}` | {meaning} | {defaults[0]} | {defaults[1]} |")
    return "\n".join(rows) + "\n"


def with_limits(page: str, table: str) -> str:
    before, rest = page.split(BEGIN)
    return before + BEGIN + table + END + rest.split(END)[1]


def with_hashes(text: str, program: str) -> str:
    """The table of state hashes with those of this program."""
    def row(match: "re.Match[str]") -> str:
        model, steps = match[1], match[2]
        done = subprocess.run([program, "derive", str(ROOT / "clients" / "gallery" / model), "--seed", "1", "--steps", steps,
                               "--hash", "--quiet"], capture_output=True, text=True, check=True)
        return f'ESPALIER_SELF_TEST_HASH("{model}", {steps}, "{done.stdout.strip()}")'

    return re.sub(r'^ESPALIER_SELF_TEST_HASH\("([\w-]+)", (\d+), "\w+"\)', row, text, flags=re.MULTILINE)


if __name__ == "__main__":
    PAGE.write_text(with_limits(PAGE.read_text(encoding="utf-8"), limits_table(sys.argv[1])), encoding="utf-8")
    HASHES.write_text(with_hashes(HASHES.read_text(encoding="utf-8"), sys.argv[1]), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)} and {HASHES.relative_to(ROOT)}")
