"""Facts that the ticks of a telemetry hold besides their numbers: when they were, and how the servos did."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.real_robot import ServoHealth, load_real_robot
from pipenav.robots.robot import RobotSpec


def tick_seconds(tick: Mapping[str, Any]) -> float:
    """Time of a tick since the start; by its number where it has no time [s]."""
    time = tick.get("time", tick["raw"].get("time"))
    return float(time) if isinstance(time, int | float) and math.isfinite(time) else CONTROL_PERIOD * tick["tick"]


def servo_health(
    header: Mapping[str, Any], robot: RobotSpec
) -> Callable[[Mapping[str, Any]], Sequence[ServoHealth | None]]:
    """The function that finds the servos' health in the `raw` of a tick: None for each where no servo was read.

    Args:
        header: header of the telemetry.
        robot: its robot.
    """
    nothing = [None] * len(robot.joints)
    if not isinstance(header.get("machine"), Mapping) or "arm" not in header["machine"]:
        return lambda _raw: nothing
    servos = load_real_robot(header.get("backend", "hardware")).recoder(robot, header["machine"]).servos
    return lambda raw: servos(raw) if raw.get("states") else nothing
