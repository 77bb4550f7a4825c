"""Arms on a slide: which headings and slides are free in a corner, for the search through cells."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple, Self

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.certify.cells import ROUNDING, Span
from pipenav.certify.model import Model
from pipenav.certify.slide_interval import Interval, slide_interval
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import spread_targets

WITHIN = 0.99
"""Share of a target's tolerance within which motions end."""

GAPS, AROUND = 101, 0.0005
"""Number of starts whose targets say where those of a bend lie, and the room that is left around these [m]."""

LIMIT_SPARE = 0.01
"""Share of a joint's travel by which motions stay off its limits: twice what ends an episode of the task."""


class Ends(NamedTuple):
    """Starts and targets: those that a proof must exclude, and the one that a motion must join.

    Lengths in the pipe's canonical frame [m]; targets lie along the second leg and to the left of it.

    Attributes:
        slide: smallest and largest slide, x of the first link's rear end, of any episode.
        start_slide: smallest and largest slide at the start of any episode.
        start_headings: largest size of each heading at the start of any episode, (hinges,) [rad].
        along: smallest and largest distance of targets along the second leg.
        left: smallest and largest distance of targets to its left.
        aim_along: distances along it of targets that a motion may end at.
        aim_left: distances to its left of these targets.
        tolerance: distance of tip and target that counts as reached.
        base: x of the robot's frame in the episode that a motion is for, whose slide starts there.
        start: headings of the links with hinges at its start, (hinges,) [rad].
        further: the same with other targets for a motion, to be tried where there is none to this one.
    """

    slide: tuple[float, float]
    start_slide: tuple[float, float]
    start_headings: Floats
    along: tuple[float, float]
    left: tuple[float, float]
    aim_along: tuple[float, float]
    aim_left: tuple[float, float]
    tolerance: float
    base: float
    start: Floats
    further: tuple[Ends, ...] = ()

    @classmethod
    def of_task(cls, model: Model, config: ReachConfig) -> Self:
        """All episodes that the task draws in a pipe; a motion is for the one in their middle, in a bend for one whose
        target is nearest to the corner: in its middle, or to either side."""
        robot, inner = model.robot, model.pipe.inner_edge
        near, far = (-inner - gap - robot.length for gap in config.start_gap)
        lower, upper = model.limits
        half = config.target_lateral * model.pipe.diameter
        depth = (inner + config.target_depth[0], inner + config.target_depth[1])
        hinges = len(robot.joints) - 1
        found = cls(
            (far + float(lower[0]), near + float(upper[0])),
            (far, near),
            np.asarray(config.start_bend * np.arange(1, hinges + 1), float),
            depth,
            (-half, half),
            depth,
            (-half, half),
            config.reach_tolerance,
            (near + far) / 2,
            np.zeros(hinges),
        )
        return found._in_bend(model, config) if model.pipe.bend_radius else found

    def _in_bend(self, model: Model, config: ReachConfig) -> Self:
        """The same for a bend: the task's targets lie along it, as far as the arm reaches."""
        bases, targets = spread_targets(model.robot, config, model.pipe, GAPS)
        every = _in_second_leg(model, targets)
        low, high = every.min(axis=0) - AROUND, every.max(axis=0) + AROUND
        around = self._replace(along=(float(low[0]), float(high[0])), left=(float(low[1]), float(high[1])))
        nearest = np.flatnonzero(every[:, 0] <= every[:, 0].min() + AROUND)
        by_side = nearest[every[nearest, 1].argsort(kind="stable")]
        first, *others = (
            around._replace(aim_along=(float(a), float(a)), aim_left=(float(b), float(b)), base=float(bases[row]))
            for row, (a, b) in ((row, every[row]) for row in by_side[[len(by_side) // 2, 0, -1]].tolist())
        )
        return first._replace(further=tuple(others))

    @classmethod
    def of_episode(cls, model: Model, config: ReachConfig, q: Floats, base: float, target: Floats) -> Self:
        """A single episode.

        Args:
            model: what the certificate is about.
            config: the task.
            q: start in the robot's own frame, (joints,).
            base: x of the robot's frame in the pipe's frame [m].
            target: target in the robot's canonical frame, (2,) [m].
        """
        lower, upper = model.limits
        headings = np.cumsum((q * model.robot.mirror_signs if model.pipe.turn_sign < 0 else q)[1:])
        along, left = _in_second_leg(model, target + np.array([base, 0.0])).tolist()
        return cls(
            (base + float(lower[0]), base + float(upper[0])),
            (base + float(q[0]), base + float(q[0])),
            np.abs(headings),
            (along, along),
            (left, left),
            (along, along),
            (left, left),
            config.reach_tolerance,
            base,
            headings,
        )


def _in_second_leg(model: Model, points: Floats) -> Floats:
    """Points of the pipe's canonical frame, (..., 2), as distances along the second leg and to its left [m]."""
    cos, sin = math.cos(model.turn), math.sin(model.turn)
    return np.asarray(points @ np.array([[cos, -sin], [sin, cos]]))


def can_be_certified(robot: RobotSpec) -> bool:
    """Whether a robot is an arm as this module knows them: a slide along the first leg, then hinges."""
    return not robot.free and not robot.hinges[0] and bool(robot.hinges[1:].all()) and 1 < len(robot.joints) <= 4


class ArmSpans:
    """Free slides of an arm in cells of headings: what `pipenav.certify.cell_search.search` asks.

    Args:
        model: what the certificate is about.
        ends: starts and targets.
        margin: distance to the walls that a motion keeps [m].
    """

    def __init__(self, model: Model, ends: Ends, margin: float) -> None:
        self.model, self.ends = model, ends
        self._proof, self._motion = model.shapes(True), model.shapes(False, margin)
        self._proof_walls, self._motion_walls = model.walls(self._proof, True), model.walls(self._motion, False)
        self._lower, self._upper = model.limits
        self._lengths = np.array(model.robot.lengths)

    @property
    def axes(self) -> int:
        """Number of headings."""
        return len(self._lower) - 1

    def __call__(self, centres: Floats, half: float) -> tuple[Span, Span]:
        """Outer spans of cells, and the free slides in their middles.

        Args:
            centres: headings in the middle of the cells, (n, axes) [rad].
            half: half width of the cells [rad].
        """
        outer, middle = self._empty(len(centres)), self._empty(len(centres))
        possible = np.flatnonzero(self._within_limits(centres, 2 * half))
        found = self._outer(centres[possible], half)
        _put(outer, possible, found)
        possible = possible[found.free]
        _put(middle, possible, self._outer(centres[possible], 0.0))
        middle.high[~self._within_limits(centres, 0.0)] = -np.inf
        # A start or a goal that the cell may hold is taken for one of its middle where the slide allows it.
        middle.start[:] = outer.start & middle.free
        return outer, middle

    def interval(self, headings: Floats) -> Interval:
        """Slides at which a motion may be, for exact headings of the hinged links, (n, axes) [rad]."""
        free = slide_interval(self._motion, self._motion_walls, _with_base(headings))
        spare = LIMIT_SPARE * (self._upper[0] - self._lower[0])
        base = self.ends.base
        return Interval(
            np.maximum(free.low, base + self._lower[0] + spare), np.minimum(free.high, base + self._upper[0] - spare)
        )

    def within_limits(self, headings: Floats) -> Flags:
        """Whether joints are off their limits by the spare that motions keep, (n,)."""
        return self._within_limits(headings, -TURNED)

    def target_slides(self, headings: Floats) -> Interval:
        """Slides at which the tip is on a target that a motion may end at, (n,) each."""
        return self._tip_slides(headings, WITHIN * self.ends.tolerance, self.ends.aim_along, self.ends.aim_left)

    def _empty(self, n: int) -> Span:
        return Span(np.full(n, np.inf), np.full(n, -np.inf), np.zeros(n, bool), np.zeros(n, bool))

    def _within_limits(self, headings: Floats, slack: float) -> Flags:
        """Whether joints are within their limits and a slack; with a negative one, off them by it and by a spare."""
        bends = np.concatenate([headings[:, :1], np.diff(headings, axis=1)], axis=1)
        bends = np.remainder(bends + math.pi, 2 * math.pi) - math.pi
        lower, upper = self._lower[1:], self._upper[1:]
        spare = LIMIT_SPARE * (upper - lower) if slack < 0 else 0.0
        least = np.full(bends.shape[1], slack)
        least[0] = slack / 2  # the first hinge's angle is one heading, those of the others the difference of two
        return np.asarray(((bends >= lower + spare - least) & (bends <= upper - spare + least)).all(axis=1))

    def _outer(self, centres: Floats, half: float) -> Span:
        ends = self.ends
        free = slide_interval(self._proof, self._proof_walls, _with_base(centres), half)
        low = np.maximum(free.low, ends.slide[0]) - ROUNDING
        high = np.minimum(free.high, ends.slide[1]) + ROUNDING
        near = (np.abs(centres) <= ends.start_headings + half + TURNED).all(axis=1)
        start = near & (low <= ends.start_slide[1]) & (high >= ends.start_slide[0])
        reach = ends.tolerance + half * float(self._lengths[1:].sum()) + ROUNDING
        at = self._tip_slides(centres, reach, ends.along, ends.left)
        return Span(low, high, start & (low <= high), np.maximum(low, at.low) <= np.minimum(high, at.high))

    def _tip_slides(
        self, headings: Floats, tolerance: float, along: tuple[float, float], left: tuple[float, float]
    ) -> Interval:
        """Slides at which the tip is within a tolerance of a rectangle of the second leg, (n,) each.

        Such places are two rectangles, made larger along one side each, and circles around the corners. Their union is
        convex, so the slides are one interval.
        """
        turn, every = self.model.turn, _with_base(headings)
        tip = np.stack([np.cos(every) @ self._lengths, np.sin(every) @ self._lengths])
        more = np.array([-tolerance, tolerance])
        parts = [_on_rectangle(tip, turn, along + more, left), _on_rectangle(tip, turn, along, left + more)]
        parts += [_on_circle(tip, turn, tolerance, corner) for corner in sorted({*itertools.product(along, left)})]
        low = np.min([np.where(part.low <= part.high, part.low, np.inf) for part in parts], axis=0)
        high = np.max([np.where(part.low <= part.high, part.high, -np.inf) for part in parts], axis=0)
        return Interval(low, high)


def _on_rectangle(tip: Floats, turn: float, along: Pair, left: Pair) -> Interval:
    """Slides at which tips, (2, n) for a slide of 0, are in a rectangle of the second leg, (n,) each."""
    low, high = np.full(tip.shape[1], -np.inf), np.full(tip.shape[1], np.inf)
    axes = ((math.cos(turn), math.sin(turn)), (-math.sin(turn), math.cos(turn)))
    for axis, (least, most) in zip(axes, (along, left), strict=True):
        at = np.asarray(axis @ tip)
        if abs(axis[0]) < SQUARE:
            outside = (at < least - SQUARE) | (at > most + SQUARE)
            low[outside] = np.inf
            continue
        ends = np.stack([least - at, most - at]) / axis[0]
        low, high = np.maximum(low, ends.min(axis=0)), np.minimum(high, ends.max(axis=0))
    return Interval(low, high)


def _on_circle(tip: Floats, turn: float, radius: float, middle: Pair) -> Interval:
    """Slides at which tips, (2, n) for a slide of 0, are in a circle around a place of the second leg, (n,) each."""
    cos, sin = math.cos(turn), math.sin(turn)
    x, y = middle[0] * cos - middle[1] * sin, middle[0] * sin + middle[1] * cos
    square = radius**2 - (y - tip[1]) ** 2
    half = np.where(square >= 0, np.sqrt(np.maximum(square, 0.0)), -np.inf)
    return Interval(x - tip[0] - half, x - tip[0] + half)


Pair = tuple[float, float] | Floats
"""Smallest and largest of something [m], or a place: along the second leg and to its left."""

SQUARE = 1e-9
"""Cosine below which a leg counts as square to the first one, times a metre far below the slack of a proof."""

TURNED = 1e-9
"""Slack of comparisons of headings [rad]."""


def _with_base(headings: Floats) -> Floats:
    """Headings of all links: the first one keeps to the first leg, (n, links) [rad]."""
    return np.concatenate([np.zeros((len(headings), 1)), headings], axis=1)


def _put(span: Span, rows: Ints, found: Span) -> None:
    for column, values in zip(span, found, strict=True):
        column[rows] = values


def configuration(model: Model, base: float, slides: Floats, headings: Floats) -> Floats:
    """Configurations in the robot's own frame, (n, joints), from slides in the pipe's frame and canonical headings."""
    bends = np.concatenate([headings[:, :1], np.diff(headings, axis=1)], axis=1)
    bends = np.remainder(bends + math.pi, 2 * math.pi) - math.pi
    q = np.concatenate([(slides - base)[:, None], bends], axis=1)
    return np.asarray(q * model.robot.mirror_signs if model.pipe.turn_sign < 0 else q)
