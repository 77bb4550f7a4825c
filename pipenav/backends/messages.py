"""Messages between a backend and its users: sensor readings, the truth that only a simulator knows, and commands."""

from __future__ import annotations

from typing import Literal, NamedTuple

from pipenav.arrays import Floats, Ints

Control = Literal["torque", "position"]


class Reading(NamedTuple):
    """Readings of the robots' own sensors. A policy sees these and nothing else of the world.

    Attributes:
        q: joint positions, (n, joints) [rad or m].
        qd: joint speeds, (n, joints) [rad/s or m/s].
        ranges: laser readings from right to left, (n, beams) [m].
        time: time since each robot's reset, (n,) [s].
        wheel_speeds: speeds of the wheels, to the left about their axles, (n, wheels) [rad/s]; None where there are
            none.
        loads: duty that each on-board controller asks for, a share of full voltage in [-1, 1]: the joints', then
            the wheels', (n, actuators); None where it is not measured.
    """

    q: Floats
    qd: Floats
    ranges: Floats
    time: Floats
    wheel_speeds: Floats | None = None
    loads: Floats | None = None

    def part(self, indices: Ints) -> Reading:
        """Readings of some robots, k of them."""
        return Reading(**{name: column[indices] for name, column in self.measured().items()})

    def put(self, indices: Ints, part: Reading) -> None:
        """Overwrite the rows of some robots, k of them, by `part`."""
        for name, rows in part.measured().items():
            if (column := getattr(self, name)) is not None:
                column[indices] = rows

    def measured(self) -> dict[str, Floats]:
        """All quantities that are measured, by name."""
        return {name: column for name, column in self._asdict().items() if column is not None}


class Truth(NamedTuple):
    """State that only a simulator knows; rewards and outcomes may use it, policies never.

    Force and penetration are the peaks over the last control period; force is a mean over 10 ms, so that it does not
    depend on the physics step.

    Attributes:
        tip: tip position and heading in the pipe's frame, (n, 3) [m, m, rad].
        contact_force: largest net force of the pipe on any one link, (n,) [N].
        penetration: deepest overlap of robot and pipe, (n,) [m].
        contact_share: share of the physics steps with contact, (n,).
        link_forces: net force of the pipe on each link at the moment when it was largest, axes of the pipe's frame,
            (n, links, 2) [N].
    """

    tip: Floats
    contact_force: Floats
    penetration: Floats
    contact_share: Floats
    link_forces: Floats


class Command(NamedTuple):
    """Command to all robots for one control period.

    Attributes:
        control: `torque`: values are duties, the share of each actuator's effort limit in [-1, 1];
            `position`: values are set-points for the on-board controllers, positions of joints and speeds of wheels.
        values: duties or set-points of the joints, then of the wheels, (n, actuators) [1, or rad and m, and rad/s].
    """

    control: Control
    values: Floats
