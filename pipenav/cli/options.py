"""Options that several commands share."""

from __future__ import annotations

from typing import Any

from pipenav.errors import PipenavError


def parse_options(given: list[str]) -> dict[str, Any]:
    """`key=value` texts as a table; values as in TOML."""
    from pipenav.learning.config import toml_value

    options = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals:
            raise PipenavError(f"option {text!r} has no value: write it as key=value, for example timestep=0.001.")
        options[key.strip()] = toml_value(value.strip())
    return options
