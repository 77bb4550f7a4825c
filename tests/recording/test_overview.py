"""A whole route with the robot's poses, in a strip of a whole robot."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.fittings import PLANE
from helpers.rolling import ROBOT
from matplotlib.figure import Figure

from pipenav.drawing.corner import free_outline
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import PipeRoute
from pipenav.recording.overview import TALLEST, close_box, draw_overview, has_overview, overview_box
from pipenav.robots.outline import link_outlines

ROUTE = PipeRoute.of(100, [(110, "left", 0), (95, "right", 0)], [900, 700, 900])
TALL = PipeRoute.of(100, [(90, "left", 0), (170, "right", 0)], [700, 1500, 1500])


def passage(pipe: Pipe) -> Trajectory:
    """A straight robot that slides along the first leg."""
    header = TrajectoryHeader(robot="pirate", pipe=pipe, base_m=-0.85, stage="traverse", outcome="reached")
    q = np.zeros((12, ROBOT.coordinates))
    q[:, 0] = np.linspace(0, 0.3, 12)
    return Trajectory(header, ROBOT, q)


@pytest.mark.parametrize("pipe", [ROUTE, TALL, PLANE], ids=lambda pipe: pipe.name)
def test_the_overview_shows_the_whole_route(pipe: PipeRoute) -> None:
    box = overview_box(passage(pipe))
    outline = 1e3 * free_outline(pipe)
    assert (outline > [box.left, box.bottom]).all() and (outline < [box.right, box.top]).all()
    assert box.aspect < 1.1 * TALLEST


def test_every_close_up_holds_the_whole_robot_and_all_have_one_size() -> None:
    one = passage(ROUTE)
    boxes = [close_box(one, row) for row in range(len(one.q))]
    for row, box in enumerate(boxes):
        outlines = [part[row] for link in link_outlines(ROBOT, one.q) for part in link]
        points = 1e3 * (np.concatenate(outlines) + np.array([one.header.base_m, 0.0]))
        assert (points > [box.left, box.bottom]).all() and (points < [box.right, box.top]).all()
    assert np.ptp([box.right - box.left for box in boxes]) < 1e-9


def test_poses_are_numbered_beside_the_pipe() -> None:
    one = passage(ROUTE)
    axes = Figure().add_subplot()
    rows = [0, 5, 11]
    draw_overview(axes, one, rows, overview_box(one))
    numbers = {text.get_text(): np.array(text.get_position()) for text in axes.texts if text.get_text().isdigit()}
    assert set(numbers) == {"1", "2", "3"}
    assert not ROUTE.contains(np.array(list(numbers.values())) / 1e3).any()
    gaps = [np.linalg.norm(numbers[a] - numbers[b]) for a, b in (("1", "2"), ("2", "3"), ("1", "3"))]
    assert min(gaps) > 20


def test_only_whole_robots_in_routes_have_an_overview() -> None:
    assert has_overview(passage(ROUTE))
    assert not has_overview(passage(PipeCorner.of(100, 90)))
    reach = passage(ROUTE)
    header = reach.header.model_copy(update={"stage": "reach"})
    assert not has_overview(Trajectory(header, reach.robot, reach.q))
