"""How far two simulators agree: the same robot, the same commands, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command, Control
from pipenav.backends.simulators import open_simulator
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.centreline import CentrelineController
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach import action, episode
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig

FREE_STEPS = 6
"""Control steps of a free motion; the drive is on for the first two."""

FREE_DRIVE = 0.5
"""Drive of a free motion: half, so that no robot reaches the walls of the widest pipe."""

PRESS_STEPS = 15
"""Control steps that a joint presses on a wall for: enough to come to rest."""

PRESS_TRAVEL = (0.8, 0.3)
"""Set-point of a hinge [rad] and of a slide [m] that presses: well beyond the wall."""

CORNERS = [
    PipeCorner.of(d, a, t)
    for d, a, t in ((120, 90, "left"), (100, 75, "right"), (100, 120, "left"), (110, 60, "right"))
]
"""Pipes of the open-loop passages and of the distance readings."""


class Sides(NamedTuple):
    """The same in the reference (first) and in the other simulator (second)."""

    reference: Floats
    other: Floats

    @property
    def difference(self) -> Floats:
        return np.abs(self.other - self.reference)


class Agreement(NamedTuple):
    """What both simulators did; a row for each joint, or for each of CORNERS.

    Attributes:
        driven: joint positions in free motion under a pulse of drive, (joints, steps, joints) [rad or m].
        stepped: the same under a step of the set-point.
        ranges: laser readings in the same poses, (poses, beams) [m].
        tips: tip positions on the same open-loop passage, (corners, steps, 2) [m]; NaN after its end.
        pressed: joint positions when each joint in turn presses on a wall, (joints, steps, joints) [rad or m].
        force: contact force meanwhile, (joints, steps) [N].
    """

    driven: Sides
    stepped: Sides
    ranges: Sides
    tips: Sides
    pressed: Sides
    force: Sides


class Check(NamedTuple):
    """One line of the table: the largest difference that was found and the one that is allowed, in `unit`."""

    what: str
    found: float
    allowed: float
    unit: str
    reason: str

    @property
    def holds(self) -> bool:
        return self.found <= self.allowed


def compare(
    robot: RobotSpec, names: tuple[str, str], options: tuple[Mapping[str, Any], Mapping[str, Any]] = ({}, {})
) -> Agreement:
    """Run everything in both simulators.

    Args:
        robot: a slide followed by hinges.
        names: of the reference and of the other backend.
        options: their settings.
    """
    passages = _record(robot, names[0], options[0])
    parts = [_play(robot, name, settings, passages) for name, settings in zip(names, options, strict=True)]
    return Agreement(*(Sides(*pair) for pair in zip(*parts, strict=True)))


class _Passages(NamedTuple):
    """Passages that a script made in the reference: set-points (corners, steps, joints), the last ones repeated; the
    number of steps of each, (corners,); where they started."""

    goals: Floats
    steps: Ints
    start: episode.ReachEpisodes


def _record(robot: RobotSpec, name: str, options: Mapping[str, Any]) -> _Passages:
    controller = CentrelineController(robot)
    n = len(CORNERS)
    start = episode.sample(robot, ReachConfig(start_bend=0.0), CORNERS, np.random.default_rng(0))
    backend = open_simulator(name, robot, n, options)
    batch = ReachBatch(robot, controller.config, backend, n, lambda _: start)
    with closing(batch):
        observation = batch.reset()
        goals: list[Floats] = []
        ended = np.zeros(n, int)
        while not ended.all():
            result = batch.step(controller.act(observation, batch))
            observation = result.observation
            now = (result.outcome != Outcome.RUNNING) & (ended == 0)
            goals.append(np.where((ended > 0)[:, None], goals[-1] if goals else 0.0, batch.q))
            ended[now] = len(goals)
    return _Passages(np.stack(goals, axis=1), ended, start)


def _play(robot: RobotSpec, name: str, options: Mapping[str, Any], passages: _Passages) -> tuple[Floats, ...]:
    """The fields of `Agreement` for one simulator."""
    joints = len(robot.joints)
    pulse = np.zeros((FREE_STEPS, joints, joints))
    pulse[:2] = FREE_DRIVE * np.eye(joints)
    step = np.tile(np.diag(action.position_step(robot, ReachConfig(control="position"))), (FREE_STEPS, 1, 1))
    press = np.diag(np.where(robot.hinges, *PRESS_TRAVEL))
    with closing(open_simulator(name, robot, joints, options)) as backend:
        driven = _run(backend, robot, "torque", pulse)
        stepped = _run(backend, robot, "position", step)
    slippery = robot.model_copy(update={"friction": 0.0})  # with friction, many forces and poses are at rest
    with closing(open_simulator(name, slippery, joints, options)) as backend:
        pressed, force = _press(backend, robot, np.tile(press, (PRESS_STEPS, 1, 1)))
    with closing(open_simulator(name, robot, len(CORNERS), options)) as backend:
        tips, ranges = _follow(backend, passages)
    return driven, stepped, ranges, tips, pressed, force


def _run(backend: Simulator, robot: RobotSpec, control: Control, values: Floats) -> Floats:
    """Joint positions in free space under commands (steps, n, joints): (n, steps, joints)."""
    n = values.shape[1]
    wide = PipeCorner.of(300, 180)
    backend.reset(np.arange(n), [wide] * n, np.zeros((n, len(robot.joints))), np.full(n, -robot.length))
    return np.stack([_stepped(backend, control, now) for now in values], axis=1)


def _stepped(backend: Simulator, control: Control, values: Floats) -> Floats:
    backend.step(Command(control, values))
    return backend.read().q


def _press(backend: Simulator, robot: RobotSpec, goals: Floats) -> tuple[Floats, Floats]:
    """Each joint presses on a wall: a slide head-on on the far wall of a right angle, a hinge sideways."""
    n = goals.shape[1]
    pipes = [PipeCorner.of(120, 180 if hinge else 90) for hinge in robot.hinges]
    gap = pipes[0].radius + 0.05
    backend.reset(np.arange(n), pipes, np.zeros((n, n)), np.full(n, pipes[0].radius - gap - robot.length))
    q, force = [], []
    for now in goals:
        q.append(_stepped(backend, "position", now))
        truth = backend.truth()
        assert truth is not None, "only simulators are compared"
        force.append(truth.contact_force)
    return np.stack(q, axis=1), np.stack(force, axis=1)


def _follow(backend: Simulator, passages: _Passages) -> tuple[Floats, Floats]:
    """Tips on the recorded passages, and the laser's readings in their poses."""
    start, indices = passages.start, np.arange(len(CORNERS))
    ranges = []
    for q in passages.goals.swapaxes(0, 1)[::3]:
        ranges.append(backend.reset(indices, CORNERS, q, start.base).ranges)
    backend.reset(indices, CORNERS, start.q, start.base)
    tips = []
    for i, goals in enumerate(passages.goals.swapaxes(0, 1)):
        backend.step(Command("position", goals))
        truth = backend.truth()
        assert truth is not None, "only simulators are compared"
        tips.append(np.where((i < passages.steps)[:, None], truth.tip[:, :2], np.nan))
    return np.stack(tips, axis=1), np.concatenate(ranges)


ROTORS = "a simulator may have to carry a rotor's inertia on a link, which shifts motion by some milliseconds"
ROUNDING = "both round to the laser's resolution: one step of it"
NEXT_STEP = "a touch at the end of a control step may fall into the next"
STATICS = "the same motors press on the same walls; with friction many forces are at rest, so it is without"
SOFTNESS = "walls give way by a fraction of a millimetre"


def checks(robot: RobotSpec, agreement: Agreement) -> list[Check]:
    """The differences that matter, with what is allowed and why."""
    found, hinges, milli = agreement, robot.hinges, 1e3
    lines = []
    for what, sides in (("a pulse of drive", found.driven), ("a step of the set-point", found.stepped)):
        off = milli * sides.difference.max(axis=(0, 1))  # (joints,)
        lines.append(Check(f"free motion under {what}: hinges", off[hinges].max(), 25.0, "mrad", ROTORS))
        lines.append(Check(f"free motion under {what}: slide", off[~hinges].max(), 1.0, "mm", ROTORS))
    ranges, resolution = milli * found.ranges.difference.max(), milli * robot.laser.resolution
    lines.append(Check("laser readings in the same pose", ranges, resolution, "mm", ROUNDING))
    way = milli * passage_difference(found)
    lines.append(Check("tip on the same passage: on the way", float(np.nanmax(way)), 8.0, "mm", ROTORS))
    ends = [row[~np.isnan(row)][-1] for row in way]
    lines.append(Check("tip on the same passage: at its end", max(ends), 5.0, "mm", ROTORS))
    touch = Sides(*((side > 0).argmax(axis=1) for side in found.force))
    lines.append(Check("first touch of a wall", float(touch.difference.max()), 1.0, "steps", NEXT_STEP))
    push = Sides(*(side[:, -1] for side in found.force))
    share = 100 * float((push.difference / push.reference).max())
    lines.append(Check("force at rest on a wall", share, 2.0, "%", STATICS))
    rest = milli * found.pressed.difference[:, -1, hinges].max()
    lines.append(Check("pose at rest on a wall: hinges", rest, 2.0, "mrad", SOFTNESS))
    return [check._replace(found=float(check.found)) for check in lines]


def passage_difference(agreement: Agreement) -> Floats:
    """Distance between the two tips on the passages, (corners, steps) [m]; NaN after a passage's end."""
    return np.asarray(np.linalg.norm(agreement.tips.other - agreement.tips.reference, axis=-1))
