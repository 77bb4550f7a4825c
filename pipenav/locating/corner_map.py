"""What a laser fan that moves along the first leg has seen of the corner ahead, and the corner that fits it best.

Everything is in the canonical frame: the robot's frame with every turn a left turn, so that the first leg's walls are
the lines y = r and y = -r. What lies ahead has three unknowns, each found by a vote of all beams so far:

- r, the pipe's radius: at which distance from the axis most beams end;
- the inner edge's place e: before it beams end at the line y = r, behind it they cross that line;
- the second leg's heading h: its outer wall runs at the distance 2 r from the inner edge.

A vote outlives readings that are wrong. A reading at the laser's minimum says no more than that something may be
nearer; one at its maximum that nothing was.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.robots.parts import Laser

Flags = Flags

SCANS = 32
"""Scans kept of each robot; later ones overwrite the oldest."""

RADII = np.arange(0.020, 0.1505, 0.001)
"""Radii that are tried [m]: those of the pipes that can be made."""

NEAR_RADII = np.array([-0.004, 0.0, 0.004, 0.008, 0.012])
"""Radii that are tried again with the second leg [m], seen from the one that the first leg's outer wall votes for: too
small ones mostly, as the corner's far end counts as that wall for a while."""

HEADINGS = np.deg2rad(np.arange(15.0, 151.0, 3.0))
"""Headings of the second leg that are tried [rad]."""

SIN, COS = np.sin(HEADINGS), np.cos(HEADINGS)
"""Of the headings, (headings,)."""

PLACES = np.linspace(0.0, 1.0, 9)
"""Places of the inner edge that are tried, as shares of the stretch in which it must lie."""

HIDDEN = 0.1
"""How far before the first beam that crosses the line y = r the edge may lie where no beam has met the wall [m]."""

TIE = 1.0
"""Corners that lose to the best one by less than one beam's vote are possible too."""

LEFTWARDS = 0.05
"""Least sine of a beam's heading that tells where it crosses the inner wall: flatter ones cross it too far away."""

CHUNK = 32
"""Robots worked on at once: their tables stay in the processor's cache."""


class CornerEstimate(NamedTuple):
    """The best guess of n robots' corners; NaN where nothing can be said yet.

    Attributes:
        radius: of the pipe, (n,) [m].
        edge: where the inner wall ends, along the first leg, (n,) [m].
        heading: of the second leg, (n,) [rad].
        target: the middle of the second leg at the wanted depth, (n, 2) [m].
        spread: how far the target of another possible corner lies from it at most, (n,) [m].
        votes: beams that agree on the second leg's outer wall, (n,).
        agreement: their share of all beams that ended past the first leg's walls, (n,).
    """

    radius: Floats
    edge: Floats
    heading: Floats
    target: Floats
    spread: Floats
    votes: Floats
    agreement: Floats


class _Rays(NamedTuple):
    """All beams so far: tip (k, m, 2) [m], direction (k, m, 2), end (k, m, 2) [m], whether it met a wall within the
    laser's range, and whether it read the laser's minimum, (k, m)."""

    tip: Floats
    direction: Floats
    end: Floats
    met: Flags
    near: Flags


class CornerMap:
    """The beams of n robots.

    Args:
        laser: the fan.
        n: robots.
        tolerance: how far from a wall a beam may end that votes for it [m].
    """

    def __init__(self, laser: Laser, n: int, tolerance: float) -> None:
        self._laser, self._tolerance = laser, tolerance
        self._scans = np.zeros(n, int)
        points, flags = np.full((3, n, SCANS, laser.beams, 2), np.nan), np.zeros((2, n, SCANS, laser.beams), bool)
        self._kept = _Rays(*points, *flags)  # (n, SCANS, beams) instead of (k, m)

    def forget(self, indices: Ints) -> None:
        """Begin anew with some robots."""
        self._scans[indices] = 0
        self._kept.end[indices], self._kept.met[indices], self._kept.near[indices] = np.nan, False, False

    def add(self, indices: Ints, tip: Floats, beams: Floats, ranges: Floats) -> None:
        """Take in one scan of some robots.

        Args:
            indices: which, (k,).
            tip: where the beams begin, (k, 2) [m].
            beams: their headings, (k, beams) [rad].
            ranges: what they read, (k, beams) [m].
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
        """The corners that fit best.

        Args:
            indices: which, (k,).
            depth: of the target past the inner edge, along the second leg [m].
        """
        parts = [self._corner(indices[i : i + CHUNK], depth) for i in range(0, len(indices), CHUNK)]
        return CornerEstimate(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _corner(self, indices: Ints, depth: float) -> CornerEstimate:
        rays = self._rays(indices)
        radius = RADII[self._radius_votes(rays, RADII[None]).argmax(axis=1)]
        radii = radius[:, None] + NEAR_RADII
        first_leg = self._radius_votes(rays, radii)
        low, high = self._edge(rays, radii)
        edges = low[..., None] + (high - low)[..., None] * PLACES  # (k, radii, places)
        agree, against, share = self._second_leg(rays, radii, high, edges)
        votes = agree - against + first_leg[..., None, None]
        return _best(radii, edges, votes, agree, share, depth)

    def _rays(self, indices: Ints) -> _Rays:
        used = int(min(SCANS, self._scans[indices].max(initial=1)))
        m = used * self._laser.beams
        tip, direction, end = (kept[indices, :used].reshape(len(indices), m, 2) for kept in self._kept[:3])
        met, near = (kept[indices, :used].reshape(len(indices), m) for kept in self._kept[3:])
        return _Rays(tip, direction, end, met, near)

    def _radius_votes(self, rays: _Rays, radii: Floats) -> Floats:
        """For radii (k, r) or (1, r): how many beams end at the outer wall, y = -r, less those beyond it, (k, r)."""
        below = -rays.end[..., 1]
        below = _packed(below, rays.met & (below > radii.min() - 2 * self._tolerance))
        off = (below[..., None] - radii[:, None]) / self._tolerance  # (k, m, r)
        beyond = off > 1.0
        votes = _kernel(off)
        votes -= beyond
        return np.asarray(votes.sum(axis=1))

    def _edge(self, rays: _Rays, radii: Floats) -> tuple[Floats, Floats]:
        """The stretch of the line y = radius in which the inner wall ends: fewest beams contradict it.

        Args:
            rays: of k robots.
            radii: (k, r) [m].

        Returns:
            Its beginning and its end, (k, r) each; NaN where no edge can be.
        """
        tip, direction, end, near = rays.tip[:, None], rays.direction[:, None], rays.end[:, None], rays.near[:, None]
        rise = direction[..., 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            length = (radii[..., None] - tip[..., 1]) / rise  # (k, r, m), as all below
            x = tip[..., 0] + length * direction[..., 0]
        height = end[..., 1] - radii[..., None]
        leftwards = (rise > LEFTWARDS) & (length > 0)
        wall = leftwards & np.where(near, length <= self._laser.range_min, np.abs(height) <= self._tolerance)
        free = leftwards & ~near & (height > self._tolerance)
        first_free = np.where(free, x, np.inf).min(axis=-1)
        wall &= x < (first_free + radii)[..., None]  # farther on, it is the second leg's outer wall that crosses y = r
        order = np.where(wall | free, x, np.inf).argsort(axis=-1, kind="stable")
        walls, frees, x = (_ordered(values, order) for values in (wall, free, x))
        # cost[j]: beams that contradict an edge between crossings j - 1 and j
        all_walls = walls.sum(axis=-1, keepdims=True)
        cost = np.concatenate([all_walls, all_walls - np.cumsum(walls, axis=-1) + np.cumsum(frees, axis=-1)], axis=-1)
        best = cost == cost.min(axis=-1, keepdims=True)
        first, last = best.argmax(axis=-1), cost.shape[-1] - 1 - best[..., ::-1].argmax(axis=-1)
        high = np.where(last < all_walls[..., 0] + frees.sum(axis=-1), _pick(x, last), np.nan)
        return np.where(first > 0, _pick(x, first - 1), high - HIDDEN), high

    def _second_leg(self, rays: _Rays, radii: Floats, high: Floats, edges: Floats) -> tuple[Floats, Ints, Floats]:
        """The vote on the second leg's outer wall.

        Args:
            rays: of k robots.
            radii: of the pipe, (k, r) [m].
            high: where the inner wall ends at the latest, (k, r) [m].
            edges: places where it may end, (k, r, places) [m].

        Returns:
            How many beams agree on the second leg, how many end beyond it, and the share that agrees of all that end
            past the first leg's walls, (k, r, places, headings) each.
        """
        x, y = rays.end[:, None, :, 0], rays.end[:, None, :, 1]  # (k, 1, m)
        inner = (np.abs(y - radii[..., None]) <= self._tolerance) & (x <= high[..., None])
        ahead = rays.met[:, None] & ~inner & (y > self._tolerance - radii[..., None])  # (k, r, m)
        wall = edges[..., None] * SIN + radii[..., None, None] * (2 - COS)  # (k, r, places, headings)
        agree, against = np.empty_like(wall), np.empty_like(wall, np.intp)
        for i, beams in enumerate(ahead):
            seen = np.flatnonzero(beams.any(axis=0))
            end = rays.end[i, seen]
            across = end[:, :1] * SIN - end[:, 1:] * COS  # (beams, headings)
            agree[i], against[i] = self._wall_votes(across, beams[:, seen], wall[i])
        return agree, against, agree / np.maximum(ahead.sum(axis=-1), 1)[..., None, None]

    def _wall_votes(self, across: Floats, asked: Flags, wall: Floats) -> tuple[Floats, Ints]:
        """How many beams end at walls, and how many beyond them.

        Most beams are far from most walls: they are counted together, and only the others one by one, in their order.

        Args:
            across: where beams end, across each heading, (beams, headings) [m].
            asked: beams that have a say at each radius, (r, beams).
            wall: across each heading, from the nearest place to the farthest, (r, places, headings) [m].

        Returns:
            Both (r, places, headings).
        """
        radii, places, headings = wall.shape
        reach = 1.001 * self._tolerance  # rounding must not make a near one far
        past, said = across > wall[:, -1:] + reach, asked[..., None]
        near = np.flatnonzero((across >= wall[:, :1] - reach) & said & ~past)  # of (r, beams, headings)
        cell = near // across.size * headings + near % headings  # of (r, headings)
        off = wall.swapaxes(0, 1).reshape(places, -1).take(cell, axis=1)
        np.subtract(across.ravel()[near % across.size], off, out=off)  # (places, near ones)
        off /= self._tolerance
        # What is beyond one place is beyond the nearer ones too.
        before = np.bincount((off > 1.0).sum(axis=0) + cell * (places + 1), minlength=radii * headings * (places + 1))
        beyond = before.reshape(radii, headings, -1)[..., :0:-1].cumsum(axis=2)[..., ::-1].swapaxes(1, 2)
        votes: Floats = np.stack([np.bincount(cell, one, radii * headings) for one in _kernel(off)])
        far = (said & past).sum(axis=1, dtype=np.int32)[:, None]
        return votes.reshape(places, radii, headings).swapaxes(0, 1), beyond + far


def _best(radii: Floats, edges: Floats, votes: Floats, agree: Floats, share: Floats, depth: float) -> CornerEstimate:
    """The corner with the most votes, averaged with those that lose to it by less than `TIE`.

    Args:
        radii: (k, radii) [m].
        edges: (k, radii, places) [m]; NaN where no edge can be.
        votes, agree, share: (k, radii, places, headings).
        depth: of the target past the inner edge [m].
    """
    none = np.isnan(edges)
    flat = np.where(none[..., None], -np.inf, votes).reshape(len(votes), -1)
    best = flat.argmax(axis=1)
    most = _pick(flat, best)
    known = np.isfinite(most)
    weight = np.maximum(flat - np.where(known, most - TIE, np.inf)[:, None], 0.0)
    weight /= np.maximum(weight.sum(axis=1, keepdims=True), 1e-9)
    grid = np.empty((3, *votes.shape))
    grid[0], grid[1], grid[2] = radii[:, :, None, None], np.where(none, 0.0, edges)[..., None], HEADINGS
    tried = grid.reshape(3, *flat.shape)
    radius, edge, heading = (weight * tried).sum(axis=-1)
    target = _target(radius, edge, heading, depth)
    row, column = np.nonzero(weight)
    away = np.zeros_like(weight)
    off = _target(tried[0, row, column], tried[1, row, column], tried[2, row, column], depth) - target[row]
    away[row, column] = np.sqrt((off * off).sum(axis=-1))
    unknown = np.where(known, 0.0, np.nan)
    return CornerEstimate(
        radius=radius + unknown,
        edge=edge + unknown,
        heading=heading + unknown,
        target=target + unknown[:, None],
        spread=np.where(known, away.max(axis=1), np.inf),
        votes=np.where(known, _pick(agree.reshape(flat.shape), best), 0.0),
        agreement=np.where(known, _pick(share.reshape(flat.shape), best), 0.0),
    )


def _target(radius: Floats, edge: Floats, heading: Floats, depth: float) -> Floats:
    """The point on the second leg's axis at `depth` past the inner edge, (..., 2)."""
    sin, cos = np.sin(heading), np.cos(heading)
    return np.stack([edge + depth * cos + radius * sin, radius + depth * sin - radius * cos], axis=-1)


def _kernel(distance: Floats) -> Floats:
    """A vote of 1 for a distance of 0, none from a distance of 1 on; takes its argument's memory, which is large."""
    np.multiply(distance, distance, out=distance)
    np.subtract(1.0, distance, out=distance)
    return np.maximum(distance, 0.0, out=distance)


def _packed(values: Floats, kept: Flags) -> Floats:
    """The kept ones of each row of values (k, m), in their order, then -inf, (k, most that a row keeps).

    Most beams say nothing about most questions, and a vote of 0 less changes no bit of a sum.
    """
    count = kept.sum(axis=1)
    first = np.argsort(~kept, axis=1, kind="stable")[:, : count.max(initial=0)]
    return np.where(np.arange(first.shape[1]) < count[:, None], _ordered(values, first), -np.inf)


def _ordered(values: NDArray[Any], order: Ints) -> NDArray[Any]:
    """numpy.take_along_axis along the last axis, without what costs it more time than a few hundred values do."""
    rows = values.reshape(-1, values.shape[-1])
    return rows[np.arange(len(rows))[:, None], order.reshape(len(rows), -1)].reshape(order.shape)


def _pick(values: Floats, index: Ints) -> Floats:
    """values[..., index] for an index (...) along the last axis, clipped to what exists, (...)."""
    rows = values.reshape(-1, values.shape[-1])
    clipped = np.minimum(np.maximum(index, 0), rows.shape[1] - 1).ravel()
    return np.asarray(rows[np.arange(len(rows)), clipped].reshape(index.shape))
