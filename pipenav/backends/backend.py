"""The seam that every backend plugin implements: `Backend`, and `Simulator` for those that know the truth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Protocol

from pipenav.arrays import Floats, Ints, Table
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec

if TYPE_CHECKING:
    from pipenav.backends.spatial import SpaceBackend

CONTROL_PERIOD = 0.1
"""One control step [s] (thesis 4.4.2: t_s = 0.1 s)."""


class BackendOptions(Table):
    """Base class of a backend's own settings: frozen, strict, unknown keys refused."""


class Backend(ABC):
    """n robots of one kind, each in a pipe of its own, stepped together.

    A class that a plugin registers is constructed as `Class(robot, n, options, wall_segments=4)`:

        robot: the robot, a `RobotSpec`.
        n: number of robots.
        options: an instance of the class's `Options`.
        wall_segments: largest number of wall segments of any pipe that `reset` will be given.
    """

    Options: type[BackendOptions]

    @abstractmethod
    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        """Put some robots at rest into pipes, leave the others untouched, and return what the k robots' sensors read.

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
        """Present sensor readings, in arrays that belong to the caller."""

    @abstractmethod
    def close(self) -> None:
        """Release everything; closing twice is harmless."""


class Variation(NamedTuple):
    """How far k robots differ from their description: factors, 1 where they do not.

    Attributes:
        friction: factor on the friction coefficient, (k,).
        mass: factor on the mass and the inertia of each link, (k, links).
        strength: factor on each actuator's effort limit and speed limit alike, as a higher supply voltage gives a
            motor, (k, actuators).
        gain: factor on the duty that each on-board controller asks for at an error, (k, actuators).
    """

    friction: Floats
    mass: Floats
    strength: Floats
    gain: Floats

    def part(self, rows: Ints) -> Variation:
        """The variation of some of the robots, by their rows."""
        return Variation(*(column[rows] for column in self))


class Viewer(Protocol):
    """A window on a backend's first robot."""

    def show(self) -> bool:
        """Show the present state; False once the person has closed the window."""
        ...

    def close(self) -> None:
        """Close the window; closing twice is harmless."""
        ...


class Simulator(Backend):
    """A backend that computes the world, and so also knows what no sensor tells.

    What a simulator can do besides is asked by its `can_...` properties; a method whose property is false refuses.
    """

    moves_in_space: ClassVar[bool] = False
    """Whether the class offers robots in space, by `in_space`."""

    @abstractmethod
    def truth(self) -> Truth:
        """State of the world and contacts of the last control period."""

    @property
    def can_vary(self) -> bool:
        """Whether single robots can be made to differ from their description, by `vary`."""
        return False

    @property
    def can_incline(self) -> bool:
        """Whether gravity can act along the pipes, by `incline`."""
        return False

    @property
    def has_viewer(self) -> bool:
        """Whether a window can show the first robot, by `open_viewer`."""
        return False

    def vary(self, indices: Ints, variation: Variation) -> None:  # noqa: ARG002  # the signature of the seam
        """Make some robots differ from their description until they are varied again; the others are untouched.

        It is called right before a reset of the same robots.

        Args:
            indices: which robots, sorted and unique, (k,).
            variation: how these robots differ.

        Raises:
            PipenavError: the simulator cannot do it.
        """
        raise PipenavError(
            f"{type(self).__name__} cannot change friction, mass, strength or gain of single robots: leave them out of "
            "the disturbance, or choose another backend."
        )

    def incline(self, indices: Ints, gravity: Floats) -> None:  # noqa: ARG002  # the signature of the seam
        """Let gravity act along the plane of some robots' pipes until they are inclined again; it does not at first.

        It is called right before a reset of the same robots, after `vary` where that is called too.

        Args:
            indices: which robots, sorted and unique, (k,).
            gravity: the part of gravity in the pipe's plane, axes of the pipe's frame, (k, 2) [m/s^2].

        Raises:
            PipenavError: the simulator cannot do it.
        """
        raise PipenavError(f"{type(self).__name__} knows no gravity along the pipe: choose --backend mujoco.")

    def open_viewer(self) -> Viewer:
        """Open a window on the first robot.

        Raises:
            PipenavError: the simulator has none, or there is no display.
        """
        raise PipenavError(f"{type(self).__name__} has no viewer: choose --backend mujoco.")

    @classmethod
    def in_space(
        cls,
        robot: RobotSpec,  # noqa: ARG003  # the signature of the seam
        n: int,  # noqa: ARG003
        options: BackendOptions,  # noqa: ARG003
        gravity: float,  # noqa: ARG003
    ) -> SpaceBackend:
        """Robots in space, for routes that leave the plane.

        Args:
            robot: the robot, with a roll joint.
            n: number of robots.
            options: an instance of the class's `Options`; it may overrule gravity.
            gravity: gravity downwards, along -z [m/s^2].

        Raises:
            PipenavError: the simulator offers none.
        """
        raise PipenavError(f"{cls.__name__} moves robots in a plane alone: choose --backend mujoco.")
