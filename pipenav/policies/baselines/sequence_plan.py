"""Where `baseline:sequence` puts the joints: how a half clamps, and how the other one goes through the corner."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_checks import BEND_RADIUS_MAX_MM
from pipenav.policies.baselines.centreline import reach
from pipenav.robots.robot import RobotSpec
from pipenav.units import mm_to_m

PRESS = 0.10
"""How far beyond a clamp's bend the set-point of its middle joint is [rad]: more than half of the joint's effort."""

SPARE = 0.003
"""How far off the outer wall the wheels of the moving half are led [m]: fewer contacts, for little room."""

REACH, WAY_POINTS = 0.6, 241
"""Where the poses along a line begin, before the inner wall's bend [m]: behind every start; and how many they are."""


class Poses(NamedTuple):
    """How one half goes through a left turn while the other one clamps and drives.

    Attributes:
        along: where the clamped half's wheel at the middle link is along the pipe, rising, (k,) [m].
        bends: the middle link's angle to the pipe's axis, then the moving half's joint angles from the middle of the
            robot outwards, (k, 4) [rad].
    """

    along: Floats
    bends: Floats

    def at(self, along: float) -> Floats:
        """Angles where the clamped half has come to `along`, (4,); beyond the ends those of the ends."""
        return np.array([np.interp(along, self.along, column) for column in self.bends.T])


class CornerPlan(NamedTuple):
    """What the sequence knows of one pipe.

    Attributes:
        steep: angle between a clamped half's links and the pipe's axis [rad].
        slant: angle to the axis at which the middle link brings its far end from the wall to the axis [rad].
        line: poses that lead the moving half's joints and its end along one line.
        tip: where that end is along the pipe in each of them, (k,) [m].
        edge: how far past the corner the inner wall's bend ends [m].
    """

    steep: float
    slant: float
    line: Poses
    tip: Floats
    edge: float

    def onto_line(self, along: float, bends: Floats, tip: float) -> Poses:
        """Poses that lead from any one to the line, on which its end is no farther back than it is now.

        Args:
            along: where the clamped half's wheel at the middle link is along the pipe [m].
            bends: as those of `Poses`, (4,) [rad].
            tip: where the moving half's end is along the pipe [m].
        """
        rest = (self.tip >= tip) & (self.line.along > along)
        return Poses(np.append(along, self.line.along[rest]), np.concatenate([bends[None], self.line.bends[rest]]))


def plan(robot: RobotSpec, pipe: PipeCorner) -> CornerPlan:
    """How to clamp in a pipe and how to go round its corner.

    A half clamps with its middle wheel on the inner wall and its other ones on the outer wall. The line keeps to the
    outer wall and turns around the corner in an arc that the middle link just spans: half-way, the wheels at its ends
    still stand on either leg's outer wall, and the poses end.

    Args:
        robot: two mirrored halves.
        pipe: a left turn.
    """
    room = pipe.radius - robot.wheels[2].radius
    steepest = (float(min(robot.upper.min(), -robot.lower.max())) - PRESS) / 2
    steep = min(math.asin(min(2 * room / float(robot.lengths[1]), 1.0)), steepest)
    slant = math.asin(min(room / float(robot.lengths[3]), 1.0))
    line, tip = _follow_line(robot, pipe, room)
    return CornerPlan(steep, slant, line, tip, pipe.inner_edge)


def _follow_line(robot: RobotSpec, pipe: PipeCorner, room: float) -> tuple[Poses, Floats]:
    """Poses with the front half's joints and its tip on the line, and where the tip is along the pipe."""
    line = _line(robot, pipe, max(room - SPARE, 0.0))
    along = np.linspace(-pipe.inner_edge - REACH, 0.0, WAY_POINTS)
    pivot = np.stack([along, np.full(WAY_POINTS, -room)], axis=1)  # the clamped half's foremost wheel, (k, 2)
    at = np.minimum((along - line[0, 0]) / (line[1, 0] - line[0, 0]), 1.0)
    heading, bends, ends = np.zeros(WAY_POINTS), [], []
    for length in robot.lengths[3:]:
        end, at = reach(line, pivot, at, float(length))
        direction = np.arctan2(*(end - pivot).T[::-1])
        bends.append(np.mod(direction - heading + math.pi, 2 * math.pi) - math.pi)
        ends.append(end)
        pivot, heading = end, direction
    beyond = pipe.distance_along(ends[0])
    kept = slice(0, int(np.argmax((beyond >= -along) & (beyond > 0))) + 1)  # up to half-way
    return Poses(along[kept], np.stack(bends, axis=1)[kept]), pipe.distance_along(ends[-1])[kept]


def _line(robot: RobotSpec, pipe: PipeCorner, lane: float) -> Floats:
    """The line at `lane` from the centre line, on the outer side, (p, 2) [m]."""
    chord = float(robot.lengths[3])
    half_turn = (math.pi - pipe.angle) / 2
    arc = chord / 2 / max(math.sin(half_turn), 1e-9)  # its radius
    bend = min(max(arc - lane, pipe.bend_radius), mm_to_m(BEND_RADIUS_MAX_MM))
    return pipe.model_copy(update={"bend_radius": bend, "leg": pipe.leg + robot.length}).line(-lane)
