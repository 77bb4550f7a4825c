"""The seam of a real arm: a backend whose robot is one machine, that can be checked, emulated and stopped."""

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
    """What became of a command.

    Attributes:
        positions: set-points as they were sent, in joint order [rad or m]; of the last ones where nothing was sent.
        clamped: names of the joints whose set-point was limited.
        packet: the bytes as hexadecimal digits; empty where nothing could be sent.
    """

    positions: list[float]
    clamped: list[str]
    packet: str


class Finding(NamedTuple):
    """One line of a check: how it stands, what was found, and where something is wrong what to do."""

    level: Literal["ok", "warning", "problem"]
    what: str
    remedy: str = ""


class Emulated(NamedTuple):
    """An arm made of software.

    Attributes:
        options: open it.
        base: where the robot's frame starts on the first leg's axis, x in the pipe's frame [m].
        log: every byte on its bus, with its time.
    """

    options: BackendOptions
    base: float
    log: Path


class Recoder(NamedTuple):
    """Repeats a recorded run's arithmetic without its machine.

    Attributes:
        read: from the `raw` of a recorded tick to the reading that the run saw, or None where it saw none.
        write: from a command to what would be sent.
    """

    read: Callable[[Mapping[str, Any]], Reading | None]
    write: Callable[[Command], Sent]


class Calibrator(ABC):
    """Finds out how an arm is mounted, one joint at a time; asks and prints nothing itself.

    Attributes:
        joints: their names, in order.
    """

    joints: list[str]

    @abstractmethod
    def set_zero(self) -> None:
        """The arm stands straight now, its carriage at the start: these are the joints' zeros."""

    @abstractmethod
    def nudge(self, joint: str) -> float:
        """Move one joint's servo counter-clockwise a little and switch torque off again; by how much [rad]."""

    @abstractmethod
    def set_direction(self, joint: str, positive: bool, moved_mm: float | None) -> None:
        """What the nudge did: whether it was the joint's positive direction, and of a slide how far it went."""

    @abstractmethod
    def text(self) -> str:
        """The content of arm.toml."""

    @abstractmethod
    def write_servos(self) -> list[str]:
        """Store the arm's limits in the servos' EEPROM; what was written, one line for each servo."""

    @abstractmethod
    def cut(self) -> None:
        """Switch torque off at once: allowed inside a signal handler."""

    @abstractmethod
    def off(self) -> list[str]:
        """Switch torque off and ask back; never raises."""

    @abstractmethod
    def close(self) -> None: ...


class RealRobot(Backend):
    """One arm. `reset` switches it on where it is, `step` sends set-points and waits for the next tick.

    Attributes:
        complete: whether the last `read` was a whole one; after one that was not, `hold` instead of `step`.
        warnings: what the person at the arm should know.
    """

    complete: bool
    warnings: list[str]

    @abstractmethod
    def send(self, command: Command) -> Sent:
        """Send set-points, limited, without waiting."""

    @abstractmethod
    def hold(self) -> None:
        """Send nothing new: the arm keeps its last set-points, and is supervised as long as this is called often."""

    @abstractmethod
    def wait(self) -> None:
        """Until the next tick is due, while sensors are listened to."""

    @abstractmethod
    def cut(self) -> None:
        """Switch torque off at once: allowed inside a signal handler."""

    @abstractmethod
    def off(self) -> list[str]:
        """Switch torque off and ask back; never raises.

        Returns:
            The joints whose servo did not confirm.
        """

    @abstractmethod
    def raw(self) -> dict[str, Any]:
        """What the last tick brought and cost, as it goes into the telemetry: bytes, scan, warnings, seconds."""

    @abstractmethod
    def description(self) -> dict[str, Any]:
        """What a replay needs to know of this machine."""

    @classmethod
    @abstractmethod
    def recoder(cls, robot: RobotSpec, description: Mapping[str, Any]) -> Recoder:
        """The arithmetic of a machine with this description."""

    @classmethod
    @abstractmethod
    def check(cls, options: BackendOptions) -> Iterator[Finding]:
        """Look at everything and change nothing."""

    @classmethod
    @abstractmethod
    def calibrator(cls, robot: RobotSpec, ports: Mapping[str, str]) -> Calibrator:
        """A calibration of a new arm.

        Args:
            robot: what it shall be.
            ports: devices of `servos`, `scanner` and, where there is one, `front`.
        """

    @classmethod
    @abstractmethod
    def emulate(
        cls, robot: RobotSpec, pipe: PipeCorner, folder: Path, seed: int, faults: Sequence[Mapping[str, Any]]
    ) -> AbstractContextManager[Emulated]:
        """An arm made of software in a pipe, while the context lasts.

        Args:
            robot: the robot.
            pipe: the pipe around it.
            folder: where its log of every byte goes.
            seed: of where it stands, of noise and of faults.
            faults: what goes wrong, see the plugin's documentation.
        """


def load_real_robot(name: str = "hardware") -> type[RealRobot]:
    """The class of a machine's backend.

    Raises:
        UnknownName, BackendUnavailable: there is none of this name, or it cannot be loaded, or it is no machine.
    """
    kind = load_backend(name)
    if not issubclass(kind, RealRobot):
        raise BackendUnavailable(name, "it is a simulator", "use pipenav eval for simulators")
    return kind
