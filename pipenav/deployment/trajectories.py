"""The parts of a run on an arm as trajectory files, so that every tool for simulated motions serves a real one too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.policy import Policy
from pipenav.tasks.outcome import Outcome


class ArmPlacement(NamedTuple):
    """Where an arm stood: the pipe, and x of the robot's frame in the pipe's frame [m]."""

    pipe: PipeCorner
    base: float


PARTS = {"locate": "locate", "reach": "front"}
"""Stages of a run that move towards the target, and what trajectory files call them."""

NEXT = {"locate": "reach", "reach": "back"}
"""What follows a stage that succeeded."""


def placement_of(pipe: PipeCorner, target: Floats, depth: float) -> ArmPlacement:
    """Where an arm stands in a known pipe, from the target that it located.

    Args:
        pipe: the pipe.
        target: in the robot's own frame, (2,) [m].
        depth: of such targets past the inner edge, along the second leg [m].
    """
    return ArmPlacement(pipe, float((pipe.inner_edge + depth) * pipe.second_leg[0] - target[0]))


def parts(policy: Policy, ticks: Sequence[dict[str, Any]], place: ArmPlacement) -> Iterator[tuple[str, Trajectory]]:
    """The parts of a run that succeeded, each with its name; a tick in which the arm held still repeats its pose."""
    names, rows = _filled(ticks)
    for stage, part in PARTS.items():
        ends = [i for i, (one, after) in enumerate(pairwise(names)) if (one, after) == (stage, NEXT[stage])]
        if not ends:
            continue
        first = names.index(stage)
        header = TrajectoryHeader.model_validate(
            {
                "robot": policy.header.robot.name,
                "pipe": place.pipe,
                "base_m": place.base,
                "goal_m": _goal(ticks, place) if part == "front" else None,
                "stage": part,
                "outcome": Outcome.REACHED.label,
                "backend": "hardware",
                "controller": str(policy.path) if part == "front" else "locate",
            }
        )
        yield part, Trajectory(header, policy.header.robot, rows[first : ends[0] + 2])


def _goal(ticks: Sequence[dict[str, Any]], place: ArmPlacement) -> tuple[float, float] | None:
    """The target in the pipe's frame; None where the arm took a point outside the pipe for one."""
    x, y = next(tick["target"] for tick in reversed(ticks) if tick.get("target"))
    goal = (x + place.base, y)
    return goal if place.pipe.contains(np.array(goal)) else None


def _filled(ticks: Sequence[dict[str, Any]]) -> tuple[list[str], Floats]:
    """Stage and pose of every tick; a tick without a whole reading is like the one before."""
    names: list[str] = []
    rows: list[Any] = []
    for tick in ticks:
        if "q" in tick:
            names.append(tick["stage"])
            rows.append(tick["q"])
        elif rows:
            names.append(names[-1])
            rows.append(rows[-1])
    return names, np.array(rows)
