"""Legs that a robot cannot reach are left out of its collisions, which alters no number."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from pipenav_mujoco import leg_boxes
from pipenav_mujoco.space_batch import SpaceBatch

from pipenav.arrays import Floats, Ints
from pipenav.backends.simulators import open_space
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import load_robot

ROBOT = load_robot("pirate-strong")
ROUTES = [
    PipeRoute.of(90, [(90, "left", 0), (75, "right", 90), (120, "left", 90, 150)], [2500, 700, 700, 800]),
    PipeRoute.of(110, [(60, "right", 30)], [2500, 900]),
]


def motion(gravity: float, steps: int) -> Floats:
    """Points of two robots that fall along x and roll forwards, at every step."""
    q = np.zeros((2, ROBOT.coordinates))
    q[:, 3:] = [[0.3, -0.6, 0.6, -0.6, 0.6, -0.3]] * 2
    speeds = np.concatenate([q[:, 3:], -5.0 * np.sign(q[:, 3:])], axis=1)
    with closing(open_space("mujoco", ROBOT, 2, {})) as backend:
        backend.incline(np.arange(2), np.array([[gravity, 0.0, -1.0], [gravity, 1.0, 0.0]]))
        backend.reset(np.arange(2), ROUTES, q, np.array([-2.0, -1.6]), np.array([0.0, 1.0]))
        points = []
        for _ in range(steps):
            backend.step(speeds, np.array([0.1, -0.1]))
            points.append(backend.truth().points)
    return np.array(points)


@pytest.mark.parametrize(("gravity", "hurries"), [(0.5, False), (9.81, True)])
def test_left_out_legs_alter_no_number(gravity: float, hurries: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    left_out, repeated = [], []
    near, repeat = leg_boxes.LegBoxes.within_reach, SpaceBatch.repeat

    def counted(self: leg_boxes.LegBoxes, points: Floats) -> Floats:
        left_out.append((~near(self, points)).sum())
        return near(self, points)

    def noted(self: SpaceBatch, indices: Ints, states: Floats) -> None:
        repeated.append(indices)
        repeat(self, indices, states)

    with monkeypatch.context() as patched:
        patched.setattr(leg_boxes.LegBoxes, "within_reach", counted)
        patched.setattr(SpaceBatch, "repeat", noted)
        some = motion(gravity, 25)
    assert sum(left_out) > 0 and bool(repeated) == hurries
    monkeypatch.setattr(leg_boxes, "PART", np.inf)
    np.testing.assert_array_equal(some, motion(gravity, 25))
