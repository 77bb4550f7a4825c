"""The steps (a) to (e) on each corner of a route, one corner after the other.

After (e) the robot drives on, clamped, until it is near the next corner; there (e) is done, and (a) begins anew. How
far the next corner is, the drawing and the wheels say, until the laser sees that corner.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pipenav.backends.messages import Reading
from pipenav.driving.steps import STEPS, StepDriver, StepGoal
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe, Turn
from pipenav.pipes.route import as_route
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, steepness
from pipenav.units import m_to_mm, rad_to_deg

NEAR = 0.09
"""Distance of the tip before the next corner's inner edge at which a robot has driven on far enough [m]: a counted
distance is wrong by a tenth."""


class CornerRow(NamedTuple):
    """Corners of a pipe, as a person reads them from its drawing.

    Attributes:
        corners: the corners, each as a pipe of its own; the turns of those in space mean nothing.
        spacing: distances from each corner to the next one along the centre line [m].
    """

    corners: tuple[PipeCorner, ...]
    spacing: tuple[float, ...]


def corner_row(pipe: Pipe | None) -> CornerRow | None:
    """Corners of a pipe; None where it is not known, or has other fittings than corners."""
    if pipe is None:
        return None
    if pipe.corner is not None and not pipe.corner.branches:
        return CornerRow((pipe.corner,), ())
    route = as_route(pipe)
    if route.has_fittings:
        return None
    signs = np.ones(len(route.corners)) if route.in_space else route.turn_signs
    corners = tuple(
        PipeCorner.of(
            m_to_mm(pipe.diameter),
            rad_to_deg(corner.angle),
            "left" if sign > 0 else "right",
            m_to_mm(corner.bend_radius),
        )
        for corner, sign in zip(route.corners, signs, strict=True)
    )
    return CornerRow(corners, tuple(float(straight) for straight in route.straights[1:-1]))


def least_spacing(robot: RobotSpec, before: PipeCorner, after: PipeCorner) -> float:
    """Distance of two corners from which on a robot has room for its steps between them [m].

    All its wheels are past one corner before its tip comes to the next.
    """
    return before.inner_edge + float(robot.lengths[1:].sum()) + after.inner_edge


def roll_room(robot: RobotSpec, pipe: PipeCorner) -> float:
    """Distance past a corner at which the rear end lies at least before a robot may roll [m]: a half that stretches
    becomes longer."""
    steep = float(steepness(robot, pipe.radius))
    return 2 * float(robot.lengths[HALF]) * (1 - math.cos(steep))


def require_room(robot: RobotSpec, pipe: Pipe) -> None:
    """Refuse a pipe that cannot be driven through by steps alone.

    Raises:
        PipenavError: it has other fittings than corners, or corners too close to each other.
    """
    row = corner_row(pipe)
    if row is None:
        raise PipenavError(f"{pipe.label} has other fittings than corners, which steps are not for: name another pipe.")
    for number, spacing in enumerate(row.spacing, 1):
        before, after = row.corners[number - 1 : number + 1]
        least = least_spacing(robot, before, after)
        if pipe.in_space:
            least += float(robot.lengths[0]) + roll_room(robot, before) + NEAR
        if spacing < least:
            raise PipenavError(
                f"{pipe.label} has {m_to_mm(spacing):.0f} mm between its corners {number} and {number + 1}, and steps "
                f"take at least {m_to_mm(least):.0f} mm there: name another pipe, or let a policy drive."
            )


class RouteSteps:
    """Carries out the steps on one robot, corner after corner; other arguments and attributes as `StepDriver`.

    Args:
        robot: the robot.
        row: the corners.
        tip_gap: distance of the tip before the first inner wall's bend at the start, about [m].
        reading: readings at the start, rows of one.
        turn_sign: by the number of a corner, +1 where it turns to the robot's left as the robot lies, else -1.

    Attributes:
        corner: number of the corner that the steps are about, from 0.
        pipe: that corner, as it turns for the robot when it begins with it.
        refusal: why the last step that was asked for did not begin; empty where it did.

    Raises:
        PipenavError: the robot is built otherwise.
    """

    def __init__(
        self,
        robot: RobotSpec,
        row: CornerRow,
        tip_gap: float,
        reading: Reading,
        turn_sign: Callable[[int], float],
    ) -> None:
        self._robot, self._row, self._reading, self._turn_sign = robot, row, reading, turn_sign
        self.corner, self.refusal = 0, ""
        self._kept: float | None = None  # distance to the next corner when a robot began to roll into its plane
        self._driven_on = 0.0
        self.pipe = self._as_it_turns()
        self._steps = StepDriver(robot, self.pipe, tip_gap, reading)

    def _as_it_turns(self) -> PipeCorner:
        """The corner that the steps are about, with its turn as the robot lies."""
        turn: Turn = "left" if self._turn_sign(self.corner) > 0 else "right"
        return self._row.corners[self.corner].model_copy(update={"turn": turn})

    @property
    def step(self) -> str:
        """The step that is under way; empty before the first one."""
        return self._steps.step

    @property
    def last(self) -> bool:
        """Whether no other corner follows."""
        return self.corner + 1 == len(self._row.corners)

    @property
    def done(self) -> bool:
        """Whether the step that is under way is done: (e) is where the next corner is near, and never in the last."""
        if self.step == "e":
            return not self.last and self._ahead() <= NEAR
        return self._steps.done

    @property
    def rear(self) -> float:
        """Distance of the rear end past the end of the corner's inner bend, after `see` [m]."""
        return self._steps.rear - self.pipe.inner_edge

    def see(self, reading: Reading) -> None:
        """Take in the readings after a control period, whoever drove in it; rows of one."""
        self._reading = reading
        self._steps.see(reading)

    def keep(self, reading: Reading, driven_on: float) -> None:
        """Take in, in place of `see`, the readings of a robot that rolled into another plane after (e).

        Args:
            reading: readings after a control period, rows of one.
            driven_on: distance that it drove on since it began to roll [m].
        """
        if self._kept is None:
            self._kept = self._ahead()
        self._reading, self._driven_on = reading, driven_on

    def begin(self, step: str) -> None:
        """Begin a step, if it is the next one or the one before; `refusal` says why not."""
        self.refusal = ""
        if step == "a" and self.step == "e" and not self.last:
            if not self.done:
                self.refusal = "the next corner is not near yet: (a) comes when (e) is done"
                return
            self._next_corner()
        self._steps.begin(step)
        self.refusal = self._steps.refusal

    def goal(self) -> StepGoal:
        """The step's goal for this control step, after `see`."""
        goal = self._steps.goal()
        if self.step != "e" or not self.done:
            return goal
        return goal._replace(wheels=np.zeros_like(goal.wheels), done=True)

    def _ahead(self) -> float:
        """Distance of the tip before the next inner wall's bend, by the wheels [m]."""
        if self._kept is not None:
            return self._kept - self._driven_on
        following = self._row.corners[self.corner + 1]
        return self._row.spacing[self.corner] - following.inner_edge - self._steps.tip

    def _next_corner(self) -> None:
        gap, self._kept = max(self._ahead(), 0.0), None
        self.corner += 1
        self.pipe = self._as_it_turns()
        self._steps = StepDriver(self._robot, self.pipe, gap, self._reading)
        self._steps.see(self._reading)


def order_after(step: str) -> str:
    """The step after another one; after (e) comes (a) again."""
    order = "".join(STEPS)
    return order[(order.index(step) + 1) % len(order)]
