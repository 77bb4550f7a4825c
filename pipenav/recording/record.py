"""An episode of a single robot, recorded as a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD, Simulator
from pipenav.backends.simulators import open_simulator
from pipenav.backends.viewer import HasWindow, Sight
from pipenav.drawing import down
from pipenav.evaluation.episode_runner import random_start
from pipenav.evaluation.locate_stage import LocateStage
from pipenav.evaluation.rear_stage import RearStage
from pipenav.evaluation.stage import Stage, TaskStage
from pipenav.locating.locator import LocateConfig, Variant, robot_for
from pipenav.locating.variants import LOCATORS
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.policies.controller import AnyController
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome, PassageStage
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.registry import TaskConfig, task_of
from pipenav.tasks.traverse.episode import TraverseEpisodes

LEVEL = (0.0, 0.0)
"""Gravity's part in a level plane [m/s^2]."""

Onlooker = Callable[[HasWindow, Sight], None]
"""Called at the start and after every control step with the simulator and what to show beside its robot."""


class RecordingSettings(NamedTuple):
    """Settings of a recording.

    Attributes:
        backend: name of the simulator that the episode runs on.
        options: its own settings.
        watch: who looks on.
        task: task of an episode in space, which may have other loads and sensors than its controller was trained for;
            None for the controller's own.
    """

    backend: str = "mujoco"
    options: Mapping[str, Any] = {}
    watch: Onlooker | None = None
    task: TaskConfig | None = None


class Located(NamedTuple):
    """A recorded search for a target (approach I).

    Attributes:
        trajectory: trajectory of the stage `locate`; its header's `goal_m` is the target that was found.
        ranges: the laser's scan of each row of the trajectory, (rows, beams) [m].
        found: row whose scan gave the target, which is also the control steps before it; None where none did.
        beam: beam on which the target lies, or the nearest one, from right to left from 0; None where none was found.
    """

    trajectory: Trajectory
    ranges: Floats
    found: int | None
    beam: int | None


class Tracking(NamedTuple):
    """Largest differences, over all control steps, of a motion from the one that was commanded.

    Attributes:
        tip: distance of the tips [m].
        joint: difference in a hinge [rad].
        slide: difference in a slide [m].
    """

    tip: float
    joint: float
    slide: float


class Weight(NamedTuple):
    """Weight as a window shows it: words, and the unit vector downwards in the pipe's frame, (x, y, z), if any."""

    words: str
    down: tuple[float, float, float] | None

    @classmethod
    def of(cls, gravity: tuple[float, float, float] | None) -> Weight:
        """Weight under gravity in the pipe's frame (x, y, z) [m/s^2]; None is not known."""
        if gravity is None or not any(gravity):
            return cls("" if gravity is None else down.LEVEL, None)
        x, y, z = (np.array(gravity) / np.linalg.norm(gravity)).tolist()
        return cls("violet arrow: down", (x, y, z))


def record(
    stage: Stage, backend: Simulator, header: TrajectoryHeader, start: Floats, watch: Onlooker | None
) -> Trajectory:
    """Run one episode of a stage that was made for one robot.

    Args:
        stage: the stage, whose next episode is run; it is closed afterwards.
        backend: the simulator that the stage runs on.
        header: header of the trajectory; its outcome is filled in.
        start: configuration in which the episode starts, (coordinates,).
        watch: see `Onlooker`.
    """
    look = watch or (lambda _, __: None)
    weight = Weight.of(header.gravity_mps2 and (*header.gravity_mps2, 0.0))
    label, target = ", ".join(part for part in (header.pipe.label, weight.words) if part), header.goal_m
    q, force, links = [start], [0.0], [np.zeros((len(stage.robot.links), 2))]
    outcome = Outcome.RUNNING
    with closing(stage):
        stage.start(np.arange(1))
        look(backend, Sight(live_text(label, 0.0), target, weight.down))
        while outcome is Outcome.RUNNING:
            step = stage.step()
            outcome = Outcome(step.outcome[0])
            seconds = CONTROL_PERIOD * len(q)
            text = live_text(label, seconds, float(step.truth.contact_force[0]), outcome)
            look(backend, Sight(text, target, weight.down))
            q.append(step.q[0])
            force.append(float(step.truth.contact_force[0]))
            links.append(step.truth.link_forces[0])
    ended = header.model_copy(update={"outcome": outcome.label})
    return Trajectory(ended, stage.robot, np.array(q), np.array(force), np.array(links))


def live_text(label: str, seconds: float, force: float | None = None, outcome: Outcome = Outcome.RUNNING) -> str:
    """Line of text in a window: pipe, time, and once they are known contact force and outcome."""
    touched = "" if force is None else f", contact {force:.1f} N"
    ended = "" if outcome is Outcome.RUNNING else f", {outcome.label}"
    return f"{label}, {seconds:.1f} s{touched}{ended}"


def record_task(
    controller: AnyController, name: str, pipe: Pipe, seed: int, episode: int, simulator: RecordingSettings
) -> Trajectory:
    """Record a controller's task: the episode that an evaluation with this seed runs as number `episode` in this pipe.

    Args:
        controller: the controller.
        name: name of the controller, for the header.
        pipe: the pipe.
        seed: seed of starts and targets.
        episode: number of the episode, from 0.
        simulator: the simulator.
    """
    robot, task = controller.robot, controller.task
    one = random_start(robot, task, [pipe], episode + 1, seed)(episode)
    base = float(one.base[0])
    target = None
    if isinstance(one, ReachEpisodes):
        x, y = frames.canonical_to_pipe(one.target[0], one.turn_sign[0], base)
        target = (float(x), float(y))
    header = TrajectoryHeader(
        robot=robot.name,
        pipe=one.pipes[0],
        base_m=base,
        goal_m=target,
        stage=task_of(task).stage,
        backend=simulator.backend,
        controller=name,
        options=dict(simulator.options),
        seed=seed,
        gravity_mps2=_gravity_of(one),
    )
    backend = open_simulator(simulator.backend, robot, 1, simulator.options, len(pipe.segments))
    stage = TaskStage(task_of(task).batch(robot, backend, 1, lambda _: one), controller)
    return record(stage, backend, header, one.q[0], simulator.watch)


def _gravity_of(episode: ReachEpisodes | TraverseEpisodes) -> tuple[float, float]:
    """Gravity's part in the plane of an episode's pipe [m/s^2]."""
    if isinstance(episode, ReachEpisodes):
        return LEVEL
    x, y = episode.gravity[0].tolist()
    return x, y


def record_locate(
    robot: RobotSpec, variant: Variant, pipe: PipeCorner, seed: int, episode: int, simulator: RecordingSettings
) -> Located:
    """Record approach I: the episode that an evaluation with this seed runs as number `episode` in this pipe.

    Args:
        robot: a slide followed by hinges.
        variant: how the target is located.
        pipe: the pipe.
        seed: seed of starts.
        episode: number of the episode, from 0.
        simulator: the simulator.

    Raises:
        PipenavError: a pipe that is too narrow, or a robot of other joints.
    """
    task, seeing = ReachConfig(), robot_for(robot, variant)
    one = random_start(seeing, task, [pipe], episode + 1, seed)(episode)
    header = TrajectoryHeader(
        robot=robot.name,
        pipe=pipe,
        base_m=float(one.base[0]),
        stage=PassageStage.LOCATE,
        backend=simulator.backend,
        controller=f"locate:{variant}",
        options=dict(simulator.options),
        seed=seed,
        gravity_mps2=LEVEL,
    )
    backend = open_simulator(simulator.backend, seeing, 1, simulator.options, len(pipe.segments))
    stage = LocateStage(seeing, LOCATORS[variant](seeing, LocateConfig(), 1), task, backend, lambda _: one)
    ranges, beams = [], []

    def look(backend: HasWindow, sight: Sight) -> None:
        ranges.append(stage.reading.ranges[0].copy())
        beams.append(int(stage.beam[0]))
        if simulator.watch is not None:
            simulator.watch(backend, sight._replace(target=found_target() if beams[-1] >= 0 else None))

    def found_target() -> tuple[float, float]:
        x, y = frames.canonical_to_pipe(stage.target[0], one.turn_sign[0], one.base[0])
        return float(x), float(y)

    trajectory = record(stage, backend, header, one.q[0], look)
    if beams[-1] < 0:
        return Located(trajectory, np.array(ranges), None, None)
    header = trajectory.header.model_copy(update={"goal_m": found_target()})
    found = int(np.argmax(np.array(beams) >= 0)) - 1  # a step decides on the scan before it
    return Located(replace(trajectory, header=header), np.array(ranges), found, beams[-1])


def record_rear(plan: Trajectory, simulator: RecordingSettings) -> Trajectory:
    """Record a rear passage: the plan's motion under the position controllers of a simulator."""
    changes = {"backend": simulator.backend, "options": dict(simulator.options), "gravity_mps2": LEVEL}
    backend = open_simulator(simulator.backend, plan.robot, 1, simulator.options, len(plan.header.pipe.segments))
    stage = RearStage(plan.robot, backend, 1, lambda _: [plan.motion])
    return record(stage, backend, plan.header.model_copy(update=changes), plan.q[0], simulator.watch)


def tracking(plan: Trajectory, recorded: Trajectory) -> Tracking:
    """Largest differences of a recording from its plan; beyond the plan's last row, that row counts."""
    target = plan.q[np.minimum(np.arange(len(recorded.q)), len(plan.q) - 1)]
    difference = np.abs(recorded.q - target).max(axis=0)
    hinges = plan.robot.hinges
    tips = [kinematics.forward(plan.robot, q).tip for q in (target, recorded.q)]
    return Tracking(
        float(np.linalg.norm(tips[0] - tips[1], axis=1).max()),
        float(difference[hinges].max(initial=0.0)),
        float(difference[~hinges].max(initial=0.0)),
    )
