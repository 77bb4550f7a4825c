"""The seam of the real robot: a backend that drives one arm, which can be checked, emulated and stopped."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pipenav.arrays import Floats
from pipenav.backends.backend import Backend, BackendOptions
from pipenav.backends.messages import Command, Reading
from pipenav.backends.registry import load_backend
from pipenav.errors import BackendUnavailable
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec


class Sent(NamedTuple):
    """A command as it was sent.

    Attributes:
        positions: set-points as they were sent, in joint order [rad or m]; the last ones where nothing was sent.
        clamped: names of the joints whose set-point was limited.
        packet: the bytes as hexadecimal digits; empty where nothing could be sent.
    """

    positions: list[float]
    clamped: list[str]
    packet: str


class Finding(NamedTuple):
    """A line of a check.

    Attributes:
        level: how it stands.
        what: what was found.
        remedy: what to do where something is wrong.
    """

    level: Literal["ok", "warning", "problem"]
    what: str
    remedy: str = ""


class ArmStart(NamedTuple):
    """Pose of an arm in a pipe at its start.

    Attributes:
        q: joint positions, (joints,) [rad or m].
        base: origin of the robot's frame on the first leg's axis, x in the pipe's frame [m].
    """

    q: Floats
    base: float


class Emulated(NamedTuple):
    """An arm made of software, running.

    Attributes:
        options: settings that open it.
        log: file of every byte on its bus, with its time.
    """

    options: BackendOptions
    log: Path


class ServoHealth(NamedTuple):
    """Load, supply and temperature of a servo.

    Attributes:
        load: signed share of its torque, positive towards rising counts.
        volts: its supply [V].
        celsius: its temperature [deg C].
    """

    load: float
    volts: float
    celsius: float


class Recoder(NamedTuple):
    """The arithmetic of a real robot, repeated without it.

    Attributes:
        read: maps the `raw` of a recorded tick to the reading that was seen in it, None where there was no whole one.
        write: maps a command to what would be sent.
        servos: maps the `raw` of a recorded tick to the servos' health, in joint order; None for one that was silent.
    """

    read: Callable[[Mapping[str, Any]], Reading | None]
    write: Callable[[Command], Sent]
    servos: Callable[[Mapping[str, Any]], list[ServoHealth | None]]


class Stoppable(ABC):
    """Arm whose torque must go off, however it is left."""

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
    def close(self) -> None:
        """Switch torque off and end.

        Raises:
            TorqueUnconfirmed: a joint did not confirm, and `off` has not named it before.
        """


class Calibrator(Stoppable):
    """Finds out how an arm is mounted, one joint at a time; asks and prints nothing itself.

    Attributes:
        joints: names of the joints, in order.
    """

    joints: list[str]

    @abstractmethod
    def set_zero(self) -> None:
        """Take the present positions for the joints' zeros: the arm stands straight, its carriage at the start."""

    @abstractmethod
    def nudge(self, joint: str) -> float:
        """Move one joint's servo counter-clockwise a little and switch torque off again.

        Returns:
            How far the servo moved [rad].
        """

    @abstractmethod
    def set_direction(self, joint: str, positive: bool, moved_mm: float | None) -> None:
        """Take over what a person saw a nudge do.

        Args:
            joint: name of the joint.
            positive: whether it moved in its positive direction.
            moved_mm: how far it moved, if it is a slide [mm].
        """

    @abstractmethod
    def text(self) -> str:
        """Content of arm.toml."""

    @abstractmethod
    def write_servos(self) -> list[str]:
        """Store the limits of arm.toml in the servos' EEPROM.

        Returns:
            What was written, one line for each servo.
        """


class RealRobot(Stoppable, Backend):
    """The seam of one arm. `reset` switches it on where it is, `step` sends set-points and waits for the next tick.

    Attributes:
        complete: whether the last `read` gave a whole reading; after one that did not, `hold` instead of `step`.
        warnings: what the person at the arm should know.
    """

    complete: bool
    warnings: list[str]

    @property
    @abstractmethod
    def joint_limits(self) -> Floats:
        """Smallest and largest position of every joint of this very arm, (joints, 2) [rad or m]."""

    @abstractmethod
    def send(self, command: Command) -> Sent:
        """Send set-points, limited, without waiting."""

    @abstractmethod
    def hold(self) -> None:
        """Send nothing new: the arm keeps its last set-points, and is supervised as long as this is called often."""

    @abstractmethod
    def wait(self) -> None:
        """Wait until the next tick is due, listening to the sensors."""

    @abstractmethod
    def raw(self) -> dict[str, Any]:
        """Bytes, scan, alarms and times [s] of the last tick, as they go into the telemetry."""

    @abstractmethod
    def description(self) -> dict[str, Any]:
        """The facts about this arm that a replay needs."""

    @classmethod
    @abstractmethod
    def recoder(cls, robot: RobotSpec, description: Mapping[str, Any]) -> Recoder:
        """The arithmetic of an arm with this description."""

    @classmethod
    @abstractmethod
    def check(cls, options: BackendOptions, robot: RobotSpec | None = None) -> Iterator[Finding]:
        """Look at everything and change nothing.

        Args:
            options: settings that open the arm.
            robot: the robot that it must be; None where any will do.

        Raises:
            ConfigError: the arm is another robot, which is found out before any port is opened.
        """

    @classmethod
    @abstractmethod
    def calibrator(cls, robot: RobotSpec, ports: Mapping[str, str], may_write: bool = False) -> Calibrator:
        """A calibration of a new arm.

        Args:
            robot: the robot that the arm is to be.
            ports: devices of `servos`, `scanner` and, where there is one, `front`.
            may_write: whether servos that could not be calibrated as they are may be given settings.
        """

    @classmethod
    @abstractmethod
    def store(cls, options: BackendOptions) -> list[str]:
        """Store the limits of arm.toml in the servos' EEPROM.

        Args:
            options: settings that open the arm.

        Returns:
            What was written, one line for each servo.
        """

    @classmethod
    @abstractmethod
    def emulate(
        cls,
        robot: RobotSpec,
        pipe: PipeCorner,
        start: ArmStart,
        folder: Path,
        seed: int,
        faults: Sequence[Mapping[str, Any]],
    ) -> AbstractContextManager[Emulated]:
        """An arm made of software in a pipe, while the context lasts.

        Args:
            robot: the robot.
            pipe: the pipe around it.
            start: where it stands in the pipe.
            folder: folder for its log of every byte.
            seed: seed of noise and of random faults.
            faults: what goes wrong, see docs/guides/the-arm.md, Faults.
        """


def load_real_robot(name: str = "hardware") -> type[RealRobot]:
    """The class of a real robot's backend.

    Raises:
        UnknownName, BackendUnavailable: there is none of this name, or it cannot be loaded, or it is a simulator.
    """
    backend_class = load_backend(name)
    if not issubclass(backend_class, RealRobot):
        raise BackendUnavailable(name, "it is a simulator", "use pipenav eval for simulators")
    return backend_class
