"""`baseline:centreline`: a scripted controller that knows the pipe and leads the arm along a line around the corner.

The hinges follow the leader: every link's far end lies on one line that swings wide before and after the corner, as a
long vehicle does. How wide is chosen per pipe, by the wall distance that the whole motion keeps. Where that stays
small, the hinge angles are improved one waypoint at a time. The controller sees the pipe, which no policy does: it
shows what geometry allows, not what a controller with sensors can do.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.centreline_plan import WIDE_ENOUGH, follow_line, improve
from pipenav.policies.controller import PrivilegedController
from pipenav.robots import frames
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach import action
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig

WIDTHS = ((0.5, 0.6, 0.7, 0.78, 0.84), (0.2, 0.3, 0.4, 0.5, 0.65, 0.8), (0.5, 0.6, 0.7, 0.8))
"""Lines to choose from: distances from the inner wall before, at and after the corner, in diameters."""


class _Plan(NamedTuple):
    """Waypoints of one robot's episode, (k, joints), and the pipe, target and edge that they were planned for."""

    key: tuple[object, ...]
    waypoints: Floats


class CentrelineController(PrivilegedController[ReachBatch]):
    """Position control along a motion that is planned at an episode's start.

    Raises:
        PipenavError: the robot is not a slide followed by hinges.
    """

    batch_type = ReachBatch
    refusal = "baseline:centreline leads an arm around a corner: choose a single corner, such as d=90,angle=90."

    def __init__(self, robot: RobotSpec, task: ReachConfig | None = None) -> None:
        kinds = [joint.type for joint in robot.joints]
        if kinds[0] != "slide" or "slide" in kinds[1:] or len(kinds) < 2:
            raise PipenavError(
                f"baseline:centreline drives a slide followed by hinges; robot {robot.name!r} has {', '.join(kinds)}."
            )
        self.robot = robot
        self.task = self.config = task or ReachConfig(control="position")
        self._widths: dict[PipeCorner, tuple[float, ...]] = {}
        self._plans: dict[int, _Plan] = {}

    def act(self, observation: Floats, batch: ReachBatch) -> Floats:  # noqa: ARG002  # the batch knows more
        q, target, edge = batch.snapshot.q, batch.target, batch.edge
        step = action.position_step(self.robot, self.config)
        actions = np.zeros((batch.n, len(step)))
        for i, pipe in enumerate(batch.pipes):
            if pipe is not None:
                actions[i] = _follow(self._waypoints(i, pipe, target[i], edge[i]), q[i], step)
        return actions

    def _waypoints(self, robot: int, pipe: PipeCorner, target: Floats, edge: Floats) -> Floats:
        """Waypoints of one robot's episode, planned when its pipe or its target is new: (k, joints)."""
        key = (pipe, *target, *edge)
        known = self._plans.get(robot)
        if known is None or known.key != key:
            left = pipe.model_copy(update={"turn": "left"})
            base = -left.tangent_length(left.radius) - float(edge[0])
            waypoints = self._plan(left, base, frames.robot_to_pipe(target, base))
            known = self._plans[robot] = _Plan(key, waypoints)
        return known.waypoints

    def _plan(self, pipe: PipeCorner, base: float, target: Floats) -> Floats:
        if pipe not in self._widths:
            self._widths[pipe] = self._choose_widths(pipe)
        motion = follow_line(self.robot, pipe, base, target, self._widths[pipe])
        if motion.score < WIDE_ENOUGH:
            return improve(self.robot, pipe, base, target, motion.q)
        return motion.q

    def _choose_widths(self, pipe: PipeCorner) -> tuple[float, ...]:
        """Widths of a good line to the middle of the target area, from the farthest start: chosen singly, twice."""
        depth = pipe.inner_edge + sum(self.config.target_depth) / 2
        base = -pipe.inner_edge - self.config.start_gap[1] - self.robot.length
        target = depth * pipe.second_leg
        best = tuple(choices[len(choices) // 2] for choices in WIDTHS)
        for i in (0, 1, 2) * 2:
            lines = [(*best[:i], width, *best[i + 1 :]) for width in WIDTHS[i]]
            best = max(lines, key=lambda line: follow_line(self.robot, pipe, base, target, line).score)
        return best


def _follow(waypoints: Floats, q: Floats, step: Floats) -> Floats:
    """Action that leads along the waypoints, (joints,): to the farthest one within one step, else towards the next one.

    Towards a waypoint, all joints move in proportion.
    """
    away = np.abs((waypoints - q) / step).max(axis=1)  # (k,)
    nearest = int(away.argmin())
    target = min(nearest + 1, len(waypoints) - 1)
    while target + 1 < len(waypoints) and away[target + 1] <= 1.0:
        target += 1
    return np.asarray((waypoints[target] - q) / step / max(1.0, away[target]))
