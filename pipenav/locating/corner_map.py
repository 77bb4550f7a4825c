"""Map of the corner ahead: all beams of a laser fan that moves along the first leg, and the corner that fits them best.

Everything is in the canonical frame: the robot's frame with every turn a left turn, so that the first leg's walls are
the lines y = r and y = -r. The corner ahead has three unknowns, each found by a vote of all beams so far:

- r, the pipe's radius: at which distance from the axis most beams end (`first_leg`);
- the inner edge e: before it beams end at the line y = r, behind it they cross that line (`first_leg`);
- the second leg's heading h: its outer wall runs at the distance 2 r from the inner edge (`second_leg`).

A vote outlives wrong readings. A reading at the laser's minimum says no more than that something may be nearer; one at
its maximum, that nothing was.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.locating.first_leg import edge_range, radius_votes
from pipenav.locating.rays import Rays, pick
from pipenav.locating.second_leg import HEADINGS, SecondLegVotes, second_leg_votes
from pipenav.robots.parts import Laser

SCANS = 32
"""Scans kept of each robot; later scans overwrite the oldest."""

RADII = np.arange(0.020, 0.1505, 0.001)
"""Radii that are tried [m]: radii of the pipes that can be made."""

NEAR_RADII = np.array([-0.004, 0.0, 0.004, 0.008, 0.012])
"""Radii that are tried again with the second leg [m], counted from the radius that the first leg's outer wall votes
for. That radius is mostly too small, as the corner's far end counts as that wall for a while."""

SHARES = np.linspace(0.0, 1.0, 9)
"""Inner edges that are tried, as shares of the stretch in which the edge must lie."""

TIE = 1.0
"""Votes by which a corner may lose to the best one and still be possible."""

CHUNK = 32
"""Robots worked on at once: their tables stay in the processor's cache."""


class CornerEstimate(NamedTuple):
    """Best estimates of n robots' corners; NaN where nothing can be said yet.

    Attributes:
        radius: radius of the pipe, (n,) [m].
        edge: end of the inner wall along the first leg, (n,) [m].
        heading: heading of the second leg, (n,) [rad].
        target: middle of the second leg at the wanted depth, (n, 2) [m].
        spread: largest distance of the target from the target of another possible corner, (n,) [m].
        votes: votes of the beams that agree on the second leg's outer wall, (n,).
        agreement: share of `votes` in all beams that ended past the first leg's walls, (n,).
    """

    radius: Floats
    edge: Floats
    heading: Floats
    target: Floats
    spread: Floats
    votes: Floats
    agreement: Floats


class CornerMap:
    """The beams of n robots, and the corners that fit them.

    Args:
        laser: the fan.
        n: number of robots.
        tolerance: largest distance from a wall of a beam that votes for it [m].
    """

    def __init__(self, laser: Laser, n: int, tolerance: float) -> None:
        self._laser, self._tolerance = laser, tolerance
        self._scans = np.zeros(n, int)
        points, flags = np.full((3, n, SCANS, laser.beams, 2), np.nan), np.zeros((2, n, SCANS, laser.beams), bool)
        self._kept = Rays(*points, *flags)  # (n, SCANS, beams) instead of (k, m)

    def forget(self, indices: Ints) -> None:
        """Begin anew with some robots."""
        self._scans[indices] = 0
        self._kept.end[indices], self._kept.met[indices], self._kept.near[indices] = np.nan, False, False

    def add(self, indices: Ints, tip: Floats, beams: Floats, ranges: Floats) -> None:
        """Take in one scan of some robots.

        Args:
            indices: which robots, (k,).
            tip: beginnings of the beams, (k, 2) [m].
            beams: headings of the beams, (k, beams) [rad].
            ranges: readings, (k, beams) [m].
        """
        slot = self._scans[indices] % SCANS
        direction, kept = np.stack([np.cos(beams), np.sin(beams)], axis=-1), self._kept
        near, far = ranges <= self._laser.range_min, ranges >= self._laser.range_max
        kept.tip[indices, slot] = tip[:, None]
        kept.direction[indices, slot] = direction
        kept.end[indices, slot] = tip[:, None] + ranges[..., None] * direction
        kept.met[indices, slot] = ~(near | far | np.isnan(ranges))
        kept.near[indices, slot] = near
        self._scans[indices] += 1

    def corner(self, indices: Ints, depth: float) -> CornerEstimate:
        """Corners of some robots that fit best.

        Args:
            indices: which robots, (k,).
            depth: distance of the target past the inner edge, along the second leg [m].
        """
        parts = [self._corner(indices[i : i + CHUNK], depth) for i in range(0, len(indices), CHUNK)]
        return CornerEstimate(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _corner(self, indices: Ints, depth: float) -> CornerEstimate:
        rays, tolerance = self._rays(indices), self._tolerance
        radius = RADII[radius_votes(rays, RADII[None], tolerance).argmax(axis=1)]
        radii = radius[:, None] + NEAR_RADII
        first_leg = radius_votes(rays, radii, tolerance)
        low, high = edge_range(rays, radii, tolerance, self._laser.range_min)
        edges = low[..., None] + (high - low)[..., None] * SHARES  # (k, radii, edges)
        second_leg = second_leg_votes(rays, radii, high, edges, tolerance)
        votes = second_leg.agree - second_leg.against + first_leg[..., None, None]
        return _best(radii, edges, votes, second_leg, depth)

    def _rays(self, indices: Ints) -> Rays:
        used = int(min(SCANS, self._scans[indices].max(initial=1)))
        m = used * self._laser.beams
        tip, direction, end = (kept[indices, :used].reshape(len(indices), m, 2) for kept in self._kept[:3])
        met, near = (kept[indices, :used].reshape(len(indices), m) for kept in self._kept[3:])
        return Rays(tip, direction, end, met, near)


def _best(radii: Floats, edges: Floats, votes: Floats, second_leg: SecondLegVotes, depth: float) -> CornerEstimate:
    """The corner with the most votes, averaged with corners that lose to it by less than `TIE`.

    Args:
        radii: radii of the corners, (k, radii) [m].
        edges: their inner edges, (k, radii, edges) [m]; NaN where no edge can be.
        votes: votes for the corners, (k, radii, edges, headings).
        second_leg: votes on the second leg.
        depth: distance of the target past the inner edge [m].
    """
    impossible = np.isnan(edges)
    flat = np.where(impossible[..., None], -np.inf, votes).reshape(len(votes), -1)  # (k, corners), as all flat ones
    best = flat.argmax(axis=1)
    most = pick(flat, best)
    known = np.isfinite(most)
    weight = np.maximum(flat - np.where(known, most - TIE, np.inf)[:, None], 0.0)
    weight /= np.maximum(weight.sum(axis=1, keepdims=True), 1e-9)
    grid = np.empty((3, *votes.shape))
    grid[0], grid[1], grid[2] = radii[:, :, None, None], np.where(impossible, 0.0, edges)[..., None], HEADINGS
    tried = grid.reshape(3, *flat.shape)
    radius, edge, heading = (weight * tried).sum(axis=-1)
    target = _target(radius, edge, heading, depth)
    robot, corner = np.nonzero(weight)
    radius_tried, edge_tried, heading_tried = tried[:, robot, corner]
    off = _target(radius_tried, edge_tried, heading_tried, depth) - target[robot]
    away = np.zeros_like(weight)
    away[robot, corner] = np.sqrt((off * off).sum(axis=-1))
    unknown = np.where(known, 0.0, np.nan)
    return CornerEstimate(
        radius=radius + unknown,
        edge=edge + unknown,
        heading=heading + unknown,
        target=target + unknown[:, None],
        spread=np.where(known, away.max(axis=1), np.inf),
        votes=np.where(known, pick(second_leg.agree.reshape(flat.shape), best), 0.0),
        agreement=np.where(known, pick(second_leg.share.reshape(flat.shape), best), 0.0),
    )


def _target(radius: Floats, edge: Floats, heading: Floats, depth: float) -> Floats:
    """The point on the second leg's axis at `depth` past the inner edge, (..., 2) [m]."""
    sin, cos = np.sin(heading), np.cos(heading)
    return np.stack([edge + depth * cos + radius * sin, radius + depth * sin - radius * cos], axis=-1)
