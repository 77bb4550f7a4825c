"""Errors by which every backend refuses what it cannot do, so that all of them say it in the same words."""

from __future__ import annotations

from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe


class TooManyWalls(PipenavError):
    """A pipe with more wall segments than the backend was opened for."""

    def __init__(self, pipe: Pipe, wall_segments: int) -> None:
        count = len(pipe.segments)
        super().__init__(
            f"pipe {pipe.name} has {count} wall segments, this backend was opened for {wall_segments}: "
            f"open it with wall_segments={count}."
        )


class UnevenTimestep(PipenavError):
    """A physics step that does not divide the control period."""

    def __init__(self, timestep: float, period: float) -> None:
        super().__init__(
            f"a timestep of {timestep:g} s does not divide the control period of {period:g} s: "
            "choose for example 0.0025 or 0.001."
        )


class CannotVary(PipenavError):
    """A simulator whose robots are all as their description says."""

    def __init__(self, simulator: object) -> None:
        super().__init__(
            f"{type(simulator).__name__} cannot change friction, mass, strength or gain of single robots: leave them "
            "out of the disturbance, or choose another backend."
        )


class CannotIncline(PipenavError):
    """A simulator in which nothing has weight in the plane of the pipe."""

    def __init__(self, simulator: object) -> None:
        super().__init__(f"{type(simulator).__name__} cannot simulate gravity along the pipe: choose --backend mujoco.")


class CannotPull(PipenavError):
    """A simulator that knows no forces beside weights and contacts."""

    def __init__(self, simulator: object) -> None:
        super().__init__(
            f"{type(simulator).__name__} cannot let a tether pull on robots: choose --backend mujoco or pybullet, or "
            "leave out the tether."
        )


class NoViewer(PipenavError):
    """A simulator without a window of its own."""

    def __init__(self, simulator: object) -> None:
        name = type(simulator).__name__
        super().__init__(f"{name} has no window of its own: choose --backend mujoco, or leave out --live.")


class PlaneOnly(PipenavError):
    """A simulator that offers no robots in space."""

    def __init__(self, name: str) -> None:
        super().__init__(
            f"backend {name!r} moves robots only in a plane: choose --backend mujoco, or routes without rolls, such "
            "as runs-level."
        )
