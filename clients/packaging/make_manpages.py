"""Man pages of the program: `make_manpages.py PROGRAM FOLDER` writes espalier.1 and a page for each command."""

import os
import sys
import time
import typing
from pathlib import Path

from command_table import Command, commands


def plain(text: str) -> str:
    """Text of a roff page."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga")
    return "\n".join("\\&" + line if line.startswith(".") else line for line in escaped.splitlines())


def title(words: tuple[str, ...]) -> str:
    """`connect HOST:PORT create` has the page espalier-connect-create."""
    return "-".join(("espalier", *(word for word in words if word.islower() or "-" in word)))


def page(command: Command, version: str, date: str) -> str:
    name = title(command.words)
    lines = [f'.TH {plain(name.upper())} 1 "{date}" "Espalier {version}" "User Commands"', ".SH NAME",
             f"{plain(name)} \\- {plain(command.summary[0].lower() + command.summary[1:])}", ".SH SYNOPSIS",
             f".B {plain(command.usage or 'espalier')}"]
    if command.positionals:
        lines.append(".SH ARGUMENTS")
        for head, meaning in command.positionals:
            lines += [".TP", f".I {plain(head.split()[0])}", plain(meaning)]
    if command.options:
        lines.append(".SH OPTIONS")
        for option in command.options:
            value = f" \\fI{plain(option.value)}\\fR" if option.value else ""
            lines += [".TP", f"\\fB{plain(', '.join(option.names))}\\fR{value}", plain(option.meaning)]
            if option.choices:
                lines.append(plain(f"Choices: {', '.join(option.choices)}."))
    if command.subcommands:
        lines.append(".SH COMMANDS")
        for head, meaning in command.subcommands:
            lines += [".TP", f".B {plain(head)}", plain(meaning)]
    if command.epilogue:
        lines += [".SH NOTES", ".nf", plain(command.epilogue), ".fi"]
    above = title(command.words[:1]) if len(command.words) > 1 else "espalier"
    lines += [".SH SEE ALSO"]
    lines.append("The handbook, in /usr/share/doc/espalier/handbook." if not command.words else
                 f".BR {plain(above)} (1). The handbook, in /usr/share/doc/espalier/handbook.")
    return "\n".join(lines) + "\n"


def pages(program: str, version: str, date: str) -> typing.Iterator[tuple[str, str]]:
    for command in commands(program):
        yield f"{title(command.words)}.1", page(command, version, date)


def main() -> None:
    program, folder = sys.argv[1], Path(sys.argv[2])
    version = os.popen(f"'{program}' --version").read().split()[-1]
    # no clock: two builds make equal pages
    date = time.strftime("%Y-%m-%d", time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", "0"))))
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages(program, version, date):
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
