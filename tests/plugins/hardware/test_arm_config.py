"""The arm's description, the arithmetic between wire and robot, and the beams: without a wire."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.arm import ARM, ROBOT
from pipenav_hardware.arm_config import arm_toml, load_arm
from pipenav_hardware.servo_config import PINION_TRAVEL

from pipenav.errors import ConfigError


def changed(servo: int, **values: Any) -> dict[str, Any]:
    table_ = ARM.model_dump()
    servos = [dict(one) for one in table_["servos"]]
    servos[servo] |= values
    return table_ | {"servos": servos}


def test_a_description_survives_its_file(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(arm_toml(ARM))
    assert load_arm(path) == ARM
    ARM.require(ROBOT)


@pytest.mark.parametrize(
    ("table_", "message"),
    [
        (changed(0, upper_mm=400.0), "a pinion of 75 mm radius moves the rack 390 mm at most"),
        (changed(0, pinion_radius_mm=60.0), "moves the rack 312 mm at most"),
        (changed(1, upper_deg=160.0), "allowed are 4 to 1019"),
        (changed(1, zero_count=900.0), "mount the servo so that 0 lies elsewhere"),
        (changed(1, lower_deg=10.0), "must lie strictly between the limits"),
        (changed(1, id=1), "two servos have the same id"),
        (changed(1, id=254), "less than or equal to 252"),
        (changed(1, sign=0), "input should be 1 or -1"),
        (changed(1, torque_limit_percent=100.0), "less than 100"),
        (ARM.model_dump() | {"baud": 300_000}, "baud 300000 is not one of 9600, 19200"),
    ],
)
def test_an_impossible_arm_is_refused_in_a_sentence(tmp_path: Path, table_: dict[str, Any], message: str) -> None:
    path = tmp_path / "arm.toml"
    text = arm_toml(ARM.model_construct(**table_)) if False else _as_toml(table_)
    path.write_text(text)
    with pytest.raises(ConfigError) as refused:
        load_arm(path)
    assert message.lower() in str(refused.value).lower()


def _as_toml(table_: dict[str, Any]) -> str:
    class Plain:
        def model_dump(self, exclude_none: bool) -> dict[str, Any]:  # noqa: ARG002  # as pydantic's
            return {key: value for key, value in table_.items() if value is not None}

    return arm_toml(Plain())  # type: ignore[arg-type]


def test_a_missing_or_broken_description_says_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="write one with pipenav calibrate"):
        load_arm(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_text("servos = [")
    with pytest.raises(ConfigError, match="not valid TOML"):
        load_arm(tmp_path / "bad.toml")
    (tmp_path / "more.toml").write_text(arm_toml(ARM).replace('robot = "basic"', 'robot = "basic"\nrobto = 1'))
    with pytest.raises(ConfigError, match="unknown key 'robto'"):
        load_arm(tmp_path / "more.toml")


def test_an_arm_of_another_robot_is_refused() -> None:
    with pytest.raises(ConfigError, match="this arm is a 'other', not a 'basic'"):
        ARM.model_copy(update={"robot": "other"}).require(ROBOT)
    swapped = ARM.model_copy(update={"servos": (ARM.servos[0], ARM.servos[2], ARM.servos[1], ARM.servos[3])})
    with pytest.raises(ConfigError, match="servos move l, theta2, theta1, theta3"):
        swapped.require(ROBOT)


def test_the_rack_is_as_long_as_a_single_turn_allows() -> None:
    slide = ARM.servos[0]
    assert slide.unit == pytest.approx(0.075)
    assert slide.limits[1] - slide.limits[0] <= PINION_TRAVEL * slide.unit < 5.236 * slide.unit
