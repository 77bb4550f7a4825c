"""The keys of a configuration's file, from its model: dotted, with default and meaning."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, NamedTuple, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo


class Key(NamedTuple):
    """A key of a configuration's file: `learner.epochs`, its default as JSON, and its meaning."""

    name: str
    default: str
    meaning: str


class _Inner(NamedTuple):
    """A table inside a table: its model, and what stands between the key and those of the table."""

    model: type[BaseModel]
    mark: str


def keys_of(model: type[BaseModel], before: str = "") -> Iterator[Key]:
    """Every key of a model and of the tables in it, each once, in the order of the models.

    Args:
        model: pydantic model of the file.
        before: dotted keys of the tables around it.
    """
    seen = set()
    for name, field in model.model_fields.items():
        key = f"{before}{field.alias or name}"
        inner = list(_inner_tables(field.annotation))
        if not inner:
            yield Key(key, _default(field), field.description or "")
        for table in inner:
            for found in keys_of(table.model, f"{key}{table.mark}."):
                if found.name not in seen:
                    seen.add(found.name)
                    yield found


def _inner_tables(annotation: Any, mark: str = "") -> Iterator[_Inner]:
    """The models in an annotation, through optional values, alternatives, lists and dictionaries."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield _Inner(annotation, mark)
        return
    origin = get_origin(annotation)
    mark += {tuple: "[]", list: "[]", dict: ".NAME"}.get(origin, "")
    for part in get_args(annotation):
        yield from _inner_tables(part, mark)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    default = field.get_default(call_default_factory=True)
    return "not set" if default is None else json.dumps(default)
