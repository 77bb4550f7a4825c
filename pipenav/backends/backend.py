"""The seam that every backend plugin implements."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from pipenav.arrays import Floats, Ints, Table
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec

CONTROL_PERIOD = 0.1
"""One control step [s] (thesis 4.4.2: t_s = 0.1 s)."""


class BackendOptions(Table):
    """Base of a backend's own settings: frozen, strict, unknown keys refused."""


class Backend(ABC):
    """n robots of one kind, each in a pipe of its own, stepped together.

    Args of a constructor:
        robot: the robot.
        n: how many of them.
        options: an instance of the class's `Options`.
        wall_segments: the most wall segments that any pipe given to `reset` will have.
    """

    Options: type[BackendOptions]

    @abstractmethod
    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None: ...

    @abstractmethod
    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        """Put some robots at rest into pipes; the others are untouched. What the k robots' sensors give there.

        Args:
            indices: which robots, sorted and unique, (k,).
            pipes: the pipe of each, k of them.
            q: configurations in the robots' frames: joint positions, of a free robot its first link's pose before them,
                (k, coordinates) [rad or m].
            base: where each robot's frame starts on the first leg's axis, x in the pipe's frame, (k,) [m].
        """

    @abstractmethod
    def step(self, command: Command) -> None:
        """Advance every robot by one control period."""

    @abstractmethod
    def read(self) -> Reading:
        """What the sensors give now, in arrays of the caller's own."""

    @abstractmethod
    def truth(self) -> Truth | None:
        """What a simulator knows of the last control period; None on hardware."""

    @abstractmethod
    def close(self) -> None:
        """Release everything; closing twice is harmless."""


class Variation(NamedTuple):
    """How far k robots differ from their description: factors, 1 where they do not.

    Attributes:
        friction: on the friction coefficient, (k,).
        mass: on the mass and the inertia of each link, (k, links).
        strength: on what each actuator makes of a drive, as a higher supply voltage gives a motor: the effort limit and
            the speed limit change alike, (k, drives).
        gain: on the drive that each on-board controller asks for at an error, (k, drives).
    """

    friction: Floats
    mass: Floats
    strength: Floats
    gain: Floats

    def part(self, rows: Ints) -> Variation:
        """That of some of the robots, by their rows."""
        return Variation(*(column[rows] for column in self))


@runtime_checkable
class Variable(Protocol):
    """What a simulator may offer besides, for randomised training and `pipenav eval --disturb`."""

    def vary(self, indices: Ints, variation: Variation) -> None:
        """Make some robots differ from their description until they are varied again; the others are untouched.

        To be called right before a reset of the same robots.

        Args:
            indices: which robots, sorted and unique, (k,).
            variation: of these.
        """
        ...


@runtime_checkable
class Inclinable(Protocol):
    """What a simulator may offer besides, for pipes that are not level."""

    def incline(self, indices: Ints, gravity: Floats) -> None:
        """Let gravity act along the plane of some robots' pipes until they are inclined again; it does not at first.

        To be called right before a reset of the same robots, after `Variable.vary` where that is called too.

        Args:
            indices: which robots, sorted and unique, (k,).
            gravity: its part in the pipe's plane, axes of the pipe's frame, (k, 2) [m/s^2].
        """
        ...


class Viewer(Protocol):
    """A window on a backend's first robot."""

    def show(self) -> bool:
        """Show how things are now; False once the person has closed the window."""
        ...

    def close(self) -> None:
        """Close the window; closing twice is harmless."""
        ...


@runtime_checkable
class Viewable(Protocol):
    """What a backend may offer besides, for `pipenav view --live`."""

    def open_viewer(self) -> Viewer:
        """Open a window.

        Raises:
            PipenavError: there is no display.
        """
        ...
