"""The servos as the motors of an arm in a pipe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends import CONTROL_PERIOD, ArmStart, Command, Simulator
from pipenav.pipes import PipeCorner
from pipenav.robots import RobotSpec, kinematics, laser
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.emulator.plant import NOLOAD_SPEED, SLOPE, Plant, ServoCommand, Shaft
from pipenav_hardware.table import SPEED_UNIT

STILL = 2e-3
"""Joint motion in a period, and joint speed, that count as rest [rad or m, and per second]."""


class JointMotion(NamedTuple):
    """Joint positions [rad or m] and speeds [per second], (joints,) each."""

    q: Floats
    qd: Floats


class PipePlant(Plant):
    """The arm in a pipe, on a simulator that steps whole control periods.

    A period begins when a command comes; the simulator computes its end at once, and in between the joints are where a
    cubic through both ends' positions and speeds has them. A command that comes as the period ends (the host's clock
    is not the emulator's) begins the next one; without a command it begins by itself after `GRACE`. A joint without
    torque stays where it is: a 254:1 gear is hard to turn from outside.

    Attributes:
        peak_force: largest contact force so far [N].
        penetration: deepest penetration of a wall so far [m].
    """

    GRACE = 0.3 * CONTROL_PERIOD
    """Largest deviation of the time between two commands from a whole period [s]."""

    def __init__(
        self, robot: RobotSpec, arm: ArmConfig, simulator: Simulator, pipe: PipeCorner, start: ArmStart
    ) -> None:
        self._robot, self._arm, self._simulator, self._base = robot, arm, simulator, start.base
        self._segments = pipe.segments.copy()[None]
        self._segments[..., 0] -= start.base
        simulator.reset(np.array([0]), [pipe], start.q[None], np.array([start.base]))
        self.stuck: set[int] = set()
        self.peak_force, self.penetration = 0.0, 0.0
        self._commands = [ServoCommand(0, 0, 0.0)] * len(arm.servos)
        self._waiting, self._start = False, 0.0
        self._before = self._after = JointMotion(start.q, np.zeros_like(start.q))

    def command(self, now: float, commands: Sequence[ServoCommand]) -> None:
        self._advance(now)
        self._waiting |= list(commands) != self._commands
        self._commands = list(commands)
        self._advance(now)

    def shafts(self, now: float) -> list[Shaft]:
        q, qd = self._motion(now)
        shafts = []
        for i, (servo, command) in enumerate(zip(self._arm.servos, self._commands, strict=True)):
            position = servo.to_counts(q[i])
            load = float(np.clip((command.goal_counts - position) / SLOPE, -command.torque_share, command.torque_share))
            shafts.append(Shaft(position, servo.sign * qd[i] / servo.unit, load))
        return shafts

    def distances(self, now: float, angles: Floats) -> Floats:
        q, _ = self._motion(now)
        pose = kinematics.forward(self._robot, q[None])
        distances: Floats = laser.cast(pose.tip, pose.headings[:, -1:] + angles, self._segments)[0]
        return distances

    def tip(self, now: float) -> Floats:
        """Position of the tip in the pipe's frame, (2,) [m]."""
        q, _ = self._motion(now)
        return np.asarray(kinematics.forward(self._robot, q[None]).tip[0] + np.array([self._base, 0.0]))

    def _motion(self, now: float) -> JointMotion:
        """Joint positions and speeds now: the cubic through both ends of the period."""
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
        return JointMotion(q, rate / CONTROL_PERIOD)

    def _advance(self, now: float) -> None:
        """Begin every period that has begun until now."""
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
        for i, (servo, command) in enumerate(zip(self._arm.servos, self._commands, strict=True)):
            if command.torque_share and i not in self.stuck:
                reach = (command.speed * SPEED_UNIT if command.speed else NOLOAD_SPEED) * servo.unit * CONTROL_PERIOD
                values[i] += np.clip(servo.to_position(command.goal_counts) - q[i], -reach, reach)
        self._simulator.step(Command("position", values[None]))
        reading, truth = self._simulator.read(), self._simulator.truth()
        self._after = JointMotion(reading.q[0], reading.qd[0])
        self.peak_force = max(self.peak_force, float(truth.contact_force[0]))
        self.penetration = max(self.penetration, float(truth.penetration[0]))
