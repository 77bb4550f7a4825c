"""Text files, which may come from a stranger or be damaged: sized up before a parser sees them. TOML and JSON.

Every reader of text goes through here. A file is read only if it is a plain one and not larger than its format needs;
a byte order mark and Windows line ends are taken off; what would make a parser crash, hang or fill the memory is
refused first: deep nesting, endless numbers and endless dotted keys.
"""

from __future__ import annotations

import json
import os
import re
import stat
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipenav.errors import ConfigError, FileProblem, shown

MAX_SETTINGS = 256 << 10
"""Largest file of settings that a person writes [bytes]: forty times the longest that is shipped."""

MAX_RECORD = 8 << 20
"""Largest JSON record that pipenav writes [bytes]: an evaluation of ten thousand pipes."""

MAX_TABLE = 8 << 20
"""Largest table of a training's progress [bytes]: some fifty thousand rows."""

MAX_DEPTH = 100
"""Most tables or lists inside each other, and most parts of a dotted key."""

MAX_NUMBER = 1000
"""Most characters of a number: Python itself refuses whole numbers of more than 4,300 digits."""

WHOLE_NUMBERS = (-(2**63), 2**63 - 1)
"""Whole numbers that TOML defines, and that other programs can read."""

_TOML_QUOTED = re.compile(
    r'"""(?:[^\\]|\\.)*?(?:"""|\Z)|' + r"'''.*?(?:'''|\Z)|" + r'"(?:[^"\\\n]|\\.)*+"?|' + r"'[^'\n]*+'?|#[^\n]*+",
    re.DOTALL,
)
_JSON_QUOTED = re.compile(r'"(?:[^"\\]|\\.)*+"?', re.DOTALL)
_LONG_NUMBER = re.compile(rf"(?<![\w.+-])[+-]?(?:0[xob]\w|\d)[\w.+-]{{{MAX_NUMBER},}}")
_LONG_KEY = re.compile(rf"(?<![\w.-])[\w-]++(?:[ \t]*+\.[ \t]*+[\w-]++){{{MAX_DEPTH},}}")


def read_bytes(path: Path, limit: int) -> bytes:
    """Content of a plain file of at most `limit` bytes.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is a folder, a device or a pipe, or it is larger.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))  # a pipe would wait for its writer
        with os.fdopen(descriptor, "rb") as file:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise ConfigError(f"{shown_path(path)} is not a plain file: give the path of one.")
            content = file.read(limit + 1)
    except OSError as error:
        raise FileProblem(path, "read", error) from error
    except ValueError as error:  # a name with a null byte in it
        raise ConfigError(f"{shown_path(path)} is not a possible file name: {error}.") from error
    if len(content) > limit:
        raise ConfigError(
            f"{shown_path(path)} is larger than {_size(limit)}, the limit for files of its kind: give another file."
        )
    return content


def read_text(path: Path, limit: int = MAX_SETTINGS) -> str:
    """Text of a plain UTF-8 file without byte order mark, lines ending in a line feed alone.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is no plain file, is larger than `limit` bytes, or is no text.
    """
    return as_text(read_bytes(path, limit), shown_path(path))


def as_text(content: bytes, where: str) -> str:
    """Text of some bytes in UTF-8, as `read_text` gives it; `where` names them in messages."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        problem = f"byte {error.start + 1} is not part of a character"
        raise ConfigError(f"{where} is not text in UTF-8: {problem}; give a text file.") from error
    return text.replace("\r\n", "\n")


def read_toml(path: Path, limit: int = MAX_SETTINGS) -> dict[str, Any]:
    """A TOML file as a table.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is no plain file, is too large, or is no TOML.
    """
    return parse_toml(read_text(path, limit), shown_path(path))


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """TOML as a table; `where` names it in messages.

    Raises:
        ConfigError: it is no TOML, or it is made to break its reader.
    """
    _check_lexically(_TOML_QUOTED.sub("_", text), where)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a ValueError also for a date such as 2000-13-01
        problem = f"{shown(error, quoted=False).rstrip('.')}; correct it there, or give another file"
        raise ConfigError(f"{where} is not valid TOML: {problem}.") from error
    _check_values(table, where)
    return table


def read_json(path: Path, limit: int = MAX_RECORD) -> Any:
    """Content of a JSON file.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is no plain file, is too large, or is no JSON.
    """
    return parse_json(read_text(path, limit), shown_path(path))


def parse_json(text: str, where: str) -> Any:
    """Content of a JSON text; `where` names it in messages.

    Raises:
        ConfigError: it is no JSON, or it is made to break its reader.
    """
    _check_lexically(_JSON_QUOTED.sub("_", text), where)
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        problem = f"{shown(error, quoted=False).rstrip('.')}; correct it there, or give another file"
        raise ConfigError(f"{where} is not valid JSON: {problem}.") from error
    _check_values(content, where)
    return content


def checked_json(text: str, where: str) -> str:
    """The same JSON text, for a reader of its own, after every check that `parse_json` makes.

    Raises:
        ConfigError: it is no JSON, or it is made to break its reader.
    """
    parse_json(text, where)
    return text


def shown_path(path: Path) -> str:
    """A path for a message, cut in its middle where it is long."""
    return shown(path, quoted=False, longest=300)


def _check_lexically(bare: str, where: str) -> None:
    """Refuse what parsers fail at; strings and comments are taken out of the text already."""
    depth = 0
    for bracket in re.finditer(r"[\[\]{}]", bare):
        depth += 1 if bracket[0] in "[{" else -1
        if depth > MAX_DEPTH:
            raise ConfigError(f"{where} holds more than {MAX_DEPTH} lists or tables inside each other.")
    if _LONG_NUMBER.search(bare):
        raise ConfigError(f"{where} holds a number of more than {MAX_NUMBER} characters.")
    if _LONG_KEY.search(bare):
        raise ConfigError(f"{where} holds a dotted key of more than {MAX_DEPTH} parts.")


def _check_values(content: Any, where: str) -> None:
    """Refuse whole numbers that no float can hold exactly enough, and what nests too deeply all in all."""
    level, depth = [content], 0
    while level:
        depth += 1
        if depth > MAX_DEPTH + 1:
            raise ConfigError(f"{where} holds more than {MAX_DEPTH} lists or tables inside each other.")
        inner: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                inner += value.values()
            elif isinstance(value, list):
                inner += value
            elif isinstance(value, int) and not WHOLE_NUMBERS[0] <= value <= WHOLE_NUMBERS[1]:
                raise ConfigError(
                    f"{where} holds the whole number {shown(value)}: the largest that is allowed is 2^63 - 1."
                )
        level = inner


def _size(limit: int) -> str:
    return f"{limit >> 20} MiB" if limit >= 1 << 20 else f"{limit >> 10} KiB"


def merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Two tables as one, key by key; `above` counts where both have a value."""
    both = dict(below)
    for key, value in above.items():
        nested = isinstance(value, Mapping) and isinstance(both.get(key), Mapping)
        both[key] = merged(both[key], value) if nested else value
    return both
