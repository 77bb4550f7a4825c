"""Recovery from jams: who counts as stuck, what a robot that recovers is told, and that others go on as they would."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.traversing import ROBOT, episodes, seeds, started
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.backends.messages import Reading
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.starts import load_starts
from pipenav.tasks.rolling.clamp import ZIGZAG, forward_directions, steepness
from pipenav.tasks.rolling.recovering import RecoveringBatch
from pipenav.tasks.rolling.recovery import IDLE, LONGEST, MAX_TRIES, SPIN, STALL, STILL, Recovery
from pipenav.tasks.traverse import observation
from pipenav.tasks.traverse.config import TraverseConfig

HELD = TraverseConfig(kind="traverse", set_points="held", recovery=True)
RADIUS = 0.05


def reading(bends: np.ndarray, wheel_speed: float = 0.0) -> Reading:
    """Readings of robots with these joints, (n, 6) [rad], whose wheels all turn forwards so fast [rad/s]."""
    speeds = wheel_speed * forward_directions(bends)
    return Reading(bends, np.zeros_like(bends), np.full((len(bends), 10), 0.2), 0.0, speeds, bends)


def steps_until_busy(bends: np.ndarray, wheel_speed: float) -> np.ndarray:
    """Control steps after which each robot that stays so recovers, (n,); 0 for those that never do."""
    recovery, begun = Recovery(ROBOT, len(bends)), np.zeros(len(bends), int)
    recovery.start(np.arange(len(bends)))
    for step in range(1, 2 * IDLE):
        recovery.sense(reading(bends, wheel_speed), np.full(len(bends), RADIUS), bends)
        begun = np.where((begun == 0) & recovery.busy, step, begun)
    return begun


@given(st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6))
def test_a_robot_at_rest_is_stuck_after_a_while(bends: list[float]) -> None:
    assert STALL <= steps_until_busy(np.array([bends]), 0.0)[0] <= STALL + 1


def test_spinning_wheels_move_a_clamped_robot_but_no_other() -> None:
    clamped = steepness(ROBOT, RADIUS) * ZIGZAG
    wedged = np.array([1.4, 1.4, 0.2, -0.1, 1.2, 0.5])
    rolls, spins = steps_until_busy(np.array([clamped, wedged]), 5.0)
    assert rolls == 0 and SPIN <= spins <= IDLE + 1


@given(st.floats(STILL * 1.1, 1.0), seeds)
def test_a_robot_that_moves_and_rolls_is_not_stuck(size: float, seed: int) -> None:
    rng, recovery = np.random.default_rng(seed), Recovery(ROBOT, 1)
    recovery.start(np.arange(1))
    for step in range(3 * IDLE):
        bends = np.full((1, 6), 0.3 + size * (step // 10 % 2)) + rng.uniform(-0.01, 0.01, (1, 6))
        recovery.sense(reading(bends, 6.0), np.full(1, RADIUS), bends)
        assert not recovery.busy[0]


@given(seeds)
def test_an_episode_does_not_depend_on_the_one_before(seed: int) -> None:
    rng = np.random.default_rng(seed)
    used, new, radius = Recovery(ROBOT, 1), Recovery(ROBOT, 1), np.full(1, RADIUS)
    for bends in rng.uniform(-1, 1, (2 * STALL, 1, 6)):
        used.sense(reading(bends, rng.uniform(-1, 1)), radius, bends)
    start = rng.uniform(-1, 1, (1, 6))
    for recovery in (used, new):
        recovery.start(np.arange(1))
    for step in range(2 * STALL):
        bends, speed = start + rng.uniform(-0.2, 0.2, (1, 6)), rng.uniform(-0.1, 0.4)
        for recovery in (used, new):
            recovery.sense(reading(bends, speed), radius, bends)
        assert used.busy[0] == new.busy[0], step


def test_a_robot_is_given_up_after_many_tries() -> None:
    bends, tries = np.full((1, 6), 0.8), 0
    recovery = Recovery(ROBOT, 1)
    recovery.start(np.arange(1))
    for _ in range((MAX_TRIES + 5) * (LONGEST + STALL + 2)):
        before = recovery.busy[0]
        recovery.sense(reading(bends), np.full(1, RADIUS), bends)
        tries += int(recovery.busy[0] and not before)
        if recovery.busy[0]:
            values = recovery.command(np.arange(1), reading(bends))[0]
            assert (values[:6] >= ROBOT.lower).all() and (values[:6] <= ROBOT.upper).all()
    assert tries == MAX_TRIES and not recovery.busy[0]


@settings(max_examples=3)
@given(seeds)
def test_robots_that_are_not_stuck_go_on_as_without_it(seed: int) -> None:
    start = episodes(HELD, seed)
    actions = np.random.default_rng(seed).uniform(-1, 1, (STALL - 1, len(start.pipes), 12))
    with started(start, HELD) as plain, started(start, HELD, RecoveringBatch) as recovering:
        for action in actions:
            a, b = plain.step(action), recovering.step(action)
            np.testing.assert_array_equal(a.observation, b.observation)
            np.testing.assert_array_equal(a.outcome, b.outcome)
            assert recovering.driven.all()


def test_a_robot_that_recovers_drives_itself_and_sees_what_it_did() -> None:
    start = episodes(HELD)
    still = np.zeros((len(start.pipes), 12))
    with started(start, HELD, RecoveringBatch) as batch:
        for _ in range(STALL + 2):
            batch.step(still)
        assert not batch.driven.any()
        done = batch.step(np.ones_like(still))
    before, size = 0, 0
    for part in observation.layout(ROBOT, HELD):
        if part.name == "action_before":
            size = len(part.scale)
            break
        before += len(part.scale)
    told = done.observation[:, before : before + size]
    assert size == 12 and (np.abs(told) < 1).any(axis=1).all()  # not the actions that were given, which are all 1


@pytest.mark.slow
def test_most_that_are_stuck_get_out(tmp_path: Path) -> None:
    whole = load_starts("stuck-starts")
    some = whole.model_copy(update={"pipes": whole.pipes[7:9]})
    file = tmp_path / "some.json"
    file.write_text(some.to_json())
    passed = []
    for recover in (False, True):
        found = CheckedEvaluation(EvaluationConfig(policy="pirate", starts=str(file), recover=recover)).run()
        passed.append(found.success)
    assert passed[1] >= 0.9 > passed[0]
