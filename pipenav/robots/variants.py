"""Robots that differ from a shipped one: `extends = "NAME"` in a robot.toml, above what is different."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipenav.errors import ConfigError, UnknownName, shown
from pipenav.storage import shipped
from pipenav.storage.text_files import merged, read_toml

EXTENDS = "extends"
"""Key by which a robot.toml names the shipped robot that it differs from."""


def robot_names() -> list[str]:
    """Names of the shipped robots."""
    return sorted(path.parent.name for path in shipped.robots_dir().glob("*/robot.toml"))


def completed(table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The description with all that it takes over from the robot that it extends.

    Args:
        table: content of a robot.toml.
        where: name of the file, for messages.

    Raises:
        ConfigError: the robot that it extends is not shipped, or extends another one itself.
        FileProblem: the file of the shipped robot cannot be read.
    """
    own = {key: value for key, value in table.items() if key != EXTENDS}
    if EXTENDS not in table:
        return own
    name = table[EXTENDS]
    if not isinstance(name, str):
        raise ConfigError(f"{where}: extends: input should be the name of a shipped robot, given {shown(name)}.")
    if name not in robot_names():
        raise ConfigError(f"{where}: extends: {UnknownName('robot', name, robot_names())}")
    below = read_toml(shipped.robots_dir() / name / "robot.toml")
    if EXTENDS in below:
        raise ConfigError(f"{where}: extends: robot {name!r} extends {below[EXTENDS]!r} itself: extend that one.")
    return merged(below, own)
