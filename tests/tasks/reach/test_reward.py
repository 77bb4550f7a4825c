"""The reward's terms, equation by equation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipenav.tasks.reach import reward
from pipenav.tasks.reach.config import RewardConfig
from pipenav.tasks.reach.reward import StepFacts


def facts(error: float = 0.018, nearest: float = 0.199, change: float = 0.199, failed: bool = False) -> StepFacts:
    """A step of one robot; the defaults make eq 3.8 equal ln 0.1 and eq 3.10 and 3.14 equal -1."""
    one, ranges = np.ones(1), np.full((1, 10), 0.4)
    ranges[0, 3] = nearest
    flags = np.array([failed])
    return StepFacts(error * one, ranges, change * one, 0.01 * one, 2.0 * one, 0.001 * one, ~flags, flags)


def test_target_term_linear_eq_3_6() -> None:
    assert reward.target_linear(np.array([0.25])) == pytest.approx([-0.25])


def test_target_term_huber_eq_3_7() -> None:
    # delta = 0.1. Inner: -0.05^2 / 2 = -0.00125; at delta -0.1^2 / 2 = -0.005. The printed outer branch,
    # 0.1 * 0.3 - 0.1^2 / 2 = +0.025, lacks its sign: it would jump from -0.005 to +0.005 at delta and then reward
    # distance. With the sign: -0.025.
    assert reward.target_huber(np.array([0.05, 0.1, 0.3])) == pytest.approx([-0.00125, -0.005, -0.025])
    assert np.all(np.diff(reward.target_huber(np.linspace(0, 1, 1001))) < 0)


def test_target_term_log_eq_3_8_with_eq_3_9() -> None:
    # e = 0: -ln 0.1 + ln 0.1 = 0. e = 0.018: 50 * 0.018 + 0.1 = 1, so ln 0.1 = -2.302585.
    # e = 0.1: -ln 5.1 + ln 0.1 = -ln 51 = -3.931826.
    assert reward.target_log(np.array([0.0, 0.018, 0.1])) == pytest.approx([0.0, -2.302585, -3.931826])


def test_laser_term_eq_3_10_with_eq_3_11() -> None:
    # min D = 0.199: 5 * 0.199 + 0.005 = 1, so -1. min D = 0.005: 0.03, so -33.3333.
    # real-setup (5.4.1), beta = 1, d0 = 0.001: min D = 0.099 gives -1 / 0.1 = -10.
    ranges = np.array([[0.4, 0.199, 0.5], [0.005, 0.3, 0.3]])
    assert reward.laser(ranges, 5.0, 0.005) == pytest.approx([-1.0, -100 / 3])
    assert reward.laser(np.array([[0.099, 0.4]]), 1.0, 0.001) == pytest.approx([-10.0])
    assert (RewardConfig().beta, RewardConfig().d0) == (5.0, 0.005)


def test_joint_change_term_eq_3_14() -> None:
    # J = 0.199: 5 * 0.199 + 0.005 = 1, so -1. A robot that is stuck, J = 0: -1 / 0.005 = -200.
    assert reward.joint_change(np.array([0.199, 0.0])) == pytest.approx([-1.0, -200.0])


def test_basic_total_eq_3_12() -> None:
    # 1.5 * ln 0.1 + 0.4 * (-1) = -3.453878 - 0.4.
    config = RewardConfig(c1=1.5, c2=0.4)
    assert reward.total(config, facts()) == pytest.approx([1.5 * math.log(0.1) - 0.4])


def test_limit_total_eq_3_13() -> None:
    assert reward.total(RewardConfig(), facts(failed=True)) == pytest.approx([-1000.0])


def test_advanced_total_eq_3_15() -> None:
    # 1.5 * ln 0.1 + 0.1 * (-1) + 1.5 * (-1).
    config = RewardConfig(c1=1.5, c2=0.1, c3=1.5)
    assert reward.total(config, facts()) == pytest.approx([1.5 * math.log(0.1) - 0.1 - 1.5])


def test_our_own_terms() -> None:
    # progress 20 / m * 0.01 m, reach 5, step -0.1, force -0.05 / N * 2 N, penetration -1 / mm * 1 mm: 4.0, times 2.
    config = RewardConfig(c1=0, c2=0, progress=20, reach=5, step=-0.1, force=-0.05, penetration=-1.0, scale=2.0)
    assert reward.total(config, facts()) == pytest.approx([2 * (0.2 + 5.0 - 0.1 - 0.1 - 1.0)])
