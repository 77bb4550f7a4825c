"""Wrong usage explained: the text that was given, and the option that it probably belongs to."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from typing import Any, NamedTuple

import typer

from pipenav.errors import LIKENESS, plain_words

UsageError: Any = typer.BadParameter.__base__
"""Base of the errors for wrong usage, wherever typer keeps it."""

OPTION_OF = {
    "eval": "--policy",
    "view": "--policy",
    "run-real": "--policy",
    "train": "--preset",
    "tune": "--space",
    "gen-pipe": "--route",
    "mirror-rear": "--trajectory",
    "locate-target": "--pipes",
    "calibrate": "--port",
    "hw-check": "--arm",
}
"""The option that a word without one most likely belongs to, by command."""

DIAMETER, ANGLE, TAKE_DIAMETER = "--d", "--angle", ("gen-pipe", "locate-target")

UNITS = {"MM": "mm", "DEG": "deg"}
"""Units of numbers, by the name that help gives their values."""


EMPTY = "is given an empty text: give it a value, or leave it out."
"""Advice for an option without a text."""


class _Typed(NamedTuple):
    """An option as it was typed, with its value; None for an option that takes none."""

    option: Any
    value: str | None


def check_typed(context: Any, args: Sequence[str]) -> None:
    """Refuse options of which only the last would count, and options without a text.

    Args:
        context: context of the command.
        args: arguments as they were typed.

    Raises:
        UsageError: with the option.
    """
    typed = list(_typed(context.command, args))
    for one in typed:
        if one.value is not None and not one.value.strip():
            raise UsageError(f"{one.option.opts[0]} {EMPTY}", context)
    counts = Counter(one.option.opts[0] for one in typed if not one.option.multiple)
    for name, count in counts.items():
        if count > 1:
            values = [shlex.quote(one.value) for one in typed if one.option.opts[0] == name and one.value is not None]
            given = f", {' and '.join(values)}" if values else ""
            raise UsageError(f"{name} is given {count} times{given}: give it once.", context)


def explain(error: Any, command: Any, args: Sequence[str]) -> None:
    """Add to an error of wrong usage what was given and what to write instead.

    Args:
        error: error of typer, whose message is changed.
        command: the command.
        args: arguments as they were typed.
    """
    error.message = plain_words(str(error.message)).replace("Value error, ", "")
    lone = _lone_words(error, command, args)
    parameter = getattr(error, "param", None)
    if lone:
        error.message = _advice(command, lone, args)
        error.format_message = lambda: error.message
    elif hasattr(error, "possibilities"):
        error.message = _unknown_option(error.option_name, command)
        error.possibilities = None
    elif "requires an argument" in error.message:
        error.message = f"{error.message.rstrip('.')}: write its value behind it."
    elif hasattr(error, "param_type"):
        missing = f"{error.format_message().rstrip('.')}; see pipenav {command.name} --help for an example."
        error.format_message = lambda: missing
    elif parameter is not None and (given := _given(parameter.opts, args)) is not None:
        error.message = _wrong_value(error.message, parameter, given)
        if not given.strip():
            error.format_message = lambda: f"{parameter.opts[0]} {EMPTY}"


def _wrong_value(message: str, parameter: Any, given: str) -> str:
    """The message about a value, with what was given."""
    if repr(given)[1:-1] in message:
        return message
    unit = UNITS.get(str(getattr(parameter, "metavar", None)))
    write = f": write a number in {unit}, without the unit" if unit else ""
    if re.fullmatch(r"[+-]?\d+,\d+", given):
        write = f": write it with a point, {given.replace(',', '.')}"
    return f"{message.rstrip('.')}, given {given!r}{write}."


def _unknown_option(name: str, command: Any) -> str:
    """Advice for an option that the command has not."""
    known = [text.removeprefix("--") for parameter in command.params for text in parameter.opts if text[:2] == "--"]
    word = name.lstrip("-").lower()
    near = [text for text in known if word and text.startswith(word)]
    near += get_close_matches(word, known, n=1, cutoff=LIKENESS)
    near += [text for text in known if word.startswith(text)]
    if near:
        return f"unknown option {name}: did you mean --{near[0]}?"
    return f"unknown option {name}: see {_typed_as(command)} --help for those that there are."


def _typed_as(command: Any) -> str:
    return "pipenav" if hasattr(command, "commands") else f"pipenav {command.name}"


def _lone_words(error: Any, command: Any, args: Sequence[str]) -> list[str]:
    """Words that stand where only options do; none where something else is wrong."""
    found = re.search(r"unexpected extra argument(?:s|\(s\))? \((.*)\)", error.message)
    if found:
        return str(found[1]).split(" ")
    if hasattr(error, "param_type") and error.param is not None and error.param.param_type_name == "option":
        rest = [text for text in args[:1] if not text.startswith("-")]
        return rest if command.name in OPTION_OF else []
    return []


def _advice(command: Any, words: Sequence[str], args: Sequence[str]) -> str:
    """Advice for words that stand where only options do."""
    name, given = command.name, " ".join(words)
    option = OPTION_OF.get(name)
    if option is None:
        return f"pipenav {name} takes no more arguments, given {given!r}: leave out what is too much."
    typed = {one.option.opts[0]: one for one in _typed(command, args)}
    before = args[args.index(words[0]) - 1] if words[0] in args[1:] else ""
    if before in typed and typed[before].value is None:
        return f"{before} takes no value, given {given!r}: leave that out."
    example = [option, words[0]]
    if name in TAKE_DIAMETER and words[0][:1].isdigit():
        example = [DIAMETER, words[0], *([ANGLE, words[1]] if len(words) > 1 else [])]
        if DIAMETER in typed:
            example = [ANGLE, words[0]]
    takes = f"pipenav {name} takes its inputs by options, given {given!r}"
    if example[0] in typed and not typed[example[0]].option.multiple:
        return f"{takes}: a value with a blank in it is written in quotes, and pipenav {name} --help shows the options."
    kept = [word for one in _typed(command, args) for word in (one.option.opts[0], one.value) if word is not None]
    return f"{takes}: try {shlex.join(['pipenav', name, *kept, *example])}"


def _typed(command: Any, args: Sequence[str]) -> Iterator[_Typed]:
    """The options that were typed, in order."""
    options = {name: parameter for parameter in command.params for name in parameter.opts if name.startswith("-")}
    words = iter(args)
    for text in words:
        name, equals, value = text.partition("=")
        if text == "--":
            return
        if name in options:
            takes = not getattr(options[name], "is_flag", False)
            yield _Typed(options[name], (value if equals else next(words, None)) if takes else None)


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
