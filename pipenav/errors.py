"""Errors that a user can cause. Each composes one sentence: what was given, what is allowed, what to do."""

from __future__ import annotations

import errno
from collections.abc import Iterable, Sequence
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
        small = {name.lower(): name for name in names}
        like = get_close_matches(given.lower(), small, n=3, cutoff=LIKENESS) if len(given) <= LONGEST_SHOWN else []
        near = [small[name] for name in like]
        choose = f"choose {_either(names)}." if names else "there are none."
        if len(names) > MOST_NAMES:
            choose = f"it is like none of the {len(names)} known ones, which pipenav list shows."
        super().__init__(f"unknown {kind} {shown(given)}: {f'did you mean {_either(near)}?' if near else choose}")


class OutOfRange(PipenavError):
    """A number outside the range that is allowed for it."""

    def __init__(self, what: str, given: float, low: float, high: float, unit: str = "") -> None:
        unit = f" {unit}" if unit else ""
        number = f"{what} {given:g}{unit}"
        if not what[-1:].isalpha():  # length of straight 2, 115 mm, ...: two numbers in a row would run together
            number = f"{what.rstrip(',')}, {given:g}{unit},"
        super().__init__(f"{number} is out of range: choose {low:g} to {high:g}{unit}.")


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
        first = first_problem(error)
        if first["type"] == "extra_forbidden":
            return cls(f"{where}: {UnknownName('key', dotted(first['loc']), known)}")
        more = f" ({error.error_count() - 1} more)" if error.error_count() > 1 else ""
        return cls(f"{where}: {described(first)}{more}.")


class FileProblem(PipenavError):
    """A file that cannot be read or written."""

    def __init__(self, path: Path, doing: str, error: OSError) -> None:
        problem = f"cannot {doing} {shown(path, quoted=False, longest=300)}: {error.strerror or error}"
        remedy = READ_REMEDIES.get(error.errno or 0) if doing == "read" else WRITE_REMEDIES.get(error.errno or 0)
        super().__init__(f"{problem}; {remedy}." if remedy else f"{problem}.")


class BackendUnavailable(PipenavError):
    """A backend that is installed but cannot run here."""

    def __init__(self, name: str, missing: str, remedy: str) -> None:
        super().__init__(f"backend {name!r} cannot run: {missing}; {remedy}.")


READ_REMEDIES = {
    errno.ENOENT: "check its name",
    errno.ENOTDIR: "check its name",
    errno.EISDIR: "give the path of a file",
    errno.EACCES: "give yourself the right to read it",
    errno.ENAMETOOLONG: "check its name",
}
"""Advice where a file cannot be read, by the number of the error."""

_ELSEWHERE = "choose another place"

WRITE_REMEDIES = {
    errno.ENOENT: _ELSEWHERE,
    errno.ENOTDIR: _ELSEWHERE,
    errno.EISDIR: _ELSEWHERE,
    errno.EACCES: f"{_ELSEWHERE}, or give yourself the right to write there",
    errno.EPERM: _ELSEWHERE,
    errno.EROFS: _ELSEWHERE,
    errno.EINVAL: _ELSEWHERE,
    errno.ENAMETOOLONG: "choose a shorter name",
}
"""Advice where a file or a folder cannot be written, by the number of the error."""

SCHEMAS = ("schema", "schema_version")
"""Keys of the versions of formats."""

LIKENESS = 0.6
"""Share of a name's letters, as difflib counts them, that a name must have in common to be suggested."""

MOST_NAMES = 30
"""Most names that a message lists."""

PLAIN_WORDS = (
    (" after validation", ""),
    (", unable to parse string as a number", ""),
    (", unable to parse string as an integer", ""),
    (", got a number with a fractional part", ""),
    ("Tuple should", "List should"),
    ("a valid tuple", "a list"),
    ("a valid list", "a list"),
    ("a valid dictionary", "a table"),
    ("nput was not a valid JSON value", "nput should be a number, a text, true, false or a list of those"),
)
"""Words of pydantic, and what people who write a file call the same."""

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


def first_problem(error: ValidationError) -> Any:
    """The problem that a message names: an unknown key, which a missing one often is by a slip, else the first."""
    problems = error.errors(include_url=False)
    return next((problem for problem in problems if problem["type"] == "extra_forbidden"), problems[0])


def described(problem: Any) -> str:
    """A problem that pydantic found in words: its key, what is allowed there, and what was given."""
    key, given, kind = dotted(problem["loc"]), problem.get("input"), problem["type"]
    where = f"{shown(key, quoted=False)}: " if key else ""
    if kind == "missing":
        return f"{where}this key is missing, add it"
    if kind == "union_tag_invalid":
        tags = [tag.strip("<>") for tag in problem["ctx"]["expected_tags"].replace("'", "").split(", ")]
        return f"{where}unknown kind {shown(problem['ctx']['tag'].strip('<>'))}, choose {_either(tags)}"
    message = plain_words(shown(problem["msg"].removeprefix("Value error, "), quoted=False, longest=500))
    instead = f", given {shown(given)}" if isinstance(given, str | int | float | bool) else ""
    if kind.endswith("_type") and isinstance(given, dict | list | tuple):
        instead = ", given a table" if isinstance(given, dict) else f", given {shown(given)}"
    if kind == "literal_error" and key in SCHEMAS and isinstance(given, int):
        instead += "; a newer pipenav may read it"
    return f"{where}{message[:1].lower()}{message[1:]}{instead}"


def plain_words(message: str) -> str:
    """A message of pydantic in the words of people who write a file."""
    for word, plain in PLAIN_WORDS:
        message = message.replace(word, plain)
    return message.split(" or instance of ")[0]


def dotted(location: Iterable[str | int]) -> str:
    """Key of a value in a configuration, `links.0.length`, from its location as pydantic gives it.

    Parts in angle brackets are left out: they are tags by which models tell kinds of one thing apart.
    """
    return ".".join(part for part in map(str, location) if not part.startswith("<"))


def _restored(kind: type[PipenavError], args: tuple[Any, ...]) -> PipenavError:
    """An error of another process, without composing its message again."""
    return kind.__new__(kind, *args)


def _either(names: Sequence[str]) -> str:
    quoted = [repr(name) for name in names]
    return " or ".join([", ".join(quoted[:-1]), quoted[-1]]) if len(quoted) > 1 else quoted[0]
