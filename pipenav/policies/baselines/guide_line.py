"""Lines around a corner that the joints of a robot follow, and where links meet such a line."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner

ENTRY = 0.12
"""Distance before the corner at which a line leaves the first leg's axis [m]: one link of the arm."""

BEYOND = 0.05
"""Distance by which a line runs on past the target [m], so that the tip can stop off a waypoint."""

LINE_POINTS = 30
"""Points of each of a line's four curves: some millimetres apart."""


class GuideLine(NamedTuple):
    """A line around a corner to a target.

    Attributes:
        points: points of the line in the pipe's frame, (p, 2) [m].
        target: index of the point at the target.
    """

    points: Floats
    target: int


class LineMeeting(NamedTuple):
    """Meeting of k links with a line.

    Attributes:
        points: far ends of the links on the line, (k, 2) [m].
        positions: positions of those ends on the line: the index of the point before them, plus a fraction, (k,).
    """

    points: Floats
    positions: Floats


def guide_line(pipe: PipeCorner, target: Floats, widths: tuple[float, ...]) -> GuideLine:
    """The line around a left turn's corner that swings wide before and after it.

    Args:
        pipe: a left turn.
        target: target in the pipe's frame, (2,) [m].
        widths: distances from the inner wall before, at and after the corner, in diameters.
    """
    before, at, after = pipe.diameter * np.array(widths)
    turn_angle = math.pi - pipe.angle
    along, across = pipe.second_leg, np.array([math.sin(turn_angle), -math.cos(turn_angle)])
    edge = pipe.apex(pipe.radius) * np.array([-math.sin(turn_angle / 2), math.cos(turn_angle / 2)])
    t = np.linspace(0.0, 1.0, LINE_POINTS, endpoint=False)[:, None]
    smooth = t * t * (3 - 2 * t)
    entry = np.concatenate([edge[0] + ENTRY * (t - 1), smooth * (edge[1] - before)], axis=1)
    ease = (1 - np.cos(math.pi * t)) / 2
    width = before + (after - before) * ease + (at - (before + after) / 2) * np.sin(math.pi * t) ** 2
    corner = edge + width * np.concatenate([np.sin(turn_angle * t), -np.cos(turn_angle * t)], axis=1)
    out = edge + after * across
    to_target = target - out
    straight = (to_target @ along) * along
    leave = out + straight * t + (to_target - straight) * smooth
    start = np.array([[-pipe.leg - 1.0, 0.0]])  # the arm may stick out of a short leg's open end
    past = target + BEYOND * t * along
    return GuideLine(np.concatenate([start, entry, corner, leave, past]), 1 + 3 * LINE_POINTS)


def meet_line(line: Floats, joints: Floats, positions: Floats, length: float) -> LineMeeting:
    """Meeting of links with a line, farther on from where they begin.

    Args:
        line: points of the line, (p, 2) [m].
        joints: near ends of k links, (k, 2) [m].
        positions: positions of the near ends on the line, as in `LineMeeting`, (k,).
        length: length of every link [m].
    """
    distance = np.hypot(*np.moveaxis(line - joints[:, None], -1, 0))  # (k, p)
    beyond = (distance >= length) & (np.arange(len(line)) > positions[:, None])
    i = np.where(beyond.any(axis=1), beyond.argmax(axis=1), len(line) - 1)
    a, d = line[i - 1], line[i] - line[i - 1]
    from_joint = a - joints
    # |from_joint + t d| = length, the larger root
    dd, df = (d * d).sum(axis=1), (d * from_joint).sum(axis=1)
    root = np.sqrt(np.maximum(df**2 - dd * ((from_joint**2).sum(axis=1) - length**2), 0.0))
    t = np.clip((root - df) / dd, 0.0, 1.0)
    return LineMeeting(a + t[:, None] * d, i - 1 + t)
