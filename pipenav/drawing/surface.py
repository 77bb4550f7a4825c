"""Surfaces of pipes with tees, crosses and caps in small pieces: the outside, or the bore, with its seams."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.pipes.pipe_system import Fitting, PipeSystem, Strand, StrandEnd

AROUND, PIECE = 36, 0.05
"""Strips around a pipe, and the longest piece of a strip [m]: with small pieces, near ones hide far ones rightly."""

SAMPLES = 240
"""Points along a line on a pipe at which it is asked whether the line runs in another pipe of its fitting."""

TOUCHING = 1e-6
"""Depth up to which a point lies on another pipe's surface rather than in that pipe [m]: rounding."""


class Surface(NamedTuple):
    """Pieces of a surface, and lines on it.

    Attributes:
        quads: corners of the pieces, (q, 4, 3) [m].
        normals: unit normals of the pieces, out of the pipe, (q, 3).
        outwards: unit vectors from the pipe's axis to the pieces, square to the axis, (q, 3).
        seams: ends of the lines where legs, bends, reducers and branches join, (s, 2, 3) [m].
        seams_outwards: unit vectors from the pipe's axis to the lines, (s, 3).
    """

    quads: Floats
    normals: Floats
    outwards: Floats
    seams: Floats
    seams_outwards: Floats

    def facing(self, direction: Floats) -> tuple[Flags, Flags]:
        """Flags of the pieces, (q,), and of the seams, (s,), on the side of their axis that a direction (3,) names."""
        return self.outwards @ direction > 0, self.seams_outwards @ direction > 0


def surface(system: PipeSystem, outside: float, piece: float = PIECE) -> Surface:
    """The surface of pipes, without what lies in another pipe.

    Args:
        system: the pipes.
        outside: distance from the bore [m]; 0 is the bore itself.
        piece: longest piece of a strip [m].
    """
    parts = [_strand_surface(system, strand, outside, piece) for strand in system.strands]
    return Surface(*map(np.concatenate, zip(*parts, strict=True)))


class _Opening(NamedTuple):
    """Distances along each line of a pipe from its fitting's centre to another pipe's wall, and out of it, (lines,)."""

    near: Floats
    far: Floats


def _strand_surface(system: PipeSystem, strand: Strand, outside: float, piece: float) -> Surface:
    legs = strand.legs
    around = np.arange(AROUND) * 2 * math.pi / AROUND
    radius = legs.radius + outside
    chords = legs.chords(float(radius.max()))
    rings = list(legs.lines(radius[None], around, chords).swapaxes(0, 1))  # (AROUND, 3) each
    first = np.cumsum([1, *(count + 1 for count in chords)])  # the first ring of every corner
    joints = {at for i, count in enumerate(chords) for at in (int(first[i]), int(first[i]) + count)}
    axes = [np.mean(after - before, axis=0) for before, after in pairwise(rings)]
    axes = [axis / max(float(np.linalg.norm(axis)), 1e-12) for axis in axes]
    rows, caps = [], []
    for end, at, sign in ((strand.start, 0, 1.0), (strand.end, -1, -1.0)):
        inwards = -end.direction
        if end.fitting is not None:
            opening = _opening(system.fittings[end.fitting], end, rings[at], outside)
            beside = rings[at] + opening.near[:, None] * inwards
            rows.append((rings[at], beside, axes[at]) if sign > 0 else (beside, rings[at], axes[at]))
            rings[at] = rings[at] + opening.far[:, None] * inwards
            joints.add(at % len(rings))
        elif end.closed:
            rings[at] = rings[at] - outside * inwards
            caps.append(_cap(rings[at], end.direction))
    rows += [(*pair, axis) for pair, axis in zip(pairwise(rings), axes, strict=True)]
    parts = [*(_strip(*row, piece) for row in rows), *caps]
    seams = [_seam(rings, axes, at) for at in sorted(joints)]
    none = [np.zeros((0, 2, 3)), np.zeros((0, 3))]
    lines = [np.concatenate([none[i], *(seam[i] for seam in seams)]) for i in (0, 1)]
    return Surface(*(np.concatenate(column) for column in zip(*parts, strict=True)), *lines)


def _opening(fitting: Fitting, end: StrandEnd, ring: Floats, outside: float) -> _Opening:
    """The part of each line on a fitting's pipe that runs in the fitting's other pipes.

    Args:
        fitting: the fitting.
        end: the strand's end there.
        ring: points where the lines begin, (lines, 3) [m].
        outside: distance of the surface from the bore [m].
    """
    share = np.linspace(0.0, 1.0, SAMPLES)
    along = 1.05 * fitting.reach(end.pipe, outside) * share
    points = ring[:, None] - along[:, None] * end.direction  # (lines, SAMPLES, 3)
    depth = np.full(points.shape[:2], -np.inf)
    for pipe, (axes, radius) in enumerate(zip(fitting.axes, fitting.radius, strict=True)):
        if pipe != end.pipe:
            local = (points - fitting.centre) @ axes
            inside = radius + outside - np.hypot(local[..., 1], local[..., 2])
            depth = np.maximum(depth, np.where(local[..., 0] > -TOUCHING, inside, -np.inf))
    within = depth > TOUCHING
    nearest = along[depth.argmax(axis=1)]  # where a line passes the other pipes by, both parts meet there
    near = np.where(within.any(axis=1), along[within.argmax(axis=1)], nearest)
    far = np.where(within.any(axis=1), along[SAMPLES - 1 - within[:, ::-1].argmax(axis=1)], nearest)
    return _Opening(near, far)


def _strip(before: Floats, after: Floats, axis: Floats, piece: float) -> tuple[Floats, Floats, Floats]:
    """Pieces between two rings (lines, 3) around an axis, their normals, and their directions from the axis."""
    length = float(np.linalg.norm(after - before, axis=1).max())
    share = np.linspace(0, 1, max(math.ceil(length / piece), 1) + 1)[:, None, None]
    rings = before + share * (after - before)  # (pieces + 1, lines, 3)
    beside = np.roll(rings, -1, axis=1)
    quads = np.stack([rings[:-1], beside[:-1], beside[1:], rings[1:]], axis=2).reshape(-1, 4, 3)
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    size = np.linalg.norm(normals, axis=1)
    quads, normals = quads[size > 1e-12], normals[size > 1e-12] / size[size > 1e-12, None]
    return quads, normals, _square_to(normals, axis)


def _square_to(vectors: Floats, axis: Floats) -> Floats:
    """Unit vectors along the parts of vectors (k, 3) that are square to an axis (3,)."""
    across = vectors - (vectors @ axis)[:, None] * axis
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12))


def _cap(ring: Floats, direction: Floats) -> tuple[Floats, Floats, Floats]:
    """A cap over a ring (lines, 3) as pieces, as `_strip`; each is a triangle with two corners in the middle."""
    middle = np.broadcast_to(ring.mean(axis=0), ring.shape)
    quads = np.stack([ring, np.roll(ring, -1, axis=0), middle, middle], axis=1)
    return quads, np.broadcast_to(direction, ring.shape), _square_to(quads[:, :2].mean(axis=1) - middle, direction)


def _seam(rings: Sequence[Floats], axes: Sequence[Floats], at: int) -> tuple[Floats, Floats]:
    """A ring as lines (lines, 2, 3), and their directions from the axis (lines, 3)."""
    lines = np.stack([rings[at], np.roll(rings[at], -1, axis=0)], axis=1)
    axis = axes[min(at, len(axes) - 1)]
    middle = lines.mean(axis=1)
    return lines, _square_to(middle - middle.mean(axis=0), axis)
