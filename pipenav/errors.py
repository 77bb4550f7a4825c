"""Errors that a user can cause. Each composes one sentence: what was given, what is allowed, what to do."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import ValidationError

__all__ = [
    "BackendUnavailable",
    "ConfigError",
    "FileProblem",
    "OutOfRange",
    "PipenavError",
    "UnknownName",
    "shown",
]


class PipenavError(Exception):
    """Base of every error that the command line prints as one line, with exit code 1."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), self.args), self.__dict__  # the message is composed, whatever made it


class UnknownName(PipenavError):
    """A name that is not among the known ones."""

    def __init__(self, kind: str, given: str, known: Iterable[str]) -> None:
        names = sorted(known)
        near = get_close_matches(given, names, n=3, cutoff=0.5) if len(given) <= LONGEST_SHOWN else []
        choose = f"choose {_either(names)}." if names else "there are none."
        super().__init__(f"unknown {kind} {shown(given)}: {f'did you mean {_either(near)}?' if near else choose}")


class OutOfRange(PipenavError):
    """A number outside the range that is allowed for it."""

    def __init__(self, what: str, given: float, low: float, high: float, unit: str = "") -> None:
        unit = f" {unit}" if unit else ""
        super().__init__(f"{what} {given:g}{unit} is out of range: choose {low:g} to {high:g}{unit}.")


class ConfigError(PipenavError):
    """A configuration that does not fit its schema."""

    @classmethod
    def from_validation(cls, where: str, error: ValidationError, known: Iterable[str] = ()) -> ConfigError:
        """The first problem that pydantic found, as one sentence.

        Args:
            where: name of the file, or other words for the configuration.
            error: error that pydantic raised.
            known: keys that exist, to suggest the nearest one for an unknown key.
        """
        first = error.errors(include_url=False)[0]
        key = dotted(first["loc"]) or "the value"
        if first["type"] == "extra_forbidden":
            return cls(f"{where}: {UnknownName('key', key, known)}")
        more = f" ({error.error_count() - 1} more)" if error.error_count() > 1 else ""
        given = first.get("input")
        instead = f", given {shown(given)}" if isinstance(given, str | int | float | bool) else ""
        message = shown(first["msg"].removeprefix("Value error, "), quoted=False, longest=500)
        return cls(f"{where}: {shown(key, quoted=False)}: {message[:1].lower()}{message[1:]}{instead}{more}.")


class FileProblem(PipenavError):
    """A file that cannot be read or written."""

    def __init__(self, path: Path, doing: str, error: OSError) -> None:
        super().__init__(f"cannot {doing} {shown(path, quoted=False, longest=300)}: {error.strerror or error}.")


class BackendUnavailable(PipenavError):
    """A backend that is installed but cannot run here."""

    def __init__(self, name: str, missing: str, remedy: str) -> None:
        super().__init__(f"backend {name!r} cannot run: {missing}; {remedy}.")


LONGEST_SHOWN = 100
"""Most characters of a given value in a message."""


def shown(value: object, quoted: bool = True, longest: int = LONGEST_SHOWN) -> str:
    """A value for a message: on one line, without control characters, its middle left out where it is long."""
    try:
        text = repr(value) if quoted else str(value)
    except (ValueError, RecursionError):  # a whole number of thousands of digits, or a value that nests too deeply
        return "a value that is too long to be shown"
    text = " ".join(text.splitlines())
    if len(text) > longest:
        text = f"{text[: longest // 2]}...{text[-(longest // 3) :]}"
    return "".join(letter if letter.isprintable() else "?" for letter in text)


def dotted(location: Iterable[str | int]) -> str:
    """Key of a value in a configuration, `links.0.length`, from its location as pydantic gives it.

    Parts in angle brackets are left out: they are tags by which models tell kinds of one thing apart.
    """
    return ".".join(part for part in map(str, location) if not part.startswith("<"))


def _restored(kind: type[PipenavError], args: tuple[Any, ...]) -> PipenavError:
    """An error of another process, without composing its message again."""
    return kind.__new__(kind, *args)


def _either(names: list[str]) -> str:
    quoted = [repr(name) for name in names]
    return " or ".join([", ".join(quoted[:-1]), quoted[-1]]) if len(quoted) > 1 else quoted[0]
