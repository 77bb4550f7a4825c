"""A pipe as a robot meets it: a single corner, or a run of several in the plane. What both are asked alike."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute

Pipe = PipeCorner | PipeRoute


def turn_signs(pipe: Pipe) -> Floats:
    """+1 for each corner that turns left, -1 for each that turns right, (corners,); a run lies in the plane."""
    return (
        np.array([pipe.turn_sign])
        if isinstance(pipe, PipeCorner)
        else np.where(np.cos(pipe.legs.inside) > 0, 1.0, -1.0)
    )


def interior_angles(pipe: Pipe) -> Floats:
    """Of each corner, (corners,) [rad]."""
    return np.array([pipe.angle] if isinstance(pipe, PipeCorner) else [corner.angle for corner in pipe.corners])


def inner_edges(pipe: Pipe) -> Floats:
    """How far before and after each corner, along either leg, the inner wall's bend ends, (corners,) [m]."""
    return np.array([pipe.inner_edge]) if isinstance(pipe, PipeCorner) else pipe.radius * pipe.legs.reach


def leaves_plane(pipe: Pipe) -> bool:
    """Whether it is a run with corners in several planes."""
    return isinstance(pipe, PipeRoute) and not pipe.planar


def corner_count(pipe: Pipe) -> int:
    return 1 if isinstance(pipe, PipeCorner) else len(pipe.corners)


def single_corner(pipe: Pipe) -> PipeCorner:
    """The pipe, where it is a single corner.

    Raises:
        PipenavError: it is a run.
    """
    if isinstance(pipe, PipeCorner):
        return pipe
    raise PipenavError(f"{pipe.name} is a run of {corner_count(pipe)} corners, where a single corner is needed.")
