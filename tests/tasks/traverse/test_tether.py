"""The tether: its drag, where it acts, and the time that a robot under load gets."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute
from pipenav.robots.cable import capstan, drag_per_metre
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import task_of
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.pace import most_slowness, slowness
from pipenav.tasks.traverse.tether import STRETCH, TetherConfig, Tethers

LENGTHS, FRICTIONS = st.floats(0, 1000), st.floats(0, 2)


def tethers(cable: float, **config: float) -> Tethers:
    made = Tethers(TetherConfig(**config), 1)
    made.start(np.arange(1), np.array([cable]), np.zeros(1))
    return made


@given(cable=LENGTHS, friction=FRICTIONS, turns=st.lists(st.floats(0, math.pi), max_size=5))
def test_turns_multiply_by_the_capstan_equation(cable: float, friction: float, turns: list[float]) -> None:
    subject = tethers(cable, friction=friction)
    straight = subject.tension(np.zeros(1), np.zeros(1))
    factors = math.prod(float(capstan(friction, turn)) for turn in turns)
    assert subject.tension(np.zeros(1), np.array([sum(turns)])) == pytest.approx(straight * factors, rel=1e-9)


@given(cable=LENGTHS, moved=st.floats(0, 10), back=st.floats(0, 2 * STRETCH))
def test_a_robot_that_rolls_back_slackens_its_cable(cable: float, moved: float, back: float) -> None:
    subject = tethers(cable)
    ahead = subject.tension(np.array([moved]), np.zeros(1))
    assert ahead == pytest.approx(TetherConfig().per_metre * (cable + moved))
    behind = subject.tension(np.array([moved - back]), np.zeros(1))
    assert behind == pytest.approx(ahead * max(0.0, 1 - back / STRETCH), abs=1e-9)


@given(weight=st.floats(0, 10), friction=FRICTIONS, rise=st.floats(-1, 1))
def test_no_cable_pulls_forwards(weight: float, friction: float, rise: float) -> None:
    assert drag_per_metre(weight, friction, rise) >= 0
    assert drag_per_metre(weight, friction, abs(rise)) >= weight * abs(rise) - 1e-12


@given(angle=st.floats(30, 150), turn=st.sampled_from(["left", "right"]), share=st.floats(0.1, 0.9))
def test_the_force_points_back_along_the_leg_of_the_tail(angle: float, turn: str, share: float) -> None:
    pipe = PipeCorner.of(100, angle, turn)  # type: ignore[arg-type]
    lines, subject = CentreLines.of([pipe]), Tethers(TetherConfig(), 1)
    subject.start(np.arange(1), np.array([100.0]), np.array([-pipe.leg]))
    ends = np.array([-share * pipe.leg, 0.0]), share * pipe.leg * pipe.second_leg
    for point, leg, turned in zip(
        ends, (np.array([1.0, 0.0]), pipe.second_leg), (0.0, math.pi - pipe.angle), strict=True
    ):
        force = subject.forces(lines, point[None])[0]
        tension = subject.tension(lines.distance(point[None, None])[:, 0], np.array([turned]))[0]
        assert tension > 5.0
        np.testing.assert_allclose(force, -tension * leg, atol=1e-9)


def test_turns_in_space_count_like_turns_in_the_plane() -> None:
    route = PipeRoute.of(90, [(120, "left", 0), (60, "right", 90)], [1500, 900, 800])
    assert CentreLines.of([route], 3).turned[0, :3] == pytest.approx([0, math.radians(60), math.radians(180)])


@given(low=LENGTHS, more=st.floats(0, 1000), inclined=st.booleans(), name=st.sampled_from(["pirate", "pirate-strong"]))
def test_no_episode_takes_longer_than_the_most_that_is_said(low: float, more: float, inclined: bool, name: str) -> None:
    robot = load_robot(name)
    config = TraverseConfig(
        kind="traverse",
        tether=TetherConfig(length=(low, low + more)),
        inclination_deg=(0.0, 360.0) if inclined else None,
    )
    pipes = [PipeCorner.of(90, 90), PipeCorner.of(70, 60)]
    episodes = task_of(config).sample(robot, pipes, np.random.default_rng(0))
    assert ((low <= episodes.cable) & (episodes.cable <= low + more)).all()
    slower = slowness(robot, config, episodes)
    assert ((slower >= 1) & (slower <= most_slowness(robot, config) + 1e-9)).all()
    assert task_of(config).most_steps(robot, pipes) >= config.max_steps * slower.max()


def test_time_limits_of_the_strong_robot_are_those_stated() -> None:
    for inclination in (None, (0.0, 360.0)):
        config = TraverseConfig(kind="traverse", inclination_deg=inclination)
        assert most_slowness(load_robot("pirate-strong"), config) == 1.0
