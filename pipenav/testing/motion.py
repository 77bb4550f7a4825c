"""Laws about motion: commands move joints the right way, within their limits, between the walls of the pipe."""

from __future__ import annotations

import numpy as np

from pipenav.backends.messages import Command
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.testing.bench import Bench, starts
from pipenav.testing.laws import require

LIMIT_SLACK = 0.02
"""Share of a joint's travel by which a backend may overstep its limits: the limits of simulators are soft."""

SPEED_SLACK = 2.0
"""Share of the no-load speed by which a joint may exceed it, swept along by its neighbours or let go by a wall."""


def check_limits_respected(bench: Bench) -> None:
    """Full duty moves no joint past its limits, nor much faster than its actuator turns without load."""
    robot = bench.robot
    slack = LIMIT_SLACK * (robot.upper - robot.lower)
    with bench.open() as subject:
        for direction in (-1.0, 1.0):
            subject.reset(*starts(bench))
            for _ in range(40):
                subject.step(Command("torque", np.full((bench.n, len(robot.driven_actuators)), direction)))
                q, qd = subject.read()[:2]
                inside = (q >= robot.lower - slack) & (q <= robot.upper + slack)
                require(bool(inside.all()), f"joints pass their limits: {q}")
                slow = np.abs(qd) <= (1 + SPEED_SLACK) * robot.speed_limits
                require(bool(slow.all()), f"joints pass their top speed: {qd}")


def check_commands_move_the_right_way(bench: Bench) -> None:
    """A positive duty increases its joint's position; a set-point in free space is reached."""
    joints, actuators = len(bench.robot.joints), len(bench.robot.driven_actuators)
    with bench.open() as subject:
        for joint in range(joints):
            subject.reset(*starts(bench))
            before = subject.read().q
            subject.step(Command("torque", np.tile(0.3 * np.eye(actuators)[joint], (bench.n, 1))))
            moved = subject.read().q[:, joint] - before[:, joint]
            require(bool((moved > 0).all()), f"a positive duty moves joint {joint} by {moved}")
        subject.reset(*starts(bench))
        set_points = starts(bench, seed=2).q[:, -joints:]
        wheels = np.zeros((bench.n, actuators - joints))
        for _ in range(20):
            subject.step(Command("position", np.concatenate([set_points, wheels], axis=1)))
        np.testing.assert_allclose(subject.read().q, set_points, atol=2e-3, err_msg="set-points are not reached")


def check_left_and_right_mirror(bench: Bench) -> None:
    """A right turn under mirrored commands is the mirror image of a left one."""
    robot = bench.robot
    with bench.open() as left, bench.open() as right:
        for turn_sign, subject in ((1.0, left), (-1.0, right)):
            start = starts(bench)
            turn = "left" if turn_sign > 0 else "right"
            pipes = [pipe.model_copy(update={"turn": turn}) for pipe in start.pipes]
            q = start.q * np.where(turn_sign > 0, 1.0, robot.mirror_coordinates)
            subject.reset(start.indices, pipes, q, start.base)
        for command in bench.commands(3, "position"):
            left.step(command)
            right.step(Command("position", command.values * robot.mirror_actuators))
        mirrored = left.read().q * robot.mirror_signs
        np.testing.assert_allclose(right.read().q, mirrored, atol=1e-3, err_msg="joints in mirrored pipes")


def check_too_many_walls_refused(bench: Bench) -> None:
    """A pipe with more wall segments than the backend was opened for is refused in one sentence."""
    bend = PipeCorner.of(100, 90, bend_radius_mm=100)
    start = starts(bench)
    with bench.open(wall_segments=4) as subject:
        try:
            subject.reset(start.indices, [bend] * bench.n, start.q, start.base)
        except PipenavError as error:
            require(str(len(bend.segments)) in str(error), f"the error does not say how many walls: {error}")
        else:
            raise AssertionError(f"a pipe of {len(bend.segments)} wall segments was accepted by a backend for 4")
    with bench.open(wall_segments=len(bend.segments)) as subject:
        subject.reset(start.indices, [bend] * bench.n, start.q, start.base)
