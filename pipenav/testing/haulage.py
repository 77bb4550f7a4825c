"""Travel and pull of a robot on wheels, measured in a straight, level pipe of a simulator: the bollard test.

The robot clamps as a zigzag, all bending joints at full effort, and turns its wheels at full speed, while a force on
its tail holds it back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import closing
from typing import Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Command
from pipenav.backends.refusals import CannotPull
from pipenav.backends.simulators import open_simulator
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.robots.zigzag import zigzag

SPRING = 200.0
"""Stiffness of the spring behind a robot on the bollard [N/m]: 14 N stretch it by 70 mm, slowly enough for a control
step."""

RUN_UP_S, MEASURED_S, BOLLARD_S = 3.0, 3.0, 20.0
"""Times until the speed is steady, over which it is measured, and until a spring is stretched [s]."""


class Haulage:
    """A robot in a straight pipe of a simulator.

    Args:
        robot: a free robot whose links, but for its ends, carry a wheel at their joint.
        backend: name of a simulator in which forces can pull.
        diameter_mm: bore [mm].
        options: settings of the simulator.

    Raises:
        CannotPull: the simulator knows no such force.
        PipenavError: the simulator cannot be opened.
    """

    def __init__(
        self,
        robot: RobotSpec,
        backend: str = "mujoco",
        diameter_mm: float = 100.0,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        self._robot, self._backend, self._options = robot, backend, options or {}
        self._pipe = PipeCorner.of(diameter_mm, 90, leg_mm=10000)
        pose = zigzag(robot, np.array([self._pipe.radius - robot.wheels[0].radius]))
        self._bends, self._base = pose.bends[0], -9.0
        self._start = np.concatenate([[0.0], pose.first_link[0], self._bends])[None]

    def roll(self, seconds: float, force: Callable[[float], float]) -> Floats:
        """Distances of the tail from its start, after each control step of a run from standstill, (steps,) [m].

        Args:
            seconds: duration of the run [s].
            force: force that holds the tail back [N], for the tail's distance from its start [m].
        """
        robot, joints = self._robot, len(self._robot.joints)
        press = np.array([motor.full_drive_error for motor in robot.joint_actuators])
        set_points = self._bends + np.copysign(press, self._bends)
        wheels = np.array([motor.speed_limit for motor in robot.driven_actuators[joints:]])
        forwards = -np.sign(self._bends[robot.wheel_joints])
        command = Command("position", np.concatenate([set_points, wheels * forwards])[None])
        moved: list[float] = []
        with closing(open_simulator(self._backend, robot, 1, self._options)) as simulator:
            if not simulator.can_pull:
                raise CannotPull(simulator)
            simulator.reset(np.arange(1), [self._pipe], self._start, np.array([self._base]))
            for _ in range(round(seconds / CONTROL_PERIOD)):
                simulator.pull(np.array([[-force(moved[-1] if moved else 0.0), 0.0]]))
                simulator.step(command)
                tip = simulator.truth().tip - [self._base, 0.0, 0.0]
                moved.append(kinematics.configuration(robot, simulator.read().q, tip)[0, 0])
        return np.array(moved)

    def speed(self, load: float = 0.0) -> float:
        """Speed of travel against a load [N], after a run-up [m/s]; negative where the load pulls the robot back."""
        moved = self.roll(RUN_UP_S + MEASURED_S, lambda _: load)
        return float(moved[-1] - moved[round(RUN_UP_S / CONTROL_PERIOD) - 1]) / MEASURED_S

    def bollard_pull(self) -> float:
        """Force with which the robot stretches a spring behind it until it stands [N]."""
        return SPRING * float(self.roll(BOLLARD_S, lambda moved: SPRING * moved)[-1])
