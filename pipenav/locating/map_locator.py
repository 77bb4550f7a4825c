"""The default method of approach I: a map of what the laser has met, and eq 3.18's advance.

The arm straightens on the first leg's axis, collects what all beams have met (`corner_map`), and stops as soon as only
one corner fits. The target is the middle of the second leg, a set depth past the inner edge; for an exit straight on it
lies on the first leg's axis, past its crossing with the branch's. The arm touches nothing, and goes back to where it
started, straight.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.locating.bend_map import bend_estimate
from pipenav.locating.corner_estimate import CornerEstimate
from pipenav.locating.corner_map import CornerMap
from pipenav.locating.locator import LocateConfig, SearchStep, Told, advance
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec

HOME = 0.002
"""Distance from its start position at which a slide is back [m]: the error of its encoder and its controller."""

STOPPED = 0.001
"""Advance below which a scan shows nothing new [m]."""


STRAIGHT_SPREAD = 0.6
"""Largest spread of possible targets straight on, as a share of their depth: a hidden edge leaves half of it."""


LAST_SPREAD = 2.0
"""Factor on the spread with which a robot in a tee or a bend is content on its way back, when it will see no more."""


class MapLocator:
    """A straight arm that advances until only one corner fits what the beams have met, and goes back.

    Where it cannot advance before the corner is known, it goes back too and looks again: no two scans are the same.
    A reading at the laser's minimum may be none at all (`_without_dropouts`).
    """

    def __init__(self, robot: RobotSpec, config: LocateConfig, n: int) -> None:
        self._robot, self._config, self.n = robot, config, n
        self._map = CornerMap(robot.laser, n, config.tolerance)
        self._straight, self._tee, self._bend = np.zeros((3, n), bool)
        self._advance, self._turn_sign, self._home = np.full(n, config.v0), np.ones(n), np.zeros(n)
        self._agreed, self._back = np.zeros(n, int), np.zeros(n, bool)
        self._wall = np.full((n, robot.laser.beams), -np.inf)
        self._target, self._beam = np.full((n, 2), np.nan), np.full(n, -1)

    def start(self, indices: Ints, reading: Reading, told: Told) -> None:
        self._map.forget(indices, told.tee)
        self._straight[indices], self._tee[indices], self._bend[indices] = told.straight, told.tee, told.bend
        self._advance[indices], self._turn_sign[indices], self._home[indices] = (
            self._config.v0,
            told.turn_sign,
            reading.q[:, 0],
        )
        self._agreed[indices], self._back[indices], self._wall[indices] = 0, False, -np.inf
        self._target[indices], self._beam[indices] = np.nan, -1

    def act(self, reading: Reading) -> SearchStep:
        robot, config = self._robot, self._config
        looking = np.flatnonzero(self._beam < 0)
        if len(looking):
            self._look(looking, reading.part(looking))
        found, at_home = self._beam >= 0, reading.q[:, 0] <= self._home + HOME
        self._advance = advance(robot, config, self._advance, self._without_dropouts(reading))
        # No wall ahead stops a robot whose exit leaves an open run: it turns back before the end of its slide.
        at_end = (self._tee | self._bend) & (reading.q[:, 0] >= robot.upper[0] - 2 * config.v0)
        self._back = found | np.where(self._back, ~at_home, (self._advance < STOPPED) | at_end)
        ahead = np.minimum(reading.q[:, 0] + self._advance, robot.upper[0])
        set_points = np.zeros_like(reading.q)
        set_points[:, 0] = np.where(self._back, np.maximum(reading.q[:, 0] - config.v0, self._home), ahead)
        return SearchStep(set_points, found & at_home, self._target.copy(), self._beam.copy())

    def _without_dropouts(self, reading: Reading) -> Floats:
        """Readings, (n, beams) [m], with the minimum replaced by what the beam read before, less the advance since.

        A scanner that faces open space may give its minimum (thesis 5.4.2), which must not stop the robot; a wall that
        really is so near was seen while it came near. A beam that has read nothing else yet is believed.
        """
        slide = reading.q[:, :1]
        read = reading.ranges > self._robot.laser.range_min
        self._wall = np.where(read, slide + reading.ranges, self._wall)
        return np.where(read, reading.ranges, np.maximum(self._wall - slide, self._robot.laser.range_min))

    def _look(self, indices: Ints, reading: Reading) -> None:
        """Take in a scan of robots that have no target yet, and set their targets where the corner is known."""
        robot, config, turn_sign = self._robot, self._config, self._turn_sign[indices]
        pose = kinematics.forward(robot, reading.q)
        beams = pose.headings[:, -1:] + robot.laser.angles
        self._map.add(
            indices, frames.robot_to_canonical(pose.tip, turn_sign), beams * turn_sign[:, None], reading.ranges
        )
        # Straight on, the pipe has room for a target that is too deep.
        room = np.where(self._straight[indices], STRAIGHT_SPREAD * config.depth, config.spread)
        hidden = self._tee[indices] | self._bend[indices]
        room[hidden & self._back[indices]] *= LAST_SPREAD  # it has seen what there is
        corner = self._estimate(indices, room)
        second_leg = (corner.votes >= config.votes) & (corner.agreement >= config.agreement)
        known = (corner.spread <= room) & (second_leg | self._straight[indices])
        self._agreed[indices] = np.where(known, self._agreed[indices] + 1, 0)
        sure = self._agreed[indices] >= config.scans
        target = frames.canonical_to_robot(corner.target, turn_sign)[sure]
        away = target - pose.tip[sure]
        off = np.arctan2(away[:, 1], away[:, 0])[:, None] - beams[sure]
        self._target[indices[sure]] = target
        self._beam[indices[sure]] = np.abs(np.angle(np.exp(1j * off))).argmin(axis=1)

    def _estimate(self, indices: Ints, room: Floats) -> CornerEstimate:
        """Corners, or bends, that fit best what some robots have met; `room` is a target's spread, (k,) [m]."""
        bend, depth = self._bend[indices], self._config.depth
        if not bend.any():
            return self._map.corner(indices, depth, self._straight[indices])
        bent = indices[bend]
        rays, tolerance = self._map.rays(bent), self._config.tolerance
        bends = bend_estimate(self._robot, rays, depth, tolerance, room[bend], self._back[bent])
        if bend.all():
            return bends
        corners = self._map.corner(indices[~bend], depth, self._straight[indices[~bend]])
        order = np.argsort(np.concatenate([np.flatnonzero(bend), np.flatnonzero(~bend)]))
        return CornerEstimate(*(np.concatenate(columns)[order] for columns in zip(bends, corners, strict=True)))
