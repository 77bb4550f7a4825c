"""The laws that every backend keeps. A check raises AssertionError, in words, where one is broken."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD, Backend, Simulator
from pipenav.backends.messages import Command
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import kinematics, laser
from pipenav.testing.bench import Bench, starts

LIMIT_SLACK = 0.02
"""Share of a joint's travel by which a backend may overstep its limits: those of simulators are soft."""

SPEED_SLACK = 2.0
"""Share of the no-load speed by which a joint may exceed it, swept along by its neighbours or let go by a wall."""

TIP_TOLERANCE = 1e-4
"""How far a simulator's tip may be from the tip of its own joint positions [m, rad]; room for single precision."""


def check_same_seed_same_trajectory(bench: Bench) -> None:
    """Two backends, treated alike, give the same numbers to the last bit."""
    with bench.open() as one, bench.open() as other:
        one.reset(*starts(bench))
        other.reset(*starts(bench))
        for command in bench.commands(25):
            one.step(command)
            other.step(command)
            _same(_state(one), _state(other), "two backends under the same commands")


def check_reset_forgets_the_past(bench: Bench) -> None:
    """A used robot, once reset, moves as a new one does."""
    with bench.open() as used, bench.open() as new:
        used.reset(*starts(bench, seed=1))
        for command in bench.commands(15, seed=1):
            used.step(command)
        for simulator in (used, new):
            simulator.reset(*starts(bench))
        _same(_state(used), _state(new), "a used and a new backend after reset")
        for command in bench.commands(15):
            used.step(command)
            new.step(command)
            _same(_state(used), _state(new), "a used and a new backend under the same commands")


def check_readings_finite_and_shaped(bench: Bench) -> None:
    """Shapes, types and bounds are those that `Reading` and `Truth` promise."""
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
            for name, values in _state(subject).items():
                expected = shapes.get(name, (n,))
                _require(values.shape == expected, f"{name} has shape {values.shape}, expected {expected}")
                _require(values.dtype == np.float64, f"{name} is of {values.dtype}, expected float64")
                _require(bool(np.isfinite(values).all()), f"{name} is not finite: {values}")
                if name not in signed:
                    _require(bool((values >= 0).all()), f"{name} is negative: {values}")
            ranges = subject.read().ranges
            fits = (ranges >= lidar.range_min) & (ranges <= lidar.range_max)
            _require(bool(fits.all()), f"ranges leave {lidar.range_min:g} to {lidar.range_max:g} m: {ranges}")


def check_reset_reads_what_read_reads(bench: Bench) -> None:
    """A reset returns the readings of the robots that it named, as `read` gives them."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        for command in bench.commands(3):
            subject.step(command)
        again, chosen = starts(bench, seed=1), np.arange(0, bench.n, 2)
        given = subject.reset(chosen, [again.pipes[k] for k in chosen], again.q[chosen], again.base[chosen])
        _same(given.measured(), subject.read().part(chosen).measured(), "what a reset returns and what is read after")


def check_contact_force_is_the_largest_of_the_links(bench: Bench) -> None:
    """Driven into a wall, the contact force is that of the link that is pushed hardest."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        for _ in range(15):
            subject.step(Command("torque", np.ones((bench.n, len(bench.robot.driven_actuators)))))
            if not isinstance(subject, Simulator):
                return
            truth = subject.truth()
            largest = np.linalg.norm(truth.link_forces, axis=2).max(axis=1)
            np.testing.assert_allclose(truth.contact_force, largest, rtol=1e-9, err_msg="contact force")


def check_no_shared_memory(bench: Bench) -> None:
    """What was read never changes afterwards, and what the caller does to arrays changes nothing inside."""
    with bench.open() as subject, bench.open() as twin:
        start = starts(bench)
        subject.reset(*start)
        twin.reset(*starts(bench))
        start.q[:], start.base[:] = 1e3, 1e3
        for command, spoilt in zip(bench.commands(5), bench.commands(5), strict=True):
            before = _state(subject)
            kept = {name: values.copy() for name, values in before.items()}
            subject.step(spoilt)
            spoilt.values[:] = 1e3
            _same(before, kept, "what was read before a step and after it")
            for values in _state(subject).values():
                values[...] = 1e3
            twin.step(command)
            _same(_state(subject), _state(twin), "a backend whose arrays the caller wrote into, and its twin")


def check_nothing_constant(bench: Bench) -> None:
    """Every joint, speed, beam and tip coordinate moves at some time."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        seen = []
        for command in bench.commands(40):
            subject.step(command)
            seen.append(_state(subject))
    for name in ("q", "qd", "ranges", "time", "tip"):
        if name in seen[0]:
            values = np.concatenate([state[name].reshape(bench.n, -1) for state in seen])
            constant = np.flatnonzero(np.ptp(values, axis=0) == 0)
            _require(len(constant) == 0, f"{name} never changes in columns {constant}")


def check_resets_differ(bench: Bench) -> None:
    """A reset puts the joints where it says, at rest, and other starts read differently."""
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
    _require(bool((ranges[0] != ranges[1]).any(axis=1).all()), "ranges are the same in different pipes")


def check_reset_touches_only_named_robots(bench: Bench) -> None:
    """Robots that are not named go on exactly as if nothing had happened."""
    chosen, others = np.arange(1, bench.n, 2), np.arange(0, bench.n, 2)
    with bench.open() as subject, bench.open() as undisturbed:
        for simulator in (subject, undisturbed):
            simulator.reset(*starts(bench))
        for i, command in enumerate(bench.commands(12)):
            if i == 6:
                again = starts(bench, seed=1)
                subject.reset(chosen, [again.pipes[k] for k in chosen], again.q[chosen], again.base[chosen])
            subject.step(command)
            undisturbed.step(command)
            mine, theirs = _state(subject), _state(undisturbed)
            _same(
                {k: v[others] for k, v in mine.items()}, {k: v[others] for k, v in theirs.items()}, "robots not reset"
            )


def check_time_counts(bench: Bench) -> None:
    """Time is zero after a reset, of the robots that were reset, and grows by the control period."""
    with bench.open() as subject:
        subject.reset(*starts(bench))
        np.testing.assert_allclose(subject.read().time, 0.0, atol=1e-9)
        for command in bench.commands(5):
            subject.step(command)
        np.testing.assert_allclose(subject.read().time, 5 * CONTROL_PERIOD, rtol=1e-6)
        first = starts(bench)
        subject.reset(first.indices[:1], first.pipes[:1], first.q[:1], first.base[:1])
        np.testing.assert_allclose(subject.read().time, [0.0] + [5 * CONTROL_PERIOD] * (bench.n - 1), atol=1e-6)


def check_limits_respected(bench: Bench) -> None:
    """Full drives push no joint past its limits, nor much faster than its actuator turns without load."""
    robot = bench.robot
    slack = LIMIT_SLACK * (robot.upper - robot.lower)
    with bench.open() as subject:
        for direction in (-1.0, 1.0):
            subject.reset(*starts(bench))
            for _ in range(40):
                subject.step(Command("torque", np.full((bench.n, len(robot.driven_actuators)), direction)))
                q, qd = subject.read()[:2]
                inside = (q >= robot.lower - slack) & (q <= robot.upper + slack)
                _require(bool(inside.all()), f"joints pass their limits: {q}")
                slow = np.abs(qd) <= (1 + SPEED_SLACK) * robot.speed_limits
                _require(bool(slow.all()), f"joints pass their top speed: {qd}")


def check_commands_move_the_right_way(bench: Bench) -> None:
    """A positive drive increases its joint's position; a set-point in free space is reached."""
    joints, actuators = len(bench.robot.joints), len(bench.robot.driven_actuators)
    with bench.open() as subject:
        for joint in range(joints):
            subject.reset(*starts(bench))
            before = subject.read().q
            subject.step(Command("torque", np.tile(0.3 * np.eye(actuators)[joint], (bench.n, 1))))
            moved = subject.read().q[:, joint] - before[:, joint]
            _require(bool((moved > 0).all()), f"a positive drive moves joint {joint} by {moved}")
        subject.reset(*starts(bench))
        set_points = starts(bench, seed=2).q[:, -joints:]
        standing = np.zeros((bench.n, actuators - joints))  # the wheels'
        for _ in range(20):
            subject.step(Command("position", np.concatenate([set_points, standing], axis=1)))
        np.testing.assert_allclose(subject.read().q, set_points, atol=2e-3, err_msg="set-points are not reached")


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
                _require(bool((off <= 1.5 * robot.laser.resolution).all()), f"beams miss the walls by {off} m")


def check_left_and_right_mirror(bench: Bench) -> None:
    """A right turn under mirrored commands is the mirror image of a left one."""
    robot = bench.robot
    with bench.open() as left, bench.open() as right:
        for turn_sign, subject in ((1.0, left), (-1.0, right)):
            start = starts(bench)
            turn = "left" if turn_sign > 0 else "right"
            pipes = [pipe.model_copy(update={"turn": turn}) for pipe in start.pipes]
            subject.reset(
                start.indices, pipes, start.q * np.where(turn_sign > 0, 1.0, robot.mirror_coordinates), start.base
            )
        for command in bench.commands(3, "position"):
            left.step(command)
            right.step(Command("position", command.values * robot.mirror_drives))
        np.testing.assert_allclose(right.read().q, left.read().q * robot.mirror_signs, atol=1e-3)


def check_too_many_walls_refused(bench: Bench) -> None:
    """A pipe with more wall segments than the backend was opened for is refused in one sentence."""
    bend = PipeCorner.of(100, 90, bend_radius_mm=100)
    start = starts(bench)
    with bench.open(wall_segments=4) as subject:
        try:
            subject.reset(start.indices, [bend] * bench.n, start.q, start.base)
        except PipenavError as error:
            _require(str(len(bend.segments)) in str(error), f"the error does not say how many walls: {error}")
        else:
            raise AssertionError(f"a pipe of {len(bend.segments)} wall segments was accepted by a backend for 4")
    with bench.open(wall_segments=len(bend.segments)) as subject:
        subject.reset(start.indices, [bend] * bench.n, start.q, start.base)


def check_closes_twice(bench: Bench) -> None:
    """Closing again is harmless, used or not."""
    with bench.open() as unused:
        unused.close()
    with bench.open() as used:
        used.reset(*starts(bench))
        used.step(bench.commands(1)[0])
        used.close()
        used.close()


CONTRACT: list[Callable[[Bench], None]] = [
    check_same_seed_same_trajectory,
    check_reset_forgets_the_past,
    check_readings_finite_and_shaped,
    check_reset_reads_what_read_reads,
    check_contact_force_is_the_largest_of_the_links,
    check_no_shared_memory,
    check_nothing_constant,
    check_resets_differ,
    check_reset_touches_only_named_robots,
    check_time_counts,
    check_limits_respected,
    check_commands_move_the_right_way,
    check_tip_and_ranges_fit_the_pose,
    check_left_and_right_mirror,
    check_too_many_walls_refused,
    check_closes_twice,
]
"""Every law; each check raises AssertionError when a backend breaks it."""


def _state(subject: Backend) -> dict[str, Floats]:
    """All that a backend tells, by the names of its fields."""
    truth = subject.truth()._asdict() if isinstance(subject, Simulator) else {}
    return {**subject.read().measured(), **truth}


def _same(one: dict[str, Floats], other: dict[str, Floats], who: str) -> None:
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=f"{name} differs between {who}")


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise AssertionError(message)
