"""Simulated robots behind their doors, in a plane or in space, as a session drives them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.backends.simulators import open_space
from pipenav.backends.viewer import HasWindow
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.driving.door import Door
from pipenav.driving.driven import DrivenSimulator
from pipenav.driving.driven_space import DrivenSpace
from pipenav.driving.plans import DrivePlan
from pipenav.driving.shown import Picture
from pipenav.driving.space_door import SpaceDoor
from pipenav.robots import frames, kinematics
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.registry import task_of
from pipenav.tasks.rolling.batch import RollingBatch
from pipenav.tasks.task import EpisodeSource


class World(Protocol):
    """n robots that are driven.

    Attributes:
        batch: the robots and their task.
        window: the simulator, which may have a window.
    """

    batch: TrainingBatch
    window: HasWindow

    def readings(self) -> Reading:
        """Readings of the robots' sensors now."""
        ...

    def picture(self) -> Picture | None:
        """The first robot in its pipe; None before it is in one."""
        ...


class PlaneWorld:
    """n robots in pipes that lie in a plane; attributes as those of `World`.

    Args:
        plan: the session's plan.
        doors: the doors, n of them.
        source: says how each episode starts.
    """

    def __init__(self, plan: DrivePlan, doors: Sequence[Door], source: EpisodeSource[Any]) -> None:
        n, task = len(doors), plan.lengthened
        segments = max(len(pipe.segments) for pipe in plan.pipes)
        inner = disturbed(plan.simulator.open(plan.robot, n, segments), plan.robot, n, plan.disturbance, plan.seed)
        self._driven = DrivenSimulator(inner, doors, plan.controller is not None, _tip_gap(plan))
        self.window: HasWindow = self._driven
        self.batch = task_of(task).batch(plan.robot, self._driven, n, source)
        self._driven.target = _targets(self.batch)

    def readings(self) -> Reading:
        return self._driven.read()

    def picture(self) -> Picture | None:
        pipe, batch = self.batch.pipes[0], self.batch
        if pipe is None:
            return None
        base, target = self._driven.bases[0], self._driven.target(0)
        points = frames.robot_to_pipe(kinematics.waypoints(batch.robot, batch.q[:1])[0], base)
        seen = None if target is None else frames.robot_to_pipe(target, base)
        return Picture(pipe.label, pipe.segments, points, seen)


class SpaceWorld:
    """n robots in routes of which some leave the plane; arguments and attributes as those of `PlaneWorld`."""

    def __init__(self, plan: DrivePlan, doors: Sequence[SpaceDoor], source: EpisodeSource[Any]) -> None:
        n, settings = len(doors), plan.simulator
        inner = open_space(settings.backend, plan.robot, n, settings.options)
        self._driven = DrivenSpace(inner, doors, plan.controller is not None, _tip_gap(plan))
        self.window: HasWindow = self._driven
        self.batch = task_of(plan.lengthened).batch_in_space(plan.robot, self._driven, n, source)

    def readings(self) -> Reading:
        return self._driven.read().body

    def picture(self) -> Picture | None:
        route, batch = self.batch.pipes[0], self.batch
        assert isinstance(batch, RollingBatch)
        if route is None:
            return None
        door = self._driven.doors[0]
        return Picture(route.label, door.walls, door.in_its_plane(batch.truth().points[0]))


def open_world(
    plan: DrivePlan, operators: Callable[[int], Any] | None, n: int, source: EpisodeSource[Any]
) -> tuple[World, list[Door]]:
    """The robots of a session and their doors.

    Args:
        plan: the session's plan.
        operators: makes the operator of a robot by its index; None for the policy alone.
        n: number of robots.
        source: says how each episode starts.

    Raises:
        PipenavError: the robot cannot do the task, or not in space.
    """
    shared = plan.controller is not None
    who = [operators(i) if operators else None for i in range(n)]
    if plan.in_space:
        doors = [SpaceDoor(plan.robot, operator, shared) for operator in who]
        return SpaceWorld(plan, doors, source), list(doors)
    plain = [Door(plan.robot, operator, shared) for operator in who]
    return PlaneWorld(plan, plain, source), plain


def _tip_gap(plan: DrivePlan) -> float:
    """Distance of the tips before the inner walls' bends at the start, about [m]."""
    return sum(plan.task.start_gap) / 2


def _targets(batch: TrainingBatch) -> Callable[[int], Floats | None]:
    """Target of a robot in its own frame, by the robot's index."""

    def target(i: int) -> Floats | None:
        if not isinstance(batch, ReachBatch) or batch.pipes[i] is None:
            return None
        pipe = batch.pipes[i]
        assert pipe is not None
        return frames.canonical_to_robot(batch.target[i], pipe.turn_sign)

    return target
