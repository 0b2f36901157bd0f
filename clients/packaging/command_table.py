"""The commands of the program with their options, read from `--help`: for man pages and completions."""

import re
import subprocess
import typing


class Option(typing.NamedTuple):
    names: list[str]  # --steps, -a
    value: str  # what stands behind it in the help; empty: a flag
    choices: list[str]
    meaning: str


class Command(typing.NamedTuple):
    words: tuple[str, ...]  # behind `espalier`
    text: str  # of --help
    summary: str
    usage: str
    positionals: list[tuple[str, str]]
    options: list[Option]
    subcommands: list[tuple[str, str]]
    epilogue: str


def sections(text: str) -> dict[str, list[str]]:
    """The lines of a help text below each heading; what stands before and behind under '' and 'footer'."""
    found: dict[str, list[str]] = {"": []}
    current = ""
    for line in text.splitlines():
        if re.fullmatch(r"(Positionals|Options|Subcommands):", line):
            current = line[:-1]
            found[current] = []
        elif current not in ("", "footer") and line and not line.startswith(" "):
            current = "footer"
            found.setdefault(current, []).append(line)
        else:
            found[current].append(line)
    return found


def entries(lines: list[str]) -> list[tuple[str, str]]:
    """(head, meaning) of the entries of a list. A meaning stands from column 30 on, or below a head that is too long."""
    made: list[tuple[str, list[str]]] = []
    for line in lines:
        if re.match(r"  \S", line):
            is_head_only = len(line) <= 30 or line[29] != " "
            made.append((line.strip(), []) if is_head_only else (line[:30].strip(), [line[30:].strip()]))
        elif made and line.strip():
            made[-1][1].append(line.strip())
    return [(head, " ".join(meaning)) for head, meaning in made]


def option(head: str, meaning: str) -> Option:
    names, rest = [], head
    match = re.match(r"((?:-{1,2}[\w-]+,?)+)\s*(.*)$", head)
    if match:
        names = match.group(1).rstrip(",").split(",")
        rest = match.group(2)
    rest = re.split(r"\s*(?:Excludes:|Needs:)", rest)[0]
    choices = re.search(r"\{([^}]*)\}", rest)
    value = re.sub(r":\{[^}]*\}|=\S+|:[A-Z]+( in \[.*?\])?|\bREQUIRED\b|\.\.\.", "", rest).strip()
    return Option(names, value or ("CHOICE" if choices else ""), choices.group(1).split(",") if choices else [], meaning)


def command(program: str, words: tuple[str, ...] = ()) -> Command:
    text = subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=True).stdout
    parts = sections(text)
    usage = next((line[len("Usage: "):] for line in parts[""] if line.startswith("Usage: ")), "")
    summary = next((line for line in parts[""] if line and not line.startswith("Usage: ")), "")
    return Command(words, text, summary, usage, entries(parts.get("Positionals", [])),
                   [option(head, meaning) for head, meaning in entries(parts.get("Options", []))],
                   entries(parts.get("Subcommands", [])), "\n".join(parts.get("footer", [])).strip("\n"))


def commands(program: str, words: tuple[str, ...] = ()) -> typing.Iterator[Command]:
    """The program, its commands, and their subcommands. `connect` has an address in front of its subcommands."""
    this = command(program, words)
    yield this
    between = re.search(r"\[OPTIONS\] ((?:[A-Z:]+ )*)SUBCOMMAND", this.usage)
    for name, _ in this.subcommands:
        yield from commands(program, (*words, *(between.group(1).split() if between and words else ()), name))
