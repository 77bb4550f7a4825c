"""Actions as commands, equation by equation."""

from __future__ import annotations

import numpy as np
import pytest

from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.action import position_step, to_command
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("basic")
LEFT = np.ones(1)


def test_torque_actions_eq_3_3() -> None:
    command = to_command(ROBOT, ReachConfig(control="torque"), np.array([[0.5, -3.0, 0, 1]]), np.zeros((1, 4)), LEFT)
    assert command.control == "torque"
    assert command.values[0] == pytest.approx([0.5, -1.0, 0.0, 1.0])  # clipped


def test_position_actions_eq_3_4_and_3_5() -> None:
    # alpha = 0.2: a hinge moves by 0.2 rad * a, the slide by 0.2 * 0.1 m * a = v0 of 5.3.1.
    config = ReachConfig(control="position")
    q = np.array([[0.1, 0.3, -0.3, 2.35]])
    command = to_command(ROBOT, config, np.array([[1.0, 0.5, -1.0, 1.0]]), q, LEFT)
    assert config.alpha == 0.2
    assert position_step(ROBOT, config) == pytest.approx([0.02, 0.2, 0.2, 0.2])
    assert command.control == "position"
    assert command.values[0] == pytest.approx([0.12, 0.4, -0.5, 2.4])  # the last at its limit
