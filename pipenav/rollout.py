"""One episode of one robot, recorded as a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav import kinematics
from pipenav.backend import Backend
from pipenav.batch import CornerBatch
from pipenav.controller import Controller
from pipenav.episode_runner import random_start
from pipenav.mirror import RearStage
from pipenav.pipe import Pipe
from pipenav.registry import open_backend
from pipenav.stage import FrontStage, Stage
from pipenav.task.episode import Verdict
from pipenav.trajectory import Trajectory, TrajectoryHeader

Array = NDArray[np.float64]
Watch = Callable[[Backend], None]
"""Called with the backend at the start and after every control step, for whoever looks on."""


class Simulator(NamedTuple):
    """On what an episode runs: a backend's name, its own settings, and who looks on."""

    backend: str = "mujoco"
    options: Mapping[str, Any] = {}
    watch: Watch | None = None


class Tracking(NamedTuple):
    """How far a motion was from the one that was commanded, the largest of all control steps.

    Attributes:
        tip: distance of the tips [m].
        joint: difference of a hinge [rad].
        slide: difference of a slide [m].
    """

    tip: float
    joint: float
    slide: float


def record(stage: Stage, backend: Backend, header: TrajectoryHeader, start: Array, watch: Watch | None) -> Trajectory:
    """Run one episode of a stage that was made for one robot.

    Args:
        stage: its next episode is run, and it is closed afterwards.
        backend: what the stage runs on.
        header: what is known of the episode; its outcome is filled in.
        start: the joint positions that the episode starts in, (joints,).
        watch: see `Watch`.
    """
    look = watch or (lambda _: None)
    q, force, links = [start], [0.0], [np.zeros((len(stage.robot.links), 2))]
    verdict = Verdict.RUNNING
    with closing(stage):
        stage.start(np.arange(1))
        look(backend)
        while verdict is Verdict.RUNNING:
            step = stage.step()
            look(backend)
            verdict = Verdict(step.verdict[0])
            q.append(step.q[0])
            force.append(float(step.truth.contact_force[0]))
            links.append(step.truth.link_forces[0])
    ended = header.model_copy(update={"outcome": verdict.label})
    return Trajectory(ended, stage.robot, np.array(q), np.array(force), np.array(links))


def record_front(
    controller: Controller, name: str, pipe: Pipe, seed: int, episode: int, simulator: Simulator
) -> Trajectory:
    """A front passage: the same episode that an evaluation with this seed runs as its number `episode` in this pipe.

    Args:
        controller: what acts.
        name: of the controller, for the header.
        pipe: where.
        seed: of starts and targets.
        episode: counted from 0.
        simulator: on what.
    """
    robot, task = controller.robot, controller.task
    one = random_start(robot, task, [pipe], episode + 1, seed)(episode)
    base = float(one.base[0])
    x, y = one.goal[0] * [1.0, one.side[0]] + [base, 0.0]
    header = TrajectoryHeader(
        robot=robot.name,
        pipe=pipe,
        base_m=base,
        goal_m=(float(x), float(y)),
        stage="front",
        backend=simulator.backend,
        controller=name,
        options=dict(simulator.options),
        seed=seed,
    )
    backend = open_backend(simulator.backend, robot, 1, simulator.options, len(pipe.segments))
    stage = FrontStage(CornerBatch(robot, task, backend, 1, lambda _: one), controller)
    return record(stage, backend, header, one.q[0], simulator.watch)


def record_rear(plan: Trajectory, simulator: Simulator) -> Trajectory:
    """A rear passage: the plan's motion under the position controllers of a backend."""
    changes = {"backend": simulator.backend, "options": dict(simulator.options)}
    backend = open_backend(simulator.backend, plan.robot, 1, simulator.options, len(plan.header.pipe.segments))
    stage = RearStage(plan.robot, backend, 1, lambda _: [plan.motion])
    return record(stage, backend, plan.header.model_copy(update=changes), plan.q[0], simulator.watch)


def tracking(plan: Trajectory, recorded: Trajectory) -> Tracking:
    """How well a recording follows its plan; beyond the plan's last row, that row counts."""
    goal = plan.q[np.minimum(np.arange(len(recorded.q)), len(plan.q) - 1)]
    difference = np.abs(recorded.q - goal).max(axis=0)
    hinges = plan.robot.hinges
    tips = [kinematics.forward(plan.robot, q).tip for q in (goal, recorded.q)]
    return Tracking(
        float(np.linalg.norm(tips[0] - tips[1], axis=1).max()),
        float(difference[hinges].max(initial=0.0)),
        float(difference[~hinges].max(initial=0.0)),
    )
