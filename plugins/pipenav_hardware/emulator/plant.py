"""Where the servos' shafts go: on their own, or as the joints of an arm in a pipe."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends import CONTROL_PERIOD, Command, Simulator
from pipenav.pipes import PipeCorner
from pipenav.robots import RobotSpec, kinematics, laser
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.table import COUNT, DIRECTION, SPEED_UNIT

NOLOAD_SPEED = 6.18
"""Of an AX-12A at 12 V [rad/s]."""

SLOPE = 32
"""Position error at which the servo gives all it is allowed, in counts: the compliance slope's initial value."""

STILL = 2e-3
"""Joint motion in a period, and joint speed, that are none [rad or m, and per second]."""

TURN = 2 * np.pi / COUNT
"""A whole turn in counts; the servo measures the first 1023 of them."""


class Drive(NamedTuple):
    """What one motor is told: goal in counts, the Moving Speed register, share of torque (0: off), wheel mode."""

    goal: int
    speed: int
    share: float
    wheel: bool = False


class Shaft(NamedTuple):
    """Position [counts], speed [rad/s], and load as a signed share of the servo's torque."""

    position: float
    speed: float
    load: float


class Plant(ABC):
    """The mechanics behind the servos."""

    @abstractmethod
    def command(self, now: float, actuators: Sequence[Drive]) -> None:
        """What the motors do from now on [s]."""

    @abstractmethod
    def shafts(self, now: float) -> list[Shaft]:
        """Every shaft at a time that never runs backwards [s]."""

    @abstractmethod
    def distances(self, now: float, angles: Floats) -> Floats:
        """True distance from the tip along rays at these angles from the tip link's axis, (k,) [m]; inf: no wall."""


class FreePlant(Plant):
    """Shafts that nothing holds but their own stops; a stuck one holds against the motor."""

    def __init__(self, count: int, seed: int = 0) -> None:
        self._position = np.full(count, 511.5)
        self._drives = [Drive(512, 0, 0.0)] * count
        self._speed, self._load, self._now = np.zeros(count), np.zeros(count), 0.0
        self.stuck: set[int] = set()
        self._rng = np.random.default_rng(seed)

    def place(self, positions: Sequence[float]) -> None:
        """Turn the shafts by hand."""
        self._position[:] = positions

    def command(self, now: float, actuators: Sequence[Drive]) -> None:
        self._advance(now)
        self._drives = list(actuators)

    def shafts(self, now: float) -> list[Shaft]:
        self._advance(now)
        seen = [self._reading(i) for i in range(len(self._position))]
        return [Shaft(p, float(v), float(f)) for p, v, f in zip(seen, self._speed, self._load, strict=True)]

    def distances(self, now: float, angles: Floats) -> Floats:  # noqa: ARG002  # the same at any time
        """A room: walls 0.2 m to the sides, 0.4 m ahead."""
        return np.asarray(
            np.minimum(0.2 / np.maximum(np.abs(np.sin(angles)), 1e-9), 0.4 / np.maximum(np.cos(angles), 1e-9))
        )

    def _advance(self, now: float) -> None:
        dt, self._now = max(now - self._now, 0.0) if self._now else 0.0, now
        for i, drive in enumerate(self._drives):
            goal, fastest = _pull(drive, self._position[i])
            error = goal - self._position[i]
            moved = 0.0 if i in self.stuck or not drive.share else float(np.clip(error, -fastest * dt, fastest * dt))
            self._position[i] += moved
            self._speed[i] = moved * COUNT / dt if dt else 0.0
            self._load[i] = np.clip((goal - self._position[i]) / SLOPE, -1, 1) * drive.share
            if not drive.wheel:
                self._position[i] = np.clip(self._position[i], 0, 1023)

    def _reading(self, i: int) -> float:
        """In the 60 deg that the servo cannot measure, it reads anything."""
        around = float(self._position[i] % TURN)
        return around if around <= 1023 else float(self._rng.integers(0, 1024))


def _pull(drive: Drive, position: float) -> tuple[float, float]:
    """Where a motor pulls to [counts] and how fast at most [counts/s]."""
    if drive.wheel:
        output = (drive.speed & (DIRECTION - 1)) / 1023
        return position + (-1e6 if drive.speed & DIRECTION else 1e6), output * NOLOAD_SPEED / COUNT
    asked = drive.speed * SPEED_UNIT if drive.speed else NOLOAD_SPEED  # 0: no speed control at all
    return drive.goal, min(asked, NOLOAD_SPEED * max(drive.share, 1e-9)) / COUNT


class PipePlant(Plant):
    """The arm in a pipe, on a simulator backend that steps whole control periods.

    A period begins when a command comes; the simulator computes its end at once, and in between the joints are where a
    cubic through both ends' positions and speeds has them. A command that comes as the period ends (the host's clock
    is not the emulator's) begins the next one; without a command it begins by itself after `GRACE`. A joint without
    torque stays where it is: a 254:1 gear is hard to turn from outside.
    """

    GRACE = 0.3 * CONTROL_PERIOD
    """How much earlier or later than a whole period after the last command the next one may come [s]."""

    def __init__(
        self, robot: RobotSpec, arm: ArmConfig, backend: Simulator, pipe: PipeCorner, q: Floats, base: float
    ) -> None:
        self._robot, self._arm, self._backend, self._base = robot, arm, backend, base
        self._segments = pipe.segments.copy()[None]
        self._segments[..., 0] -= base
        backend.reset(np.array([0]), [pipe], q[None], np.array([base]))
        self.stuck: set[int] = set()
        self.peak_force, self.penetration = 0.0, 0.0
        self._drives: list[Drive] = [Drive(0, 0, 0.0)] * len(arm.servos)
        self._waiting, self._start = False, 0.0
        self._before = self._after = (q, np.zeros_like(q))

    def command(self, now: float, actuators: Sequence[Drive]) -> None:
        self._advance(now)
        self._waiting |= list(actuators) != self._drives
        self._drives = list(actuators)
        self._advance(now)

    def shafts(self, now: float) -> list[Shaft]:
        q, qd = self._motion(now)
        shafts = []
        for i, (servo, drive) in enumerate(zip(self._arm.servos, self._drives, strict=True)):
            position = servo.to_counts(q[i])
            load = float(np.clip((drive.goal - position) / SLOPE, -drive.share, drive.share))
            shafts.append(Shaft(position, servo.sign * qd[i] / servo.unit, load))
        return shafts

    def distances(self, now: float, angles: Floats) -> Floats:
        q, _ = self._motion(now)
        pose = kinematics.forward(self._robot, q[None])
        distances: Floats = laser.cast(pose.tip, pose.headings[:, -1:] + angles, self._segments)[0]
        return distances

    def tip(self, now: float) -> Floats:
        """Tip in the pipe's frame, (2,) [m]."""
        q, _ = self._motion(now)
        return np.asarray(kinematics.forward(self._robot, q[None]).tip[0] + np.array([self._base, 0.0]))

    def _motion(self, now: float) -> tuple[Floats, Floats]:
        """Joint positions and speeds: the cubic through both ends of the period."""
        self._advance(now)
        t = min(max((now - self._start) / CONTROL_PERIOD, 0.0), 1.0)
        (q0, v0), (q1, v1) = self._before, self._after
        m0, m1 = v0 * CONTROL_PERIOD, v1 * CONTROL_PERIOD
        q = (
            (2 * t**3 - 3 * t**2 + 1) * q0
            + (t**3 - 2 * t**2 + t) * m0
            + (3 * t**2 - 2 * t**3) * q1
            + (t**3 - t**2) * m1
        )
        rate = 6 * (t**2 - t) * (q0 - q1) + (3 * t**2 - 4 * t + 1) * m0 + (3 * t**2 - 2 * t) * m1
        return q, rate / CONTROL_PERIOD

    def _advance(self, now: float) -> None:
        for _ in range(10):
            elapsed = now - self._start
            if self._waiting and (self._resting or elapsed >= CONTROL_PERIOD - self.GRACE):
                self._begin(now)
            elif elapsed >= CONTROL_PERIOD + self.GRACE:
                self._begin(self._start + CONTROL_PERIOD)
            else:
                return
        self._start = now  # nobody has looked for more than a second: the arm has come to rest

    @property
    def _resting(self) -> bool:
        """Whether nothing moves in this period, so that it can be left at any time."""
        (before, _), (after, speed) = self._before, self._after
        return bool(np.abs(after - before).max() < STILL and np.abs(speed).max() < STILL)

    def _begin(self, start: float) -> None:
        """Compute the period that starts now."""
        self._before, self._start, self._waiting = self._after, start, False
        q = self._after[0]
        values = q.copy()
        for i, (servo, drive) in enumerate(zip(self._arm.servos, self._drives, strict=True)):
            if drive.share and i not in self.stuck:
                reach = (drive.speed * SPEED_UNIT if drive.speed else NOLOAD_SPEED) * servo.unit * CONTROL_PERIOD
                values[i] += np.clip(servo.to_position(drive.goal) - q[i], -reach, reach)
        self._backend.step(Command("position", values[None]))
        reading, truth = self._backend.read(), self._backend.truth()
        self._after = (reading.q[0], reading.qd[0])
        if truth is not None:
            self.peak_force = max(self.peak_force, float(truth.contact_force[0]))
            self.penetration = max(self.penetration, float(truth.penetration[0]))
