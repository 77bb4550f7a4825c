"""The summary of a mission: how well the loop kept its time, where the arm stood, its picture and its motions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipenav.deployment.picture import mission_picture
from pipenav.deployment.plan import PICTURE, MissionPlan
from pipenav.deployment.trajectories import ArmPlacement, parts, placement_of
from pipenav.locating.locator import LocateConfig
from pipenav.motions.trajectory_file import write_trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.storage.atomic_files import atomic_write


class Pace(NamedTuple):
    """Punctuality of the control loop.

    Attributes:
        ticks: number of ticks.
        rate: achieved rate [Hz].
        worst: longest time from when a tick was due to when its command was out [s].
        late: number of ticks later than their deadline.
        parts: mean time of each part of the loop [s].
        clamped: number of ticks in which a set-point was limited.
    """

    ticks: int
    rate: float
    worst: float
    late: int
    parts: dict[str, float]
    clamped: int


def pace(ticks: Sequence[dict[str, Any]]) -> Pace:
    """Punctuality of recorded ticks."""
    timed = [tick for tick in ticks if "seconds" in tick]
    names = ("bus", "read", "decide", "send", "taken")
    parts = {
        name: float(np.mean([tick["seconds"][name] for tick in timed if name in tick["seconds"]] or [0.0]))
        for name in names
    }
    span = timed[-1]["time"] - timed[0]["time"] if len(timed) > 1 else 0.0
    count = timed[-1]["tick"] - timed[0]["tick"] if timed else 0
    return Pace(
        ticks=len(ticks),
        rate=count / span if span else 0.0,
        worst=max((tick["seconds"].get("taken", 0.0) for tick in timed), default=0.0),
        late=max((tick["raw"]["late"] for tick in ticks), default=0),
        parts=parts,
        clamped=sum(bool(tick.get("clamped")) for tick in ticks),
    )


def located_placement(plan: MissionPlan, ticks: Sequence[dict[str, Any]], pipe: PipeCorner) -> ArmPlacement | None:
    """Placement of the arm in a known pipe; None where it located no target."""
    target = next((tick["target"] for tick in reversed(ticks) if tick.get("target")), None)
    if plan.target is not None or target is None:
        return None
    return placement_of(pipe, np.array(target), LocateConfig().depth)


def write_motions(
    plan: MissionPlan, ticks: Sequence[dict[str, Any]], outcome: str, placement: ArmPlacement | None
) -> Iterator[Path]:
    """Write the mission's picture, and where the arm's placement is known its motions as trajectory files.

    Args:
        plan: the mission's plan.
        ticks: telemetry records.
        outcome: how the mission ended.
        placement: where the arm stood; None where that is not known.

    Yields:
        Every file that was written.
    """
    robot = plan.policy.header.robot
    where = "" if placement is None else f" in {placement.pipe.label}"
    title = f"{robot.name}{where}: {outcome}, {len(ticks)} ticks"
    picture = plan.folder / PICTURE
    pipe, base = (None, 0.0) if placement is None else placement
    atomic_write(picture, mission_picture(robot, ticks, title, pipe, base))
    yield picture
    if placement is not None:
        for part in parts(plan.policy, ticks, placement):
            path = plan.folder / f"{part.name}.csv"
            write_trajectory(path, part.trajectory)
            yield path
