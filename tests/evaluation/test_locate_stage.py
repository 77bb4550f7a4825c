"""Searches as an evaluation runs them: where a found target must lie, and what the default finds on physics."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.locating import ROBOTS, SIMULATOR, search
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.evaluation.locate_stage import LocateStage, inside_second_leg
from pipenav.evaluation.passage import EpisodePlan, Passages
from pipenav.locating.locator import LocateConfig
from pipenav.locating.map_locator import MapLocator
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.testing import KinematicBackend, KinematicOptions

STARTS = {
    "d": st.floats(70, 120),
    "angle": st.floats(55, 125),
    "gap": st.floats(0.06, 0.1),
    "bend": st.lists(st.floats(-0.02, 0.02), min_size=3, max_size=3),
}


@pytest.mark.parametrize("name", ROBOTS)
@settings(max_examples=20, deadline=None)
@given(**STARTS)
def test_the_default_finds_a_target_inside_the_second_leg(
    name: str, d: float, angle: float, gap: float, bend: list[float]
) -> None:
    pipe = PipeCorner.of(d, angle, "right")
    found = search(name, pipe, gap, np.array(bend))
    assert found.outcome is Outcome.REACHED
    along, off = pipe.along_second_leg(found.target)
    assert along - pipe.inner_edge == pytest.approx(0.1, abs=0.03)
    assert abs(off) < 0.03
    assert found.q[-1, 0] <= 0.002 + 1e-9  # back where it began, straight
    assert found.q[-1, 1:] == pytest.approx(np.zeros(3), abs=0.01)


@settings(max_examples=15, deadline=None)
@given(**STARTS)
def test_a_mirrored_pipe_gives_the_mirrored_target(d: float, angle: float, gap: float, bend: list[float]) -> None:
    left = search("basic", PipeCorner.of(d, angle, "left"), gap, np.array(bend))
    right = search("basic", PipeCorner.of(d, angle, "right"), gap, -np.array(bend))
    assert left.outcome is right.outcome
    # The simulated laser rounds to 5 mm, where the last bit of a distance may tip a reading.
    assert right.target * [1.0, -1.0] == pytest.approx(left.target, abs=2e-3)
    assert right.q[: len(left.q), 0] == pytest.approx(left.q[: len(right.q), 0], abs=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_on_physics_nothing_is_touched(name: str) -> None:
    rng = np.random.default_rng(7)
    turns = ["left", "right"]
    random = [PipeCorner.of(d, a, turns[i % 2]) for i, (d, a) in enumerate(rng.uniform((70, 55), (120, 125), (10, 2)))]
    pipes = [*random, *(PipeCorner.of(70, angle, turn) for angle in (55, 85, 120, 125) for turn in turns)]
    part = Passages(EpisodePlan(load_robot(name), ReachConfig(), pipes, 2, 3, SIMULATOR)).locate()
    assert part.passed.all()
    assert part.results.force.max() == 0.0
    assert part.results.penetration.max() == 0.0


def test_inside_the_second_leg_begins_past_the_bend() -> None:
    pipe = PipeCorner.of(100, 90)
    for along, inside in ((0.049, False), (0.051, True), (0.59, True), (0.61, False)):
        assert inside_second_leg(pipe, np.array([0.0, along])) is inside
    assert not inside_second_leg(pipe, np.array([0.06, 0.2]))  # in the wall
    assert not inside_second_leg(pipe, np.array([-0.2, 0.0]))  # in the first leg


def test_a_robot_of_other_joints_is_refused() -> None:
    robot = load_robot("basic")
    hinges = robot.model_copy(update={"links": robot.links[1:]})
    with pytest.raises(
        PipenavError, match="a slide followed by hinges, and robot 'basic' has hinge, hinge, hinge: choose"
    ):
        LocateStage(
            hinges,
            MapLocator(robot, LocateConfig(), 1),
            ReachConfig(),
            KinematicBackend(robot, 1, KinematicOptions()),
            lambda _: pytest.fail("no episode is drawn"),
        )
