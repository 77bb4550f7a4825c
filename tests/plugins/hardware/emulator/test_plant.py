"""The mechanics behind the emulated servos."""

from __future__ import annotations

import numpy as np
import pytest
from pipenav_hardware.arm_config import ScannerConfig, default_arm
from pipenav_hardware.emulator.free_plant import TURN, FreePlant
from pipenav_hardware.emulator.pipe_plant import PipePlant
from pipenav_hardware.emulator.plant import ServoCommand
from pipenav_hardware.table import COUNT, SPEED_UNIT

from pipenav.backends.real_robot import ArmStart
from pipenav.backends.simulators import open_simulator
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot


def test_a_shaft_follows_its_goal_at_its_speed() -> None:
    plant = FreePlant(1)
    plant.command(1.0, [ServoCommand(612, 100, 1.0)])
    shaft = plant.shafts(1.1)[0]
    assert shaft.position == pytest.approx(511.5 + 100 * SPEED_UNIT * 0.1 / COUNT)
    assert shaft.speed == pytest.approx(100 * SPEED_UNIT)
    assert shaft.load > 0.9
    assert plant.shafts(9.0)[0].position == 612


def test_speed_0_is_full_speed() -> None:
    plant = FreePlant(1)
    plant.command(1.0, [ServoCommand(1000, 0, 1.0)])
    assert plant.shafts(1.1)[0].position - 511.5 > 100


def test_a_shaft_without_torque_or_held_stays() -> None:
    plant = FreePlant(2)
    plant.stuck = {1}
    plant.command(1.0, [ServoCommand(900, 100, 0.0), ServoCommand(900, 100, 0.5)])
    free, held = plant.shafts(2.0)
    assert (free.position, free.load) == (511.5, 0.0)
    assert (held.position, held.load) == (511.5, 0.5)


def test_a_wheel_keeps_turning_and_reads_nonsense_in_its_dead_band() -> None:
    plant = FreePlant(1)
    plant.command(1.0, [ServoCommand(0, 300, 1.0, wheel=True)])
    readings = [plant.shafts(1.0 + 0.01 * i)[0].position for i in range(1000)]
    assert all(0 <= reading <= 1023 for reading in readings)
    steps = np.abs(np.diff(readings))
    assert (steps > 100).sum() > 2 * 10 * 300 / 1023 * 6.18 / COUNT / TURN, "more than the jumps of a wrapping counter"


def test_the_arm_in_a_pipe_moves_as_the_backend_says() -> None:
    robot = load_robot("basic")
    arm = default_arm(robot, "bus", ScannerConfig(driver="scip2", port="scanner"), None)
    pipe, q = PipeCorner.of(120, 90), np.zeros(4)
    plant = PipePlant(robot, arm, open_simulator("mujoco", robot, 1, {"threads": 1}), pipe, ArmStart(q, -0.6))
    goals = np.array([0.02, 0.1, -0.1, 0.1])
    actuators = [ServoCommand(round(s.to_counts(g)), 250, 0.3) for s, g in zip(arm.servos, goals, strict=True)]
    plant.command(1.0, actuators)
    start = [shaft.position for shaft in plant.shafts(1.0)]
    assert start == pytest.approx([servo.to_counts(0.0) for servo in arm.servos])
    for k in range(1, 12):
        plant.command(1.0 + 0.1 * k, actuators)
    shafts = plant.shafts(2.15)
    assert [s.to_position(shaft.position) for s, shaft in zip(arm.servos, shafts, strict=True)] == pytest.approx(
        goals, abs=0.01
    )
    assert np.isfinite(plant.distances(2.15, np.zeros(1))).all()


def test_a_joint_in_the_pipe_without_torque_stays() -> None:
    robot = load_robot("basic")
    arm = default_arm(robot, "bus", ScannerConfig(driver="scip2", port="scanner"), None)
    plant = PipePlant(
        robot, arm, open_simulator("mujoco", robot, 1, {}), PipeCorner.of(120, 90), ArmStart(np.zeros(4), -0.6)
    )
    plant.command(1.0, [ServoCommand(700, 250, 0.0)] * 4)
    for k in range(5):
        positions = [shaft.position for shaft in plant.shafts(1.0 + 0.1 * k)]
    assert positions == pytest.approx([servo.to_counts(0.0) for servo in arm.servos], abs=1)
