"""Laws about readings and the truth: their shapes and bounds, and that they fit each other and the pipe."""

from __future__ import annotations

import numpy as np

from pipenav.backends.backend import CONTROL_PERIOD, Simulator
from pipenav.backends.messages import Command
from pipenav.robots import kinematics, laser
from pipenav.testing.bench import Bench, starts
from pipenav.testing.laws import require, require_same, state_of

TIP_TOLERANCE = 1e-4
"""Distance allowed between a simulator's tip and the tip of its own joint positions [m, rad]: single precision."""


def check_readings_finite_and_shaped(bench: Bench) -> None:
    """Readings and the truth have the shapes, types and bounds that `Reading` and `Truth` promise."""
    n, joints, lidar = bench.n, len(bench.robot.joints), bench.robot.laser
    signed = {"q", "qd", "tip", "link_forces", "wheel_speeds", "loads"}
    shapes = {"q": (n, joints), "qd": (n, joints), "ranges": (n, lidar.beams), "time": (n,), "tip": (n, 3)}
    shapes |= {"link_forces": (n, len(bench.robot.links), 2), "loads": (n, len(bench.robot.driven_actuators))}
    shapes["wheel_speeds"] = (n, len(bench.robot.wheels))
    with bench.open() as subject:
        subject.reset(*starts(bench))
        for command in [None, *bench.commands(20)]:
            if command:
                subject.step(command)
            for name, values in state_of(subject).items():
                expected = shapes.get(name, (n,))
                require(values.shape == expected, f"{name} has shape {values.shape}, expected {expected}")
                require(values.dtype == np.float64, f"{name} is of {values.dtype}, expected float64")
                require(bool(np.isfinite(values).all()), f"{name} is not finite: {values}")
                if name not in signed:
                    require(bool((values >= 0).all()), f"{name} is negative: {values}")
            ranges = subject.read().ranges
            fits = (ranges >= lidar.range_min) & (ranges <= lidar.range_max)
            require(bool(fits.all()), f"ranges leave {lidar.range_min:g} to {lidar.range_max:g} m: {ranges}")


def check_reset_reads_what_read_reads(bench: Bench) -> None:
    """A reset returns the readings of the robots that it names, as `read` gives them."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        for command in bench.commands(3):
            subject.step(command)
        again, chosen = starts(bench, seed=1), np.arange(0, bench.n, 2)
        given, read = subject.reset(*again.part(chosen)), subject.read().part(chosen)
        require_same(given.measured(), read.measured(), "what a reset returns and what is read after")


def check_nothing_constant(bench: Bench) -> None:
    """Every joint, speed, beam and tip coordinate changes at some time."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        seen = []
        for command in bench.commands(40):
            subject.step(command)
            seen.append(state_of(subject))
    for name in ("q", "qd", "ranges", "time", "tip"):
        if name in seen[0]:
            values = np.concatenate([state[name].reshape(bench.n, -1) for state in seen])
            constant = np.flatnonzero(np.ptp(values, axis=0) == 0)
            require(len(constant) == 0, f"{name} never changes in columns {constant}")


def check_resets_differ(bench: Bench) -> None:
    """A reset puts the joints where it says, at rest, and different starts give different readings."""
    with bench.open() as subject:
        ranges = []
        for seed in (0, 1):
            start = starts(bench, seed)
            subject.reset(*start)
            reading = subject.read()
            set_to = start.q[:, -len(bench.robot.joints) :]
            np.testing.assert_allclose(reading.q, set_to, atol=1e-6, err_msg="joint positions after a reset")
            np.testing.assert_allclose(reading.qd, 0.0, atol=1e-6, err_msg="joint speeds after a reset")
            ranges.append(reading.ranges)
    require(bool((ranges[0] != ranges[1]).any(axis=1).all()), "ranges are the same in different pipes")


def check_time_counts(bench: Bench) -> None:
    """Time is zero after a reset, for the robots that it names, and grows by the control period."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        np.testing.assert_allclose(subject.read().time, 0.0, atol=1e-9, err_msg="time after a reset")
        for command in bench.commands(5):
            subject.step(command)
        np.testing.assert_allclose(subject.read().time, 5 * CONTROL_PERIOD, rtol=1e-6, err_msg="time after 5 steps")
        subject.reset(*starts(bench).part(np.arange(1)))
        expected = [0.0] + [5 * CONTROL_PERIOD] * (bench.n - 1)
        np.testing.assert_allclose(subject.read().time, expected, atol=1e-6, err_msg="time after a reset of one robot")


def check_tip_and_ranges_fit_the_pose(bench: Bench) -> None:
    """In a simulator the tip is the tip of the joint positions, and beams end at the pipe's walls."""
    robot = bench.robot
    with bench.open() as subject:
        start = starts(bench)
        subject.reset(*start)
        for command in [None, *bench.commands(10)]:
            if command:
                subject.step(command)
            if not isinstance(subject, Simulator):
                return
            truth, reading = subject.truth(), subject.read()
            seen = truth.tip - np.column_stack([start.base, np.zeros((bench.n, 2))])
            pose = kinematics.forward(robot, kinematics.configuration(robot, reading.q, seen))
            tip = np.column_stack([pose.tip[:, 0] + start.base, pose.tip[:, 1], pose.headings[:, -1]])
            np.testing.assert_allclose(truth.tip, tip, atol=TIP_TOLERANCE, err_msg="tip in the pipe's frame")
            for i, pipe in enumerate(start.pipes):
                true = laser.cast(tip[i : i + 1, :2], tip[i : i + 1, 2:] + robot.laser.angles, pipe.segments[None])
                off = np.abs(reading.ranges[i] - laser.measure(robot.laser, true)[0])
                require(bool((off <= 1.5 * robot.laser.resolution).all()), f"beams miss the walls by {off} m")


def check_contact_force_is_the_largest_of_the_links(bench: Bench) -> None:
    """In a simulator the contact force is the force on the link that a wall pushes hardest."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        for _ in range(15):
            subject.step(Command("torque", np.ones((bench.n, len(bench.robot.driven_actuators)))))
            if not isinstance(subject, Simulator):
                return
            truth = subject.truth()
            largest = np.linalg.norm(truth.link_forces, axis=2).max(axis=1)
            message = "the contact force is not the largest force on a link"
            np.testing.assert_allclose(truth.contact_force, largest, rtol=1e-9, err_msg=message)
