"""Completions for shells: `make_completions.py PROGRAM FOLDER` writes espalier (bash), _espalier (zsh) and espalier.fish."""

import re
import sys
from pathlib import Path

from command_table import Command, Option, commands

FOLDERS_AND_FILES = {"FILE", "FILE.v", "FILE.snapshot", "FILE.svg", "FOLDER", "ENVIRONMENT", "MODEL", "TEXT"}


def names(command: Command) -> str:
    """The words of a command without the address that stands between some of them."""
    return " ".join(word for word in command.words if re.fullmatch(r"[a-z][a-z-]*", word))


def short(meaning: str) -> str:
    """The first sentence, without what a shell would read."""
    return re.sub(r"[^\w .,/-]", "", re.split(r"[.;:(]", meaning)[0]).strip()


def bash(table: list[Command]) -> str:
    lines = ["# bash completion for espalier; written by make_completions.py from the program's own help", "", "_espalier() {",
             '  local word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" path="" each words="" values=""',
             '  for each in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do',
             '    case "$path $each" in']
    for command in table[1:]:
        parent, _, last = names(command).rpartition(" ")
        lines.append(f'      "{parent} {last}") path="{names(command)}" ;;')
    lines += ["    esac", "  done", '  case "$path" in']
    for command in table:
        words = [name for option in command.options for name in option.names] + [name for name, _ in command.subcommands]
        lines.append(f'    "{names(command)}") words="{" ".join(words)}" ;;')
    lines += ["  esac", '  case "$path $before" in']
    for command in table:
        for option in command.options:
            if option.choices:
                keys = "|".join(f'"{names(command)} {name}"' for name in option.names)
                lines.append(f'    {keys}) values="{" ".join(option.choices)}" ;;')
    lines += ["  esac", '  if [[ -n "$values" ]]; then', '    COMPREPLY=($(compgen -W "$values" -- "$word"))', '  elif [[ "$word" == -* || -z "$path" ]]; then',
              '    COMPREPLY=($(compgen -W "$words" -- "$word"))', "  else",
              '    COMPREPLY=($(compgen -W "$words" -- "$word") $(compgen -f -- "$word"))', "  fi", "}", "complete -o filenames -F _espalier espalier", ""]
    return "\n".join(lines)


def zsh_option(option: Option) -> list[str]:
    value = ""
    if option.choices:
        value = f":value:({' '.join(option.choices)})"
    elif option.value:
        value = f":{re.sub(r'[^A-Za-z]', '', option.value) or 'value'}:{'_files' if option.value in FOLDERS_AND_FILES else ''}"
    return [f"'*{name}[{short(option.meaning)}]{value}'" for name in option.names]


def zsh(table: list[Command]) -> str:
    lines = ["#compdef espalier", "# written by make_completions.py from the program's own help", "", "_espalier() {", '  local place="" each',
             '  for each in "${(@)words[2,CURRENT-1]}"; do', '    case "$place $each" in']
    for command in table[1:]:
        parent, _, last = names(command).rpartition(" ")
        lines.append(f'      "{parent} {last}") place="{names(command)}" ;;')
    lines += ["    esac", "  done", '  case "$place" in']
    for command in table:
        arguments = [each for option in command.options for each in zsh_option(option)]
        if command.subcommands:
            described = " ".join(f"'{name}:{short(meaning)}'" for name, meaning in command.subcommands)
            lines.append(f'    "{names(command)}") local -a list=({described}); _describe command list; _arguments {" ".join(arguments)} ;;')
        else:
            lines.append(f"    \"{names(command)}\") _arguments {' '.join(arguments)} '*:file:_files' ;;")
    lines += ["  esac", "}", '_espalier "$@"', ""]
    return "\n".join(lines)


def fish(table: list[Command]) -> str:
    lines = ["# written by make_completions.py from the program's own help", ""]
    for command in table:
        path = names(command).split()
        seen = [f"__fish_seen_subcommand_from {word}" for word in path]
        if command.subcommands:
            below = " ".join(name for name, _ in command.subcommands)
            condition = "; and ".join([*seen, f"not __fish_seen_subcommand_from {below}"])
            lines += [f"complete -c espalier -n '{condition}' -f -a {name} -d '{short(meaning)}'" for name, meaning in command.subcommands]
        condition = "; and ".join(seen) or "__fish_use_subcommand"
        for option in command.options:
            flags = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names)
            value = f" -x -a '{' '.join(option.choices)}'" if option.choices else " -r" if option.value else ""
            lines.append(f"complete -c espalier -n '{condition}' {flags}{value} -d '{short(option.meaning)}'")
    return "\n".join(lines) + "\n"


def main() -> None:
    table = list(commands(sys.argv[1]))
    folder = Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("espalier", bash(table)), ("_espalier", zsh(table)), ("espalier.fish", fish(table))):
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
