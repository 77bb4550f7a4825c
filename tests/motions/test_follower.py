"""Playing back a path: pose after pose, never ahead of the arm, and a little back where it is caught."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pipenav.motions.follower import CAUGHT, FOLLOWING, PATIENCE, SLACK, Follower
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")
PERIOD = 0.1
REACH = ROBOT.speed_limits * PERIOD


def path(rows: int, step: float = 0.5) -> np.ndarray:
    """Poses so far apart, as a share of the fastest motion in a tick, every joint alike."""
    return np.arange(rows)[:, None] * step * REACH


def follower(poses: np.ndarray, n: int = 1) -> Follower:
    made = Follower(ROBOT, n, PERIOD)
    made.start(np.arange(n), [poses] * n)
    return made


@settings(deadline=None)
@given(rows=st.integers(2, 12), late=st.integers(0, 2))
def test_an_arm_that_keeps_up_gets_every_pose_once_and_in_order(rows: int, late: int) -> None:
    poses = path(rows)
    one, sent = follower(poses), [poses[0]] * (late + 1)
    for _ in range(rows + late):
        sent.append(one.act(sent[-1 - late][None])[0])
    assert np.array(sent[late + 1 : late + rows]) == pytest.approx(poses[1:])
    assert one.at_last[0]
    assert sent[-1] == pytest.approx(poses[-1])


@settings(deadline=None)
@given(lag=st.floats(0, 4))
def test_the_next_pose_waits_for_the_slowest_joint(lag: float) -> None:
    assume(abs(lag - FOLLOWING) > 1e-6)
    poses = path(5)
    one, q = follower(poses), poses[0].copy()
    q[2] -= lag * REACH[2]
    one.act(q[None])
    assert one.rows[0] == (1 if lag <= FOLLOWING else 0)


def test_a_caught_arm_goes_back_each_time_farther() -> None:
    poses = path(12, step=0.9)
    one, rows = follower(poses), []
    for _ in range(80):
        q = np.minimum(one.act(poses[min(int(one.rows[0]), 3)][None]), poses[3])  # it never gets beyond pose 3
        rows.append(int(one.rows[0]))
    assert max(rows) == 3 + int(FOLLOWING / 0.9) + 1  # the first pose that is too far away
    turns = [after - before for before, after in pairwise(rows) if after < before]
    assert turns[:3] == [-1, -2, -3]
    assert min(rows[10:]) == 0
    assert (q <= poses[3]).all()


def test_a_pose_is_held_for_so_long() -> None:
    poses = path(8, step=0.9)
    one, rows = follower(poses), []
    first_too_far = int(FOLLOWING / 0.9) + 1
    for _ in range(first_too_far + CAUGHT):
        one.act(poses[0][None])
        rows.append(int(one.rows[0]))
    assert rows == [*range(1, first_too_far + 1), *[first_too_far] * (CAUGHT - 1), first_too_far - 1]


def test_arms_start_anew_one_by_one() -> None:
    one = Follower(ROBOT, 3, PERIOD)
    one.start(np.arange(3), [path(4), path(6), path(2)])
    assert one.patience.tolist() == [PATIENCE * last + SLACK for last in (3, 5, 1)]
    for _ in range(3):
        one.act(one.act(np.zeros((3, 4))) * 0)
    before = one.rows.copy()
    one.start(np.array([1]), [path(9)])
    assert one.rows.tolist() == [before[0], 0, before[2]]
    assert one.patience[1] == PATIENCE * 8 + SLACK
