"""The bend ahead that fits best what the beams of a robot have met.

The robot is told that a bend lies ahead, as a network's plan says it; how wide, how sharp and how far away it finds out.
A bend has four unknowns: the pipe's radius r, where the bend starts, the radius of its centre line, and the change of
heading. All are tried on a grid, and every beam votes: for a bend whose wall it ends at, against one beyond whose walls
it ends or whose inner wall it goes through. Frame and names are those of `corner_map`.

The target lies on the centre line: a set depth past the bend, or where the arm can reach no farther (`bend_reach`). So
it need not be known how a long bend ends, which the robot cannot see.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.locating.corner_estimate import TIE, CornerEstimate
from pipenav.locating.first_leg import RADII, edge_range, radius_votes
from pipenav.locating.rays import Rays, weights
from pipenav.robots.bend_reach import Bends, reach_along
from pipenav.robots.robot import RobotSpec

NEAR_RADII = np.array([-0.003, 0.0, 0.003])
"""Radii that are tried again with the bend [m], counted from the radius that the first leg's walls vote for."""

BEND_RADII = np.array([0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0])
"""Radii of the bend that are tried, in diameters: elbows are made of 1, 1.5 and 3, bent pipes of up to 5."""

TURNS = np.deg2rad(np.arange(15.0, 151.0, 7.5))
"""Changes of heading that are tried [rad]."""

STARTS = 14
"""Starts of the bend that are tried, in the stretch where it may start."""

HARDLY_BENT = 0.1
"""Distance past its start at which an inner wall has left its line by what a beam can tell [m]: the laser's tolerance of
10 mm at radii of up to half a metre."""


class _Tried(NamedTuple):
    """Bends that are tried for one robot, (c,) each.

    Attributes:
        radius: radius of the pipe [m].
        start: where the bend starts, x in the robot's frame [m].
        middle_radius: radius of the middle line's bend [m].
    """

    radius: Floats
    start: Floats
    middle_radius: Floats


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


def bend_estimate(robot: RobotSpec, rays: Rays, depth: float, tolerance: float) -> CornerEstimate:
    """Bends that fit best, and targets in them.

    Args:
        robot: the robot.
        rays: rays of k robots, in the canonical frame.
        depth: distance of the target past the end of the inner wall's bend, where the arm can reach that [m].
        tolerance: largest distance from a wall of a beam that votes for it [m].
    """
    both = np.ones(len(rays.tip), bool)  # either wall of the first leg tells of the radius
    radius = RADII[radius_votes(rays, RADII[None], tolerance, both).argmax(axis=1)]
    low, high = edge_range(rays, radius[:, None], tolerance, robot.laser.range_min)
    estimates = [
        _estimate(robot, Rays(*(part[i] for part in rays)), _tried(radius[i], low[i, 0], high[i, 0]), depth, tolerance)
        if np.isfinite(high[i, 0])
        else _nothing_known()
        for i in range(len(radius))
    ]
    return CornerEstimate(*map(np.concatenate, zip(*estimates, strict=True)))


def _tried(radius: float, low: float, high: float) -> _Tried:
    """Bends to try in a pipe whose inner wall ends, as far as beams can tell, from `low` to `high`."""
    starts = np.linspace(low - HARDLY_BENT, high, STARTS)
    radii, starts, bends = (grid.ravel() for grid in np.meshgrid(radius + NEAR_RADII, starts, BEND_RADII))
    return _Tried(radii, starts, 2 * radii * bends)


def _estimate(robot: RobotSpec, rays: Rays, tried: _Tried, depth: float, tolerance: float) -> CornerEstimate:
    """Estimate for one robot, k = 1, whose rays are (m, ...)."""
    votes = _votes(rays, tried, tolerance)
    best = np.unravel_index(votes.total.argmax(), votes.total.shape)
    bend, turn = np.nonzero(votes.total > votes.total[best] - TIE)
    weight = votes.total[bend, turn] - votes.total[best] + TIE
    weight /= weight.sum()
    numbers = np.stack([tried.radius[bend], tried.start[bend], tried.middle_radius[bend], TURNS[turn]])
    possible = Bends(numbers[0], numbers[2], numbers[3])
    mean = (numbers @ weight)[:, None]  # (4, 1)
    reach = reach_along(robot, Bends(mean[0], mean[2], mean[3]), -mean[1])
    along = np.minimum(possible.end + depth, reach)
    targets = possible.points(along, np.zeros_like(along)) + numbers[1][:, None] * [1.0, 0.0]
    target = weight @ targets
    return CornerEstimate(
        radius=mean[0],
        edge=mean[1],
        heading=mean[3],
        target=target[None],
        spread=np.linalg.norm(targets - target, axis=1).max(keepdims=True),
        votes=votes.ahead[best][None],
        agreement=votes.share[best][None],
    )


def _votes(rays: Rays, tried: _Tried, tolerance: float) -> _Votes:
    told = ~rays.near & np.isfinite(rays.end).all(axis=1)
    tip, end, met = (part[told] for part in (rays.tip, rays.end, rays.met))
    past = end[:, 0] > tried.start.min()  # the others end in the first leg, whichever bend follows
    tip, end, radius, start, rho = (part / tolerance for part in (tip, end, *tried))  # as weights count distances
    through = _off_turning_point(tip, end, start, rho) < (rho - radius - 1.0)[:, None]
    before = np.abs(end[~past, 1]) - radius[:, None]  # (c, rays before)
    off, met_past = _off_walls(end[past], _Tried(radius, start, rho)), met[past]
    against = (off > 1.0).sum(axis=-1) + ((before > 1.0).sum(axis=-1) + through.sum(axis=-1))[:, None]
    agree, ahead = weights(off), (end[past, 0] > start[:, None]) & met_past  # (c, turns, m), (c, m)
    votes_ahead = np.einsum("ctm,cm->ct", agree, ahead.astype(agree.dtype))
    total = agree @ met_past.astype(agree.dtype) + (weights(before) @ met[~past])[:, None] - against
    return _Votes(total, votes_ahead, votes_ahead / np.maximum(ahead.sum(axis=-1), 1)[:, None])


def _off_walls(end: Floats, tried: _Tried) -> Floats:
    """Distance of the ends of rays (m, 2) past the walls of bends of each of `TURNS`, negative inside: (c, turns, m).

    Single precision is enough for votes, and these are the arrays that take the time.
    """
    radius, start, rho = tried
    x, y = end.T
    sin, cos = np.sin(TURNS)[:, None], np.cos(TURNS)[:, None]  # (turns, 1)
    along, across = (x * cos + y * sin).astype(np.float32), (x * sin - y * cos).astype(np.float32)  # (turns, m)
    start_along, start_across = start * cos + rho * sin, start * sin - rho * cos  # (turns, c)
    # Offset from the middle line towards the inside: of the leg before, of the bend, and of the leg after.
    from_start, from_axis = x - start[:, None], y - rho[:, None]  # (c, m)
    bent = np.where(from_start <= 0, y, rho[:, None] - np.hypot(from_start, from_axis)).astype(np.float32)
    offset = (start_across.T + rho[:, None]).astype(np.float32)[..., None] - across
    after = along > start_along.T.astype(np.float32)[..., None]
    after &= (from_start > 0)[:, None]
    offset = np.where(after, offset, bent[:, None])
    np.abs(offset, out=offset)
    offset -= radius.astype(np.float32)[:, None, None]
    return offset


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
