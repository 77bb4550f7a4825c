"""The seam that every backend plugin implements: `Backend`, and `Simulator` for those that know the truth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

from pipenav.arrays import Floats, Ints, Table
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.backends.refusals import CannotIncline, CannotPull, CannotVary, NoViewer, PlaneOnly, UnevenTimestep
from pipenav.backends.spatial import SpaceBackend
from pipenav.backends.viewer import Viewer
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec

CONTROL_PERIOD = 0.1
"""Duration of a control step [s] (thesis 4.4.2: t_s = 0.1 s)."""


def physics_steps(timestep: float) -> int:
    """Number of physics steps of `timestep` [s] in a control period.

    Raises:
        UnevenTimestep: a whole number of them does not fill the control period.
    """
    steps = round(CONTROL_PERIOD / timestep)
    if abs(steps * timestep - CONTROL_PERIOD) > 1e-9:
        raise UnevenTimestep(timestep, CONTROL_PERIOD)
    return steps


class BackendOptions(Table):
    """Base class of a backend's own settings: frozen, strict, unknown keys refused."""


class Backend(ABC):
    """n robots of one kind, each in a pipe of its own, stepped together.

    A class that a plugin registers is constructed as `Class(robot, n, options, wall_segments=4)`:

        robot: the robot, a `RobotSpec`.
        n: number of robots.
        options: an instance of the class's `Options`.
        wall_segments: largest number of wall segments of any pipe that `reset` will receive.
    """

    Options: type[BackendOptions]

    @abstractmethod
    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        """Put some robots at rest into pipes, leave the others untouched, and return what the k robots' sensors read.

        Args:
            indices: robots that are reset, sorted and unique, (k,).
            pipes: pipe of each of these robots, k of them.
            q: configurations in the robots' frames: joint positions, preceded in a free robot by the pose of its first
                link, (k, coordinates) [rad or m].
            base: origin of each robot's frame on the first leg's axis, x in the pipe's frame, (k,) [m].

        Raises:
            PipenavError: a pipe has more wall segments than the backend was opened for.
        """

    @abstractmethod
    def step(self, command: Command) -> None:
        """Advance every robot by one control period."""

    @abstractmethod
    def read(self) -> Reading:
        """Return the present sensor readings, in arrays that belong to the caller."""

    @abstractmethod
    def close(self) -> None:
        """Release everything; closing twice is harmless."""


class Variation(NamedTuple):
    """Factors by which k robots differ from their description, 1 where they do not.

    Attributes:
        friction: factor on the friction coefficient, (k,).
        mass: factor on the mass and the inertia of each link, (k, links).
        strength: factor on both the effort limit and the speed limit of each actuator, as if the supply voltage had
            changed, (k, actuators).
        gain: factor on the duty that each on-board controller asks for at a given error, (k, actuators).
    """

    friction: Floats
    mass: Floats
    strength: Floats
    gain: Floats

    def part(self, rows: Ints) -> Variation:
        """Variation of some of the robots, by their rows."""
        return Variation(*(column[rows] for column in self))


class Simulator(Backend):
    """A backend that computes the world, and so also knows what no sensor measures.

    Some abilities are optional: `vary`, `incline`, `pull`, `open_viewer` and `in_space`. A property tells whether a
    simulator has each of them; the method of an ability that it lacks raises an error.
    """

    moves_in_space: ClassVar[bool] = False
    """Whether the class offers robots in space, by `in_space`."""

    robots_are_independent: ClassVar[bool] = False
    """Whether a robot's readings are the same to the last bit whichever other robots are stepped together with it."""

    steps_in_threads: ClassVar[bool] = False
    """Whether a simulator's `step` may run in another thread than the rest, and leaves Python to the others meanwhile.

    Then half of a training's robots move while the other half is attended to.
    """

    @abstractmethod
    def truth(self) -> Truth:
        """State of the world now, and contacts of the last control period."""

    @property
    def can_vary(self) -> bool:
        """Whether single robots can be made to differ from their description, by `vary`."""
        return False

    @property
    def can_incline(self) -> bool:
        """Whether gravity can act along the pipes, by `incline`."""
        return False

    @property
    def can_pull(self) -> bool:
        """Whether a force can act on the rear end of each robot, by `pull`."""
        return False

    @property
    def has_viewer(self) -> bool:
        """Whether a window can show the first robot, by `open_viewer`."""
        return False

    def vary(self, indices: Ints, variation: Variation) -> None:  # noqa: ARG002  # the signature of the seam
        """Make some robots differ from their description until they are varied again; the others are untouched.

        It is called right before a reset of the same robots.

        Args:
            indices: robots that are varied, sorted and unique, (k,).
            variation: differences of these robots.

        Raises:
            CannotVary: the simulator cannot do it.
        """
        raise CannotVary(self)

    def incline(self, indices: Ints, gravity: Floats) -> None:  # noqa: ARG002  # the signature of the seam
        """Let gravity act in the plane of some robots' pipes until they are inclined again; at first it does not.

        It is called right before a reset of the same robots, after `vary` where that is called too.

        Args:
            indices: robots whose pipes are inclined, sorted and unique, (k,).
            gravity: part of gravity in the pipe's plane, axes of the pipe's frame, (k, 2) [m/s^2].

        Raises:
            CannotIncline: the simulator cannot do it.
        """
        raise CannotIncline(self)

    def pull(self, forces: Floats) -> None:  # noqa: ARG002  # the signature of the seam
        """Let forces act on the rear ends of the robots' first links until other ones are given; at first none do.

        Args:
            forces: force on each robot, axes of the pipe's frame, (n, 2) [N].

        Raises:
            CannotPull: the simulator cannot do it.
        """
        raise CannotPull(self)

    def open_viewer(self) -> Viewer:
        """Open a window on the first robot.

        Raises:
            NoViewer: the simulator has none.
            PipenavError: there is no display.
        """
        raise NoViewer(self)

    @classmethod
    def in_space(
        cls,
        robot: RobotSpec,  # noqa: ARG003  # the signature of the seam
        n: int,  # noqa: ARG003
        options: BackendOptions,  # noqa: ARG003
    ) -> SpaceBackend:
        """Construct robots in space, for routes that leave the plane.

        Args:
            robot: the robot, with a roll joint.
            n: number of robots.
            options: an instance of the class's `Options`.

        Raises:
            PlaneOnly: the simulator offers none.
        """
        raise PlaneOnly(cls.__name__)
