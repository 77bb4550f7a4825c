"""How far a robot has come along its pipe: for rewards, verdicts and pictures, never for a policy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav import kinematics
from pipenav.pipe import Pipe
from pipenav.robot import RobotSpec

Array = NDArray[np.float64]


class Ways(NamedTuple):
    """The ways through n pipes.

    Attributes:
        second: unit vector along the second leg, (n, 2).
        end: where along the way the inner wall's bend ends, (n,) [m].
    """

    second: Array
    end: Array

    @classmethod
    def of(cls, pipes: Sequence[Pipe]) -> Ways:
        """Those of some pipes."""
        second = np.array([pipe.second_leg for pipe in pipes]).reshape(-1, 2)
        return cls(second, np.array([pipe.inner_edge for pipe in pipes]))

    def put(self, rows: NDArray[np.intp], ways: Ways) -> None:
        """Overwrite some rows."""
        self.second[rows], self.end[rows] = ways.second, ways.end

    def along(self, points: Array) -> Array:
        """Distance along the mitred centre line, 0 at the corner, of points (n, m, 2) of the pipes' frames: (n, m) [m].

        As `Pipe.centre_line_distance`: a point counts to the leg on its side of the corner's bisector.
        """
        first, second = points[..., 0], np.einsum("nmi,ni->nm", points, self.second)
        return np.where(first + second > 0, np.maximum(second, 0.0), np.minimum(first, 0.0))


def waypoints(robot: RobotSpec, configuration: Array) -> Array:
    """Rear end, joints and tip of n robots in their own frame, (n, links + 1, 2) [m], of (n, coordinates)."""
    pose = kinematics.forward(robot, configuration)
    return np.concatenate([pose.joints, pose.tip[:, None]], axis=1)
