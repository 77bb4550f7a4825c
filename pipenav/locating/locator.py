"""Approach I (thesis 3.4, 5.3.1): the robot finds a target around the corner by itself.

It sees its own sensors and knows the side that the corner turns to, nothing else. Two ways to do it:

- `PrintedLocator` is the method as the thesis prints it, eq 3.16 to 3.19. The head turns towards the corner while the
  base moves forwards; the first beam that is long enough shows an open space, and a point on it is the target. It
  takes a straight pipe ahead for an open space, and presses its head against the wall of a narrow pipe.
- `MapLocator`, the default, keeps eq 3.18's advance. It straightens the arm on the first leg's axis, collects what all
  beams have met (`corner_map`), and stops as soon as only one corner fits that. The target is the middle of the second
  leg, a set depth past the inner edge. Nothing is touched, and it goes back to where it started, with a straight arm.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, Protocol

import numpy as np
from pydantic import Field

from pipenav.arrays import Flags, Floats, Ints, Table
from pipenav.backends.messages import Reading
from pipenav.errors import PipenavError
from pipenav.locating.corner_map import CornerMap
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec

Flags = Flags
Variant = Literal["map", "thesis"]

HOME = 0.002
"""How near to its start position a slide is back [m]: what its encoder and its controller leave."""

STOPPED = 0.001
"""An advance below this [m] shows nothing new."""


class LocateConfig(Table):
    """Settings of approach I; the thesis's numbers are those of its eq 5.2."""

    omega0: float = Field(0.15, gt=0, description="turn of the head per control step [rad] (eq 3.18; thesis variant)")
    v0: float = Field(0.02, gt=0, description="advance of the slide per control step [m] (eq 3.18)")
    delta: float = Field(0.05, gt=0, description="front distance below which the advance slows down [m] (eq 3.18)")
    slowdown: float = Field(8.0, gt=1, description="N of eq 3.18: what the advance is divided by in each such step")
    front: float = Field(
        math.radians(20),
        gt=0,
        description="half width of the fan that looks ahead [rad]; the thesis gives none. Chosen: the 20 mm arm at a "
        "distance delta covers 11 deg to either side, and the walls of a 70 mm pipe come in at 35 deg",
    )
    open_range: float = Field(0.3, gt=0, description="L_o: a longer beam shows an open space [m] (eq 3.19)")
    target_range: float = Field(0.2, gt=0, description="L: how far along that beam the target lies [m] (eq 3.17)")

    depth: float = Field(0.1, gt=0, description="target past the inner edge [m]: the middle of the task's target area")
    tolerance: float = Field(
        0.01, gt=0, description="distance from a wall at which a beam still speaks for it [m]: two steps of the laser"
    )
    spread: float = Field(
        0.015, gt=0, description="the target is known when all possible ones lie so close [m]; the tip reaches to 0.02"
    )
    votes: float = Field(4.0, ge=1, description="beams that must agree on the second leg's outer wall")
    agreement: float = Field(
        0.4,
        gt=0,
        le=1,
        description="their least share of the beams that end beyond the corner: where readings scatter by as much as "
        "`tolerance`, right ones give half a vote each",
    )
    scans: int = Field(2, ge=1, description="scans in a row that must say the same")


class Decision(NamedTuple):
    """What k robots do next, and what they know.

    Attributes:
        set_points: set-points in the robot's own frame, (k, joints) [rad or m].
        done: whether the part is over, (k,).
        target: in the robot's own frame, (k, 2) [m]; NaN before one is found.
        beam: the beam on or nearest to which the target lies, from right to left from 0, (k,); -1 before.
    """

    set_points: Floats
    done: Flags
    target: Floats
    beam: Ints


class Locator(Protocol):
    """A behaviour of n robots that finds targets from what their sensors give."""

    n: int

    def start(self, indices: Ints, reading: Reading, turn_sign: Floats) -> None:
        """Begin anew with k robots.

        Args:
            indices: which, sorted and unique, (k,).
            reading: of these robots.
            turn_sign: that the corner turns to: +1 left, -1 right, (k,).
        """
        ...

    def act(self, reading: Reading) -> Decision:
        """One control step of all n robots."""
        ...


class PrintedLocator:
    """Eq 3.16 to 3.19 as printed. Where several beams are open, the longest counts, of equal ones the first."""

    def __init__(self, robot: RobotSpec, config: LocateConfig, n: int) -> None:
        self._robot, self._config, self.n = robot, config, n
        self._advance, self._turn_sign = np.full(n, config.v0), np.ones(n)
        self._start = np.zeros((n, len(robot.joints)))

    def start(self, indices: Ints, reading: Reading, turn_sign: Floats) -> None:
        self._advance[indices], self._turn_sign[indices], self._start[indices] = self._config.v0, turn_sign, reading.q

    def act(self, reading: Reading) -> Decision:
        robot, config = self._robot, self._config
        self._advance = advance(robot, config, self._advance, reading.ranges)
        set_points = self._start.copy()
        set_points[:, 0] = reading.q[:, 0] + self._advance
        set_points[:, -1] = reading.q[:, -1] + config.omega0 * self._turn_sign
        beam = reading.ranges.argmax(axis=1)
        found = reading.ranges.max(axis=1) > config.open_range
        return Decision(
            np.where(found[:, None], reading.q, np.clip(set_points, robot.lower, robot.upper)),
            found,
            np.where(found[:, None], point_on_beam(robot, reading.q, beam, config.target_range), np.nan),
            np.where(found, beam, -1),
        )


class MapLocator:
    """Straight along the axis until only one corner fits what the beams have met, and back.

    Where the way ahead ends before the corner is known, it goes back too, and looks again: no two scans are the same.
    A reading at the laser's minimum may be none at all (`_without_dropouts`).
    """

    def __init__(self, robot: RobotSpec, config: LocateConfig, n: int) -> None:
        self._robot, self._config, self.n = robot, config, n
        self._map = CornerMap(robot.laser, n, config.tolerance)
        self._advance, self._turn_sign, self._home = np.full(n, config.v0), np.ones(n), np.zeros(n)
        self._agreed, self._back = np.zeros(n, int), np.zeros(n, bool)
        self._wall = np.full((n, robot.laser.beams), -np.inf)
        self._target, self._beam = np.full((n, 2), np.nan), np.full(n, -1)

    def start(self, indices: Ints, reading: Reading, turn_sign: Floats) -> None:
        self._map.forget(indices)
        self._advance[indices], self._turn_sign[indices], self._home[indices] = (
            self._config.v0,
            turn_sign,
            reading.q[:, 0],
        )
        self._agreed[indices], self._back[indices], self._wall[indices] = 0, False, -np.inf
        self._target[indices], self._beam[indices] = np.nan, -1

    def act(self, reading: Reading) -> Decision:
        robot, config = self._robot, self._config
        looking = np.flatnonzero(self._beam < 0)
        if len(looking):
            self._look(looking, reading.part(looking))
        found, at_home = self._beam >= 0, reading.q[:, 0] <= self._home + HOME
        self._advance = advance(robot, config, self._advance, self._without_dropouts(reading))
        self._back = found | np.where(self._back, ~at_home, self._advance < STOPPED)
        ahead = np.minimum(reading.q[:, 0] + self._advance, robot.upper[0])
        set_points = np.zeros_like(reading.q)
        set_points[:, 0] = np.where(self._back, np.maximum(reading.q[:, 0] - config.v0, self._home), ahead)
        return Decision(set_points, found & at_home, self._target.copy(), self._beam.copy())

    def _without_dropouts(self, reading: Reading) -> Floats:
        """Readings in which the laser's minimum is what the same beam read before, less the way since, (n, beams).

        A scanner that faces open space may give its minimum (thesis 5.4.2), which must not stop the robot; a wall that
        really is so near was seen while it came near. A beam that has read nothing else yet is taken at its word.
        """
        slide = reading.q[:, :1]
        read = reading.ranges > self._robot.laser.range_min
        self._wall = np.where(read, slide + reading.ranges, self._wall)
        return np.where(read, reading.ranges, np.maximum(self._wall - slide, self._robot.laser.range_min))

    def _look(self, indices: Ints, reading: Reading) -> None:
        """Take in a scan of robots that have no target yet, and see whether the corner is known."""
        robot, config, turn_sign = self._robot, self._config, self._turn_sign[indices]
        pose = kinematics.forward(robot, reading.q)
        beams = pose.headings[:, -1:] + robot.laser.angles
        self._map.add(
            indices, frames.robot_to_canonical(pose.tip, turn_sign), beams * turn_sign[:, None], reading.ranges
        )
        corner = self._map.corner(indices, config.depth)
        known = (corner.spread <= config.spread) & (corner.votes >= config.votes)
        known &= corner.agreement >= config.agreement
        self._agreed[indices] = np.where(known, self._agreed[indices] + 1, 0)
        sure = self._agreed[indices] >= config.scans
        target = frames.canonical_to_robot(corner.target, turn_sign)[sure]
        away = target - pose.tip[sure]
        off = np.arctan2(away[:, 1], away[:, 0])[:, None] - beams[sure]
        self._target[indices[sure]] = target
        self._beam[indices[sure]] = np.abs(np.angle(np.exp(1j * off))).argmin(axis=1)


LOCATORS: dict[Variant, type[MapLocator] | type[PrintedLocator]] = {"map": MapLocator, "thesis": PrintedLocator}


def require_arm(robot: RobotSpec) -> None:
    """Check that approach I can drive a robot.

    Raises:
        PipenavError: its joints are not a slide followed by hinges.
    """
    if robot.hinges[0] or not robot.hinges[1:].all() or len(robot.hinges) < 2:
        kinds = ", ".join(joint.type for joint in robot.joints)
        raise PipenavError(f"approach I drives a slide followed by hinges; robot {robot.name!r} has {kinds}.")


def robot_for(robot: RobotSpec, variant: Variant) -> RobotSpec:
    """The robot whose fan the variant wants: the printed method counts on the printed fan of eq 3.16.

    Raises:
        PipenavError: as `require_arm`.
    """
    require_arm(robot)
    if variant != "thesis":
        return robot
    return robot.model_copy(update={"laser": robot.laser.model_copy(update={"fan": "printed"})})


def advance(robot: RobotSpec, config: LocateConfig, before: Floats, ranges: Floats) -> Floats:
    """Eq 3.18: how far the slide moves in this step, (n,) [m].

    A reading at the laser's minimum may be any distance below it, so it never counts as free.

    Args:
        robot: the robot.
        config: v0, delta and N.
        before: the step before's, (n,) [m].
        ranges: laser readings, (n, beams) [m].
    """
    ahead = np.abs(robot.laser.angles) <= config.front
    clear = ranges[:, ahead].min(axis=1) > max(config.delta, robot.laser.range_min)
    return np.where(clear, config.v0, before / config.slowdown)


def point_on_beam(robot: RobotSpec, q: Floats, beam: Ints, distance: float) -> Floats:
    """Eq 3.17 with eq 3.16's angles, in the robot's own frame: (n, 2) [m].

    The thesis counts a beam's angle beta from the head's right, the laser's `angles` from straight ahead.

    Args:
        robot: the robot.
        q: joint positions, (n, joints) [rad or m].
        beam: from 0, (n,).
        distance: L, along the beam [m].
    """
    pose = kinematics.forward(robot, q)
    heading = pose.headings[:, -1] + robot.laser.angles[beam]
    return np.asarray(pose.tip + distance * np.stack([np.cos(heading), np.sin(heading)], axis=1))
