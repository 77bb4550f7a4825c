"""Lines of the text files that networks come in, read through pipenav's one reader."""

from __future__ import annotations

from pathlib import Path

from pipenav.errors import ConfigError
from pipenav.storage.text_files import as_text, parse_json, read_bytes, shown_path

MAX_NETWORK = 128 << 20
"""Largest file of a network [bytes]: a million lines."""


def network_text(path: Path) -> str:
    """Text of a network's file; in Windows' western letters where it is not UTF-8, as older programs write it.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is no plain file, too large, or no text.
    """
    content = _content(path)
    if b"\0" in content[: 1 << 16]:
        raise ConfigError(f"{shown_path(path)} is not text: give a file of the format that its ending names.")
    try:
        return as_text(content, shown_path(path))
    except ConfigError:
        return content.decode("cp1252", errors="replace").replace("\r\n", "\n")


def network_json(path: Path) -> object:
    """Content of a network's JSON file.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is no plain file, too large, or no JSON.
    """
    return parse_json(as_text(_content(path), shown_path(path)), shown_path(path))


def _content(path: Path) -> bytes:
    content = read_bytes(path, MAX_NETWORK)
    if not content.strip():
        raise ConfigError(f"{shown_path(path)} is empty: give the file of a network.")
    return content
