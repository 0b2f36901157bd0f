"""Reference pages that the program and its tables write: commands, functions, processes, methods and errors."""

import json
import re
import subprocess
import typing
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def said(program: str, *arguments: str) -> str:
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=True).stdout


def subcommands(text: str) -> list[str]:
    """The names below `Subcommands:` of a help text."""
    _, _, rest = text.partition("\nSubcommands:\n")
    return re.findall(r"^  ([a-z][\w-]*) ", rest.split("\n\n")[0], re.MULTILINE)


def helps(program: str, command: tuple[str, ...] = ()) -> typing.Iterator[tuple[tuple[str, ...], str]]:
    """Every command with its help, subcommands behind their command."""
    text = said(program, *command, "--help")
    yield command, text
    for name in subcommands(text):
        yield from helps(program, (*command, name))


def commands(program: str) -> str:
    page = ["# Commands", "", "What `espalier COMMAND --help` prints. [The command line](../docs/command-line.md) explains what several commands share.", ""]
    for command, text in helps(program):
        page += [f"## {' '.join(('espalier', *command))}", "", "```", text.rstrip().replace("```", "'''"), "```", ""]
    return "\n".join(page)


def functions() -> str:
    table = (ROOT / "engine" / "language" / "function.def").read_text(encoding="utf-8")
    page = ["# Functions", "", "The functions of expressions. [Their meaning](../docs/language.md#13-expressions) and the statements of blocks stand in the "
            "reference of the language. Angles are in degrees.", "", "| function | arguments | depends on its arguments only |", "|---|---|---|"]
    for name, least, most, pure in re.findall(r'^ESPALIER_FUNCTION\(\w+, "(\w+)", (\d+), (\d+), (\w+)\)', table, re.MULTILINE):
        page.append(f"| `{name}` | {least if least == most else f'{least} or {most}'} | {'yes' if pure == 'true' else 'no'} |")
    return "\n".join(page) + "\n"


def process_names(program: str) -> list[str]:
    return [line.split()[0] for line in said(program, "environment", "--list").splitlines()]


def cell(text: object) -> str:
    return str(text).replace("|", "\\|").replace("\n", " ")


def process_page(description: dict[str, typing.Any]) -> str:
    name = description["name"]
    page = [f"# {name}", "", description["summary"], "", f"What it computes, and how: [environments](../../docs/environments.md#{name}).", ""]
    if description.get("aliases"):
        page += [f"Also called: {', '.join(f'`{alias}`' for alias in description['aliases'])}.", ""]
    for title, key in (("Sent", "inputs"), ("Returned", "outputs")):
        if description.get(key):
            page += [f"## {title}", "", "| parameter | name | unit |", "|---|---|---|"]
            page += [f"| {number} | {cell(each['name'])} | {cell(each.get('unit', ''))} |" for number, each in enumerate(description[key], 1)] + [""]
    keys = description["configuration"].get("properties", {})
    if keys:
        page += ["## Keys", "", "| key | default | unit | meaning |", "|---|---|---|---|"]
        for key, schema in keys.items():
            default = json.dumps(schema["default"]) if "default" in schema else ""
            page.append(f"| `{key}` | {cell(default if len(default) < 60 else '…')} | {cell(schema.get('unit', ''))} | {cell(schema.get('description', ''))} |")
        page.append("")
    page += ["## How to cite", ""]
    if description.get("source"):
        page += [f"Cite the source of the model: {description['source']}. Cite Espalier for the implementation, with its version "
                 "([cite](../../docs/howto/cite.md))."]
    else:
        page += ["The process has no published source: cite Espalier, with its version ([cite](../../docs/howto/cite.md))."]
    return "\n".join(page) + "\n"


def processes(program: str) -> dict[str, str]:
    """Page by name below reference/: the index, and a page for each process."""
    index = ["# Processes", "", "The built-in environment processes, with what they are sent, what they return, their units, keys and sources.", "",
             "| process | |", "|---|---|"]
    pages = {}
    for name in process_names(program):
        description = json.loads(said(program, "environment", name, "--describe", "--json"))
        pages[f"processes/{name}.md"] = process_page(description)
        index.append(f"| [{name}](processes/{name}.md) | {cell(description['summary'])} |")
    return {"processes.md": "\n".join(index) + "\n", **pages}


def protocol() -> str:
    page = ["# Methods and errors", "", "The tables that server and clients are compiled from. [The protocol](../protocol/README.md) explains each method "
            "with an example.", "", "## Errors by number", "", "| code | name | meaning |", "|---:|---|---|"]
    header = (ROOT / "protocol" / "errors.h").read_text(encoding="utf-8")
    for name, code, remark in re.findall(r"^  (\w+) = (-?\d+),(?: *// (.*))?$", header, re.MULTILINE):
        page.append(f"| {code} | {name} | {cell(remark)} |")
    page += ["", "## Methods", "", "| method | |", "|---|---|"]
    table = (ROOT / "protocol" / "methods.def").read_text(encoding="utf-8")
    page += [f"| `{name}` | {cell(meaning)} |"
             for name, meaning in re.findall(r'^ESPALIER_\w+\("([^"]+)",[^;]*?"([^"]+)"\)', table, re.MULTILINE)]
    return "\n".join(page) + "\n"


def all_pages(program: str) -> dict[str, str]:
    return {"commands.md": commands(program), "functions.md": functions(), "protocol.md": protocol(), **processes(program)}
