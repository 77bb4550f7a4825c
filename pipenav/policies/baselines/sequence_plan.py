"""Poses that `baseline:sequence` plans: how a half clamps, and how the other half goes through the corner."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_checks import BEND_RADIUS_MAX_MM
from pipenav.policies.baselines.guide_line import meet_line
from pipenav.robots.robot import RobotSpec
from pipenav.units import mm_to_m

PRESS = 0.10
"""Distance of the middle joint's set-point beyond a clamp's bend [rad]: more than half of the joint's effort."""

SPARE = 0.003
"""Distance from the outer wall at which the moving half's wheels are led [m]: fewer contacts, for little room."""

REACH = 0.6
"""Distance before the inner wall's bend at which the poses along a line begin [m]: behind every start."""

POSES = 241
"""Number of those poses."""


class Poses(NamedTuple):
    """Poses of a half that goes through a left turn while the other half clamps and drives.

    Attributes:
        distance: distance along the pipe of the clamped half's wheel at the middle link, rising, (k,) [m].
        bends: angle of the middle link to the pipe's axis, then the moving half's joint angles from the middle of the
            robot outwards, (k, 4) [rad].
    """

    distance: Floats
    bends: Floats

    def at(self, distance: float) -> Floats:
        """Bends where the clamped half has come to a distance, (4,); beyond the ends, the bends of the ends."""
        return np.array([np.interp(distance, self.distance, column) for column in self.bends.T])


class CornerPlan(NamedTuple):
    """Plan of the sequence in one pipe.

    Attributes:
        steep: angle between a clamped half's links and the pipe's axis [rad].
        slant: angle to the axis at which the middle link brings its far end from the wall to the axis [rad].
        line: poses that lead the moving half's joints and its end along one line.
        tip: distance of that end along the pipe in each pose, (k,) [m].
        edge: distance past the corner at which the inner wall's bend ends [m].
    """

    steep: float
    slant: float
    line: Poses
    tip: Floats
    edge: float

    def onto_line(self, distance: float, bends: Floats, tip: float) -> Poses:
        """Poses that lead from any pose onto the line, to where the half's end is no farther back than it is now.

        Args:
            distance: distance along the pipe of the clamped half's wheel at the middle link [m].
            bends: bends in that pose, as in `Poses`, (4,) [rad].
            tip: distance of the moving half's end along the pipe [m].
        """
        rest = (self.tip >= tip) & (self.line.distance > distance)
        bends = np.concatenate([bends[None], self.line.bends[rest]])
        return Poses(np.append(distance, self.line.distance[rest]), bends)


class _LineMotion(NamedTuple):
    """Poses along a line, and the distance of the tip along the pipe in each of them, (k,) [m]."""

    poses: Poses
    tip: Floats


def plan(robot: RobotSpec, pipe: PipeCorner) -> CornerPlan:
    """Plan how to clamp in a pipe and how to go round its corner.

    A half clamps with its middle wheel on the inner wall and its other wheels on the outer wall. The line keeps to the
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
    motion = _follow_line(robot, pipe, room)
    return CornerPlan(steep, slant, motion.poses, motion.tip, pipe.inner_edge)


def _follow_line(robot: RobotSpec, pipe: PipeCorner, room: float) -> _LineMotion:
    """Poses with the front half's joints and its tip on the line; `room` is a wheel's largest distance off the axis."""
    line = _line(robot, pipe, max(room - SPARE, 0.0))
    distance = np.linspace(-pipe.inner_edge - REACH, 0.0, POSES)
    joint = np.stack([distance, np.full(POSES, -room)], axis=1)  # at the clamped half's foremost wheel, (k, 2)
    positions = np.minimum((distance - line[0, 0]) / (line[1, 0] - line[0, 0]), 1.0)
    heading, bends, ends = np.zeros(POSES), [], []
    for length in robot.lengths[3:]:
        end, positions = meet_line(line, joint, positions, float(length))
        direction = np.arctan2(*(end - joint).T[::-1])
        bends.append(np.mod(direction - heading + math.pi, 2 * math.pi) - math.pi)
        ends.append(end)
        joint, heading = end, direction
    beyond = pipe.distance_along(ends[0])
    half_way = int(np.argmax((beyond >= -distance) & (beyond > 0)))
    kept = slice(0, half_way + 1)
    poses = Poses(distance[kept], np.stack(bends, axis=1)[kept])
    return _LineMotion(poses, pipe.distance_along(ends[-1])[kept])


def _line(robot: RobotSpec, pipe: PipeCorner, lane: float) -> Floats:
    """The line at the distance `lane` from the centre line, on the outer side, (p, 2) [m]."""
    chord = float(robot.lengths[3])
    half_turn = (math.pi - pipe.angle) / 2
    arc_radius = chord / 2 / max(math.sin(half_turn), 1e-9)
    bend = min(max(arc_radius - lane, pipe.bend_radius), mm_to_m(BEND_RADIUS_MAX_MM))
    return pipe.model_copy(update={"bend_radius": bend, "leg": pipe.leg + robot.length}).line(-lane)
