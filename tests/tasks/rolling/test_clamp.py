"""Which robots can clamp themselves for a roll."""

from __future__ import annotations

import pytest

from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot
from pipenav.tasks.rolling.clamp import check_robot


def test_only_a_robot_of_two_halves_rolls() -> None:
    with pytest.raises(PipenavError, match=r"robot 'basic' cannot roll: .*: choose --robot pirate"):
        check_robot(load_robot("basic"))
