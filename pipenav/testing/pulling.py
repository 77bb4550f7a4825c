"""The law of a simulator in which forces pull on robots (`Simulator.pull`); it holds trivially for all others."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD, Simulator
from pipenav.backends.messages import Command
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import kinematics, traction
from pipenav.testing.bench import Bench
from pipenav.testing.laws import Law, require

DRAWN = 0.01
"""Distance by which a robot is drawn in a control period [m]."""


def check_a_pull_moves_a_free_robot_as_newton_says(bench: Bench) -> None:
    """The centre of mass of a robot that touches nothing moves by F t^2 / 2 m along the force, each by its own.

    A force across the robot moves its rear end farther than its centre of mass: there it acts.
    """
    robot, n = bench.robot, bench.n
    q, base = np.zeros((n, robot.coordinates)), np.full(n, -1.5 - robot.length)
    for axis in np.eye(2):
        ways = DRAWN * np.linspace(-1.0, 1.0, n)[:, None] * axis
        with bench.open() as subject:
            if not (isinstance(subject, Simulator) and subject.can_pull and robot.free):
                return
            subject.reset(np.arange(n), [PipeCorner.of(300, 90, leg_mm=4000)] * n, q, base)
            before = _places(bench, subject, base)
            subject.pull(2 * traction.mass(robot) / CONTROL_PERIOD**2 * ways)
            subject.step(Command("position", np.zeros((n, len(robot.driven_actuators)))))
            moved = _places(bench, subject, base) - before
        np.testing.assert_allclose(moved[0], ways, atol=0.05 * DRAWN, err_msg="way of the centre of mass under a pull")
        farther = np.abs(moved[1] @ axis) >= np.abs(ways @ axis) * (1.5 if axis[1] else 0.9)
        require(bool(farther.all()), f"a pull on the rear end moves it by {moved[1]}, the whole robot by {ways}")


def _places(bench: Bench, subject: Simulator, base: Floats) -> Floats:
    """Centres of mass, wheels at their joints, then rear ends, in the pipe's frame, (2, n, 2) [m]."""
    robot, shift = bench.robot, np.stack([base, np.zeros_like(base)], axis=1)
    tip = subject.truth().tip - np.pad(shift, [(0, 0), (0, 1)])
    points = kinematics.waypoints(robot, kinematics.configuration(robot, subject.read().q, tip))
    middles, joints = (points[:, :-1] + points[:, 1:]) / 2, points[:, :-1]
    links = np.array([link.mass for link in robot.links])
    wheels = np.array([link.wheel.mass if link.wheel else 0.0 for link in robot.links])
    centre = (np.tensordot(middles, links, (1, 0)) + np.tensordot(joints, wheels, (1, 0))) / traction.mass(robot)
    return np.stack([centre + shift, points[:, 0] + shift])


PULL_LAWS: list[Law] = [check_a_pull_moves_a_free_robot_as_newton_says]
"""Laws of simulators in which forces pull on robots."""
