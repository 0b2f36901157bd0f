"""Writes tests/benchmark/RESULTS.md: the machine, the date, the version, and the tables of a whole run."""

import datetime
import os
import platform
import re
import subprocess
from pathlib import Path

HEAD = """# Benchmark results

`./dev bench` writes this page; do not edit it. A ratio of one run counts, an absolute time does not: [README.md](README.md) says what
each benchmark times and what the columns compare.

"""


def first_match(pattern: str, file: str) -> str:
    try:
        found = re.search(pattern, Path(file).read_text(encoding="utf-8"), re.MULTILINE)
    except OSError:
        return "unknown"
    return found.group(1).strip() if found else "unknown"


def machine() -> list[list[str]]:
    memory = first_match(r"^MemTotal: +(\d+)", "/proc/meminfo")
    processor = first_match(r"^model name\s*: (.+)$", "/proc/cpuinfo")
    system = first_match(r'^PRETTY_NAME="(.+)"', "/etc/os-release")
    load = os.getloadavg()[0]
    return [["", ""],
            ["date", datetime.date.today().isoformat()],
            ["processor", f"{processor}, {len(os.sched_getaffinity(0))} cores"],
            ["memory", f"{int(memory) / 1e6:.0f} GB" if memory.isdigit() else memory],
            ["system", f"{system}, {platform.libc_ver()[0]} {platform.libc_ver()[1]}"],
            ["load when the tables were made", f"{load:.1f}" + (" (not idle: compare ratios only)" if load > 2.0 else "")]]


def table(rows: list[list[str]]) -> str:
    """As Markdown, without the columns that no row fills."""
    used = [i for i in range(len(rows[0])) if any(row[i] for row in rows[1:])]
    lines = ["| " + " | ".join(row[i] for i in used) + " |" for row in rows]
    lines.insert(1, "|" + "|".join("---" if i == used[0] else "---:" for i in used) + "|")
    return "\n".join(lines) + "\n"


class Page:
    """Collects tables and writes them as one page."""

    def __init__(self, espalier: str, names: list[str]) -> None:
        """`names` are those that the run was restricted to; none: a whole run."""
        version = subprocess.run([espalier, "--version"], capture_output=True, text=True, check=True).stdout.strip()
        self.tables: dict[str, str] = {}
        self.parts = [HEAD + table([*machine(), ["version", version], ["benchmarks", ", ".join(names) or "all"]])]

    def add_table(self, title: str, rows: list[list[str]]) -> None:
        self.tables[title] = table(rows)
        self.parts.append(f"## {title}\n\n{table(rows)}")

    def write(self, file: str) -> None:
        Path(file).write_text("\n".join(self.parts), encoding="utf-8")

    def update(self, file: str) -> None:
        """Puts the tables of this run in the place of those of the same titles; new ones go to the end."""
        update_tables(file, self.tables)


def names_in(text: str) -> set[str]:
    """The first cells of the rows of a table, without its head."""
    return {line.split("|")[1].strip() for line in [row for row in text.splitlines() if row.startswith("| ")][1:]}


def update_tables(file: str, tables: dict[str, str]) -> None:
    """Puts tables, by their titles, in the place of those of the same titles; new ones go to the end. A table that has rows which this
    run has not measured stays as it is."""
    said = f"Measured {datetime.date.today().isoformat()}, load {os.getloadavg()[0]:.1f}.\n\n"
    head, *sections = Path(file).read_text(encoding="utf-8").split("\n## ")
    titles = [section.split("\n", 1)[0] for section in sections]
    for title, text in tables.items():
        section = f"{title}\n\n{said}{text}"
        left = names_in(sections[titles.index(title)]) - names_in(text) if title in titles else set()
        if left:
            print(f"{title}: the table stays, for this run has not measured {len(left)} of its rows, such as {min(left)}")
        elif title in titles:
            sections[titles.index(title)] = section
        else:
            sections.append(section)
    Path(file).write_text("\n## ".join([head, *sections]), encoding="utf-8")


def append_table(file: str, title: str, rows: list[list[str]]) -> None:
    with open(file, "a", encoding="utf-8") as page:
        page.write(f"\n## {title}\n\n{table(rows)}")
