"""States of eq 3.1 and 3.2, mirrored for right turns, scaled by fixed physical numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.layout import BEYOND_STOP, IMPACT, ObservationField
from pipenav.tasks.reach.config import ReachConfig

POSITION_SCALE = 0.5
"""Scale of observed positions [m]: about the robot's reach, so that values stay near [-1, 1]."""

FARTHEST = 100.0
"""Bound of observed positions, in `POSITION_SCALE`: 50 m, farther than any corner is large."""

NEAR = 0.03
"""Distance at which `goal_near` has half its length [m]: that value resolves the last centimetres before the target."""


class Snapshot(NamedTuple):
    """Readings of one control step in the canonical frame, with the tip's pose that follows from them.

    Attributes:
        q, qd: joint positions and speeds, (n, joints) [rad or m, per s].
        ranges: laser readings from right to left, (n, beams) [m].
        tip: position of the tip, (n, 2) [m].
        heading: heading of the last link, (n,) [rad].
    """

    q: Floats
    qd: Floats
    ranges: Floats
    tip: Floats
    heading: Floats

    def part(self, indices: Ints) -> Snapshot:
        """Snapshot of some robots, k of them."""
        return Snapshot(*(column[indices] for column in self))

    def put(self, indices: Ints, part: Snapshot) -> None:
        """Overwrite some robots' rows with those of `part`, in place."""
        for column, rows in zip(self, part, strict=True):
            column[indices] = rows


def canonical(robot: RobotSpec, reading: Reading, turn_sign: Floats) -> Snapshot:
    """Readings in the canonical frame, as if every turn were a left turn.

    Args:
        robot: the robot.
        reading: readings of the sensors in the robot's own frame.
        turn_sign: +1 for a left turn, -1 for a right one, (n,).
    """
    signs = joint_signs(robot, turn_sign)
    ranges = np.where(turn_sign[:, None] > 0, reading.ranges, reading.ranges[:, ::-1])
    q = reading.q * signs
    pose = kinematics.forward(robot, q)
    return Snapshot(q, reading.qd * signs, ranges, pose.tip, pose.headings[:, -1])


def joint_signs(robot: RobotSpec, turn_sign: Floats) -> Floats:
    """Factor on joint positions, speeds and actions that turns them into the canonical frame or back, (n, joints)."""
    return np.where(turn_sign[:, None] > 0, 1.0, robot.mirror_signs)


def layout(robot: RobotSpec, config: ReachConfig) -> list[ObservationField]:
    """Parts of the observation, in order."""
    joints = len(robot.joints)
    position = np.maximum(-robot.lower, robot.upper)
    ranges = np.full(robot.laser.beams, robot.laser.range_max)
    q = ObservationField("q", "rad, m", position, BEYOND_STOP)
    qd = ObservationField("qd", "rad/s, m/s", robot.speed_limits, IMPACT)
    scans = ObservationField("ranges", "m", ranges)
    xy = np.full(2, POSITION_SCALE)
    tip, target = (ObservationField(name, "m", xy, FARTHEST) for name in ("p_ee", "p_goal"))
    in_tip, near = ObservationField("goal_in_tip", "m", xy, FARTHEST), ObservationField("goal_near", "1", np.ones(2))
    relative = [q, qd, scans, in_tip, near]
    if config.observation == "relative":
        return relative
    if config.observation == "basic":
        return [q, qd, tip, target, scans]
    before = [part._replace(name=f"{part.name}_before") for part in (q, qd, scans)]
    action = ObservationField("action_before", "1", np.ones(joints))
    if config.observation == "relative-history":
        return [*relative, before[-1], action]
    return [q, qd, scans, *before, action, tip, target]


def observe(config: ReachConfig, now: Snapshot, before: Snapshot, action_before: Floats, target: Floats) -> Floats:
    """Unscaled observation, (n, size).

    `basic` is eq 3.1, `[q, qd, p_ee, p_goal, D]`, and `history` is eq 3.2, which adds the step before. `relative` sees
    the target from the tip; `relative-history` adds the scan before and the last action.

    Args:
        config: settings, which name the state.
        now: readings of this step.
        before: readings of the step before; at the first step the same as `now`.
        action_before: the last action in the canonical frame, zero at the first step, (n, joints).
        target: the target in the canonical frame, (n, 2) [m].
    """
    tip = now.tip
    if config.observation in ("relative", "relative-history"):
        target_in_tip = _in_tip_frame(target - tip, now.heading)
        distance = np.hypot(target_in_tip[:, :1], target_in_tip[:, 1:])
        near = target_in_tip / (distance + NEAR)
        seen = [now.q, now.qd, now.ranges, target_in_tip, near]
        memory = [before.ranges, action_before] if config.observation == "relative-history" else []
        return np.concatenate([*seen, *memory], axis=1)
    if config.observation == "basic":
        return np.concatenate([now.q, now.qd, tip, target, now.ranges], axis=1)
    return np.concatenate(
        [now.q, now.qd, now.ranges, before.q, before.qd, before.ranges, action_before, tip, target], axis=1
    )


def _in_tip_frame(vector: Floats, heading: Floats) -> Floats:
    """Vectors of the canonical frame, (n, 2), in frames turned by `heading`, (n,)."""
    cos, sin = np.cos(heading), np.sin(heading)
    x, y = vector[:, 0], vector[:, 1]
    return np.array([cos * x + sin * y, cos * y - sin * x]).T
