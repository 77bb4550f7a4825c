"""Terms of the reward, one function each; equation numbers are the thesis's."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.tasks.reach.config import RewardConfig

LOG_SLOPE, LOG_OFFSET = 50.0, 0.1
"""alpha [1/m] and c of eq 3.8, from eq 3.9."""

HUBER_DELTA = 0.1
"""delta of eq 3.7 [m]; the thesis gives none. Quadratic within the last decimetre."""

JOINT_SLOPE, JOINT_OFFSET = 5.0, 0.005
"""Constants of eq 3.14."""


class StepFacts(NamedTuple):
    """Quantities that the reward of one control step depends on.

    Attributes:
        error: distance from the tip to the target, (n,) [m].
        ranges: laser readings, (n, beams) [m].
        joint_change: sum over the joints of |q_t - q_(t-1)|, (n,) [rad + m].
        progress: length by which the step shortened the path to the target, (n,) [m].
        contact_force: peak contact force of the step, (n,) [N].
        penetration: deepest overlap with the wall in the step, (n,) [m].
        reached: whether the target was reached, (n,).
        failed: whether the step ended at a joint limit or in a wall, (n,).
    """

    error: Floats
    ranges: Floats
    joint_change: Floats
    progress: Floats
    contact_force: Floats
    penetration: Floats
    reached: Flags
    failed: Flags


def target_linear(error: Floats) -> Floats:
    """Linear target term, eq 3.6."""
    return -error


def target_huber(error: Floats) -> Floats:
    """Huber target term, eq 3.7, minus the Huber loss on both branches (in print, the outer branch lacks its sign)."""
    inner = -0.5 * error**2
    outer = -(HUBER_DELTA * error - 0.5 * HUBER_DELTA**2)
    return np.asarray(np.where(error <= HUBER_DELTA, inner, outer))


def target_log(error: Floats) -> Floats:
    """Logarithmic target term, eq 3.8 with eq 3.9."""
    return np.asarray(-np.log(LOG_SLOPE * error + LOG_OFFSET) + np.log(LOG_OFFSET))


def laser(ranges: Floats, beta: float, d0: float) -> Floats:
    """Laser term, eq 3.10, (n, beams) -> (n,)."""
    return np.asarray(-1.0 / (beta * ranges.min(axis=1) + d0))


def joint_change(change: Floats) -> Floats:
    """Joint-change term, eq 3.14."""
    return np.asarray(-1.0 / (JOINT_SLOPE * change + JOINT_OFFSET))


TARGET_TERMS = {"linear": target_linear, "huber": target_huber, "log": target_log}


def total(config: RewardConfig, facts: StepFacts) -> Floats:
    """Sum of all terms, (n,): eq 3.12 (c3 = 0) and eq 3.15, then our own terms where their weights are not zero."""
    reward = np.full(len(facts.error), config.step)
    if config.c1:
        reward = reward + config.c1 * TARGET_TERMS[config.target](facts.error)
    if config.c2:
        reward = reward + config.c2 * laser(facts.ranges, config.beta, config.d0)
    if config.c3:
        reward = reward + config.c3 * joint_change(facts.joint_change)
    reward = reward + config.progress * facts.progress + config.reach * facts.reached
    reward = reward + config.force * facts.contact_force + config.penetration * 1e3 * facts.penetration
    return np.asarray(config.scale * np.where(facts.failed, config.limit, reward))
