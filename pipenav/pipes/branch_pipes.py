"""Branches of a route: where they lie, and the tees and crosses that are possible.

A tee or a cross has a straight run, two pipes in line with the same bore, and branches that leave it. The route can
come by any of its pipes and go on by any other. Every pipe is half of a cylinder that begins where the axes cross, so
the fitting is their union.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.errors import PipenavError
from pipenav.pipes.branch import IN_LINE, MAX_BRANCHES, Branch
from pipenav.pipes.convex import apart
from pipenav.pipes.corner_checks import (
    ANGLE_RANGE_DEG,
    DIAMETER_RANGE_MM,
    LEG_MAX_MM,
    ROLL_MAX_DEG,
    check_range,
)
from pipenav.pipes.rotations import about_x, about_z
from pipenav.pipes.route_corner import Corner, inside_angles
from pipenav.pipes.route_legs import ROUND, SPACING, rod_angles
from pipenav.units import m_to_mm, rad_to_deg

BRANCH_ANGLE_RANGE_DEG = (30.0, 150.0)
"""Angles between a branch and its run, and between two branches."""


LEAST_SHOWN = 0.3
"""Shortest default length of a branch [m]: some diameters, so that a laser and a lost robot find a pipe there."""


class BranchPipes(NamedTuple):
    """All branches of a route, corner by corner.

    Attributes:
        corner: corner of each branch, counted from 0, (b,).
        start: crossing of the axes, (b, 3) [m].
        axes: unit vectors along the branch, to its left and upwards as columns, (b, 3, 3).
        radius: radius of the bore, (b,) [m].
        length: length from the crossing of the axes to the end, (b,) [m].
        closed: whether a cap closes the end, (b,).
    """

    corner: Ints
    start: Floats
    axes: Floats
    radius: Floats
    length: Floats
    closed: Flags

    @property
    def in_plane(self) -> bool:
        """Whether all branches lie in the x-y plane."""
        return bool((np.abs(self.axes[:, 2, 0]) < IN_LINE).all())

    def contain(self, points: Floats) -> Flags:
        """Flags of points (..., 3) in the bore of a branch: (...)."""
        local = np.einsum("...bi,bij->...bj", points[..., None, :] - self.start, self.axes)
        along, off = local[..., 0], np.hypot(local[..., 1], local[..., 2])
        return np.asarray(((along >= 0) & (along <= self.length) & (off <= self.radius)).any(axis=-1))


class _Arm(NamedTuple):
    """A pipe of a fitting: unit vector away from the crossing, (3,), and diameter [m]."""

    direction: Floats
    diameter: float


class MeetingBranch(NamedTuple):
    """A branch that meets another pipe: its corner, counted from 0, and the other pipe in words."""

    corner: int
    other: str


def meeting_branch(branches: BranchPipes, rods: Sequence[Floats], wall: float) -> MeetingBranch | None:
    """A branch that meets, or nearly meets, a leg or a branch of another corner, as solid rods.

    Args:
        branches: branches of a route.
        rods: the legs' rods, see `Legs.rods`.
        wall: wall thickness [m].
    """
    around = rod_angles()
    circle = np.stack([np.zeros(ROUND), np.cos(around), np.sin(around)], axis=1) / math.cos(math.pi / ROUND)
    ends = [
        start + (radius + wall) * circle @ axes.T + far * axes[:, 0]
        for start, axes, radius, length in zip(*branches[1:5], strict=True)
        for far in (0.0, length)
    ]
    own = [np.concatenate(ends[2 * i : 2 * i + 2]) for i in range(len(branches.corner))]
    for i, corner in enumerate(branches.corner.tolist()):
        for leg, rod in enumerate(rods):
            if leg not in (corner, corner + 1) and not apart(own[i], rod, SPACING):
                return MeetingBranch(corner, f"straight {leg + 1}")
        for j, other in enumerate(branches.corner.tolist()):
            if other > corner and not apart(own[i], own[j], SPACING):
                return MeetingBranch(corner, f"the branch at corner {other + 1}")
    return None


def make_branches(corners: Sequence[Corner], start: Floats, axes: Floats) -> BranchPipes:
    """The branches of a route whose legs begin at `start` (legs, 3) with `axes` (legs, 3, 3)."""
    before = np.cumsum([0.0, *(corner.roll for corner in corners)])
    found = [(i, branch) for i, corner in enumerate(corners) for branch in corner.branches]
    turned = [axes[i] @ _turned(branch, float(before[i])) for i, branch in found]
    at = np.array([i for i, _ in found], int)
    return BranchPipes(
        at,
        start[at + 1].reshape(-1, 3),
        np.array(turned).reshape(-1, 3, 3),
        np.array([branch.diameter / 2 for _, branch in found]),
        np.array([branch.length for _, branch in found]),
        np.array([branch.closed for _, branch in found], bool),
    )


def reach_of_opening(radius: float, other: float, cosine: float) -> float:
    """Distance along a pipe from the crossing of the axes to where the wall of another pipe meets its own [m].

    Args:
        radius: radius of the pipe [m].
        other: radius of the other pipe [m].
        cosine: cosine of the angle between the two, both seen from the crossing; 0 m where they are in line.
    """
    sine = math.sqrt(max(1.0 - cosine**2, 0.0))
    return 0.0 if sine < IN_LINE else max((other + radius * cosine) / sine, 0.0)


def reaches(directions: Floats, radius: Floats) -> Floats:
    """Reach of a fitting's openings along each of its pipes from the crossing of their axes, (pipes,) [m].

    Args:
        directions: unit vectors along the pipes, away from the crossing, (pipes, 3).
        radius: radius of each pipe's bore, or of its outside, (pipes,) [m].
    """
    cosines, pipes = directions @ directions.T, range(len(radius))
    return np.array(
        [
            max(reach_of_opening(float(radius[i]), float(radius[j]), float(cosines[i, j])) for j in pipes if j != i)
            for i in pipes
        ]
    )


def reaches_of(corner: Corner, before: float, after: float, wall: float = 0.0) -> Floats:
    """Reach of all openings along every pipe of a fitting: the leg before, the leg after, and the branches, (p,) [m].

    Args:
        corner: a tee or a cross.
        before: diameter of the leg before [m].
        after: diameter of the leg after [m].
        wall: thickness of the wall where the outsides are asked for [m].
    """
    arms = _arms(corner, before, after)
    return reaches(np.array([arm.direction for arm in arms]), np.array([arm.diameter / 2 + wall for arm in arms]))


def way_past(corner: Corner, before: float, after: float) -> float:
    """Distance along the longer of its two legs to where a fitting's openings that the robot passes end [m].

    A robot that turns passes the edge between its two legs, one that goes straight on passes the openings of all
    branches.

    Args:
        corner: a tee or a cross.
        before: radius of the leg before [m].
        after: radius of the leg after [m].
    """
    if corner.straight_on:
        return float(reaches_of(corner, 2 * before, 2 * after)[:2].max())
    cosine = math.cos(corner.angle)
    return max(reach_of_opening(before, after, cosine), reach_of_opening(after, before, cosine))


def check_fitting(number: int, corner: Corner, before: float, after: float, wall: float) -> None:
    """Refuse a tee or a cross that is none, or whose branches are too short.

    Args:
        number: number of the corner in its route, from 1.
        corner: the corner.
        before: diameter of the leg before [m].
        after: diameter of the leg after [m].
        wall: wall thickness [m].

    Raises:
        OutOfRange: a number outside its range.
        PipenavError: no run, a branch wider than its run, or branches that overlap.
    """
    if len(corner.branches) > MAX_BRANCHES:
        raise PipenavError(
            f"corner {number} has {len(corner.branches)} branches: a tee has one, a cross {MAX_BRANCHES}."
        )
    check_range(f"bend radius of corner {number}, a tee or cross,", m_to_mm(corner.bend_radius), 0.0, 0.0, "mm")
    for branch in corner.branches:
        check_range(f"diameter of a branch at corner {number}", m_to_mm(branch.diameter), *DIAMETER_RANGE_MM, "mm")
        check_range(f"angle of a branch at corner {number}", rad_to_deg(branch.angle), *ANGLE_RANGE_DEG, "deg")
        check_range(f"roll of a branch at corner {number}", rad_to_deg(branch.roll), -ROLL_MAX_DEG, ROLL_MAX_DEG, "deg")
    _check_arms(number, _arms(corner, before, after))
    least = shortest_branches(corner, before, after, wall)
    for branch, shortest in zip(corner.branches, least, strict=True):
        low = math.ceil(m_to_mm(shortest) - 1e-6)
        check_range(f"length of a branch at corner {number}", m_to_mm(branch.length), low, LEG_MAX_MM, "mm")


def shortest_branches(corner: Corner, before: float, after: float, wall: float) -> list[float]:
    """Least length of each branch of a fitting: past the opening, by a tenth of its diameter, (branches,) [m]."""
    needed = reaches_of(corner, before, after, wall)[2:]
    return [float(reach) + 0.1 * branch.diameter for reach, branch in zip(needed, corner.branches, strict=True)]


def with_default_branches(corner: Corner, before: float, after: float, wall: float) -> Corner:
    """A fitting whose branches without a length get one: `LEAST_SHOWN`, or more where the fitting needs it.

    Args:
        corner: a tee or a cross; a length of 0 is none.
        before: diameter of the leg before [m].
        after: diameter of the leg after [m].
        wall: wall thickness [m].
    """
    numbers = [before, after, wall, corner.angle, corner.roll]
    numbers += [number for branch in corner.branches for number in (branch.angle, branch.roll, branch.diameter)]
    if not all(map(math.isfinite, numbers)):
        return corner  # the checks refuse it in words
    least = shortest_branches(corner, before, after, wall)
    branches = [
        branch
        if branch.length
        else branch.model_copy(update={"length": max(LEAST_SHOWN, math.ceil((shortest + branch.diameter) * 100) / 100)})
        for branch, shortest in zip(corner.branches, least, strict=True)
    ]
    return corner.model_copy(update={"branches": tuple(branches)})


def _check_arms(number: int, arms: list[_Arm]) -> None:
    """Refuse pipes of a fitting that have no run, or whose branches are wider than the run or overlap."""
    in_line = [pair for pair in combinations(arms, 2) if pair[0].direction @ pair[1].direction < -math.cos(IN_LINE)]
    runs = [pair for pair in in_line if abs(pair[0].diameter - pair[1].diameter) < 1e-9]
    if not runs:
        raise PipenavError(
            f"corner {number} has no run: two pipes of a tee or cross must be in line and of one diameter; give the "
            "corner or a branch the angle 180 deg, or two branches to opposite sides."
        )
    run = max(runs, key=lambda pair: pair[0].diameter)
    low, high = BRANCH_ANGLE_RANGE_DEG
    others = [arm for arm in arms if not any(arm is part for part in run)]
    for arm in others:
        check_range(
            f"diameter of a branch at corner {number} (at most its run's)",
            m_to_mm(arm.diameter),
            DIAMETER_RANGE_MM[0],
            m_to_mm(run[0].diameter),
            "mm",
        )
        angle = math.degrees(math.acos(np.clip(arm.direction @ run[0].direction, -1.0, 1.0)))
        check_range(f"angle between a branch at corner {number} and its run", angle, low, high, "deg")
    for one, other in combinations(others, 2):
        angle = math.degrees(math.acos(np.clip(one.direction @ other.direction, -1.0, 1.0)))
        check_range(f"angle between the branches at corner {number}", angle, low, 180.0, "deg")


def _arms(corner: Corner, before: float, after: float) -> list[_Arm]:
    """The leg before, the leg after and the branches of a fitting, in the frame of the leg before without twist."""
    (inside,) = inside_angles([corner])
    turned = about_x(inside) @ about_z(math.pi - corner.angle)
    legs = [_Arm(np.array([-1.0, 0.0, 0.0]), before), _Arm(turned[:, 0], after)]
    return [*legs, *(_Arm(_turned(branch, 0.0)[:, 0], branch.diameter) for branch in corner.branches)]


def _turned(branch: Branch, rolled: float) -> Floats:
    """Axes of a branch in the frame of the leg before it, (3, 3); `rolled` sums the rolls of the corners before."""
    around = rolled + branch.roll + math.pi * (branch.turn == "right")
    return np.asarray(about_x(around) @ about_z(math.pi - branch.angle) @ about_x(-around))
