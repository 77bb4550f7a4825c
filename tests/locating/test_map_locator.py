"""Approach I under a scanner that gives its minimum where nothing is near: it goes on, and still stops at a wall."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.backends.simulators import SimulatorSettings
from pipenav.disturbances.disturbance import Disturbance, load_disturbance
from pipenav.evaluation.passage import EpisodePlan, Passages
from pipenav.locating.locator import Exit, LocateConfig
from pipenav.locating.map_locator import MapLocator
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("basic")
LASER = ROBOT.laser
OPEN = np.full(LASER.beams, 0.3)
ONE = np.arange(1)
PIPES = [PipeCorner.of(d, angle, turn) for d in (90, 120) for angle in (60, 90, 120) for turn in ("left", "right")]


def reading(slide: float, ranges: Floats) -> Reading:
    q = np.zeros((1, len(ROBOT.joints)))
    q[0, 0] = slide
    return Reading(q, np.zeros_like(q), ranges[None], np.zeros(1))


def advances(scans: list[Floats]) -> list[float]:
    """Motion of a slide that follows at once, after each scan [m]."""
    locator, slide, moved = MapLocator(ROBOT, LocateConfig(), 1), 0.0, []
    locator.start(ONE, reading(0.0, scans[0]), Exit("left").told)
    for ranges in scans:
        set_points = float(locator.act(reading(slide, ranges)).set_points[0, 0])
        moved.append(set_points - slide)
        slide = set_points
    return moved


@settings(max_examples=30, deadline=None)
@given(lost=st.lists(st.booleans(), min_size=LASER.beams, max_size=LASER.beams))
def test_beams_that_drop_out_do_not_stop_the_advance(lost: list[bool]) -> None:
    dropped = np.where(lost, LASER.range_min, OPEN)
    assert advances([OPEN, dropped, dropped]) == pytest.approx([0.02, 0.02, 0.02])


def test_a_beam_that_has_only_read_the_minimum_is_taken_at_its_word() -> None:
    near = OPEN.copy()
    near[5] = LASER.range_min
    assert advances([near, near]) == pytest.approx([0.02 / 8, -0.02 / 8])  # slower, then back to where it began


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(first=st.floats(0.06, 0.2))
def test_a_wall_that_was_last_seen_farther_away_stops_the_advance_when_it_must_be_near(first: float) -> None:
    seen, silent = np.full(LASER.beams, first), np.full(LASER.beams, LASER.range_min)
    covered = sum(advances([seen, *[silent] * 20]))
    config = LocateConfig()
    # Whole steps until no more than delta is left, then v0 / 8 + v0 / 64 ...
    assert covered < max(first - config.delta, 0.0) + config.v0 * (1 + 1 / (config.slowdown - 1))
    assert covered < first


@pytest.mark.slow
@pytest.mark.parametrize("name", ["basic", "high-fidelity", "real-setup"])
@pytest.mark.parametrize("disturbance", ["real-world", "half"])
def test_targets_are_located_without_a_touch(name: str, disturbance: str) -> None:
    given = Disturbance(dropouts=(0.5, 0.5)) if disturbance == "half" else load_disturbance(disturbance)
    simulator = SimulatorSettings("mujoco", {"timestep": 0.005, "threads": 1})
    part = Passages(EpisodePlan(load_robot(name), ReachConfig(), PIPES, 4, 0, simulator, given)).locate()
    assert part.passed.all()
    assert part.results.force.max() == 0.0
