"""Walls of one corner as two rounded wedges, in the canonical frame, in which every turn is a left turn.

Every bend of this package is a fillet, so each wall is the boundary of a cone of directions C, the same for both, moved
to an apex and rounded by a radius: the robot must stay inside of `outer` and outside of `inner`. C lies between the
second leg's direction and -x. For a mitre both radii are 0, for a swept bend both apexes are the bend's centre.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_lines import ARC_TOLERANCE, fillet_radius

BORES = ("plane", "round")
"""Kinds of bores: between boards, or a round tube, in which high parts have less width."""


class Wedge(NamedTuple):
    """A cone at an apex, rounded: all points within `radius` of it.

    Attributes:
        x: x of the apex [m], one number or (...).
        y: y of the apex [m].
        radius: radius by which the cone is widened and rounded [m].
    """

    x: Floats
    y: Floats
    radius: Floats


class CornerWalls(NamedTuple):
    """Walls of a corner for parts of several heights.

    Attributes:
        turn: change of heading, pi - interior angle [rad].
        inner: the inner wall, which the parts must not enter.
        outer: the outer wall, within which they must stay.
    """

    turn: float
    inner: Wedge
    outer: Wedge

    def opened(self, by: ArrayLike) -> CornerWalls:
        """The walls moved back by a distance, which widens the pipe by twice as much: (...) [m]."""
        # The inner wall shrinks first by its rounding, then along the axis of its cone, which lies in the middle
        # between the second leg's direction and -x. cos(turn / 2) is the sine of half the interior angle.
        back, inner, outer = np.asarray(by, float), self.inner, self.outer
        deeper = np.maximum(back - inner.radius, 0.0) / math.cos(self.turn / 2)
        axis = (self.turn + math.pi) / 2
        x, y = inner.x + deeper * math.cos(axis), inner.y + deeper * math.sin(axis)
        moved = Wedge(x, y, np.maximum(inner.radius - back, 0.0))
        return CornerWalls(self.turn, moved, outer._replace(radius=outer.radius + back))


def width_seen(diameter: float, height: ArrayLike, bore: str) -> Floats:
    """Width of the pipe that parts of some heights see: all of it between boards, sqrt(d^2 - h^2) in a round bore.

    Parts that are higher than the bore see no width: 0.
    """
    height = np.asarray(height, float)
    if bore == "plane":
        return np.full(height.shape, diameter)
    return np.sqrt(np.maximum(diameter**2 - height**2, 0.0))


def corner_walls(pipe: PipeCorner, height: ArrayLike, bore: str, proof: bool) -> CornerWalls:
    """Walls that parts of some heights see in a corner.

    A bore's slice at any height is a corner of the same bend radius with a smaller width. Drawn and simulated walls
    have chords in place of arcs, within `ARC_TOLERANCE`: for a proof the pipe is wider by that, for a motion narrower.

    Args:
        pipe: the corner, without its branches.
        height: heights of the parts, (...) [m].
        bore: `plane` or `round`.
        proof: whether the walls may be too far away, or too near.
    """
    half = width_seen(pipe.diameter, height, bore) / 2
    turn = math.pi - pipe.angle
    tan = math.tan(pipe.angle / 2)
    fillet_in = np.array([fillet_radius(float(r), pipe.bend_radius) for r in half.ravel()]).reshape(half.shape)
    fillet_out = np.array([fillet_radius(-float(r), pipe.bend_radius) for r in half.ravel()]).reshape(half.shape)
    inner = Wedge(-(half + fillet_in) / tan, half + fillet_in, fillet_in)
    outer = Wedge(-(fillet_out - half) / tan, fillet_out - half, fillet_out)
    if not pipe.bend_radius:
        return CornerWalls(turn, inner, outer)
    if proof:
        return CornerWalls(turn, inner._replace(radius=np.maximum(fillet_in - ARC_TOLERANCE, 0.0)), outer)
    return CornerWalls(turn, inner, outer._replace(radius=fillet_out - ARC_TOLERANCE))
