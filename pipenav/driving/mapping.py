"""Mappings from keys, buttons, sticks and faders to actions, as TOML files hold them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from pipenav.arrays import Table
from pipenav.driving.primitives import PRIMITIVES
from pipenav.driving.steps import STEPS
from pipenav.errors import ConfigError, PipenavError, shown
from pipenav.robots.robot import RobotSpec
from pipenav.storage import shipped
from pipenav.storage.text_files import read_toml

Device = Literal["keyboard", "gamepad", "midi"]

TAPS = (*(f"step-{step}" for step in STEPS), *PRIMITIVES, "halt", "hand-back", "stop", "end")
"""Actions of one press."""

HELD = ("tip-forward", "tip-back", "tip-left", "tip-right", "wheels+", "wheels-")
"""Actions while a key or button is held, besides `NAME+` and `NAME-` of every joint."""

ANALOGUE = ("tip-along", "tip-left", "wheels")
"""Actions of a stick or fader, besides every joint's name."""

CONTROLS = {
    "keyboard": re.compile(r"up|down|left|right|space|enter|tab|esc|backspace|[!-~]"),
    "gamepad": re.compile(r"axis\d{1,2}-?|button\d{1,2}"),
    "midi": re.compile(r"cc\d{1,3}|note\d{1,3}"),
}
"""Names of the controls of each device: `axis0-` is a stick the other way round."""

EXAMPLES = {
    "keyboard": "a letter, up, down, left, right, space, enter, tab, esc or backspace",
    "gamepad": "axis0, axis0- or button0",
    "midi": "cc0 or note36",
}
"""Words for such names."""


class MappingTable(Table):
    """A file of mappings: for each device, the action of every control."""

    keyboard: dict[str, str] = Field({}, description="action of each key")
    gamepad: dict[str, str] = Field({}, description="action of each stick's axis and of each button")
    midi: dict[str, str] = Field({}, description="action of each fader, by its controller number, and of each note")


def load_mapping(path: Path | None, robot: RobotSpec, device: Device) -> dict[str, str]:
    """Action of every control of a device, with joints by their names.

    Args:
        path: the TOML file; None for the shipped one, without the joints that the robot lacks.
        robot: the robot.
        device: the device.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no mapping.
        PipenavError: it names an unknown control, action or joint, or two controls for one action, or nothing at all.
    """
    file = path or shipped.mappings_dir() / ("whole.toml" if robot.free else "arm.toml")
    try:
        table = MappingTable.model_validate(read_toml(file))
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error, MappingTable.model_fields) from error
    numbers = {f"joint{i}": joint.name for i, joint in enumerate(robot.joints, 1)}
    given: Mapping[str, str] = getattr(table, device)
    if path is None:
        given = {control: action for control, action in given.items() if _fits(action, numbers)}
    if not given:
        raise PipenavError(f"{file} maps nothing of the {device}: write a table [{device}] into it.")
    mapped: dict[str, str] = {}
    for control, action in given.items():
        if not CONTROLS[device].fullmatch(control):
            raise PipenavError(f"{file}: the {device} has no {control!r}: write {EXAMPLES[device]}.")
        named = _named(action, numbers)
        _check(file, device, control, named, robot)
        before = next((c for c, a in mapped.items() if a == named), None)
        if before is not None:
            raise PipenavError(
                f"{file}: {before!r} and {control!r} of the {device} both do {action!r}: give it one of them."
            )
        mapped[control] = named
    return mapped


def legend(mapping: Mapping[str, str]) -> Iterator[str]:
    """Each control with its action, as the screen shows it."""
    for control, action in mapping.items():
        yield f"{control} {action}"


def _fits(action: str, numbers: Mapping[str, str]) -> bool:
    number = re.fullmatch(r"(joint\d+)[+-]?", action)
    return number is None or number[1] in numbers


def _named(action: str, numbers: Mapping[str, str]) -> str:
    """The action with its joint by name: `joint2+` is `theta1+` of an arm."""
    number = re.fullmatch(r"(joint\d+)([+-]?)", action)
    return action if number is None or number[1] not in numbers else numbers[number[1]] + number[2]


def _check(file: Path, device: Device, control: str, action: str, robot: RobotSpec) -> None:
    """Refuse an action that the control cannot do.

    Raises:
        PipenavError: there is no such action or joint.
    """
    joints = [joint.name for joint in robot.joints]
    turned = joints if robot.roll is None else [*joints, robot.roll.joint.name]
    analogue = control.startswith(("axis", "cc"))
    known = [*ANALOGUE, *joints] if analogue else [*TAPS, *HELD, *(name + sign for name in turned for sign in "+-")]
    if action in known:
        return
    if re.fullmatch(r"joint\d+[+-]?", action):
        raise PipenavError(
            f"{file}: {control!r} of the {device} names {action!r}, and robot {robot.name!r} has {len(joints)} joints: "
            f"{', '.join(joints)}."
        )
    near = get_close_matches(action, known, n=1)
    others = "a joint" if analogue else "a joint with + or -"
    choose = f"did you mean {near[0]!r}?" if near else f"choose {', '.join(ANALOGUE if analogue else TAPS + HELD)}, or "
    raise PipenavError(
        f"{file}: {control!r} of the {device} names an unknown action, {shown(action)}: {choose}"
        + ("" if near else f"{others}.")
    )
