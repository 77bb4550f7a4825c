"""Approach I in tees: the target lies in the exit that the robot was told, never in another one."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.locating import ROBOTS, search
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.evaluation.locate_stage import inside_second_leg
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.tee import TeePassage, tee
from pipenav.robots import kinematics
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome

STARTS = {
    "way": st.sampled_from(["straight", "into", "out"]),
    "turn": st.sampled_from(["left", "right"]),
    "d": st.floats(70, 120),
    "angle": st.floats(45, 135),
    "gap": st.floats(0.06, 0.18),
    "bend": st.lists(st.floats(-0.02, 0.02), min_size=3, max_size=3),
}

Start = tuple[str, str, float, float, float, list[float]]


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
@settings(max_examples=40, deadline=None)
@given(start=st.tuples(*STARTS.values()))
def test_no_target_lies_in_another_exit_and_nothing_is_touched(name: str, start: Start) -> None:
    """A robot may see too little to know the target, or miss the exit by some millimetres; it never takes another."""
    way, turn, d, angle, gap, bend = start
    pipe = tee(d, angle, TeePassage(way, turn))
    found = search(name, pipe, gap, np.array(bend))
    assert found.outcome is not Outcome.PENETRATION
    assert (found.outcome is Outcome.REACHED) == inside_second_leg(pipe, found.target)
    assert (found.outcome is Outcome.REACHED) == pipe.contains(found.target)
    robot = load_robot(name)
    tips = kinematics.forward(robot, found.q).tip + np.array([-pipe.inner_edge - gap - robot.length, 0.0])
    assert pipe.contains(tips).all()


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(start=st.tuples(*STARTS.values()))
def test_a_wide_fan_finds_every_exit(start: Start) -> None:
    way, turn, d, angle, gap, bend = start
    found = search("basic", tee(d, angle, TeePassage(way, turn)), min(gap, 0.1), np.array(bend))
    assert found.outcome is Outcome.REACHED


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_most_exits_around_a_corner_are_found(name: str) -> None:
    """A fan of 86 deg sees little of a branch that leads back, and so turns back before it is content."""
    rng, found = np.random.default_rng(5), []
    for number in range(40):
        pipe = tee(rng.uniform(70, 120), rng.uniform(45, 135), TeePassage(["into", "out"][number % 2]))
        found.append(search(name, pipe, rng.uniform(0.06, 0.1), rng.uniform(-0.02, 0.02, 3)).outcome is Outcome.REACHED)
    assert np.mean(found) > 0.9


@pytest.mark.parametrize("angle", [45, 90, 135])
def test_a_point_in_another_exit_is_not_inside_the_second_leg(angle: float) -> None:
    for way in ("straight", "into", "out"):
        pipe = tee(100, angle, TeePassage(way))
        leg = pipe.inner_edge + 0.15
        assert inside_second_leg(pipe, leg * pipe.second_leg)
        for exit in _exits(pipe):
            assert not inside_second_leg(pipe, 0.25 * exit)


def _exits(pipe: PipeCorner) -> list[np.ndarray]:
    """Unit vectors along the branches of a tee, and back along the first leg."""
    headings = [(1 if branch.turn == "left" else -1) * (np.pi - branch.angle) for branch in pipe.branches]
    return [np.array([np.cos(heading), np.sin(heading)]) for heading in [*headings, np.pi]]
