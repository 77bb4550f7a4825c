"""The seam for robots in space: what a simulator offers besides `Backend`, where pipes leave the plane.

The robot is the one of the plane, a chain that bends in a plane of its own, but free in space; its roll joint divides
it into two halves, and the plane of the front half is turned from the rear half's by that joint's position.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.pipes.route import PipeRoute

HALVES = 2
"""The rear half, then the front half."""


class SpaceReading(NamedTuple):
    """What the robots' own sensors give.

    Attributes:
        body: what they give in the plane too.
        roll: position of the roll joint, (n,) [rad].
        down: what an accelerometer in either half of the divided link gives at rest, turned round: which way is down,
            in the half's frame (x forwards along the link, y to its left, z across its plane), unit vectors
            (n, halves, 3); 0 where nothing has weight.
        turned: by how much either half of the divided link turned about its x, y and z in the last control period, as
            its gyroscope sums it up, (n, halves, 3) [rad].
    """

    body: Reading
    roll: Floats
    down: Floats
    turned: Floats

    def row(self, i: int) -> SpaceReading:
        """That of one robot: its arrays without their first axis."""
        body = Reading(**{name: column[i] for name, column in self.body.measured().items()})
        return SpaceReading(body, self.roll[i], self.down[i], self.turned[i])


class SpaceTruth(NamedTuple):
    """What only a simulator knows; rewards and verdicts may use it, policies never. As `Truth`, in space.

    Attributes:
        points: rear end, joints and tip in the run's frame, (n, links + 1, 3) [m].
        normals: of the halves' planes, (n, halves, 3).
        contact_force: largest net force of the pipe on any one link, (n,) [N].
        penetration: deepest overlap of robot and pipe, (n,) [m].
        contact_share: share of the physics steps with contact, (n,).
        link_forces: net force of the pipe on each link when that was largest, (n, links, 3) [N].
    """

    points: Floats
    normals: Floats
    contact_force: Floats
    penetration: Floats
    contact_share: Floats
    link_forces: Floats


class SpaceBackend(ABC):
    """n robots of one kind, each in a run of its own, stepped together."""

    @abstractmethod
    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        """Put some robots at rest into runs; the others are untouched. What the k robots' sensors give there.

        Args:
            indices: which robots, sorted and unique, (k,).
            routes: the run of each, k of them.
            q: configurations in the robots' frames, as for `Backend.reset`, (k, coordinates) [rad or m].
            base: where each robot's frame starts on the first leg's axis, x in the run's frame, (k,) [m].
            plane: how far each robot's plane is turned from the x-y plane, about x by the right-hand rule, (k,) [rad].
        """

    @abstractmethod
    def step(self, set_points: Floats, roll: Floats) -> None:
        """Advance every robot by one control period.

        Args:
            set_points: for the on-board controllers, positions of joints and speeds of wheels, (n, actuators).
            roll: set-points of the roll joints, (n,) [rad].
        """

    @abstractmethod
    def read(self) -> SpaceReading:
        """What the sensors give now, in arrays of the caller's own."""

    @abstractmethod
    def truth(self) -> SpaceTruth:
        """What a simulator knows of the last control period."""

    @abstractmethod
    def close(self) -> None:
        """Release everything; closing twice is harmless."""
