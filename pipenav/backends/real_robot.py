"""The seam of a real arm: a backend of one machine, which can be checked, calibrated, emulated and stopped."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pipenav.backends.backend import Backend, BackendOptions
from pipenav.backends.messages import Command, Reading
from pipenav.backends.registry import load_backend
from pipenav.errors import BackendUnavailable
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec


class Sent(NamedTuple):
    """Result of sending a command.

    Attributes:
        positions: set-points as they were sent, in joint order [rad or m]; the last ones where nothing was sent.
        clamped: names of the joints whose set-point was limited.
        packet: bytes that were sent, as hexadecimal digits; empty where nothing could be sent.
    """

    positions: list[float]
    clamped: list[str]
    packet: str


class Finding(NamedTuple):
    """Finding of a check: its level, what was found, and where something is wrong, what to do about it."""

    level: Literal["ok", "warning", "problem"]
    what: str
    remedy: str = ""


class Emulated(NamedTuple):
    """An arm made of software.

    Attributes:
        options: settings that open it.
        base: origin of the robot's frame on the first leg's axis, x in the pipe's frame [m].
        log: file with every byte on its bus and the time of each.
    """

    options: BackendOptions
    base: float
    log: Path


class Recoder(NamedTuple):
    """Repeats the arithmetic of a recorded mission without its machine.

    Attributes:
        read: computes the reading of a tick from its recorded `raw`; None where the mission saw none.
        write: computes what would be sent for a command.
    """

    read: Callable[[Mapping[str, Any]], Reading | None]
    write: Callable[[Command], Sent]


class Calibrator(ABC):
    """Finds out how an arm is mounted, one joint at a time; asks and prints nothing itself.

    Attributes:
        joints: names of the joints, in order.
    """

    joints: list[str]

    @abstractmethod
    def set_zero(self) -> None:
        """Take the present positions as the joints' zeros: the arm stands straight, its carriage at the start."""

    @abstractmethod
    def nudge(self, joint: str) -> float:
        """Turn a joint's servo counter-clockwise a little, switch torque off again, and return the angle [rad]."""

    @abstractmethod
    def set_direction(self, joint: str, positive: bool, moved_mm: float | None) -> None:
        """Note the effect of the nudge.

        Args:
            joint: name of the joint.
            positive: whether it moved in its positive direction.
            moved_mm: travel of a slide [mm]; None for a hinge.
        """

    @abstractmethod
    def text(self) -> str:
        """Content of arm.toml."""

    @abstractmethod
    def write_servos(self) -> list[str]:
        """Store the arm's limits in the servos' EEPROM, and return a line about each servo."""

    @abstractmethod
    def cut(self) -> None:
        """Switch torque off at once: allowed inside a signal handler."""

    @abstractmethod
    def off(self) -> list[str]:
        """Switch torque off and ask back; never raises.

        Returns:
            Names of the joints whose servo did not confirm.
        """

    @abstractmethod
    def close(self) -> None:
        """Release everything; closing twice is harmless."""


class RealRobot(Backend):
    """A real arm. `reset` switches it on where it is, `step` sends set-points and waits for the next tick.

    Attributes:
        complete: whether the last `read` was complete; after an incomplete one, call `hold` instead of `step`.
        warnings: sentences for the person at the arm.
    """

    complete: bool
    warnings: list[str]

    @abstractmethod
    def send(self, command: Command) -> Sent:
        """Send set-points within the limits, without waiting."""

    @abstractmethod
    def hold(self) -> None:
        """Send nothing new: the arm keeps its last set-points, and is supervised as long as this is called often."""

    @abstractmethod
    def wait(self) -> None:
        """Wait until the next tick is due, and listen to the sensors meanwhile."""

    @abstractmethod
    def cut(self) -> None:
        """Switch torque off at once: allowed inside a signal handler."""

    @abstractmethod
    def off(self) -> list[str]:
        """Switch torque off and ask back; never raises.

        Returns:
            Names of the joints whose servo did not confirm.
        """

    @abstractmethod
    def raw(self) -> dict[str, Any]:
        """Record of the last tick for the telemetry: bytes, scan, warnings, seconds."""

    @abstractmethod
    def description(self) -> dict[str, Any]:
        """Description of this machine that a replay needs."""

    @classmethod
    @abstractmethod
    def recoder(cls, robot: RobotSpec, description: Mapping[str, Any]) -> Recoder:
        """Recoder for a machine with this description."""

    @classmethod
    @abstractmethod
    def check(cls, options: BackendOptions) -> Iterator[Finding]:
        """Look at everything and change nothing."""

    @classmethod
    @abstractmethod
    def calibrator(cls, robot: RobotSpec, ports: Mapping[str, str]) -> Calibrator:
        """Start the calibration of a new arm.

        Args:
            robot: robot that the arm is built as.
            ports: devices of `servos`, `scanner` and, where there is one, `front`.
        """

    @classmethod
    @abstractmethod
    def emulate(
        cls, robot: RobotSpec, pipe: PipeCorner, folder: Path, seed: int, faults: Sequence[Mapping[str, Any]]
    ) -> AbstractContextManager[Emulated]:
        """Run an arm made of software in a pipe while the context lasts.

        Args:
            robot: the robot.
            pipe: the pipe around it.
            folder: folder for its log of every byte.
            seed: seed of its start position, of noise and of faults.
            faults: faults that it has, see the plugin's documentation.
        """


def load_real_robot(name: str = "hardware") -> type[RealRobot]:
    """Import the class of a real arm's backend.

    Raises:
        UnknownName: no installed distribution declares it.
        BackendUnavailable: it cannot be loaded, or it is no real arm.
    """
    kind = load_backend(name)
    if not issubclass(kind, RealRobot):
        raise BackendUnavailable(name, "it is a simulator", "use pipenav eval for simulators")
    return kind
