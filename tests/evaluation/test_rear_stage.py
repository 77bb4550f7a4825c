"""The rear half leaves the corner by the mirrored motion of the front half."""

from __future__ import annotations

import numpy as np
import pytest

from pipenav.arrays import Ints
from pipenav.backends.simulators import open_simulator
from pipenav.evaluation.rear_stage import RearStage
from pipenav.motions import follower
from pipenav.motions.mirror import rear_motion
from pipenav.motions.trajectory import Motion, Trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.testing import KinematicBackend, KinematicOptions

ROBOT = load_robot("basic")
FAST = {"timestep": 0.005, "threads": 1}


def run(stage: RearStage) -> tuple[list[str], list[int]]:
    """Outcome of the first episode of every robot, and its number of steps."""
    stage.start(np.arange(stage.n))
    outcome, steps = np.zeros(stage.n, int), np.zeros(stage.n, int)
    while not outcome.all():
        step = stage.step()
        running = outcome == Outcome.RUNNING
        steps[running] = stage.steps[running]
        outcome[running] = step.outcome[running]
    stage.close()
    return [Outcome(one).label for one in outcome], steps.tolist()


def test_the_rear_leaves_the_corner(front: Trajectory) -> None:
    rear = rear_motion(ROBOT, front.motion)
    ends, steps = run(
        RearStage(ROBOT, open_simulator("mujoco", ROBOT, 3, FAST), 3, lambda indices: [rear] * len(indices))
    )
    assert ends == ["reached"] * 3
    assert max(steps) <= follower.PATIENCE * (len(rear.q) - 1) + follower.SLACK


def test_each_robot_replays_its_own_motion_anew_after_each_start(front: Trajectory) -> None:
    rear = rear_motion(ROBOT, front.motion)
    slow = rear._replace(q=np.repeat(rear.q, 2, axis=0))
    given: list[list[int]] = []

    def source(indices: Ints) -> list[Motion]:
        given.append(indices.tolist())
        return [rear if robot % 2 == 0 else slow for robot in indices]

    stage = RearStage(ROBOT, KinematicBackend(ROBOT, 4, KinematicOptions()), 4, source)
    stage.start(np.arange(4))
    for _ in range(5):
        step = stage.step()
    assert step.q[[0, 2]] == pytest.approx(np.stack([rear.q[5]] * 2))
    assert step.q[[1, 3]] == pytest.approx(np.stack([slow.q[5]] * 2))
    stage.start(np.array([1, 2]))
    step = stage.step()
    assert given == [[0, 1, 2, 3], [1, 2]]
    assert stage.steps.tolist() == [6, 1, 1, 6]
    assert step.q == pytest.approx(np.stack([rear.q[6], slow.q[1], rear.q[1], slow.q[6]]))


def test_an_arm_that_stays_in_the_corner_times_out() -> None:
    bent = np.tile([0.2, 0.3, 0.3, 0.3], (4, 1))
    motion = Motion(PipeCorner.of(120, 90), -0.5, bent)
    stage = RearStage(ROBOT, KinematicBackend(ROBOT, 1, KinematicOptions()), 1, lambda _: [motion])
    assert run(stage) == (["timeout"], [3 * follower.PATIENCE + follower.SLACK])


def test_a_joint_at_its_limit_and_a_link_in_the_wall_end_it() -> None:
    pipe = PipeCorner.of(120, 90)
    at_limit = Motion(pipe, -0.5, np.array([[0.0, 0.0, 0.0, 2.39]] * 2))
    stage = RearStage(ROBOT, KinematicBackend(ROBOT, 1, KinematicOptions()), 1, lambda _: [at_limit])
    assert run(stage) == (["limit"], [1])
    in_wall = Motion(pipe, -0.5, np.array([[0.0, 0.5, 0.0, 0.0]] * 2))
    assert run(RearStage(ROBOT, open_simulator("mujoco", ROBOT, 1, FAST), 1, lambda _: [in_wall])) == (
        ["penetration"],
        [1],
    )
