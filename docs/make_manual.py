"""Writes docs/flankload.1, the manual page of the command, from the parser of the command."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from flankload.cli import parser

PAGE = Path(__file__).parent / "flankload.1"


def manual() -> str:
    """The page as roff."""
    top = parser()
    names, described = commands(top)
    lines = [
        '.TH FLANKLOAD 1 "" flankload "User Commands"',
        ".SH NAME",
        f"flankload \\- {escaped(str(top.description).rstrip('.').lower())}",
        ".SH SYNOPSIS",
        ".B flankload",
        escaped("[--help] [--version] COMMAND …"),
        ".SH COMMANDS",
    ]
    for name in names:
        lines += section(name, names[name], described[name])
    lines += [
        ".SH OPTIONS",
        *(line for action in options(top) for line in entry(action)),
        ".SH EXIT STATUS",
        escaped(str(top.epilog).removeprefix("exit codes: ")),
        ".SH ENVIRONMENT",
        ".TP",
        ".B OMP_NUM_THREADS",
        "threads that share the positions of a sweep",
    ]
    return "\n".join(lines) + "\n"


def commands(
    top: argparse.ArgumentParser,
) -> tuple[dict[str, argparse.ArgumentParser], dict[str, str]]:
    """The parser of each command, and its line of help."""
    found: Any = next(a for a in top._actions if isinstance(a, argparse._SubParsersAction))
    return found.choices, {action.dest: action.help for action in found._choices_actions}


def section(name: str, of_command: argparse.ArgumentParser, described: str) -> list[str]:
    """A command with its arguments."""
    usage = " ".join(str(a.metavar or a.dest) for a in of_command._actions if not a.option_strings)
    lines = [
        f".SS {escaped(f'flankload {name} {usage}'.strip())}",
        escaped(described) + ".",
    ]
    for action in of_command._actions:
        if not isinstance(action, argparse._HelpAction):
            lines += entry(action)
    return lines


def options(of_command: argparse.ArgumentParser) -> list[argparse.Action]:
    """What starts with a dash."""
    return [action for action in of_command._actions if action.option_strings]


def entry(action: argparse.Action) -> list[str]:
    """One argument: its names, its value, its help."""
    value = action.metavar if action.nargs != 0 else None
    if value is None and action.choices:
        value = "{" + ",".join(map(str, action.choices)) + "}"
    name = ", ".join(action.option_strings)
    text = " ".join(part for part in (name, str(value or "")) if part)
    return [".TP", f".B {escaped(text)}", escaped(str(action.help))]


def escaped(text: str) -> str:
    """For roff: dashes that can be copied, ASCII letters only, single percent signs."""
    text = text.replace("%%", "%")
    return text.replace("\\", "\\e").replace("-", "\\-").replace("…", "...")


if __name__ == "__main__":
    PAGE.write_text(manual(), encoding="ascii")
