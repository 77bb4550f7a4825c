"""Joint, wheel and link types of a robot.toml: numbers that several links share stand once, under a name.

Schema 2 of the file has the tables `[joint_types.NAME]`, `[wheel_types.NAME]` and `[link_types.NAME]`. A joint, a wheel
or a link with `like = "NAME"` takes over every key of that type that it does not give itself. Format:
docs/formats/robot-file.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from pydantic import BaseModel

from pipenav.errors import ConfigError, UnknownName
from pipenav.robots.parts import Joint, Link, Wheel

LIKE = "like"
"""Key under which a joint, a wheel or a link names its type."""

SCHEMAS = (1, 2)
"""Versions of robot.toml that can be read; 1 has no types."""

RESOLVED_SCHEMA = 1
"""Version of a description without types, which is what policy files hold."""


class _Kind(NamedTuple):
    """A kind of type: joint, wheel or link.

    Attributes:
        word: word for the kind in messages.
        table: key of the table that holds its types.
        keys: keys that a type of this kind may give.
    """

    word: str
    table: str
    keys: list[str]


def _kind(name: str, model: type[BaseModel]) -> _Kind:
    own = ("name", "joint", "wheel")  # what each joint, wheel and link says for itself
    return _Kind(f"{name} type", f"{name}_types", [key for key in model.model_fields if key not in own])


KINDS = {name: _kind(name, model) for name, model in (("joint", Joint), ("wheel", Wheel), ("link", Link))}


def resolve_types(table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The description without types, as `RobotSpec` takes it.

    Args:
        table: content of a robot.toml of any schema.
        where: name of the file, for messages.

    Raises:
        ConfigError: unknown schema, unknown type or a key that a type cannot have.
    """
    resolved = dict(table)
    version = resolved.get("schema_version", RESOLVED_SCHEMA)
    if type(version) is not int or version not in SCHEMAS:
        raise ConfigError(f"{where}: schema_version: input should be 1 or 2, given {version!r}.")
    given = resolved.keys() & {kind.table for kind in KINDS.values()}
    if version == 1:
        if given:
            raise ConfigError(f"{where}: [{min(given)}] needs schema_version = 2.")
        return resolved
    types = {name: _types(kind, resolved.pop(kind.table, {}), where) for name, kind in KINDS.items()}
    resolver = _Resolver(types, where)
    resolved["schema_version"] = RESOLVED_SCHEMA
    if isinstance(links := resolved.get("links"), list):
        resolved["links"] = [resolver.link(link, f"links.{i}") for i, link in enumerate(links)]
    if "roll" in resolved:
        resolved["roll"] = resolver.parts(resolved["roll"], "roll")
    return resolved


class _Resolver(NamedTuple):
    """Fills in what links take over from their types. What is no table is left for the model to complain about.

    Attributes:
        types: types by kind and name.
        where: name of the file, for messages.
    """

    types: Mapping[str, Mapping[str, Mapping[str, Any]]]
    where: str

    def link(self, given: Any, key: str) -> Any:
        """A link, its joint and its wheel, each with the keys of its type."""
        return self.parts(self._filled("link", given, key), key)

    def parts(self, owner: Any, key: str) -> Any:
        """A link or the roll, its joint and its wheel with the keys of their types."""
        if not isinstance(owner, Mapping):
            return owner
        kinds = [kind for kind in ("joint", "wheel") if kind in owner]
        return {**owner, **{kind: self._filled(kind, owner[kind], f"{key}.{kind}") for kind in kinds}}

    def _filled(self, kind: str, given: Any, key: str) -> Any:
        """A table with the keys of its type that it does not give itself."""
        if not isinstance(given, Mapping) or LIKE not in given:
            return given
        name, known = given[LIKE], self.types[kind]
        if not isinstance(name, str) or name not in known:
            raise ConfigError(f"{self.where}: {key}.{LIKE}: {UnknownName(KINDS[kind].word, str(name), known)}")
        return {**known[name], **{own: value for own, value in given.items() if own != LIKE}}


def _types(kind: _Kind, tables: Any, where: str) -> dict[str, Mapping[str, Any]]:
    """The types of one kind by name, with no key that the kind does not have."""
    named = tables if isinstance(tables, Mapping) else {"": tables}
    for name, table in named.items():
        if not isinstance(table, Mapping):
            raise ConfigError(f"{where}: {kind.table} must hold one table per type, as in [{kind.table}.NAME].")
        unknown = [key for key in table if key not in kind.keys]
        if unknown:
            known = [f"{kind.table}.{name}.{key}" for key in kind.keys]
            raise ConfigError(f"{where}: {UnknownName('key', f'{kind.table}.{name}.{unknown[0]}', known)}")
    return dict(named)
