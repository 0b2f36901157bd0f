"""Reference pages that the program writes: commands, functions, turtle symbols, processes, methods and errors. Nothing here names one."""

import json
import re
import subprocess
import sys
import typing
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "clients" / "packaging"))

import command_table  # noqa: E402


def said(program: str, *arguments: str) -> str:
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=True).stdout


def commands(program: str) -> str:
    page = ["# Commands", "", "What `espalier COMMAND --help` prints. [The command line](../docs/command-line.md) explains what several commands share.", ""]
    for command in command_table.commands(program):
        page += [f"## {' '.join(('espalier', *command.words))}", "", "```", command.text.rstrip(), "```", ""]
    return "\n".join(page)


def rows(program: str, table: str) -> list[dict[str, typing.Any]]:
    """The rows of a table that the program works with: functions, symbols, methods, errors."""
    return typing.cast("list[dict[str, typing.Any]]", json.loads(said(program, "reference", table, "--json")))


def anchor(heading: str) -> str:
    """The anchor of a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def place(page: str, section: str) -> str:
    """The anchor of a section of a page of docs/: `5` is the heading `5. Functions`, `Limits` the heading `Limits`."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    found = [each for each in headings if each == section or each.startswith((f"{section} ", f"{section}. "))]
    if not found:
        raise ValueError(f"docs/{page} has no section {section}, which a table of the program names")
    return anchor(found[0])


def told(text: str, docs: str) -> str:
    """A text of the program as Markdown in a cell: its places become links. `docs`: the way to the folder docs/."""
    text = re.sub(r"([\w-]+\.md), (\d[\d.]*\d|\d|[A-Z][a-z ]+[a-z])",
                  lambda match: f"[{match[0]}]({docs}{match[1]}#{place(match[1], match[2])})", text)
    return cell(text.replace("[!]", "**[!]**"))


def usages(row: dict[str, typing.Any]) -> str:
    return " or ".join(f"`{cell(each)}`" for each in row["usage"].split(" or "))


def shared(table: list[dict[str, typing.Any]], docs: str, *more: typing.Callable[[dict[str, typing.Any]], str]) -> list[str]:
    """Rows of a page: usage, further cells, meaning. Neighbours with the same cells behind the usage share a row."""
    merged: list[tuple[list[str], str]] = []
    for each in table:
        rest = " | ".join([*(cells(each) for cells in more), told(each["meaning"], docs)])
        if merged and merged[-1][1] == rest:
            merged[-1][0].append(usages(each))
        else:
            merged.append(([usages(each)], rest))
    return [f"| {', '.join(heads)} | {rest} |" for heads, rest in merged]


def function_table(program: str, docs: str = "") -> list[str]:
    """As docs/language.md has it."""
    return ["| function | value, and traps |", "|---|---|", *shared(rows(program, "functions"), docs)]


def symbol_table(program: str, docs: str = "") -> list[str]:
    return ["| symbol | effect |", "|---|---|", *shared(rows(program, "symbols"), docs), "| any other symbol | no effect |"]


def error_table(program: str, docs: str = "") -> list[str]:
    """For readers of messages."""
    return ["| code | name | it means | do |", "|---:|---|---|---|",
            *(f"| {each['code']} | {each['name']} | {told(each['meaning'], docs)} | {told(each['remedy'], docs)} |"
              for each in rows(program, "errors"))]


def error_data_table(program: str) -> list[str]:
    """For those who write programs."""
    return ["| code | name | data |", "|---|---|---|",
            *(f"| {each['code']} | {each['name']} | {cell(each['data'])} |" for each in rows(program, "errors"))]


def method_table(program: str) -> list[str]:
    return ["| method | answered by | role | |", "|---|---|---|---|",
            *(f"| `{each['name']}` | {each['answeredBy']} | {each['role']} | {cell(each['meaning'])} |".replace("|  |", "| |")
              for each in rows(program, "methods"))]


def functions(program: str) -> str:
    def arguments(row: dict[str, typing.Any]) -> str:
        least, most = row.get("least"), row.get("most")
        return "as its text says" if least is None else str(least) if least == most else f"{least} or {most}"

    page = ["# Functions", "", "The functions of expressions, as `espalier reference functions` prints them. "
            "[Expressions](../docs/language.md#13-expressions) and the statements of blocks stand in the reference of the language. "
            "Angles are in degrees; **[!]** marks what surprises.", "",
            "| function | arguments | depends on its arguments only | value |", "|---|---|---|---|"]
    page += shared(rows(program, "functions"), "../docs/", arguments, lambda row: "yes" if row["isPure"] else "no")
    return "\n".join(page) + "\n"


def symbols(program: str) -> str:
    return "\n".join(["# Turtle symbols", "", "What the turtle does at each symbol, as `espalier reference symbols` prints it. "
                      "[Turtle interpretation](../docs/language.md#2-turtle-interpretation) says what the letters mean and what holds for all; "
                      "**[!]** marks what surprises.", "", *symbol_table(program, "../docs/")]) + "\n"


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


def protocol(program: str) -> str:
    return "\n".join(["# Methods and errors", "", "The tables that server and clients are compiled from. [The protocol](../protocol/README.md) "
                      "explains each method with an example; [Reading messages](../docs/messages.md) has the messages of models.", "",
                      "## Errors by number", "", *error_table(program, "../docs/"), "", "What `data` holds:", "", *error_data_table(program), "",
                      "## Methods", "", *method_table(program)]) + "\n"


def all_pages(program: str) -> dict[str, str]:
    return {"commands.md": commands(program), "functions.md": functions(program), "symbols.md": symbols(program),
            "protocol.md": protocol(program), **processes(program)}
