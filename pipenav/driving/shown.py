"""A control step as a screen shows it and as the telemetry holds it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.backends.viewer import HasWindow
from pipenav.driving.door import Door


class Picture(NamedTuple):
    """The robot in its pipe, in the plane in which it bends.

    Attributes:
        label: words for the pipe; empty where it is not known.
        walls: the pipe's walls, (k, 2, 2) [m].
        points: rear end, joints and tip in the same frame, (m, 2) [m].
        target: target of the tip in that frame, (2,) [m]; None where there is none.
    """

    label: str
    walls: Floats
    points: Floats
    target: Floats | None = None


class Shown(NamedTuple):
    """A control step of the first robot, as a screen shows it.

    Attributes:
        picture: the robot in its pipe.
        reading: readings of the sensors, rows of one.
        door: the door.
        seconds: time since the start [s].
        force: largest contact force so far [N].
        world: the simulator, which may have a window; None on the arm.
    """

    picture: Picture
    reading: Reading
    door: Door
    seconds: float
    force: float
    world: HasWindow | None = None


def tick_record(tick: int, door: Door, reading: Reading, force: float | None) -> dict[str, Any]:
    """A control step, as the telemetry holds it: who drove, what was asked for, what the robot was told."""
    asked = {key: value for key, value in door.asked._asdict().items() if value}
    record: dict[str, Any] = {
        "tick": tick,
        "stage": door.who,
        "step": door.step,
        "asked": asked,
        "q": reading.q[0].tolist(),
        "qd": reading.qd[0].tolist(),
        "ranges": reading.ranges[0].tolist(),
        "time": float(reading.time[0]),
        "command": door.command.tolist(),
        "raw": {},
        **door.in_space,
    }
    if reading.wheel_speeds is not None:
        record["wheel_speeds"] = reading.wheel_speeds[0].tolist()
    if force is not None:
        record["force"] = force if np.isfinite(force) else None
    return record
