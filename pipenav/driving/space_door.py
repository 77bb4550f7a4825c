"""The door of a robot in a route in space, which also has a roll joint."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.backends.spatial import SpaceReading
from pipenav.driving.ask import PERSON, Operator, Seen
from pipenav.driving.door import TURNING_LEASH, Door, Scene
from pipenav.driving.plane_roll import PlaneRoll, down_words
from pipenav.driving.primitives import AS_STEPS, ROLL
from pipenav.driving.rear_flip import RearFlip
from pipenav.driving.route_steps import roll_room
from pipenav.driving.slew import TO_FULL_SPEED, Slew, SlewLimits
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import check_robot, rolled_distance
from pipenav.tasks.rolling.manoeuvre import SETTLED, RollCommand
from pipenav.units import rad_to_deg

TWISTED = "the halves lie in different planes: finish the roll, or turn the roll joint back"
"""Why a step or primitive did not begin."""

OTHER_PLANE = "the next corner lies in another plane: roll into it first"
"""Why step (a) did not begin."""

NO_STRAIGHT = "a roll takes a straight: finish (e) first"
SAME_PLANE = "the robot lies in the next corner's plane"
NO_ROOM = "the corner behind is too near to roll: drive on, (e)"
"""Why a roll did not begin."""


class SpaceDoor(Door):
    """The door of a robot in space; arguments and attributes as those of `Door`.

    Raises:
        PipenavError: the robot cannot roll.
    """

    def __init__(self, robot: RobotSpec, operator: Operator | None, has_policy: bool) -> None:
        check_robot(robot)
        super().__init__(robot, operator, has_policy)
        self._roll_slew = Slew(roll_limits(robot), 1)
        self._roll_share = 0.0  # speed of the roll joint that is asked for by hand
        self._roll_goal = 0.0
        self._flip: RearFlip | None = None
        self._driven_on = 0.0  # distance since the roll began [m]
        self._rolled = (
            False  # since then (e) drives on clamped as the roll has left it: turning over would lose the plane
        )

    @property
    def told(self) -> Floats:
        """The last command, with the roll joint's set-point, (actuators + 1,)."""
        return np.append(self.command, self._roll_slew.last)

    @property
    def limits(self) -> Floats:
        return np.append(super().limits, roll_limits(self.robot).step)

    @property
    def step_done(self) -> bool:
        return self._plane.done if self.step == ROLL else super().step_done

    @property
    def in_space(self) -> dict[str, Any]:
        turned = {"roll": float(self._now.roll[0]), "roll_command": float(self._roll_slew.last[0])}
        return {**turned, "down": self._now.down[0].tolist(), "plane": self._plane.plane}

    @property
    def walls(self) -> Floats:
        """Walls of the corner that comes next where they cut the robot's plane, (k, 2, 2) [m]; those of the straight
        before it alone where it lies in another plane."""
        return self._plane.walls(self._shown)

    def in_its_plane(self, points: Floats) -> Floats:
        """Points of the route's frame, (m, 3), as `walls` has them, (m, 2) [m]."""
        return self._plane.projected(points, self._shown)

    @property
    def _shown(self) -> int:
        """Number of the corner that is shown."""
        if self._ahead is not None:
            return self._ahead
        return 0 if self._steps is None else self._steps.corner

    @property
    def scenery(self) -> str:
        """Words for which way is down, and how far the robot's plane is from that of the next corner."""
        corner = self._ahead
        off = (
            ""
            if corner is None
            else f"   the next corner's plane is {round(rad_to_deg(self._plane.away(corner))):+d}° from the robot's"
        )
        return down_words(self._plane.down(self._shown)) + off

    def start_in_space(self, reading: SpaceReading, scene: Scene, route: PipeRoute) -> None:
        """Begin an episode; readings are rows of one."""
        self._plane, self._now = PlaneRoll(self.robot, route), reading
        self._roll_slew.start(reading.roll)
        self._flip, self._rolled = None, False
        self.start(reading.body, scene)

    def next_in_space(self, reading: SpaceReading, policy: Callable[[], RollCommand] | None) -> RollCommand:
        """The command of the next control step, rows of one.

        Args:
            reading: readings of the robot's sensors, rows of one.
            policy: gives what the policy commands, if it is to drive; None without one.

        Raises:
            OperatorLost: the person's device is gone.
        """
        self._now, self._roll_share, before = reading, 0.0, self.who
        self._plane.see(reading)
        by_policy: list[Floats] = []

        def command() -> Floats:
            assert policy is not None
            told = policy()
            by_policy.append(told.roll)
            return np.asarray(told.values[0])

        values = self.next(reading.body, None if policy is None else command)
        if by_policy:
            if before == PERSON:
                self._roll_slew.hand_over()
            roll = self._roll_slew.policy(by_policy[0])
        else:
            roll = self._roll_by_hand()
        return RollCommand(values[None], roll)

    def _roll_by_hand(self) -> Floats:
        """The roll joint's set-point while a person drives, (1,)."""
        goal, speed = self._roll_slew.last[0], 1.0
        if self.step == ROLL:
            goal = self._roll_goal
        elif self._roll_share:
            goal, speed = np.copysign(np.inf, self._roll_share), min(abs(self._roll_share), 1.0)
        at = self._now.roll
        return self._roll_slew.person(np.clip([goal], at - TURNING_LEASH, at + TURNING_LEASH), speed)

    @property
    def _ahead(self) -> int | None:
        """Number of the corner whose plane is the next one to lie in; None where no corner follows."""
        steps = self._steps
        if steps is None or (steps.step == "e" and steps.last):
            return None
        return steps.corner + 1 if steps.step == "e" else steps.corner

    def _turn_sign(self, corner: int) -> float:
        return self._plane.turn_sign(corner)

    def _see(self, reading: Reading) -> None:
        if not self._rolled or self._steps is None or self._steps.step != "e":
            super()._see(reading)
            return
        if self.step != ROLL:  # a robot that rolls stays where it is
            assert reading.wheel_speeds is not None
            self._driven_on += float(rolled_distance(self.robot, reading.q, reading.wheel_speeds)[0])
        self._steps.keep(reading, self._driven_on)

    def _seen(self, reading: Reading) -> Seen:
        corner = self._ahead
        return super()._seen(reading)._replace(in_plane=corner is None or self._plane.fits(corner))

    def _begin(self, name: str, reading: Reading) -> None:
        steps = self._steps
        if abs(float(self._now.roll[0])) > SETTLED and (name != ROLL or self._plane.done):
            self.said = TWISTED
            return
        if steps is not None and AS_STEPS.get(name, name) == "a" and steps.step == "e" and steps.done:
            self._plane.lies(self._now, steps.corner + 1)
            if not self._plane.fits(steps.corner + 1):
                self.said = OTHER_PLANE
                return
        super()._begin(name, reading)
        if self.step == "a" and steps is not None:
            self._flip, self._rolled = RearFlip.needed(self.robot, steps.pipe, reading.q[0]), False
        if self.step == "e" and self._rolled and self._clamped is not None:
            self._clamped.begin("forward", reading, self.command[: self._joints])

    def _begin_roll(self, reading: Reading) -> None:  # noqa: ARG002  # `_now` has it all
        steps, corner = self._steps, self._ahead
        assert steps is not None
        if corner is None or self._plane.fits(corner):
            self.said = SAME_PLANE
        elif steps.step not in ("", "e"):
            self.said = NO_STRAIGHT
        elif steps.step == "e" and steps.rear < roll_room(self.robot, steps.pipe):
            self.said = NO_ROOM
        else:
            self._plane.begin(self._now, corner)
            self._under_way, self._rolled, self._driven_on = ROLL, True, self._driven_on if self._rolled else 0.0

    def _goal(self, reading: Reading) -> Floats | None:
        if self.step == "a" and self._flip is not None:
            flipping = self._flip.goal(reading.q[0])
            if not self._flip.done:
                return flipping
            self._flip = None
        if self.step == "e" and self._rolled and self._clamped is not None:
            forward = self._clamped.goal(reading)
            forward[self._joints :] *= not self.step_done
            return forward
        if self.step != ROLL:
            return super()._goal(reading)
        goal = self._plane.goal(self._now)
        self._roll_goal = float(goal.roll[0])
        return np.asarray(goal.values[0])

    def _turn_roll_joint(self, share: float) -> None:
        self._roll_share = share


def roll_limits(robot: RobotSpec) -> SlewLimits:
    """Limits of the commands to a roll joint, arrays of one: no faster than its motor turns without load."""
    assert robot.roll is not None
    joint = robot.roll.joint
    step = np.array([robot.actuators[joint.actuator].speed_limit * CONTROL_PERIOD])
    return SlewLimits(step, step / TO_FULL_SPEED, np.array([joint.lower]), np.array([joint.upper]))
