"""A policy of the arm that moves a whole robot's front half: the clamped rear half is the mount, its wheels the slide.

The front half is the arm at another scale. Its three bending joints are the arm's hinges, and the laser is the same.
Lengths in the policy's observation are divided by the ratio of the two reaches; lengths in its actions are multiplied.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.policy import Policy
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.action import position_step
from pipenav.tasks.reach.observation import Snapshot, observe
from pipenav.tasks.registry import require_reach, task_of
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.observation import action_scale

SLOWER = 0.7
"""Another factor on the slide's steps: the whole robot's joints are half as fast as the arm's."""

HINGES = slice(3, 6)
"""Joints of the front half."""

DRIVING = 1
"""Wheel of the clamp that stands for the slide: the middle one, which carries the most."""

FRONT_MOUNT = 4
"""Point at which the front half begins, its first joint, counted from the robot's rear end."""


class ArmAction(NamedTuple):
    """Action of a whole robot that moves its front half as an arm.

    Attributes:
        wheels: share of the clamped wheels' speed, in [-1, 1].
        joints: steps of the front half's joints, in [-1, 1], (3,).
    """

    wheels: float
    joints: Floats


class FrontArm:
    """A policy that reaches a target, used as the front half of a whole robot.

    Args:
        robot: the whole robot.
        task: settings of the whole robot's task.
        policy: a policy of an arm.

    Raises:
        PipenavError: the policy is for another task or control, or for another laser.
    """

    def __init__(self, robot: RobotSpec, task: TraverseConfig, policy: Policy) -> None:
        self._robot, self._policy, self._arm = robot, policy, policy.header.robot
        self._task = require_reach(policy.header.task, "the front half")
        if self._task.control != "position" or len(self._arm.joints) != 1 + len(robot.joints) // 2:
            raise PipenavError(f"{policy.path} does not step a slide and as many hinges as half of {robot.name!r} has.")
        own, other = robot.laser, self._arm.laser
        if (own.beams, own.fan_deg, own.fan) != (other.beams, other.fan_deg, other.fan):
            raise PipenavError(f"{policy.path} was made for another laser than that of robot {robot.name!r}.")
        self._scale = float(robot.lengths[FRONT_MOUNT:].sum() / self._arm.lengths[1:].sum())
        parts = task_of(task).layout(robot)
        ends = np.cumsum([len(part.scale) for part in parts])
        self._seen = {
            part.name: (slice(end - len(part.scale), end), part.scale) for part, end in zip(parts, ends, strict=True)
        }
        full = action_scale(robot, task)
        step = position_step(self._arm, self._task)
        rim = (
            full[-1] * robot.wheels[DRIVING].radius * CONTROL_PERIOD
        )  # distance of a wheel at full speed in a step [m]
        self._step = np.array([SLOWER * self._scale * step[0] / rim, *(step[1:] / full[HINGES])])

    def target(self, pipe: PipeCorner) -> Floats:
        """Target of the front half's tip: the middle of the arm's target area, in a left turn, (2,) [m]."""
        left = pipe.model_copy(update={"turn": "left"})
        return (pipe.inner_edge + self._scale * sum(self._task.target_depth) / 2) * left.second_leg

    def reached(self, tip: Floats, target: Floats) -> bool:
        """Whether the tip is as near to the target as the arm's task asks for; both (2,) [m]."""
        return bool(np.hypot(*(tip - target)) <= self._task.reach_tolerance)

    def act(self, observation: Floats, points: Floats, target: Floats, start: float) -> ArmAction:
        """Action of the whole robot's wheels and of its front half.

        Args:
            observation: scaled observation of the whole robot, (size,).
            points: rear end, joints and tip in a left turn, (links + 1, 2) [m].
            target: target of the tip in a left turn, (2,) [m].
            start: x of the front half's first joint in the pipe's frame when the policy took over [m].
        """
        arm, scale = self._arm, self._scale
        seen = {name: observation[part] * size for name, (part, size) in self._seen.items()}
        d = np.diff(points[FRONT_MOUNT:], axis=0)
        headings = np.arctan2(d[:, 1], d[:, 0])
        slide = float(np.clip((points[FRONT_MOUNT, 0] - start) / scale, arm.lower[0], arm.upper[0]))
        q = np.array([slide, headings[0], *seen["q"][HINGES][1:]])
        speed = seen["wheel_speeds"][DRIVING] * self._robot.wheels[DRIVING].radius / scale
        qd = np.array([speed, *seen["qd"][HINGES]])
        ranges = np.clip(seen["ranges"] / scale, arm.laser.range_min, arm.laser.range_max)
        origin = np.array([start - arm.lengths[0] * scale, 0.0])  # origin of the arm's frame
        tip, target = (points[-1] - origin) / scale, (target - origin) / scale
        now = Snapshot(q[None], qd[None], ranges[None], tip[None], headings[-1:])
        state = observe(self._task, now, now, np.zeros_like(q[None]), target[None])
        scaled = state / task_of(self._task).observation_scale(arm)
        action = np.clip(self._policy.act(scaled)[0] * self._step, -1.0, 1.0)
        return ArmAction(float(action[0]), action[1:])
