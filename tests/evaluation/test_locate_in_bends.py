"""Searches in swept bends: the target is found where the arm can come, and told right from wrong by the centre line."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.locating import SIMULATOR, search
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.evaluation.locate_stage import inside_second_leg, well_placed
from pipenav.evaluation.passage import EpisodePlan, Passages
from pipenav.locating.locator import LocateConfig, Told
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("basic")
turns = st.sampled_from(["left", "right"])
bends = st.builds(
    lambda d, angle, times, turn: PipeCorner.of(d, angle, turn, times * d),
    st.floats(70, 120),
    st.floats(85, 140),
    st.floats(1, 4),
    turns,
)
gaps = st.floats(0.06, 0.1)


@settings(max_examples=15, deadline=None)
@given(pipe=bends, gap=gaps, bend=st.lists(st.floats(-0.02, 0.02), min_size=3, max_size=3))
def test_the_default_finds_a_target_that_the_arm_can_reach(pipe: PipeCorner, gap: float, bend: list[float]) -> None:
    found = search("basic", pipe, gap, np.array(bend))
    assert found.outcome is Outcome.REACHED
    assert pipe.contains(found.target)
    assert found.q[-1, 0] <= 0.002 + 1e-9  # back where it began, straight
    assert found.q[-1, 1:] == pytest.approx(np.zeros(3), abs=0.01)


@settings(max_examples=60, deadline=None)
@given(pipe=bends, seed=st.integers(0, 2**32 - 1))
def test_every_target_that_is_drawn_is_well_placed(pipe: PipeCorner, seed: int) -> None:
    drawn = episode.sample(ROBOT, ReachConfig(), [pipe], np.random.default_rng(seed))
    base = float(drawn.base[0])
    target = (drawn.target[0] + [base, 0.0]) * [1.0, pipe.turn_sign]
    assert well_placed(ROBOT, pipe, base, target)


@settings(max_examples=60, deadline=None)
@given(pipe=bends, gap=gaps, back=st.floats(0.0, 0.5), aside=st.floats(-0.4, 0.4))
def test_no_target_is_well_placed_before_the_bend_or_in_a_wall(
    pipe: PipeCorner, gap: float, back: float, aside: float
) -> None:
    base = -pipe.inner_edge - gap - ROBOT.length
    before = np.array([-(1 + back) * pipe.inner_edge, aside * pipe.diameter])
    assert not well_placed(ROBOT, pipe, base, before)
    assert not well_placed(ROBOT, pipe, base, np.array([-pipe.inner_edge, 1.01 * pipe.radius * pipe.turn_sign]))


@settings(max_examples=40, deadline=None)
@given(d=st.floats(70, 120), angle=st.floats(55, 125), turn=turns, seed=st.integers(0, 2**32 - 1))
def test_in_a_mitre_well_placed_is_inside_the_second_leg(d: float, angle: float, turn: str, seed: int) -> None:
    pipe = PipeCorner.of(d, angle, turn)
    points = np.random.default_rng(seed).uniform(-0.4, 0.4, (50, 2))
    base = -pipe.inner_edge - 0.08 - ROBOT.length
    for point in points:
        assert well_placed(ROBOT, pipe, base, point) == inside_second_leg(pipe, point)


def test_a_robot_is_told_of_a_bend_but_not_its_radius() -> None:
    told = Told.of([PipeCorner.of(100, 90, "left", r) for r in (0, 100, 300)])
    assert told.bend.tolist() == [False, True, True]
    assert set(told._fields) == {"turn_sign", "tee", "straight", "bend"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["basic", "high-fidelity"])
def test_on_physics_nothing_is_touched(name: str) -> None:
    pipes = [
        PipeCorner.of(d, a, turn, d * times)
        for d in (80, 110)
        for a in (90, 120)
        for times in (1, 1.5, 3)
        for turn in ("left", "right")
    ]
    part = Passages(EpisodePlan(load_robot(name), ReachConfig(), pipes, 1, 3, SIMULATOR)).locate()
    assert part.passed.all()
    assert part.results.force.max() == 0.0
    assert part.results.penetration.max() == 0.0


def test_the_depth_that_is_wanted_is_the_middle_of_the_tasks() -> None:
    assert LocateConfig().depth == pytest.approx(sum(ReachConfig().target_depth) / 2)
