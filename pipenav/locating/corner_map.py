"""Map of the corner ahead: all beams of a laser fan that moves along the first leg, and the corner that fits them best.

Everything is in the canonical frame: the robot's frame with every turn a left turn, so that the first leg's walls are
the lines y = r and y = -r. The corner ahead has three unknowns, each found by a vote of all beams so far:

- r, the pipe's radius: at which distance from the axis most beams end (`first_leg`);
- the inner edge e: before it beams end at the line y = r, behind it they cross that line (`first_leg`);
- the second leg's heading h: its outer wall runs at the distance 2 r from the inner edge (`second_leg`).

In a tee or a cross the first leg's walls may go on behind the opening, or the outer wall may open too. So there, beams
that end at y = r never tell of the second leg, and beams beyond y = -r nothing of the radius.

A vote outlives wrong readings. A reading at the laser's minimum says no more than that something may be nearer; one at
its maximum, that nothing was.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.locating.corner_estimate import TIE, CornerEstimate
from pipenav.locating.first_leg import RADII, edge_range, radius_votes
from pipenav.locating.rays import Rays, pick
from pipenav.locating.second_leg import HEADINGS, OuterWall, SecondLegVotes, second_leg_votes
from pipenav.robots.parts import Laser

SCANS = 32
"""Scans kept of each robot; later scans overwrite the oldest."""

NEAR_RADII = np.array([-0.004, 0.0, 0.004, 0.008, 0.012])
"""Radii that are tried again with the second leg [m], counted from the radius that the first leg's outer wall votes
for. That radius is mostly too small, as the corner's far end counts as that wall for a while."""

SHARES = np.linspace(0.0, 1.0, 9)
"""Inner edges that are tried, as shares of the stretch in which the edge must lie."""

CHUNK = 32
"""Robots worked on at once: their tables stay in the processor's cache."""


class CornerMap:
    """The beams of n robots, and the corners that fit them.

    Args:
        laser: the fan.
        n: number of robots.
        tolerance: largest distance from a wall of a beam that votes for it [m].
    """

    def __init__(self, laser: Laser, n: int, tolerance: float) -> None:
        self._laser, self._tolerance = laser, tolerance
        self._scans, self._tee = np.zeros(n, int), np.zeros(n, bool)
        points, flags = np.full((3, n, SCANS, laser.beams, 2), np.nan), np.zeros((2, n, SCANS, laser.beams), bool)
        self._kept = Rays(*points, *flags)  # (n, SCANS, beams) instead of (k, m)

    def forget(self, indices: Ints, tee: Flags) -> None:
        """Begin anew with some robots, of which some come to a tee or a cross, (k,)."""
        self._scans[indices], self._tee[indices] = 0, tee
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

    def corner(self, indices: Ints, depth: float, straight: Flags) -> CornerEstimate:
        """Corners of some robots that fit best.

        Args:
            indices: which robots, (k,).
            depth: distance of the target past the inner edge, along the second leg [m].
            straight: whether the target lies straight on, past the crossing of the axes, (k,).
        """
        chunks = [slice(i, i + CHUNK) for i in range(0, len(indices), CHUNK)]
        parts = [self._corner(indices[chunk], depth, straight[chunk]) for chunk in chunks]
        return CornerEstimate(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _corner(self, indices: Ints, depth: float, straight: Flags) -> CornerEstimate:
        rays, tolerance, tee = self.rays(indices), self._tolerance, self._tee[indices]
        radius = RADII[radius_votes(rays, RADII[None], tolerance, tee).argmax(axis=1)]
        radii = radius[:, None] + NEAR_RADII
        first_leg = radius_votes(rays, radii, tolerance, tee)
        low, high = edge_range(rays, radii, tolerance, self._laser.range_min)
        edges = low[..., None] + (high - low)[..., None] * SHARES  # (k, radii, edges)
        second_leg = second_leg_votes(rays, radii, OuterWall(edges, high, tee), tolerance)
        votes = second_leg.agree - second_leg.against + first_leg[..., None, None]
        return _best(radii, edges, votes, second_leg, _Wanted(depth, straight))

    def rays(self, indices: Ints) -> Rays:
        """All beams of some robots, which `scan` by scan are kept here."""
        used = int(min(SCANS, self._scans[indices].max(initial=1)))
        m = used * self._laser.beams
        tip, direction, end = (kept[indices, :used].reshape(len(indices), m, 2) for kept in self._kept[:3])
        met, near = (kept[indices, :used].reshape(len(indices), m) for kept in self._kept[3:])
        return Rays(tip, direction, end, met, near)


class _Wanted(NamedTuple):
    """Target that is wanted: its depth [m], and whether it lies straight on, (k,)."""

    depth: float
    straight: Flags


def _best(radii: Floats, edges: Floats, votes: Floats, second_leg: SecondLegVotes, wanted: _Wanted) -> CornerEstimate:
    """The corner with the most votes, averaged with corners that lose to it by less than `TIE`.

    Args:
        radii: radii of the corners, (k, radii) [m].
        edges: their inner edges, (k, radii, edges) [m]; NaN where no edge can be.
        votes: votes for the corners, (k, radii, edges, headings).
        second_leg: votes on the second leg.
        wanted: the target that is wanted.
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
    target = _target(radius, edge, heading, wanted)
    farthest = np.where(weight > 0, tried[1], -np.inf).max(axis=1)
    surely = _target(radius, np.where(known, farthest, 0.0), heading, wanted)
    robot, corner = np.nonzero(weight)
    radius_tried, edge_tried, heading_tried = tried[:, robot, corner]
    wanted_there = wanted._replace(straight=wanted.straight[robot])
    off = _target(radius_tried, edge_tried, heading_tried, wanted_there) - target[robot]
    away = np.zeros_like(weight)
    away[robot, corner] = np.sqrt((off * off).sum(axis=-1))
    unknown = np.where(known, 0.0, np.nan)
    return CornerEstimate(
        radius=radius + unknown,
        edge=edge + unknown,
        heading=heading + unknown,
        target=np.where(wanted.straight[:, None], surely, target) + unknown[:, None],
        spread=np.where(known, away.max(axis=1), np.inf),
        votes=np.where(known, pick(second_leg.agree.reshape(flat.shape), best), 0.0),
        agreement=np.where(known, pick(second_leg.share.reshape(flat.shape), best), 0.0),
    )


def _target(radius: Floats, edge: Floats, heading: Floats, wanted: _Wanted) -> Floats:
    """The point on the second leg's axis past the inner edge, or on the first leg's axis past the crossing, (k, 2) [m].

    The crossing lies radius x tan(heading / 2) past the edge. Straight on, nothing but the edge and the radius need be
    known: the point is exact for a branch at a right angle, and past the crossing for others, in bores up to 120 mm.
    """
    sin, cos, depth = np.sin(heading), np.cos(heading), wanted.depth
    around = np.stack([edge + depth * cos + radius * sin, radius + depth * sin - radius * cos], axis=-1)
    ahead = np.stack([edge + radius + depth, np.zeros_like(edge)], axis=-1)
    return np.where(wanted.straight[:, None], ahead, around)
