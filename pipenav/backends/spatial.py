"""The seam for robots in space, where pipes leave the plane: what `Simulator.in_space` returns.

A robot is the same chain as in the plane, and bends in a plane of its own, but it is free in space. Its roll joint
divides it into two halves; the plane of the front half is turned from that of the rear half by the joint's position.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.backends.refusals import NoViewer
from pipenav.backends.viewer import Viewer
from pipenav.pipes.route import PipeRoute

HALVES = 2
"""Number of halves of a robot with a roll joint: the rear half, then the front half."""


class SpaceReading(NamedTuple):
    """Readings of the robots' own sensors in space.

    Attributes:
        body: readings that there are in the plane too.
        roll: position of the roll joint, (n,) [rad].
        down: direction downwards in the frame of each half of the divided link (x forwards along the link, y to its
            left, z across its plane): the reversed reading of an accelerometer there at rest, unit vectors
            (n, halves, 3); 0 where nothing has weight.
        turned: rotation of each half of the divided link about its x, y and z in the last control period, as its
            gyroscope sums it up, (n, halves, 3) [rad].
    """

    body: Reading
    roll: Floats
    down: Floats
    turned: Floats


class SpaceTruth(NamedTuple):
    """State that only a simulator knows, as `Truth` in the plane; rewards and outcomes may use it, policies never.

    Attributes:
        points: rear end, joints and tip in the route's frame, (n, links + 1, 3) [m].
        normals: unit normals of the halves' planes, (n, halves, 3).
        contact_force: largest net force of the pipe on any one link, (n,) [N].
        penetration: deepest overlap of robot and pipe, (n,) [m].
        contact_share: share of the physics steps with contact, (n,).
        link_forces: net force of the pipe on each link at the moment when it was largest, (n, links, 3) [N].
    """

    points: Floats
    normals: Floats
    contact_force: Floats
    penetration: Floats
    contact_share: Floats
    link_forces: Floats


class SpaceBackend(ABC):
    """n robots of one kind in space, each in a route of its own, stepped together."""

    @abstractmethod
    def incline(self, indices: Ints, gravity: Floats) -> None:
        """Let gravity act on some robots until they are inclined again; at first nothing weighs.

        It is called right before a reset of the same robots.

        Args:
            indices: robots whose routes are inclined, sorted and unique, (k,).
            gravity: gravity in the route's frame, (k, 3) [m/s^2].
        """

    @abstractmethod
    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        """Put some robots at rest into routes, leave the others untouched, and return the k robots' readings.

        Args:
            indices: robots that are reset, sorted and unique, (k,).
            routes: route of each of these robots, k of them.
            q: configurations in the robots' frames, as for `Backend.reset`, (k, coordinates) [rad or m].
            base: origin of each robot's frame on the first leg's axis, x in the route's frame, (k,) [m].
            plane: angle from the x-y plane to each robot's plane, about x by the right-hand rule, (k,) [rad].
        """

    @abstractmethod
    def pull(self, forces: Floats) -> None:
        """Let forces act on the rear ends of the robots' first links until other ones are given or a robot is reset.

        Args:
            forces: force on each robot, axes of the route's frame, (n, 3) [N].
        """

    @abstractmethod
    def step(self, set_points: Floats, roll: Floats) -> None:
        """Advance every robot by one control period.

        Args:
            set_points: set-points of the on-board controllers, positions of joints and speeds of wheels, (n, actuators)
                [rad or m, rad/s].
            roll: set-points of the roll joints, (n,) [rad].
        """

    def begin(self, set_points: Floats, roll: Floats) -> Callable[[], None]:
        """Begin a control period: what is returned moves the robots, and may be called in another thread.

        Until it has returned nothing else may be called. The arguments are those of `step`; a simulator that has work
        to do before robots move does it here, where it delays no other robots.
        """
        return partial(self.step, set_points, roll)

    @abstractmethod
    def read(self) -> SpaceReading:
        """Return the present sensor readings, in arrays that belong to the caller."""

    @abstractmethod
    def truth(self) -> SpaceTruth:
        """State of the world now, and contacts of the last control period."""

    def open_viewer(self) -> Viewer:
        """Open the simulator's own window on the first robot.

        Raises:
            NoViewer: the simulator has none.
            PipenavError: no window can be opened on this display.
        """
        raise NoViewer(self)

    @abstractmethod
    def close(self) -> None:
        """Release everything; closing twice is harmless."""
