"""Sets of pipes near the frontiers: every pipe is passable, and a pipe 6 mm narrower is not."""

from __future__ import annotations

import pytest

from pipenav.certify.frontier import shipped_frontier
from pipenav.certify.model import Model
from pipenav.certify.verdict import passable
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import corner_set_names, parse_corners
from pipenav.robots import load_robot
from pipenav.units import m_to_mm, rad_to_deg

NAMES = [name for name in corner_set_names() if name.startswith("frontier-")]
EVERY = 13
"""Pipes of a set among which one is certified again; no factor of the numbers of bores, angles or turns."""


def robot_of(name: str) -> str:
    return name.removeprefix("frontier-").removesuffix("-train")


def test_every_shipped_shape_has_a_set_to_evaluate_and_one_to_train_in() -> None:
    robots = {robot_of(name) for name in NAMES}
    assert robots == {"basic", "real-setup", "high-fidelity", "pirate"}
    assert set(NAMES) == {f"frontier-{robot}{ending}" for robot in robots for ending in ("", "-train")}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_pipes_of_a_set_have_a_motion(name: str) -> None:
    for pipe in parse_corners([name])[::EVERY]:
        assert passable(Model(load_robot(robot_of(name)), pipe), None) is not None, pipe.label


@pytest.mark.parametrize("name", NAMES)
def test_pipes_of_a_set_lie_within_6_mm_above_the_frontier(name: str) -> None:
    frontier = shipped_frontier(load_robot(robot_of(name)), "plane", 0.0)
    assert frontier is not None
    early = 0.5  # motions are found with luck, here some tenths of a millimetre earlier than beside
    shallow = 1.5  # the frontier bends between points 20 deg apart, so that it lies above the straight line there
    for pipe in parse_corners([name]):
        least = frontier.passable(rad_to_deg(pipe.angle))
        assert least is not None
        assert -early <= m_to_mm(pipe.diameter) - least <= 6.0 + shallow, pipe.label


@pytest.mark.parametrize("name", NAMES)
def test_sets_of_one_robot_share_no_angle_and_no_diameter(name: str) -> None:
    other = name.removesuffix("-train") if name.endswith("-train") else f"{name}-train"

    def numbers(pipes: list[PipeCorner]) -> tuple[set[float], set[float]]:
        return {round(m_to_mm(one.diameter), 6) for one in pipes}, {round(rad_to_deg(one.angle), 6) for one in pipes}

    for mine, others in zip(numbers(parse_corners([name])), numbers(parse_corners([other])), strict=True):
        assert not mine & others


def test_wider_pipes_lie_more_than_6_mm_above_the_frontier_at_the_same_angles() -> None:
    frontier = shipped_frontier(load_robot("pirate"), "plane", 0.0)
    assert frontier is not None
    wider, near = parse_corners(["wider-pirate-train"]), parse_corners(["frontier-pirate-train"])
    assert {pipe.angle for pipe in wider} == {pipe.angle for pipe in near}
    for pipe in wider:
        least = frontier.passable(rad_to_deg(pipe.angle))
        assert least is not None
        assert least + 6.0 < m_to_mm(pipe.diameter) <= 130.0
