"""Trials that show how a simulator moves, sees and touches: the same commands to the same robot in each simulator."""

from __future__ import annotations

import io
from contextlib import closing
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command, Control
from pipenav.backends.simulators import SimulatorSettings
from pipenav.jobs import JobControl
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.centreline import CentrelineController
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach import action, episode
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig

FREE_STEPS = 6
"""Number of control steps of a free motion; a pulse of duty lasts for the first two."""

FREE_DUTY = 0.5
"""Duty of a free motion: half, so that no robot reaches the walls of the widest pipe."""

PRESS_STEPS = 15
"""Number of control steps for which a joint presses on a wall: enough to come to rest."""

PRESS_TRAVEL = (0.8, 0.3)
"""Set-point of a hinge [rad] and of a slide [m] that presses: well beyond the wall."""

CORNERS = [
    PipeCorner.of(d, a, t)
    for d, a, t in ((120, 90, "left"), (100, 75, "right"), (100, 120, "left"), (110, 60, "right"))
]
"""Pipes of the open-loop passages and of the laser readings."""


class OpenLoopPassages(NamedTuple):
    """Open-loop passages of CORNERS, as a controller made them in the reference.

    Attributes:
        set_points: set-points of each control step, the last ones repeated, (corners, steps, joints) [rad or m].
        steps: number of control steps of each passage, (corners,).
        start: start poses of the passages.
    """

    set_points: Floats
    steps: Ints
    start: episode.ReachEpisodes


class Trials(NamedTuple):
    """Motions, readings and contacts of one simulator; a row for each joint, or for each of CORNERS.

    Attributes:
        driven: joint positions in free motion under a pulse of duty, (joints, steps, joints) [rad or m].
        stepped: joint positions in free motion under a step of the set-point, (joints, steps, joints) [rad or m].
        ranges: laser readings in the poses of the passages, (poses, beams) [m].
        tips: tip positions on the passages, (corners, steps, 2) [m]; NaN after a passage's end.
        pressed: joint positions when each joint in turn presses on a wall, (joints, steps, joints) [rad or m].
        force: contact force when each joint in turn presses on a wall, (joints, steps) [N].
    """

    driven: Floats
    stepped: Floats
    ranges: Floats
    tips: Floats
    pressed: Floats
    force: Floats


def record_passages(robot: RobotSpec, reference: SimulatorSettings) -> OpenLoopPassages:
    """Let a scripted controller pass CORNERS in the reference, and record its set-points."""
    controller = CentrelineController(robot)
    n = len(CORNERS)
    start = episode.sample(robot, ReachConfig(start_bend=0.0), CORNERS, np.random.default_rng(0))
    batch = ReachBatch(robot, controller.config, reference.open(robot, n), n, lambda _: start)
    with closing(batch):
        observation = batch.reset()
        set_points: list[Floats] = []
        ended = np.zeros(n, int)
        while not ended.all():
            result = batch.step(controller.act(observation, batch))
            observation = result.observation
            now = (result.outcome != Outcome.RUNNING) & (ended == 0)
            set_points.append(np.where((ended > 0)[:, None], set_points[-1] if set_points else 0.0, batch.q))
            ended[now] = len(set_points)
    return OpenLoopPassages(np.stack(set_points, axis=1), ended, start)


def run_trials(robot: RobotSpec, simulator: SimulatorSettings, passages: OpenLoopPassages) -> Trials:
    """Run all trials in one simulator."""
    joints = len(robot.joints)
    pulse = np.zeros((FREE_STEPS, joints, joints))
    pulse[:2] = FREE_DUTY * np.eye(joints)
    step = np.tile(np.diag(action.position_step(robot, ReachConfig(control="position"))), (FREE_STEPS, 1, 1))
    press = np.diag(np.where(robot.hinges, *PRESS_TRAVEL))
    with closing(simulator.open(robot, joints)) as backend:
        driven = _move_freely(backend, robot, "torque", pulse)
        stepped = _move_freely(backend, robot, "position", step)
    slippery = robot.model_copy(update={"friction": 0.0})  # with friction, many forces and poses are at rest
    with closing(simulator.open(slippery, joints)) as backend:
        pressing = _press(backend, robot, np.tile(press, (PRESS_STEPS, 1, 1)))
    with closing(simulator.open(robot, len(CORNERS))) as backend:
        ranges = _scan(backend, passages)
        tips = _pass(backend, passages)
    return Trials(driven, stepped, ranges, tips, pressing.q, pressing.force)


class TrialsOrder(NamedTuple):
    """The data of a job that runs all trials: arguments of `run_trials`."""

    robot: RobotSpec
    simulator: SimulatorSettings
    passages: OpenLoopPassages


def trials_job(order: TrialsOrder, control: JobControl) -> bytes:
    """Run all trials: the function of such a job."""
    trials = run_trials(order.robot, order.simulator.on_cores(control.cores), order.passages)
    file = io.BytesIO()
    np.savez(file, allow_pickle=False, **trials._asdict())
    return file.getvalue()


def trials_from(content: bytes) -> Trials:
    """Trials from what their job returned."""
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        return Trials(**{name: file[name] for name in Trials._fields})


def _move_freely(backend: Simulator, robot: RobotSpec, control: Control, values: Floats) -> Floats:
    """Joint positions in free space under commands (steps, n, joints): (n, steps, joints)."""
    n = values.shape[1]
    wide = PipeCorner.of(300, 180)
    backend.reset(np.arange(n), [wide] * n, np.zeros((n, len(robot.joints))), np.full(n, -robot.length))
    return np.stack([_stepped(backend, control, now) for now in values], axis=1)


def _stepped(backend: Simulator, control: Control, values: Floats) -> Floats:
    """Joint positions after a control step under these values, (n, joints)."""
    backend.step(Command(control, values))
    return backend.read().q


class _Pressing(NamedTuple):
    """Joint positions and contact force while joints press, (joints, steps, joints) and (joints, steps)."""

    q: Floats
    force: Floats


def _press(backend: Simulator, robot: RobotSpec, set_points: Floats) -> _Pressing:
    """Let each joint press on a wall: a slide head-on on the far wall of a right angle, a hinge sideways."""
    n = set_points.shape[1]
    pipes = [PipeCorner.of(120, 180 if hinge else 90) for hinge in robot.hinges]
    gap = pipes[0].radius + 0.05
    backend.reset(np.arange(n), pipes, np.zeros((n, n)), np.full(n, pipes[0].radius - gap - robot.length))
    q, force = [], []
    for now in set_points:
        q.append(_stepped(backend, "position", now))
        force.append(backend.truth().contact_force)
    return _Pressing(np.stack(q, axis=1), np.stack(force, axis=1))


def _scan(backend: Simulator, passages: OpenLoopPassages) -> Floats:
    """Laser readings in every third pose of the passages, (poses, beams)."""
    indices, base = np.arange(len(CORNERS)), passages.start.base
    poses = passages.set_points.swapaxes(0, 1)[::3]
    return np.concatenate([backend.reset(indices, CORNERS, q, base).ranges for q in poses])


def _pass(backend: Simulator, passages: OpenLoopPassages) -> Floats:
    """Tips on the passages under the recorded set-points, (corners, steps, 2)."""
    start, tips = passages.start, []
    backend.reset(np.arange(len(CORNERS)), CORNERS, start.q, start.base)
    for i, set_points in enumerate(passages.set_points.swapaxes(0, 1)):
        backend.step(Command("position", set_points))
        tips.append(np.where((i < passages.steps)[:, None], backend.truth().tip[:, :2], np.nan))
    return np.stack(tips, axis=1)
