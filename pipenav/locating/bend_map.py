"""The bend ahead that fits best what the beams of a robot have met.

The robot is told that a bend lies ahead, as a network's plan says it; how wide, sharp and far away it is, it finds out.
A bend has four unknowns: the pipe's radius r, where the bend starts, the radius of its centre line, and the change of
heading. All are tried on a grid, and every beam votes: for a bend whose wall it ends at, against one beyond whose walls
it ends or whose inner wall it goes through. Frame and names are those of `corner_map`.

The target lies on the centre line: a set depth past the bend, or where the arm can reach no farther (`bend_reach`). So
it need not be known how a long bend ends, which the robot cannot see.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats
from pipenav.locating.corner_estimate import TIE, CornerEstimate
from pipenav.locating.first_leg import edge_range
from pipenav.locating.rays import Rays, weights
from pipenav.robots.bend_reach import Bends, reach_along
from pipenav.robots.robot import RobotSpec

STRAYS = 2
"""Beams that may end beyond the outer wall by a wrong reading, when the least possible radius is asked for."""

WIDER = np.arange(0.0, 0.041, 0.005)
"""Radii of the pipe that are tried first [m], counted from the least that the beams allow."""

NEAR_RADII = np.array([-0.003, 0.0, 0.003])
"""Radii that are tried then [m], counted from the best of the first ones."""

HARDLY_BENT = 0.1
"""Distance past its start at which an inner wall has left its line by what a beam can tell [m]: the tolerance of 10 mm
at radii of up to half a metre."""

MOST_RAYS = 60
"""Most rays that vote: as many as six scans of ten beams; of more, every second or third."""

LEAST_RAYS = 4
"""Least rays that must end past the first start: fewer could not agree on a bend."""

NEARER = np.array([0.0, 0.02, 0.04, 0.06])
"""Distances by which a target may lie before the one that is wanted, where only a nearer one is sure [m]."""


class Grid(NamedTuple):
    """Bends that are tried.

    Attributes:
        starts: number of starts of the bend, in the stretch where it may start.
        radii: radii of the bend, in diameters: elbows are made of 1, 1.5 and 3, bent pipes of up to 5.
        turns: changes of heading [rad].
    """

    starts: int
    radii: Floats
    turns: Floats


COARSE = Grid(10, np.array([0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0]), np.deg2rad(np.arange(15.0, 151.0, 15.0)))
FINE = Grid(
    14,
    np.array([0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0]),
    np.deg2rad(np.arange(15.0, 151.0, 9.0)),
)
"""Grids that are tried one after the other: with many radii of the pipe, and with those near the best one."""


class _Tried(NamedTuple):
    """Bends that are tried for one robot, (c,) each, with every change of heading, (turns,).

    Attributes:
        radius: radius of the pipe [m].
        start: where the bend starts, x in the robot's frame [m].
        middle_radius: radius of the middle line's bend [m].
        turns: changes of heading [rad].
    """

    radius: Floats
    start: Floats
    middle_radius: Floats
    turns: Floats


class _Votes(NamedTuple):
    """Votes of one robot's beams on bends of each change of heading, (c, turns) each.

    Attributes:
        total: votes for less votes against.
        ahead: votes of the beams that end past the bend's start.
        share: share of `ahead` in all beams that end there.
    """

    total: Floats
    ahead: Floats
    share: Floats


def bend_estimate(
    robot: RobotSpec, rays: Rays, depth: float, tolerance: float, room: Floats, nearer: Flags
) -> CornerEstimate:
    """Bends that fit best, and targets in them.

    Args:
        robot: the robot.
        rays: rays of k robots, in the canonical frame.
        depth: distance of the target past the end of the inner wall's bend, where the arm can reach that [m].
        tolerance: largest distance from a wall of a beam that votes for it [m].
        room: spread that a target may have, (k,) [m].
        nearer: whether a nearer target will do where the wanted one has a larger spread, (k,).
    """
    estimates = []
    for i, near in enumerate(nearer):
        seen = _telling(rays.part(i))
        wanted = _Wanted(depth, float(room[i]), NEARER if near else NEARER[:1])
        estimates.append(_estimate(robot, seen, wanted, tolerance))
    return CornerEstimate(*map(np.concatenate, zip(*estimates, strict=True)))


class _Wanted(NamedTuple):
    """Target that is wanted: its depth and spread [m], and by how much nearer it may lie, (distances,) [m]."""

    depth: float
    room: float
    nearer: Floats


def _telling(rays: Rays) -> Rays:
    """Rays of one robot that say something about walls, (m, ...)."""
    told = np.flatnonzero(~rays.near & np.isfinite(rays.end).all(axis=1))
    return rays.part(told[:: -(-len(told) // MOST_RAYS) or 1])


def _estimate(robot: RobotSpec, rays: Rays, wanted: _Wanted, tolerance: float) -> CornerEstimate:
    """Estimate for one robot, k = 1."""
    least = np.sort(np.append(-rays.end[rays.met, 1], np.zeros(STRAYS + 1)))[-1 - STRAYS] - tolerance
    radii = max(least, robot.width / 2) + WIDER
    for grid in (COARSE, FINE):
        tried = _tried(robot, rays, radii, grid, tolerance)
        if np.count_nonzero(rays.met & (rays.end[:, 0] > tried.start.min(initial=np.inf))) < LEAST_RAYS:
            return _nothing_known()
        votes = _votes(rays, tried, tolerance)
        best = np.unravel_index(votes.total.argmax(), votes.total.shape)
        radii = tried.radius[best[0]] + NEAR_RADII
    bend, turn = np.nonzero(votes.total > votes.total[best] - TIE)
    weight = votes.total[bend, turn] - votes.total[best] + TIE
    weight /= weight.sum()
    numbers = np.stack([tried.radius[bend], tried.start[bend], tried.middle_radius[bend], tried.turns[turn]])
    radius, edge, _, heading = (numbers @ weight)[:, None]
    found = _target(robot, numbers, weight, wanted)
    return CornerEstimate(radius, edge, heading, *found, votes.ahead[best][None], votes.share[best][None])


class _Target(NamedTuple):
    """Target, (1, 2) [m], and its spread as a `CornerEstimate` has it, (1,) [m]."""

    target: Floats
    spread: Floats


def _target(robot: RobotSpec, numbers: Floats, weight: Floats, wanted: _Wanted) -> _Target:
    """Target in the possible bends.

    Args:
        robot: the robot.
        numbers: radius of the pipe, start, radius of the middle line and change of heading of each bend, (4, possible).
        weight: weights of the bends, (possible,).
        wanted: the target that is wanted.
    """
    possible = Bends(numbers[0], numbers[2], numbers[3])
    mean = (numbers @ weight)[:, None]
    reach = reach_along(robot, Bends(mean[0], mean[2], mean[3]), -mean[1])
    for nearer in wanted.nearer:
        along = np.minimum(possible.end + wanted.depth, reach) - nearer
        targets = possible.points(along, np.zeros_like(along)) + numbers[1][:, None] * [1.0, 0.0]
        target = weight @ targets
        spread = np.linalg.norm(targets - target, axis=1).max(keepdims=True)
        if spread[0] <= wanted.room:
            break
    return _Target(target[None], spread)


def _tried(robot: RobotSpec, rays: Rays, radii: Floats, grid: Grid, tolerance: float) -> _Tried:
    """Bends to try: of each radius of the pipe, where the inner wall may end as far as beams can tell."""
    low, high = edge_range(rays.part(None), radii[None], tolerance, robot.laser.range_min)
    share = np.linspace(0.0, 1.0, grid.starts)
    starts = low[0, :, None] - HARDLY_BENT + (high - low + HARDLY_BENT)[0, :, None] * share  # (r, starts)
    shape = (len(radii), grid.starts, len(grid.radii))
    radius, start = np.broadcast_to(radii[:, None, None], shape), np.broadcast_to(starts[..., None], shape)
    seen = np.isfinite(start).ravel()
    middle_radius = (2 * radius * grid.radii).ravel()[seen]
    return _Tried(radius.ravel()[seen], start.ravel()[seen], middle_radius, grid.turns)


def _votes(rays: Rays, tried: _Tried, tolerance: float) -> _Votes:
    past = rays.end[:, 0] > tried.start.min()  # the others end in the first leg, whichever bend follows
    lengths = (rays.tip, rays.end, *tried[:3])
    tip, end, radius, start, rho = (part / tolerance for part in lengths)  # as weights count distances
    met = rays.met
    through = _off_turning_point(tip, end, start, rho) < (rho - radius - 1.0)[:, None]
    before = np.abs(end[~past, 1]) - radius[:, None]  # (c, rays before)
    off, met_past = _off_walls(end[past], _Tried(radius, start, rho, tried.turns)), met[past]
    against = (off > 1.0).sum(axis=-1) + ((before > 1.0).sum(axis=-1) + through.sum(axis=-1))[:, None]
    agree, ahead = weights(off), (end[past, 0] > start[:, None]) & met_past  # (c, turns, m), (c, m)
    votes_ahead = np.einsum("ctm,cm->ct", agree, ahead.astype(agree.dtype))
    total = agree @ met_past.astype(agree.dtype) + (weights(before) @ met[~past])[:, None] - against
    return _Votes(total, votes_ahead, votes_ahead / np.maximum(ahead.sum(axis=-1), 1)[:, None])


def _off_walls(end: Floats, tried: _Tried) -> NDArray[np.float32]:
    """Distance of the ends of rays (m, 2) past the walls of bends, negative inside: (c, turns, m).

    Single precision is enough for votes, and these are the arrays that take the time.
    """
    radius, start, rho, turns = tried
    x, y = end.T
    sin, cos = np.sin(turns)[:, None], np.cos(turns)[:, None]  # (turns, 1)
    along, across = (x * cos + y * sin).astype(np.float32), (x * sin - y * cos).astype(np.float32)  # (turns, m)
    start_along, start_across = start * cos + rho * sin, start * sin - rho * cos  # (turns, c)
    # Offset from the middle line towards the inside: of the leg before, of the bend, and of the leg after.
    from_start, from_axis = x - start[:, None], y - rho[:, None]  # (c, m)
    bent = np.where(from_start <= 0, y, rho[:, None] - np.hypot(from_start, from_axis)).astype(np.float32)
    offset = (start_across.T + rho[:, None]).astype(np.float32)[..., None] - across
    after = along > start_along.T.astype(np.float32)[..., None]
    after &= (from_start > 0)[:, None]
    walls: NDArray[np.float32] = np.abs(np.where(after, offset, bent[:, None]))
    walls -= radius.astype(np.float32)[:, None, None]
    return walls


def _off_turning_point(tip: Floats, end: Floats, start: Floats, rho: Floats) -> Floats:
    """Distance of rays (m, 2) from the turning points of bends (c,), (c, m)."""
    dx, dy = (end - tip).T
    x, y = start[:, None] - tip[:, 0], rho[:, None] - tip[:, 1]
    share = np.clip((x * dx + y * dy) / np.maximum(dx * dx + dy * dy, 1e-12), 0.0, 1.0)
    return np.asarray(np.hypot(x - share * dx, y - share * dy))


def _nothing_known() -> CornerEstimate:
    """Estimate for one robot that has seen no bend yet, k = 1."""
    nan = np.full(1, np.nan)
    return CornerEstimate(nan, nan, nan, np.full((1, 2), np.nan), np.full(1, np.inf), np.zeros(1), np.zeros(1))
