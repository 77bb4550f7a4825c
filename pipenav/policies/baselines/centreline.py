"""`baseline:centreline`: a scripted controller that knows the pipe and leads the arm along a line around the corner.

The hinges follow the leader: every link's far end lies on one line that swings wide before and after the corner, as a
long vehicle does. How wide is chosen per pipe, by the clearance that the whole motion keeps. Where that stays small,
the hinge angles are improved one waypoint at a time. It sees the pipe, which no policy does: it says what geometry
allows, not what a controller with sensors can do.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import clearance
from pipenav.policies.controller import PrivilegedController
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach import action
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig

ENTRY = 0.12
"""How far before the corner the line leaves the first leg's axis [m]: one link of the arm."""

BEYOND = 0.05
"""How far the line runs on past the target [m], for the tip to slide along when it has to stop off a waypoint."""

LINE_POINTS = 30
"""Points of each of the line's four curves: some millimetres apart."""

WAYPOINTS = 40
"""Poses along the slide's whole travel, about a centimetre apart."""

WIDE_ENOUGH = 0.006
"""Clearance [m] that leaves room for the servos' lag; what is above it is as good as this."""

WIDTHS = ((0.5, 0.6, 0.7, 0.78, 0.84), (0.2, 0.3, 0.4, 0.5, 0.65, 0.8), (0.5, 0.6, 0.7, 0.8))
"""Lines to choose from: distance from the inner wall before, at and after the corner, in diameters."""

ROUNDS, FIRST_MOVE, SHRINK = 40, 0.08, 0.96
"""The improvement's rounds, the first change of an angle that it tries [rad], and what it shrinks by per round."""

BEND_COST = 0.02
"""What a bend of 1 rad between neighbouring waypoints costs, as clearance [m]: keeps the motion smooth."""

TARGET_COST = 0.5
"""What a millimetre of the tip's distance to the target costs, in millimetres of clearance."""


class PlannedMotion(NamedTuple):
    """A motion through one pipe.

    Attributes:
        q: waypoints in the robot's frame, the slide's position rising, (k, joints) [m, rad].
        score: its smallest clearance [m], less a metre or more where it ends short of the target.
    """

    q: Floats
    score: float


class CentrelineController(PrivilegedController[ReachBatch]):
    """Position control along a motion that is planned at an episode's start.

    Raises:
        PipenavError: a robot that is not a slide followed by hinges.
    """

    batch_type = ReachBatch
    only = "baseline:centreline leads an arm around a corner: choose a single corner, as d=90,angle=90."

    def __init__(self, robot: RobotSpec, task: ReachConfig | None = None) -> None:
        kinds = [joint.type for joint in robot.joints]
        if kinds[0] != "slide" or "slide" in kinds[1:] or len(kinds) < 2:
            raise PipenavError(
                f"baseline:centreline drives a slide followed by hinges; robot {robot.name!r} has {', '.join(kinds)}."
            )
        self.robot = robot
        self.task = self.config = task or ReachConfig(control="position")
        self._lines: dict[PipeCorner, tuple[float, ...]] = {}
        self._ways: dict[int, tuple[object, Floats]] = {}

    def act(self, observation: Floats, batch: ReachBatch) -> Floats:  # noqa: ARG002  # the batch tells more
        q, target, edge = batch.snapshot.q, batch.target, batch.edge
        step = action.position_step(self.robot, self.config)
        actions = np.zeros((batch.n, len(step)))
        for i, pipe in enumerate(batch.pipes):
            if pipe is not None:
                actions[i] = _towards(self._way(i, pipe, target[i], edge[i]), q[i], step)
        return actions

    def _way(self, robot: int, pipe: PipeCorner, target: Floats, edge: Floats) -> Floats:
        """The waypoints of one robot's episode, planned when its pipe or its target is new: (k, joints)."""
        key = (pipe, *target, *edge)
        known = self._ways.get(robot)
        if known is None or known[0] != key:
            left = pipe.model_copy(update={"turn": "left"})
            base = -left.tangent_length(left.radius) - float(edge[0])
            known = self._ways[robot] = key, self._plan(left, base, frames.robot_to_pipe(target, base))
        return known[1]

    def _plan(self, pipe: PipeCorner, base: float, target: Floats) -> Floats:
        if pipe not in self._lines:
            self._lines[pipe] = self._choose_line(pipe)
        way = _follow_line(self.robot, pipe, base, target, self._lines[pipe])
        if way.score < WIDE_ENOUGH:
            return _improve(self.robot, pipe, base, target, way.q)
        return way.q

    def _choose_line(self, pipe: PipeCorner) -> tuple[float, ...]:
        """A good line for the middle of the target area, from the farthest start: one width after the other, twice."""
        depth = pipe.inner_edge + sum(self.config.target_depth) / 2
        base = -pipe.inner_edge - self.config.start_gap[1] - self.robot.length
        target = depth * pipe.second_leg
        best = tuple(choices[len(choices) // 2] for choices in WIDTHS)
        for place in (0, 1, 2) * 2:
            lines = [(*best[:place], width, *best[place + 1 :]) for width in WIDTHS[place]]
            best = max(lines, key=lambda line: _follow_line(self.robot, pipe, base, target, line).score)
        return best


def _towards(way: Floats, q: Floats, step: Floats) -> Floats:
    """The action that leads along the waypoints, (joints,): the farthest waypoint within one step, or a part of the way
    to the next one, all joints in proportion."""
    away = np.abs((way - q) / step).max(axis=1)  # (k,)
    nearest = int(away.argmin())
    target = min(nearest + 1, len(way) - 1)
    while target + 1 < len(way) and away[target + 1] <= 1.0:
        target += 1
    return np.asarray((way[target] - q) / step / max(1.0, away[target]))


def _follow_line(
    robot: RobotSpec, pipe: PipeCorner, base: float, target: Floats, widths: tuple[float, ...]
) -> PlannedMotion:
    """The motion of a chain whose hinges follow the leader along one line, up to where the tip reaches the target.

    Args:
        robot: a slide, then hinges.
        pipe: a left turn.
        base: where the robot's frame starts, x in the pipe's frame [m].
        target: target in the pipe's frame, (2,) [m].
        widths: see `WIDTHS`.
    """
    line, end = _line(pipe, target, widths)
    top = robot.upper - 0.01 * (robot.upper - robot.lower)  # off the limits, which end an episode
    q = np.zeros((WAYPOINTS, len(robot.links)))
    q[:, 0] = np.linspace(0.0, top[0], WAYPOINTS)
    hinge = np.stack([q[:, 0] + base + robot.links[0].length, np.zeros(WAYPOINTS)], axis=1)  # (k, 2)
    nearest = np.hypot(*np.moveaxis(line - hinge[:, None], -1, 0)).argmin(axis=1)
    at = np.where(hinge[:, 0] < line[1, 0], 0.0, nearest)
    heading = np.zeros(WAYPOINTS)
    for j, link in enumerate(robot.links[1:], 1):
        far_end, at = reach(line, hinge, at, link.length)
        direction = np.arctan2(*(far_end - hinge).T[::-1])
        q[:, j] = np.mod(direction - heading + math.pi, 2 * math.pi) - math.pi
        hinge, heading = far_end, direction
    arrived = np.flatnonzero(at >= end)
    if len(arrived):
        last = max(int(arrived[0]), 1)
        share = (end - at[last - 1]) / (at[last] - at[last - 1])
        q[last] = q[last - 1] + share * (q[last] - q[last - 1])
        q = q[: last + 1]
    missing = 0.0 if len(arrived) else 1.0 + end - float(at[-1])
    room = float(clearance(robot, pipe, q, base).min())
    too_bent = float((np.abs(q[:, 1:]) > np.minimum(top, -robot.lower)[1:]).any())
    return PlannedMotion(q, room - missing - too_bent)


def _line(pipe: PipeCorner, target: Floats, widths: tuple[float, ...]) -> tuple[Floats, int]:
    """The line around a left turn's corner, (p, 2) [m], and the index of the point at the target."""
    before, at, after = pipe.diameter * np.array(widths)
    turn = math.pi - pipe.angle
    along, across = pipe.second_leg, np.array([math.sin(turn), -math.cos(turn)])
    edge = pipe.apex(pipe.radius) * np.array([-math.sin(turn / 2), math.cos(turn / 2)])
    t = np.linspace(0.0, 1.0, LINE_POINTS, endpoint=False)[:, None]
    smooth = t * t * (3 - 2 * t)
    entry = np.concatenate([edge[0] + ENTRY * (t - 1), smooth * (edge[1] - before)], axis=1)
    ease = (1 - np.cos(math.pi * t)) / 2
    width = before + (after - before) * ease + (at - (before + after) / 2) * np.sin(math.pi * t) ** 2
    corner = edge + width * np.concatenate([np.sin(turn * t), -np.cos(turn * t)], axis=1)
    out = edge + after * across
    way = target - out
    straight = (way @ along) * along
    leave = out + straight * t + (way - straight) * smooth
    start = np.array([[-pipe.leg - 1.0, 0.0]])  # the arm may stick out of a short leg's open end
    past = target + BEYOND * t * along
    return np.concatenate([start, entry, corner, leave, past]), 1 + 3 * LINE_POINTS


def reach(line: Floats, hinge: Floats, at: Floats, length: float) -> tuple[Floats, Floats]:
    """Where a link from each hinge (k, 2) meets the line farther on: points (k, 2), places on the line (k,).

    A place is an index with a fraction; the link starts at place `at`.
    """
    distance = np.hypot(*np.moveaxis(line - hinge[:, None], -1, 0))  # (k, p)
    beyond = (distance >= length) & (np.arange(len(line)) > at[:, None])
    i = np.where(beyond.any(axis=1), beyond.argmax(axis=1), len(line) - 1)
    a, d = line[i - 1], line[i] - line[i - 1]
    from_hinge = a - hinge
    # |from_hinge + t d| = length, the larger root
    dd, df = (d * d).sum(axis=1), (d * from_hinge).sum(axis=1)
    root = np.sqrt(np.maximum(df**2 - dd * ((from_hinge**2).sum(axis=1) - length**2), 0.0))
    t = np.clip((root - df) / dd, 0.0, 1.0)
    return a + t[:, None] * d, i - 1 + t


def _improve(robot: RobotSpec, pipe: PipeCorner, base: float, target: Floats, q: Floats) -> Floats:
    """More clearance where it is below `WIDE_ENOUGH`, by small changes of one hinge at a time: (k, joints).

    Every other waypoint moves in a round, so that each can count on its neighbours. The first one, where the robot
    starts, stays; the last one also keeps the tip near the target.
    """
    hinges = np.eye(q.shape[1])[1:]
    moves = np.concatenate([np.zeros((1, q.shape[1])), hinges, -hinges])  # (m, joints), the first one is no move
    size = FIRST_MOVE
    for turn in range(ROUNDS):
        moving = slice(1 + turn % 2, None, 2)
        before, after = q[:-1], np.concatenate([q[2:], q[-1:]])
        middle = ((before + after) / 2)[turn % 2 :: 2]  # of the neighbours of each waypoint that moves
        tried = q[moving, None] + size * moves  # (k / 2, m, joints)
        bend = ((tried - middle[:, None])[..., 1:] ** 2).sum(axis=-1)
        cost = BEND_COST * bend - np.minimum(clearance(robot, pipe, tried, base), WIDE_ENOUGH)
        if (len(q) - 2 - turn) % 2 == 0:  # the last waypoint is among those that move
            tip = frames.robot_to_pipe(kinematics.forward(robot, tried[-1]).tip, base)
            cost[-1] += TARGET_COST * np.linalg.norm(tip - target, axis=-1)
        q = q.copy()
        q[moving] += size * moves[cost.argmin(axis=1)]
        size *= SHRINK
    return q
