"""The device by which a person drives."""

from __future__ import annotations

import contextlib
import sys
from typing import TYPE_CHECKING

from pipenav.cli.drive_options import DriverOptions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pipenav.driving.ask import Operator
    from pipenav.robots.robot import RobotSpec


def person(opened: contextlib.ExitStack, driver: DriverOptions, robot: RobotSpec) -> tuple[Operator, Mapping[str, str]]:
    """A person's device, open until `opened` is closed, and its mapping.

    Raises:
        PipenavError: there is no such device, or the mapping does not fit.
    """
    from pipenav.driving.gamepad import Gamepad
    from pipenav.driving.keyboard import Keyboard
    from pipenav.driving.mapping import load_mapping
    from pipenav.driving.midi import Faders, open_port

    mapping = load_mapping(driver.mapping, robot, driver.input)
    if driver.input == "keyboard":
        return opened.enter_context(Keyboard(mapping, _stdin())), mapping
    if driver.input == "gamepad":
        return opened.enter_context(Gamepad(mapping, driver.device)), mapping
    return opened.enter_context(Faders(mapping, robot, open_port(driver.device))), mapping


def _stdin() -> int:
    """File descriptor of stdin; -1, which is no terminal, where there is none."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return -1
