"""The motion in a telemetry, in the robot's own frame: a telemetry does not know where the robot stood in its pipe."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from pipenav.deployment.picture import drawable
from pipenav.deployment.plan import POLICY_COPY
from pipenav.deployment.telemetry import Recording
from pipenav.deployment.ticks import servo_health, tick_seconds
from pipenav.errors import PipenavError
from pipenav.policies.policy import load_policy
from pipenav.recording.posed_motion import PosedMotion, plane_motion
from pipenav.robots.robot import BASE, RobotSpec, load_robot


def robot_of(path: Path, header: Mapping[str, Any]) -> RobotSpec | None:
    """Robot of a telemetry: the one in it, that of the policy beside it, or the one that it names; None without any.

    Args:
        path: file of the telemetry.
        header: its first line.
    """
    copy = path.with_name(POLICY_COPY)
    try:
        if "robot_file" in header:
            return RobotSpec.model_validate_json(json.dumps(header["robot_file"]))
        return load_policy(copy).header.robot if copy.exists() else load_robot(str(header.get("robot")))
    except (PipenavError, ValidationError):
        return None


def posed_telemetry(recording: Recording, robot: RobotSpec) -> PosedMotion | None:
    """The motion in a telemetry; None where no tick has a pose of this robot.

    Of a free robot a telemetry has the joints alone: its rear end stays where it is.
    """
    ticks = [tick for tick in (_with_base(tick, robot) for tick in recording.ticks) if drawable(tick, robot)]
    if not ticks:
        return None
    q, ranges = np.array([tick["q"] for tick in ticks]), np.array([tick["ranges"] for tick in ticks])
    times = np.maximum.accumulate([tick_seconds(tick) for tick in ticks])
    target = next((tick["target"] for tick in reversed(ticks) if tick.get("target")), None)
    return plane_motion(
        robot,
        q,
        0.0,
        ranges,
        name=str(recording.header.get("robot")),
        walls=[],
        time=times,
        target=None if target is None else np.array([*target, 0.0]),
        series=_series(recording, robot, ticks),
        events=_events(recording, ticks),
    )


def _with_base(tick: dict[str, Any], robot: RobotSpec) -> dict[str, Any]:
    """A tick whose positions begin with a resting base, if its robot is free and it has none."""
    q = tick.get("q")
    if not robot.free or not isinstance(q, list) or len(q) != len(robot.joints):
        return tick
    return {**tick, "q": [0.0] * len(BASE) + q}


def _series(recording: Recording, robot: RobotSpec, ticks: list[dict[str, Any]]) -> dict[str, Any]:
    """Numbers of the ticks over time, NaN where a tick has none."""
    free, names = robot.coordinates - len(robot.joints), [joint.name for joint in robot.joints]
    series = {f"joint/{name}": np.array([tick["q"][free + i] for tick in ticks]) for i, name in enumerate(names)}
    sent = [tick.get("sent") or [np.nan] * len(names) for tick in ticks]
    series |= {f"set_point/{name}": np.array([row[i] for row in sent], float) for i, name in enumerate(names)}
    series["least_range"] = np.array([min(tick["ranges"]) for tick in ticks])
    series["contact_force"] = np.array([tick.get("force", np.nan) for tick in ticks], float)
    servos = servo_health(recording.header, robot)
    rows = [servos(tick["raw"]) for tick in ticks]
    for key in ("load", "volts", "celsius"):
        for i, name in enumerate(names):
            series[f"{key}/{name}"] = np.array([np.nan if row[i] is None else getattr(row[i], key) for row in rows])
    return series


def _events(recording: Recording, ticks: list[dict[str, Any]]) -> list[tuple[int, str]]:
    """Stages as they begin, warnings as they appear first, and the end."""
    events: list[tuple[int, str]] = []
    stage, said = "", set()
    for row, tick in enumerate(ticks):
        if tick["stage"] != stage:
            stage = tick["stage"]
            events.append((row, stage))
        new = [text for text in tick.get("warnings") or [] if text not in said]
        events += [(row, str(text)) for text in new]
        said |= set(new)
    if recording.end is not None:
        end = recording.end
        events.append((len(ticks) - 1, ": ".join(str(end[key]) for key in ("end", "cause", "message") if end.get(key))))
    return events
