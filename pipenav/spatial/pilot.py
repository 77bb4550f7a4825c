"""What one robot in space knows and does besides its policy: where it is, and when and how far to roll.

It knows the pipe's drawing: its diameter, and of every corner the angle, the turn and the roll. All else it finds out from
its own sensors. Around a corner the policy drives; its front half heads another way there than its rear half, and when
they head the same way again the corner is behind. In a straight the robot clamps and rolls along; having left the
corner behind it turns its plane into that of the next one, and goes on until its laser sees a wall end.

How its plane lies tell its accelerometers, where a straight is not too steep for that, and else how far it has turned.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from pipenav.backend import CONTROL_PERIOD
from pipenav.pipe_run import PipeRun
from pipenav.robot import RobotSpec
from pipenav.space import SpaceReading
from pipenav.spatial.clamp import HALF, Drive, forwards, room, steepness
from pipenav.spatial.roll import Phase, Roll

Array = NDArray[np.float64]

ENTERED, BEHIND = 0.6, 0.2
"""Shares of a corner's turn by which the front half heads another way than the rear one: once more than the first, the
robot is around the corner; then less than the second, it has left it behind; so it has too when its wheels have rolled
on by its length since."""

STEADY = 3
"""Control steps for which the robot has to see something before it acts on it."""

MARGIN = 0.03
"""How far behind it leaves a corner before it rolls, besides what it stretches backwards [m]."""

TOLERANCE = math.radians(6.0)
"""How far the robot's plane may be from a corner's."""

GOES = 3
"""How often it rolls at most before a corner."""

STEEPEST = 0.25
"""Share of the weight that must pull across a straight for the accelerometers to tell how the robot's plane lies."""

AHEAD = (0.05, 0.21)
"""Beams that meet a straight's wall so far ahead of the laser tell that it ends [m]; the policy starts 60 to 100 mm
before a corner."""

UNLIKE = 0.25
"""They do by readings that differ from a straight's by more than this share."""


class Mode(IntEnum):
    """Who drives: the policy around a corner; or, in a straight, the robot going on to where it may roll, rolling, and
    going on to the next corner."""

    CORNER = 0
    LEAVE = 1
    ROLL = 2
    APPROACH = 3


class Pilot:
    """One robot's.

    Attributes:
        mode: who drives.
        corner: the corner ahead or around the robot.
        plane: how the robot's plane is turned from the straights' untwisted frames, as it knows [rad].
        set_points: of the joints, (6,) [rad].
    """

    def __init__(self, robot: RobotSpec, run: PipeRun, set_points: Array) -> None:
        self._robot, self._run = robot, run
        self.mode, self.corner, self.set_points = Mode.CORNER, 0, set_points
        self.plane = float(run.legs.inside[0]) - math.pi * (run.corners[0].turn == "right")
        self._entered, self._gone, self._since, self._goes = False, 0.0, 0, 0
        self._drive: Drive | None = None
        self._roll: Roll | None = None
        stretch = 2 * float(robot.lengths[HALF]) * (1 - math.cos(steepness(robot, run.radius)))
        self._leave = float(robot.lengths[0]) + stretch + MARGIN
        self.log: list[str] = []

    @property
    def side(self) -> float:
        """+1 where the corner turns to the robot's left, -1 to its right."""
        return 1.0 if math.cos(float(self._run.legs.inside[self.corner]) - self.plane) > 0 else -1.0

    def command(self, reading: SpaceReading, of_policy: Array) -> tuple[Array, float]:
        """Set-points of joints and wheels, (12,), and of the roll joint [rad].

        Args:
            reading: one robot's, its arrays without the first axis.
            of_policy: what the policy wants of joints and wheels, (12,).
        """
        bends, wheels, roll = reading.body.q, reading.body.wheel_speeds, 0.0
        assert wheels is not None
        command = of_policy
        if self._roll is not None:
            command, roll = self._roll.act(bends, float(reading.roll), wheels, reading.down)
        elif self._drive is not None:
            command = self._drive.act(bends, wheels)
        self.set_points = command[: 2 * HALF].copy()
        return command, roll

    def sense(self, reading: SpaceReading) -> None:
        """Take in what the sensors give after a control period, and decide who drives next."""
        if self.mode is Mode.CORNER:
            turned = self._side_of_halves(reading.body.q) * self.side
            whole = math.pi - self._run.corners[self.corner].angle
            self._entered |= turned > ENTERED * whole
            last = self.corner + 1 == len(self._run.corners)
            self._gone += self._rolled(reading) if self._entered else 0.0
            straight = self._lasts(self._entered and turned < BEHIND * whole)
            if (straight or self._gone > self._robot.length) and not last:
                self._corner_behind(reading)
        elif self._drive is not None and self.mode is Mode.LEAVE:
            if self._drive.ready and self._drive.gone >= self._leave:
                self._roll_or_go(reading)
        elif self._roll is not None:
            if self._roll.phase is Phase.DONE:
                self.plane += self._roll.turn
                self._roll = None
                self._roll_or_go(reading)
        elif self._drive is not None and self._lasts(self._sees_corner(reading, self._drive)):
            self._begin(Mode.CORNER)

    def _begin(self, mode: Mode) -> None:
        self.mode, self._since, self._drive, self._roll = mode, 0, None, None

    def _rolled(self, reading: SpaceReading) -> float:
        """How far the wheels rolled forwards in a control period, their mean [m]."""
        assert reading.body.wheel_speeds is not None
        speed = float((reading.body.wheel_speeds * forwards(reading.body.q)).mean())
        return CONTROL_PERIOD * self._robot.wheels[0].radius * speed

    def _lasts(self, seen: bool) -> bool:
        self._since = self._since + 1 if seen else 0
        return self._since >= STEADY

    def _corner_behind(self, reading: SpaceReading) -> None:
        inside = float(self._run.legs.inside[self.corner])
        self.plane = inside + math.pi * (self.side < 0)  # it came through in the corner's own plane
        self.corner += 1
        self._entered, self._gone, self._goes = False, 0.0, 0
        self._begin(Mode.LEAVE)
        self._drive = Drive(self._robot, self._run.radius, reading.body.q, self.set_points)

    def _roll_or_go(self, reading: SpaceReading) -> None:
        """Roll where the plane is not that of the corner ahead, else go on to it."""
        seen = self._seen_plane(reading)
        self.log.append(
            f"c{self.corner} knows {math.degrees(self.plane):.0f} sees {math.degrees(seen) if seen is not None else math.nan:.0f}"
        )
        self.plane = self.plane if seen is None else seen
        away = math.remainder(float(self._run.legs.inside[self.corner]) - self.plane, math.pi)
        bends = reading.body.q
        if abs(away) > TOLERANCE and self._goes < GOES:
            self._goes += 1
            self._begin(Mode.ROLL)
            self._roll = Roll(self._robot, self._run.radius, away, bends, reading.down)
        else:
            self._begin(Mode.APPROACH)
            self._drive = Drive(self._robot, self._run.radius, bends, self.set_points)

    def _side_of_halves(self, bends: Array) -> float:
        """By how much the front half heads to the left of the rear half, each from its first wheel to its last [rad]."""
        way = self._ways(bends)
        rear, front = way[1:HALF].sum(axis=0), way[HALF + 1 : 2 * HALF].sum(axis=0)
        return math.atan2(rear[0] * front[1] - rear[1] * front[0], rear @ front)

    def _ways(self, bends: Array) -> Array:
        """From one end of each link to the other, (links, 2) [m], in the frame of the first link."""
        headings = np.cumsum(np.append(0.0, bends))
        return self._robot.lengths[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1)

    def _seen_plane(self, reading: SpaceReading) -> float | None:
        """The plane's angle from the accelerometers; None where the straight is too steep."""
        across = -self._run.legs.axes[self.corner][2]  # which way is down, in the straight's frame
        if math.hypot(across[1], across[2]) < STEEPEST or not np.any(reading.down):
            return None
        way = self._ways(reading.body.q)
        axis = way[1:-1].sum(axis=0)
        heading = math.atan2(way[HALF, 1], way[HALF, 0]) - math.atan2(axis[1], axis[0])  # of the divided link
        x, y, z = reading.down.mean(axis=0)
        sideways = math.sin(heading) * x + math.cos(heading) * y
        return math.atan2(across[2], across[1]) - math.atan2(z, sideways)

    def _sees_corner(self, reading: SpaceReading, drive: Drive) -> bool:
        """Whether a wall ends ahead of a clamped robot: its last two wheels stand on either wall."""
        lidar, radius = self._robot.laser, self._run.radius
        way = self._ways(reading.body.q)
        front = way[HALF + 1 : 2 * HALF].sum(axis=0)  # along the axis: from one wheel to another one on the same wall
        heading = math.atan2(front[0] * way[-1, 1] - front[1] * way[-1, 0], front @ way[-1])
        offset = -drive.third * room(self._robot, radius) + float(self._robot.lengths[-1]) * math.sin(heading)
        beams = lidar.angles + heading
        across = np.where(beams > 0, radius - offset, radius + offset)
        straight = across / np.maximum(np.abs(np.sin(beams)), 1e-6)
        ahead = straight * np.cos(beams)
        telling = (ahead >= AHEAD[0]) & (ahead <= AHEAD[1])
        return drive.ready and bool((reading.body.ranges - straight > UNLIKE * straight)[telling].any())
