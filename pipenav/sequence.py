"""`baseline:sequence`: the turning sequence of the thesis's figure 1.2, scripted for a whole robot that knows the pipe.

One half of the robot clamps and drives while the other one, unclamped, goes through the corner. A half clamps with its
three wheels, by turns on the outer and the inner wall, and the bending joint between them presses. Before the clamped
rear half the front's hinges follow the leader along one line around the corner, as those of `baseline:centreline` do.
The rear half passes as the front half did, mirrored and reversed in time (approach II, 3.5): in a robot that is the
same seen from either end, that is the front's motion with the joints counted from the other end.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.centreline import reach
from pipenav.errors import PipenavError
from pipenav.pipe import BEND_RADIUS_MAX_MM, Pipe
from pipenav.robot import RobotSpec
from pipenav.tasks import TaskBatch
from pipenav.traverse.batch import TraverseBatch
from pipenav.traverse.config import TraverseConfig
from pipenav.units import mm_to_m

Array = NDArray[np.float64]

PRESS = 0.10
"""How far beyond the joint the set-point of a clamp is [rad]: more than half of the joint's effort at standstill."""

SPARE = 0.003
"""How far off the outer wall the wheels of the moving half are led [m]: a contact less, for little room."""

SPEED = 0.8
"""Rolling speed where the joints need not bend, as a share of the wheels' no-load speed."""

LAG = 0.25
"""Farthest distance of a joint from its set-point at which the robot still rolls on [rad]."""

LOOK_AHEAD = 0.010
"""How far ahead of the clamp the moving half's set-points are [m]: it lags behind them by about as much."""

SETTLED = 0.15
"""How near to its set-points a half is, every joint, when it counts as clamped or unclamped [rad]."""

DWELL = 30
"""Control steps after which a clamp that was not completed has to do: a wheel may stand on the wall elsewhere."""

REACH, WAY_POINTS = 0.6, 241
"""Where a half's table of poses begins, before the inner wall's bend [m]: behind every start; and its poses."""


class Phase(IntEnum):
    """What a robot is doing; the letters are those of the thesis (1.2)."""

    CLAMP_REAR = 0
    """The rear half clamps and the front half stretches: (a)."""
    FRONT_THROUGH = 1
    """The rear half drives, the front half goes through the corner: (b)."""
    CLAMP_FRONT = 2
    """Both halves clamp, one on either side of the corner: (c)."""
    REAR_THROUGH = 3
    """The rear half stretches, then the front half drives and draws it through: (c), (d)."""
    CLAMP_BOTH = 4
    """All wheels are past the corner: the rear half clamps again and all six wheels drive: (e)."""


class Passage(NamedTuple):
    """How one half goes through one pipe, a left turn.

    Attributes:
        along: where the clamped half's wheel next to the middle link is along the pipe, rising, (k,) [m].
        bends: joint angles from there on: the middle link's to the pipe's axis, then the moving half's own, (k, 4).
        steep: angle of a clamped link to the pipe's axis [rad].
        clear: where the moving half's last wheel is when it may clamp again, along the pipe [m].
    """

    along: Array
    bends: Array
    steep: float
    clear: float

    def at(self, along: float) -> Array:
        """Joint angles where the clamped half has come to `along`, (4,)."""
        return np.array([np.interp(along, self.along, column) for column in self.bends.T])


class SequenceController:
    """The turning sequence, each robot in its own phase.

    Attributes:
        phase: a `Phase` of each robot, (n,).

    Raises:
        PipenavError: a robot that does not consist of two mirrored halves of three joints and three wheels.
    """

    def __init__(self, robot: RobotSpec, task: TraverseConfig | None = None) -> None:
        _check_robot(robot)
        self.robot, self.task = robot, task or TraverseConfig(kind="traverse")
        self.phase = np.zeros(0, np.intp)
        self._since = np.zeros(0, np.intp)
        self._passages: dict[Pipe, Passage] = {}

    def act(self, observation: Array, batch: TaskBatch) -> Array:  # noqa: ARG002  # it knows more than that
        """Canonical actions in [-1, 1], (n, drives)."""
        assert isinstance(batch, TraverseBatch)  # its task is no other
        if len(self.phase) != batch.n:
            self.phase, self._since = np.zeros(batch.n, np.intp), np.zeros(batch.n, np.intp)
        anew = batch.steps == 0
        self.phase[anew], self._since[anew] = Phase.CLAMP_REAR, 0
        joints, along = len(self.robot.joints), batch.along
        actions = np.zeros((batch.n, len(self.robot.drives)))
        for i, pipe in enumerate(batch.pipes):
            if pipe is not None:
                passage = self._passage(pipe)
                bends = batch.q[i, -joints:] * pipe.side
                actions[i] = self._drive(i, passage, bends, along[i])
        return actions

    def _passage(self, pipe: Pipe) -> Passage:
        left = pipe.model_copy(update={"turn": "left"})
        if left not in self._passages:
            self._passages[left] = plan(self.robot, left)
        return self._passages[left]

    def _drive(self, i: int, passage: Passage, bends: Array, along: Array) -> Array:
        """The action of one robot, (drives,), after its phase has gone on where it was done.

        Args:
            i: which robot.
            passage: through its pipe.
            bends: its joint angles in a left turn, (joints,) [rad].
            along: where its way points are along the pipe, (links + 1,) [m].
        """
        goal = set_points(Phase(self.phase[i]), passage, along)
        if self._done(i, passage, np.abs(goal - bends), along):
            self.phase[i] += 1
            self._since[i] = 0
            goal = set_points(Phase(self.phase[i]), passage, along)
        self._since[i] += 1
        phase = Phase(self.phase[i])
        away, press = goal - bends, np.zeros(len(bends))
        press[[PRESSING[half] for half in CLAMPED[phase]]] = PRESS
        step = np.clip((away - press) / self.task.alpha, -1.0, 1.0)
        rolls = phase not in (Phase.CLAMP_REAR, Phase.CLAMP_FRONT)
        speed = SPEED * max(0.0, 1.0 - float(np.abs(away[press == 0]).max()) / LAG) if rolls else 0.0
        return np.concatenate([step, np.full(len(self.robot.wheels), speed)])

    def _done(self, i: int, passage: Passage, away: Array, along: Array) -> bool:
        phase = Phase(self.phase[i])
        if phase is Phase.FRONT_THROUGH:
            return bool(along[3] >= passage.along[-1])
        if phase is Phase.REAR_THROUGH:
            return bool(along[1] >= passage.clear)
        if phase is Phase.CLAMP_BOTH:
            return False
        return bool(away.max() <= SETTLED or self._since[i] >= DWELL)


REAR, FRONT = 0, 1
CLAMPED = {
    Phase.CLAMP_REAR: (REAR,),
    Phase.FRONT_THROUGH: (REAR,),
    Phase.CLAMP_FRONT: (REAR, FRONT),
    Phase.REAR_THROUGH: (FRONT,),
    Phase.CLAMP_BOTH: (REAR, FRONT),
}
"""Which halves clamp."""

PRESSING = {REAR: 1, FRONT: 4}
"""The joint in the middle of a half, which presses."""


def set_points(phase: Phase, passage: Passage, along: Array) -> Array:
    """Joint angles that a robot in this phase shall have in a left turn, (6,) [rad].

    Args:
        phase: of the sequence.
        passage: through its pipe.
        along: where its way points are along the pipe, (8,) [m].
    """
    steep = passage.steep
    if phase in (Phase.CLAMP_REAR, Phase.FRONT_THROUGH):
        middle, *moving = passage.at(float(along[3]) + LOOK_AHEAD)
        return np.array([steep, -2 * steep, steep + middle, *moving])
    if phase is Phase.CLAMP_FRONT:
        middle = float(passage.bends[-1, 0])
        return np.array([steep, -2 * steep, steep + middle, steep + middle, -2 * steep, steep])
    if phase is Phase.REAR_THROUGH:
        # The same poses, passed through from the last to the first, joints counted from the other end.
        middle, *moving = passage.at(-float(along[4]) - LOOK_AHEAD)
        return np.array([*moving[::-1], steep + middle, -2 * steep, steep])
    return np.array([steep, -2 * steep, steep, steep, -2 * steep, steep])


def plan(robot: RobotSpec, pipe: Pipe) -> Passage:
    """The passage of the front half, which is also the rear's: all its joints and its tip lie on one line.

    The line keeps to the outer wall and turns around the corner in an arc over which the middle link just spans, so that
    half-way the last wheel of either half still stands on its own leg's wall.

    Args:
        robot: two mirrored halves.
        pipe: a left turn.
    """
    wheel, link = robot.wheels[2].radius, float(robot.lengths[3])
    room = pipe.radius - wheel
    steepest = 0.5 * float(min(robot.upper.min(), -robot.lower.max()))
    steep = min(math.asin(min(2 * room / float(robot.lengths[1]), 1.0)), steepest - PRESS / 2)
    lane = max(room - SPARE, 0.0)
    half_turn = (math.pi - pipe.angle) / 2
    bend = min(max(link / 2 / max(math.sin(half_turn), 1e-9) - lane, pipe.bend_radius), mm_to_m(BEND_RADIUS_MAX_MM))
    line = pipe.model_copy(update={"bend_radius": bend, "leg": pipe.leg + robot.length}).line(-lane)
    start = -pipe.inner_edge - REACH
    along = np.linspace(start, 0.0, WAY_POINTS)
    pivot = np.stack([along, np.full(WAY_POINTS, -room)], axis=1)
    at = np.minimum((along - line[0, 0]) / (line[1, 0] - line[0, 0]), 1.0)
    heading, bends, ends = np.zeros(WAY_POINTS), [], []
    for length in robot.lengths[3:]:
        end, at = reach(line, pivot, at, float(length))
        direction = np.arctan2(*(end - pivot).T[::-1])
        bends.append(np.mod(direction - heading + math.pi, 2 * math.pi) - math.pi)
        ends.append(end)
        pivot, heading = end, direction
    beyond = pipe.centre_line_distance(ends[0])
    half_way = int(np.argmax((beyond >= -along) & (beyond > 0)))
    keep = slice(0, half_way + 1)
    return Passage(along[keep], np.stack(bends, axis=1)[keep], steep, pipe.inner_edge)


def _check_robot(robot: RobotSpec) -> None:
    lengths = robot.lengths
    halves = len(robot.joints) == len(robot.wheels) == 6 and bool(robot.hinges.all())
    if not (robot.free and halves and np.allclose(lengths, lengths[::-1])):
        raise PipenavError(
            "baseline:sequence drives two mirrored halves of three bending joints with a driven wheel at each; robot "
            f"{robot.name!r} is built otherwise: choose --robot pirate."
        )
