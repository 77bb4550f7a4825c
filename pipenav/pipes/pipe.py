"""The interface of every kind of pipe that a robot travels through."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Literal, NamedTuple, Self

import numpy as np
from pydantic import ConfigDict

from pipenav.arrays import Flags, Floats, Table
from pipenav.errors import PipenavError
from pipenav.pipes.centre_lines import CentreLines

if TYPE_CHECKING:
    from pipenav.pipes.corner import PipeCorner

Turn = Literal["left", "right"]
"""Side that a corner turns to, seen by the robot that comes to it."""

DEFAULT_WALL = 0.003
"""Wall thickness [m]: a common PVC gas pipe of 90-110 mm has about 3 mm."""


class LegFrames(NamedTuple):
    """The straight legs of one pipe, without twist from one to the next.

    Attributes:
        start: points where the legs begin on the centre line, (legs, 3) [m]; the second leg begins at the origin.
        axes: unit vectors along the leg, to its left and upwards as columns, (legs, 3, 3).
        length: lengths along the centre line, from open end or corner to corner or open end, (legs,) [m].
        radius: radius of the bore in each leg, (legs,) [m].
    """

    start: Floats
    axes: Floats
    length: Floats
    radius: Floats


class WallSide(NamedTuple):
    """A wall of a pipe in the plane, as polylines from the first open end to the last, (k, 2) [m] each.

    Attributes:
        face: the surface that the robot can touch.
        back: the surface behind it, a wall thickness away.
    """

    face: Floats
    back: Floats


class Pipe(Table, ABC):
    """A pipe: straight legs one after the other, a corner between any two, and walls around them.

    A corner is the crossing of two legs' axes, whatever fitting joins the legs there: a mitre and a bend are drawn
    today. The centre line is the polyline from open end to open end through the corners, so in a bend it keeps to the
    legs' axes. Frame: the first corner is the origin, the first leg lies along -x, the robot comes from -x moving
    towards +x, a left turn of the first corner goes towards +y, z points up.

    Tasks, simulators and scenes ask only what is declared here. File formats, meshes and drawings with dimensions are
    written for one kind of pipe each, and an arm on a mount needs a single corner (`require_corner`).

    Attributes:
        diameter: inner diameter at the first open end, where the robot comes in [m].
        wall: wall thickness [m].
    """

    model_config = ConfigDict(allow_inf_nan=True)  # ranges are checked by `check_range`, with a sentence of their own

    diameter: float
    wall: float = DEFAULT_WALL

    @property
    def radius(self) -> float:
        """Radius of the bore at the first open end [m]; `leg_frames` has that of every leg."""
        return self.diameter / 2

    @property
    def narrowest(self) -> float:
        """Smallest inner diameter of all legs [m]."""
        return 2 * float(self.leg_frames.radius.min())

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name, usable as a file name."""

    @property
    @abstractmethod
    def label(self) -> str:
        """Description in words, for tables and messages."""

    @property
    @abstractmethod
    def planar(self) -> bool:
        """Whether the whole pipe lies in the x-y plane."""

    @property
    @abstractmethod
    def leg_frames(self) -> LegFrames:
        """The straight legs; the arrays are read-only."""

    @property
    def in_space(self) -> bool:
        """Whether robots move in space there: the pipe leaves the x-y plane, or its first leg is not level."""
        return not self.planar

    @property
    def down(self) -> Floats:
        """Direction of gravity in the pipe's frame where the pipe lies in space, a unit vector (3,)."""
        return np.array([0.0, 0.0, -1.0])

    @property
    @abstractmethod
    def interior_angles(self) -> Floats:
        """Interior angle between the legs at each corner, (corners,) [rad]; pi where the next leg goes straight on."""

    @property
    @abstractmethod
    def turn_signs(self) -> Floats:
        """Turn of each corner, +1 to the left, -1 to the right, (corners,); without meaning outside of the plane."""

    @property
    @abstractmethod
    def inner_edges(self) -> Floats:
        """Distance along either leg from each corner to where the inner wall's bend ends, (corners,) [m]."""

    @property
    @abstractmethod
    def segments(self) -> Floats:
        """Wall segments `[[x1, y1], [x2, y2]]`, free space on the left of each, (s, 2, 2) [m]; read-only.

        Raises:
            PipenavError: the pipe leaves the plane.
        """

    @property
    @abstractmethod
    def edges(self) -> Flags:
        """Flags of segment ends that lie at an inner edge, (s, 2); an open end counts as its segment's other end."""

    @property
    @abstractmethod
    def wall_sides(self) -> list[WallSide]:
        """The two walls in the plane.

        Raises:
            PipenavError: the pipe leaves the plane.
        """

    @property
    @abstractmethod
    def corner(self) -> PipeCorner | None:
        """The pipe as a single corner; None where it is anything else."""

    def require_corner(self) -> PipeCorner:
        """The pipe as a single corner.

        Raises:
            PipenavError: the pipe is anything else.
        """
        if self.corner is None:
            count = len(self.interior_angles)
            raise PipenavError(f"{self.name} is a route of {count} corners, where a single corner is needed.")
        return self.corner

    @abstractmethod
    def contains(self, points: Floats) -> Flags:
        """Flags of points (..., 2) of the plane, or (..., 3) of a route, that lie in the free space: (...)."""

    def distance_along(self, points: Floats) -> Floats:
        """Distance along the centre line of points (..., 2) of the plane or (..., 3), 0 at the first corner: (...) [m].

        `CentreLines.distance` says which leg a point counts to, and asks the same of many pipes at once.
        """
        points = np.asarray(points, float)
        lines = CentreLines.of([self], points.shape[-1])
        return np.asarray(lines.distance(points.reshape(1, -1, points.shape[-1])).reshape(points.shape[:-1]))

    @abstractmethod
    def with_ends(self, first: float, last: float) -> Self:
        """The pipe with its first and its last leg at least so long [m].

        Raises:
            CrossesItself: longer ends would meet other legs.
        """
