"""Output in an encoding that lacks some letters: a plain letter is printed in place of an error."""

from __future__ import annotations

import codecs
import io
import sys

PLAIN = {"\N{EN DASH}": "-", "\N{MINUS SIGN}": "-", "\N{HORIZONTAL ELLIPSIS}": "~", "\N{MULTIPLICATION SIGN}": "x"}
"""Plain letters for those that pipenav prints; any other letter becomes a question mark."""

HANDLER = "pipenav.plain"


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(PLAIN.get(letter, "?") for letter in error.object[error.start : error.end]), error.end


def print_plain_letters() -> None:
    """Let stdout and stderr print every text in whatever encoding they have; twice is harmless."""
    codecs.register_error(HANDLER, _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=HANDLER)
