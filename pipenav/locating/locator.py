"""Approach I (thesis 3.4, 5.3.1): the robot finds a target around the corner by itself.

It sees its own sensors and is told which exit to take (`Told`), nothing else. There are two ways to do it,
`printed_locator` and `map_locator`; `variants` names them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple, Protocol

import numpy as np
from pydantic import Field

from pipenav.arrays import Flags, Floats, Ints, Table
from pipenav.backends.messages import Reading
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Turn
from pipenav.robots.robot import RobotSpec

Variant = Literal["map", "thesis"]
"""Names of the two ways."""


class LocateConfig(Table):
    """Settings of approach I; the thesis's numbers are those of its eq 5.2."""

    omega0: float = Field(0.15, gt=0, description="turn of the head per control step [rad] (eq 3.18; thesis variant)")
    v0: float = Field(0.02, gt=0, description="advance of the slide per control step [m] (eq 3.18)")
    delta: float = Field(0.05, gt=0, description="front distance below which the advance slows down [m] (eq 3.18)")
    slowdown: float = Field(8.0, gt=1, description="N of eq 3.18: divisor of the advance in each such step")
    front: float = Field(
        math.radians(20),
        gt=0,
        description="half width of the fan that looks ahead [rad]; the thesis gives none. Chosen: the 20 mm arm at a "
        "distance delta covers 11 deg to either side, and the walls of a 70 mm pipe come in at 35 deg",
    )
    open_range: float = Field(0.3, gt=0, description="L_o: a longer beam shows an open space [m] (eq 3.19)")
    target_range: float = Field(0.2, gt=0, description="L: distance of the target along that beam [m] (eq 3.17)")

    depth: float = Field(
        0.1, gt=0, description="distance of the target past the inner edge [m]: the middle of the task's target area"
    )
    tolerance: float = Field(
        0.01, gt=0, description="largest distance from a wall of a beam that votes for it [m]: two steps of the laser"
    )
    spread: float = Field(
        0.015,
        gt=0,
        description="largest distance of other possible targets from a known one [m]; the tip reaches to 0.02",
    )
    votes: float = Field(4.0, ge=1, description="votes of beams that must agree on the second leg's outer wall")
    agreement: float = Field(
        0.4,
        gt=0,
        le=1,
        description="least share of those votes in all beams that end beyond the corner: where readings scatter by as "
        "much as `tolerance`, right ones give half a vote each",
    )
    scans: int = Field(2, ge=1, description="scans in a row that must find the same target")


class Told(NamedTuple):
    """Knowledge that k robots are given about the fitting ahead.

    Attributes:
        turn_sign: +1 where the exit, or the branch beside an exit straight on, lies to the left, -1 to the right, (k,).
        tee: whether the fitting is a tee or a cross, with other exits besides, (k,).
        straight: whether the exit is straight on, (k,).
        bend: whether the fitting is a swept bend, which has no inner edge to look for, (k,).
    """

    turn_sign: Floats
    tee: Flags
    straight: Flags
    bend: Flags

    @classmethod
    def of(cls, pipes: Sequence[PipeCorner]) -> Told:
        """Knowledge about pipes, in which each robot takes the second leg."""
        tee = np.array([bool(pipe.branches) for pipe in pipes], bool)
        straight = np.array([pipe.as_route_corner.straight_on for pipe in pipes], bool)
        bend = np.array([pipe.bend_radius > 0 for pipe in pipes], bool)
        return cls(np.array([pipe.turn_sign for pipe in pipes]), tee, tee & straight, bend)


class Exit(NamedTuple):
    """The exit that one arm takes, in words that a person gives.

    Attributes:
        turn: side on which it lies; straight on, the side of the branch that the arm passes.
        tee: whether the fitting is a tee or a cross.
        straight: whether the exit is straight on.
        bend: whether the fitting is a swept bend.
    """

    turn: Turn
    tee: bool = False
    straight: bool = False
    bend: bool = False

    @classmethod
    def of(cls, pipe: PipeCorner) -> Exit:
        """Exit of an arm that takes a pipe's second leg."""
        tee = bool(pipe.branches)
        return cls(pipe.turn, tee, tee and pipe.as_route_corner.straight_on, pipe.bend_radius > 0)

    @property
    def turn_sign(self) -> float:
        """+1 for left, -1 for right."""
        return 1.0 if self.turn == "left" else -1.0

    @property
    def told(self) -> Told:
        """Knowledge of this exit, for k = 1 robots."""
        return Told(np.array([self.turn_sign]), np.array([self.tee]), np.array([self.straight]), np.array([self.bend]))

    @property
    def label(self) -> str:
        """The exit in words."""
        if self.straight:
            return f"straight on past a branch to the {self.turn}"
        if self.bend:
            return f"around a bend to the {self.turn}"
        return f"to the {self.turn} in a tee" if self.tee else f"around a {self.turn} turn"


class SearchStep(NamedTuple):
    """Next step of k robots, and the targets that they know.

    Attributes:
        set_points: set-points in the robot's own frame, (k, joints) [rad or m].
        done: whether each robot has finished locating, (k,).
        target: in the robot's own frame, (k, 2) [m]; NaN before one is found.
        beam: index of the beam on or nearest to the target, from right to left, (k,); -1 before one is found.
    """

    set_points: Floats
    done: Flags
    target: Floats
    beam: Ints


class Locator(Protocol):
    """A behaviour of n robots that finds targets from the readings of their sensors.

    Attributes:
        n: number of robots.
    """

    n: int

    def start(self, indices: Ints, reading: Reading, told: Told) -> None:
        """Begin anew with k robots.

        Args:
            indices: which robots, sorted and unique, (k,).
            reading: readings of these robots.
            told: knowledge that each of them is given.
        """
        ...

    def act(self, reading: Reading) -> SearchStep:
        """Decide one control step of all n robots."""
        ...


def require_arm(robot: RobotSpec) -> None:
    """Check that approach I can move a robot.

    Raises:
        PipenavError: the robot's joints are not a slide followed by hinges.
    """
    if robot.hinges[0] or not robot.hinges[1:].all() or len(robot.hinges) < 2:
        kinds = ", ".join(joint.type for joint in robot.joints)
        problem = f"approach I drives a slide followed by hinges, and robot {robot.name!r} has {kinds}"
        raise PipenavError(f"{problem}: choose another robot, for example basic.")
    front = LocateConfig().front
    if not (np.abs(robot.laser.angles) <= front).any():
        raise PipenavError(
            f"approach I looks ahead, and robot {robot.name!r} has no beam within {np.degrees(front):.0f} deg of its "
            "tip's axis: give its laser more beams."
        )


def robot_for(robot: RobotSpec, variant: Variant) -> RobotSpec:
    """The robot with the fan that a variant needs: the printed method relies on the printed fan of eq 3.16.

    Raises:
        PipenavError: the robot's joints are not a slide followed by hinges.
    """
    require_arm(robot)
    if variant != "thesis":
        return robot
    return robot.model_copy(update={"laser": robot.laser.model_copy(update={"fan": "printed"})})


def advance(robot: RobotSpec, config: LocateConfig, before: Floats, ranges: Floats) -> Floats:
    """Advance of the slide in this step by eq 3.18, (n,) [m].

    A reading at the laser's minimum may be any distance below it, so it never counts as free.

    Args:
        robot: the robot.
        config: settings, with v0, delta and N.
        before: advance in the step before, (n,) [m].
        ranges: laser readings, (n, beams) [m].
    """
    ahead = np.abs(robot.laser.angles) <= config.front
    clear = ranges[:, ahead].min(axis=1) > max(config.delta, robot.laser.range_min)
    return np.where(clear, config.v0, before / config.slowdown)
