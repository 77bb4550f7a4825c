"""States of eq 3.1 and 3.2, mirrored for right turns, scaled by fixed physical numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.layout import ObservationField
from pipenav.tasks.reach.config import ReachConfig

POSITION_SCALE = 0.5
"""Positions are observed in units of this [m]: about the robot's reach, so that values stay near [-1, 1]."""

NEAR = 0.03
"""Distance at which `goal_near` has half its length [m]: it resolves the last centimetres, where success is decided."""


class Snapshot(NamedTuple):
    """Readings of one control step in the canonical frame, and where that puts the tip.

    Attributes:
        q, qd: joint positions and speeds, (n, joints) [rad or m, per s].
        ranges: laser readings from right to left, (n, beams) [m].
        tip: (n, 2) [m].
        heading: of the last link, (n,) [rad].
    """

    q: Floats
    qd: Floats
    ranges: Floats
    tip: Floats
    heading: Floats

    def part(self, indices: Ints) -> Snapshot:
        """The snapshot of some robots, k of them."""
        return Snapshot(*(column[indices] for column in self))

    def put(self, indices: Ints, part: Snapshot) -> None:
        """Make some robots' rows those of `part`, in place."""
        for column, rows in zip(self, part, strict=True):
            column[indices] = rows


def canonical(robot: RobotSpec, reading: Reading, turn_sign: Floats) -> Snapshot:
    """Readings as if every turn were a left turn.

    Args:
        robot: the robot.
        reading: what the sensors give.
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
    """The observation's parts in order, with the scale that each value is divided by."""
    joints = len(robot.joints)
    position = np.maximum(-robot.lower, robot.upper)
    ranges = np.full(robot.laser.beams, robot.laser.range_max)
    q, qd = ObservationField("q", "rad, m", position), ObservationField("qd", "rad/s, m/s", robot.speed_limits)
    scans = ObservationField("ranges", "m", ranges)
    xy = np.full(2, POSITION_SCALE)
    tip, target = ObservationField("p_ee", "m", xy), ObservationField("p_goal", "m", xy)
    relative = [q, qd, scans, ObservationField("goal_in_tip", "m", xy), ObservationField("goal_near", "1", np.ones(2))]
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
    """Unscaled observation, (n, size): eq 3.1 `[q, qd, p_ee, p_goal, D]`, eq 3.2 with the step before, or
    `relative`, of which `relative-history` also has the scan before and the last action.

    Args:
        config: names the state.
        now: this step's readings.
        before: the step before's; at the first step the same as `now`.
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
    """World vectors (n, 2) in frames turned by `heading` (n,)."""
    cos, sin = np.cos(heading), np.sin(heading)
    x, y = vector[:, 0], vector[:, 1]
    return np.array([cos * x + sin * y, cos * y - sin * x]).T
