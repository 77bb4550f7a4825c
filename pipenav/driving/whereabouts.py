"""Place of a whole robot in a corner, told by its own sensors and the pipe's drawing.

A half that clamps says how the robot lies: its wheels stand on known walls. How far along the pipe it lies is counted
by its wheels, and put right by the laser, as long as the corner is in sight: the scan is compared with the scans that
the drawing gives for many distances.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.driving.scan_match import ScanMatch
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.sequence_phases import RobotState
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, forward_directions

CLAMPED = 0.35
"""Largest distance of a clamped half's middle joint from the bend that fits the bore [rad]; farther, it does not lie as
it is thought to, and a scan says nothing."""


class Whereabouts:
    """Place of one robot, which clamps with its rear half at first.

    Args:
        robot: two mirrored halves with three wheels each.
        pipe: the pipe as a left turn.
        tip_gap: distance of the tip before the inner wall's bend at the start, as far as it is known [m].
        bends: joint angles at the start, as in a left turn, (6,) [rad].
    """

    def __init__(self, robot: RobotSpec, pipe: PipeCorner, tip_gap: float, bends: Floats) -> None:
        self._robot, self._pipe = robot, pipe
        self._room = pipe.radius - robot.wheels[0].radius
        self._steep = math.asin(min(2 * self._room / float(robot.lengths[1]), 0.999))
        self._front = False
        self._match = ScanMatch(robot, pipe)
        ahead = robot.lengths[HALF:] * np.cos(np.cumsum(bends)[HALF - 1 :])  # whichever way round it clamps
        # Distance along its leg of the clamped half's wheel at the middle link [m].
        self._distance = -pipe.inner_edge - tip_gap - float(ahead.sum())

    def clamp_front(self, state: RobotState) -> None:
        """The front half clamps from now on, in the second leg, and the rear half may let go."""
        self._front, self._distance = True, state.front_clamp

    def update(self, reading: Reading) -> RobotState:
        """Pose of the robot after a control period, from its readings as in a left turn (rows of one)."""
        bends, speeds = reading.q[0], reading.wheel_speeds
        assert speeds is not None
        half = slice(HALF, None) if self._front else slice(0, HALF)
        rolled = (speeds[0] * forward_directions(reading.q)[0])[half]
        self._distance += CONTROL_PERIOD * self._robot.wheels[0].radius * float(np.median(rolled))
        if not self._front and abs(float(bends[1]) + 2 * self._steep) < CLAMPED:
            self._look(bends, reading.ranges[0])
        points = self._points(bends, self._distance)
        return RobotState(bends, points, self._pipe.distance_along(points))

    def _look(self, bends: Floats, ranges: Floats) -> None:
        """Put the counted distance right by a scan."""
        points = self._points(bends, self._distance)
        x, y = points[-1] - points[-2]
        self._distance += self._match.error(points[-1], math.atan2(y, x), ranges)

    def _points(self, bends: Floats, distance: float) -> Floats:
        """Rear end, joints and tip in the pipe's frame, (8, 2) [m], with the clamped half at a distance [m]."""
        lengths, steep = self._robot.lengths, self._steep
        if self._front:
            leg = math.pi - self._pipe.angle
            anchor, at = self._on_second_leg(distance), HALF + 1
            headings = leg + steep + np.concatenate([np.zeros(1), np.cumsum(bends[HALF + 1 :])])
            back = leg + steep - np.cumsum(bends[HALF::-1])
            headings = np.concatenate([back[::-1], headings])
        else:
            anchor, at = np.array([distance, -self._room]), HALF
            headings = -steep + np.concatenate([-np.cumsum(bends[HALF - 2 :: -1])[::-1], [0.0], np.cumsum(bends[2:])])
        steps = lengths[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1)
        points = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        return np.asarray(points - points[at] + anchor)

    def _on_second_leg(self, distance: float) -> Floats:
        """Point on the second leg's outer side at a distance along the pipe, (2,) [m]."""
        leg = math.pi - self._pipe.angle
        along = np.array([math.cos(leg), math.sin(leg)])
        return np.asarray(distance * along - self._room * np.array([-along[1], along[0]]))
