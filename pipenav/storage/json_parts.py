"""Large JSON as text in parts, so that neither all of the data nor all of the text need be in memory at once."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

_ENCODER = json.JSONEncoder(separators=(",", ":"), allow_nan=False)


def json_parts(table: Mapping[str, Any]) -> Iterator[str]:
    """Text of a table, equal to that of `json.dumps` without spaces.

    Args:
        table: values that JSON can hold; lists, and iterators, which stand for lists, are made entry by entry.

    Raises:
        ValueError: a number is not finite.
    """
    before = "{"
    for key, value in table.items():
        yield f"{before}{_ENCODER.encode(key)}:"
        if isinstance(value, Iterator | list):
            yield from _list_parts(value)
        else:
            yield _ENCODER.encode(value)
        before = ","
    yield "}" if table else "{}"


def _list_parts(entries: Iterator[Any] | list[Any]) -> Iterator[str]:
    before = "["
    for entry in entries:
        yield before + _ENCODER.encode(entry)
        before = ","
    yield "]" if before == "," else "[]"
