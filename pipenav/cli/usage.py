"""Wrong usage explained: the text that was given, and the option that it probably belongs to."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from typing import Any

import typer

UsageError: Any = typer.BadParameter.__base__
"""Base of the errors for wrong usage, wherever typer keeps it."""

OPTION_OF = {
    "eval": "--policy",
    "view": "--policy",
    "run-real": "--policy",
    "train": "--preset",
    "gen-pipe": "--route",
    "mirror-rear": "--trajectory",
    "locate-target": "--pipes",
    "calibrate": "--port",
    "hw-check": "--arm",
    "compare-backends": "--robot",
}
"""The option that a word without one most likely belongs to, by command."""

DIAMETER, TAKE_DIAMETER = "--d", ("gen-pipe", "locate-target")

UNITS = {"MM": "mm", "DEG": "deg"}
"""Units of numbers, by the name that help gives their values."""


def explain(error: Any, command: str, args: Sequence[str]) -> None:
    """Add to an error of wrong usage what was given and what to write instead.

    Args:
        error: error of typer, whose message is changed.
        command: name of the command.
        args: arguments as they were typed.
    """
    message = str(error.message)
    if "unexpected extra argument" in message:
        error.message = _lone_word(command, message)
    parameter = getattr(error, "param", None)
    given = None if parameter is None else _given(parameter.opts, args)
    if given is not None and repr(given)[1:-1] not in message:
        unit = UNITS.get(str(getattr(parameter, "metavar", None)))
        write = f": write a number in {unit}, without the unit" if unit else ""
        error.message = f"{message.rstrip('.')}, given {given!r}{write}."


def _lone_word(command: str, message: str) -> str:
    """Advice for words that stand where only options do."""
    found = re.search(r"argument(?:s|\(s\))? \((.*)\)", message)
    words = found[1] if found else message
    option = DIAMETER if command in TAKE_DIAMETER and words[:1].isdigit() else OPTION_OF.get(command)
    if option is None:
        return f"pipenav {command} takes no more arguments, given {words!r}."
    first = shlex.quote(words.split(" ")[0])
    return f"pipenav {command} takes its inputs by options, given {words!r}: try pipenav {command} {option} {first}"


def _given(names: Sequence[str], args: Sequence[str]) -> str | None:
    """The last text that was typed for an option of these names."""
    found = None
    for i, text in enumerate(args):
        if text in names and i + 1 < len(args):
            found = args[i + 1]
        for name in names:
            if text.startswith(f"{name}="):
                found = text.removeprefix(f"{name}=")
    return found
