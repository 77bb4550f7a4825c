"""The parts of a mission as trajectory files, so that every tool for simulated motions serves a real one too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.policy import Policy
from pipenav.robots import frames
from pipenav.tasks.outcome import Outcome


class ArmPlacement(NamedTuple):
    """Placement of an arm in a pipe.

    Attributes:
        pipe: the pipe around it.
        base: x of the robot's frame in the pipe's frame [m].
    """

    pipe: PipeCorner
    base: float


class MissionPart(NamedTuple):
    """A part of a mission: the name of its file, and its motion."""

    name: str
    trajectory: Trajectory


class _Poses(NamedTuple):
    """Stages of k ticks, and their joint positions, (k, joints) [rad or m]."""

    stages: list[str]
    q: Floats


FILE_NAMES = {"locate": "locate", "reach": "front"}
"""Names of the trajectory files of these stages, the ones that move towards the target."""

NEXT = {"locate": "reach", "reach": "back"}
"""Stage that follows a stage that succeeded."""


def placement_of(pipe: PipeCorner, target: Floats, depth: float) -> ArmPlacement:
    """Placement of an arm in a known pipe, from the target that it located.

    Args:
        pipe: the pipe.
        target: target in the robot's own frame, (2,) [m].
        depth: how far such targets lie past the inner edge, along the second leg [m].
    """
    return ArmPlacement(pipe, float((pipe.inner_edge + depth) * pipe.second_leg[0] - target[0]))


def parts(policy: Policy, ticks: Sequence[dict[str, Any]], placement: ArmPlacement) -> Iterator[MissionPart]:
    """The parts of a mission that succeeded.

    A tick in which the arm held still repeats its pose.
    """
    stages, q = _filled(ticks)
    for stage, file_name in FILE_NAMES.items():
        ends = [i for i, pair in enumerate(pairwise(stages)) if pair == (stage, NEXT[stage])]
        if not ends:
            continue
        first = stages.index(stage)
        header = TrajectoryHeader.model_validate(
            {
                "robot": policy.header.robot.name,
                "pipe": placement.pipe,
                "base_m": placement.base,
                "goal_m": _target(ticks, placement) if stage == "reach" else None,
                "stage": stage,
                "outcome": Outcome.REACHED.label,
                "backend": "hardware",
                "controller": str(policy.path) if stage == "reach" else "locate",
            }
        )
        yield MissionPart(file_name, Trajectory(header, policy.header.robot, q[first : ends[0] + 2]))


def _target(ticks: Sequence[dict[str, Any]], placement: ArmPlacement) -> tuple[float, float] | None:
    """The target in the pipe's frame; None where the arm took a point outside the pipe for one."""
    seen = next(tick["target"] for tick in reversed(ticks) if tick.get("target"))
    target = frames.robot_to_pipe(seen, placement.base)
    return (float(target[0]), float(target[1])) if placement.pipe.contains(target) else None


def _filled(ticks: Sequence[dict[str, Any]]) -> _Poses:
    """Stage and pose of every tick; a tick without a whole reading is like the one before."""
    stages: list[str] = []
    q: list[Any] = []
    for tick in ticks:
        if "q" in tick:
            stages.append(tick["stage"])
            q.append(tick["q"])
        elif q:
            stages.append(stages[-1])
            q.append(q[-1])
    return _Poses(stages, np.array(q))
