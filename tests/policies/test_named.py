"""The controllers that a person may name."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.controllers import first_outcomes

from pipenav.errors import UnknownName
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.named import RandomController, open_controller
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("basic")


def test_random_is_reproducible_by_its_seed() -> None:
    observation = np.zeros((5, 3))

    one, same, other = (RandomController(ROBOT, seed) for seed in (3, 3, 4))
    first = one.act(observation)
    np.testing.assert_array_equal(same.act(observation), first)
    assert not np.array_equal(other.act(observation), first)
    assert not np.array_equal(one.act(observation), first)
    assert first.shape == (5, 4)
    assert np.abs(first).max() <= 1.0


def test_random_seldom_passes() -> None:
    outcomes = first_outcomes(open_controller("baseline:random", seed=1), [PipeCorner.of(80, 60)], 8)
    assert outcomes.count("reached") <= 1


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(UnknownName, match="did you mean 'baseline:random'"):
        open_controller("baseline:randm")
    with pytest.raises(UnknownName, match="unknown robot"):
        open_controller("baseline:random", "no-such-robot")
    with pytest.raises(UnknownName, match="unknown policy"):
        open_controller("no-such-policy")


def test_every_baseline_says_its_task() -> None:
    assert open_controller("baseline:centreline").task.control == "position"
    assert open_controller("baseline:random").task == ReachConfig()
