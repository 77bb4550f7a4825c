"""A given target of a mission, and whether the arm's tip can come to it."""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm, mm_to_m

LOOKS_LIKE_METRES = 5.0
"""Coordinates up to this many millimetres are taken for metres in a message: no target is that close [mm]."""

ROUNDING = 1e-9
"""Distance by which a stretched arm's own tip may seem out of its reach [m]."""


def parse_target(text: str) -> Floats:
    """A target as typed, `X,Y` in mm, in the robot's frame, (2,) [m].

    Raises:
        PipenavError: the text is not two finite numbers.
    """
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise PipenavError(f"target {text!r} is not X,Y: give two numbers in mm, for example 420,80.")
    return np.array([mm_to_m(x), mm_to_m(y)])


def require_reachable(robot: RobotSpec, target: Floats, joint_limits: Floats) -> None:
    """Check that the tip of an arm in a pipe can come to a target.

    The hinged links reach a circle around the first hinge, which the slide moves. In a pipe they cannot fold back: half
    their length before the tip of the straight arm, with its slide drawn back, is as near as a target can lie.

    Args:
        robot: the robot, a slide followed by hinges.
        target: target in the robot's frame, (2,) [m].
        joint_limits: smallest and largest position of every joint, (joints, 2) [rad or m].

    Raises:
        PipenavError: the target is out of reach.
    """
    x, y = target
    rear, ahead = robot.lengths[0] + joint_limits[0]
    hinged = float(robot.lengths[1:].sum())
    nearest, farthest = rear + hinged / 2, ahead + hinged
    off = math.hypot(x - min(max(x, rear), ahead), y)
    if x >= nearest and off <= hinged + ROUNDING:
        return
    given = f"{m_to_mm(x):g},{m_to_mm(y):g}"
    metres = " (is it in metres?)" if max(abs(m_to_mm(x)), abs(m_to_mm(y))) < LOOKS_LIKE_METRES else ""
    raise PipenavError(
        f"target {given} mm is out of the arm's reach{metres}: x must lie between {m_to_mm(nearest):.0f} and "
        f"{m_to_mm(farthest):.0f} mm, within {m_to_mm(hinged):.0f} mm of the first hinge; give X,Y in mm in the "
        "robot's frame."
    )
