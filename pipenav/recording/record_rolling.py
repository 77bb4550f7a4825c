"""An episode of a single robot in space, recorded for pictures."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.simulators import open_space
from pipenav.backends.viewer import Sight
from pipenav.drawing.down import WEIGHTLESS
from pipenav.evaluation.episode_runner import random_start
from pipenav.evaluation.stage import TaskStage
from pipenav.pipes.route import PipeRoute
from pipenav.policies.controller import AnyController
from pipenav.recording.record import RecordingSettings, Weight, live_text
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.rolling.batch import RollingBatch, check_in_space
from pipenav.tasks.traverse.config import TraverseConfig


@dataclass(frozen=True)
class SpaceRecording:
    """A motion in space, one row per control step, the start first. Its arrays must not be written to.

    Attributes:
        route: the route, its ends long enough for the robot.
        robot: the robot.
        controller: name of the controller.
        backend: name of the simulator backend.
        outcome: label of the episode's `Outcome`.
        points: rear end, joints and tip, (rows, links + 1, 3) [m].
        normals: normals of the halves' planes, (rows, halves, 3).
        contact_force: largest net force of the pipe on any one link, (rows,) [N].
        doing: what drives the robot in each row, a `Mode` in words.
        options: settings of the backend.
        seed: seed of the episode; None where it is not known.
        gravity: gravity in the route's frame, (3,) [m/s^2]; None where it is not known.
    """

    route: PipeRoute
    robot: RobotSpec
    controller: str
    backend: str
    outcome: str
    points: Floats
    normals: Floats
    contact_force: Floats
    doing: tuple[str, ...]
    options: Mapping[str, Any] = field(default_factory=dict)
    seed: int | None = None
    gravity: Floats | None = None

    @property
    def time(self) -> Floats:
        """Time of each row, (rows,) [s]."""
        return np.round(np.arange(len(self.points)) * CONTROL_PERIOD, 6)

    @property
    def succeeded(self) -> bool:
        return self.outcome == Outcome.REACHED.label


def record_in_space(
    controller: AnyController, name: str, route: PipeRoute, seed: int, episode: int, simulator: RecordingSettings
) -> SpaceRecording:
    """Record the episode that an evaluation with this seed runs as number `episode` in this route.

    The arguments are those of `record_task`.

    Raises:
        PipenavError: a robot or a backend that cannot roll, or a live window that cannot open.
    """
    robot, task = controller.robot, simulator.task or controller.task
    check_in_space(robot, simulator.backend)
    assert isinstance(task, TraverseConfig)  # no other task takes such routes
    one = random_start(robot, task, [route], episode + 1, seed)(episode)
    world = open_space(simulator.backend, robot, 1, simulator.options)
    given = simulator.options.get("gravity")  # a backend's own setting overrules the episode's
    weight = one.gravity_in_space[0] if given is None else np.array([0.0, 0.0, -float(given)])
    said = Weight.of((float(weight[0]), float(weight[1]), float(weight[2])))
    label = f"{route.label}, {said.words if weight.any() else WEIGHTLESS}"
    batch = RollingBatch(robot, task, world, 1, lambda _: one)
    look, outcome = simulator.watch or (lambda _, __: None), Outcome.RUNNING
    with closing(TaskStage(batch, controller)) as stage:
        stage.start(np.arange(1))
        truth = batch.truth()
        points, normals, force, doing = [truth.points[0]], [truth.normals[0]], [0.0], [batch.doing[0]]
        look(world, Sight(f"{live_text(label, 0.0)}, {doing[0]}", down=said.down))
        while outcome is Outcome.RUNNING:
            outcome = Outcome(stage.step().outcome[0])
            truth = batch.truth()
            points.append(truth.points[0])
            normals.append(truth.normals[0])
            force.append(float(truth.contact_force[0]))
            doing.append(batch.doing[0])
            line = live_text(label, CONTROL_PERIOD * (len(points) - 1), force[-1], outcome)
            look(world, Sight(f"{line}, {doing[-1]}", down=said.down))
    long = batch.pipes[0]
    assert long is not None
    arrays = np.array(points), np.array(normals), np.array(force)
    settings = simulator.options, seed, weight
    return SpaceRecording(long, robot, name, simulator.backend, outcome.label, *arrays, tuple(doing), *settings)
