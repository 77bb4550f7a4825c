"""The drawing from above: what is seen is where it says it is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from pipenav.drawing import scene as drawn
from pipenav.drawing.scene import Scene, contact_point, draw_scene, scene_pixels
from pipenav.envs.gymnasium_env import CornerEnv
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.recording import film
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")


def scene(pipe: PipeCorner, **more: object) -> Scene:
    given: dict[str, object] = {"q": np.array([0.05, 0.1, -0.1, 0.2]), "ranges": np.full(10, 0.06)} | more
    return Scene(pipe=pipe, robot=ROBOT, base=-0.6, **given)  # type: ignore[arg-type]


def test_the_picture_shows_robot_wall_and_target_where_they_are() -> None:
    straight = np.zeros(4)
    view = scene(PipeCorner.of(100, 90), q=straight, target=np.array([0.0, 0.1]))
    picture = scene_pixels(view, 400, around=0.4)  # a pixel is 2 mm, the tip at (-0.21, 0) in the middle

    def colour(x: float, y: float) -> tuple[int, ...]:
        return tuple(int(v) for v in picture[round(200 - y / 0.002), round(200 + (x + 0.21) / 0.002)])

    def near(x: float, y: float, name: str) -> bool:
        return np.abs(np.array(colour(x, y)) - np.array(to_rgb(name)) * 255).max() < 12

    assert near(-0.30, 0.0, drawn.LINK)
    assert near(0.0, 0.1, drawn.TARGET)
    assert near(-0.4, 0.052, "#4a5560")
    assert near(-0.4, -0.052, "#4a5560")
    assert near(-0.4, 0.2, "white")
    assert near(0.03, -0.03, "#eaf0f6")


def test_an_arrow_starts_at_the_contact_and_grows_with_the_force() -> None:
    def arrow(newtons: float) -> np.ndarray:
        axes = Figure().add_subplot()
        draw_scene(
            axes, scene(PipeCorner.of(100, 90), link_forces=np.array([[0, 0], [0, 0], [0, 0], [0, newtons]], float))
        )
        (patch,) = [one for one in axes.patches if hasattr(one, "get_arrowstyle")]
        return np.array(patch._posA_posB)  # type: ignore[attr-defined]

    one, two = arrow(5.0), arrow(10.0)
    assert np.array_equal(one[0], two[0])
    assert two[1] - two[0] == pytest.approx(2 * (one[1] - one[0]))
    assert (two[1] - two[0])[1] == pytest.approx(10 * drawn.FORCE_SCALE)


def test_forces_too_small_for_an_arrow_have_none() -> None:
    axes = Figure().add_subplot()
    small = 0.9 * drawn.LEAST_FORCE
    draw_scene(axes, scene(PipeCorner.of(100, 90), link_forces=np.full((4, 2), small / np.sqrt(2))))
    assert not [one for one in axes.patches if hasattr(one, "get_arrowstyle")]


@given(st.floats(-0.02, 0.02), st.floats(-0.4, 0.4))
def test_the_contact_point_is_the_point_of_the_link_nearest_to_a_wall(y: float, heading: float) -> None:
    pipe = PipeCorner.of(100, 90)
    square = np.array([[-0.02, -0.01], [0.02, -0.01], [0.02, 0.01], [-0.02, 0.01]])
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    polygon = square @ turn.T + [-0.3, y]
    found = contact_point([polygon], pipe)
    assert pipe.radius - abs(found[1]) == pytest.approx((pipe.radius - np.abs(polygon[:, 1])).min(), abs=1e-9)


def test_an_inner_edge_that_meets_a_flank_is_the_contact_point() -> None:
    pipe = PipeCorner.of(100, 90)
    edge = pipe.walls.inner[1]
    along, across = np.array([1.0, 1.0]) / np.sqrt(2), np.array([1.0, -1.0]) / np.sqrt(2)
    polygon = edge + np.array(
        [-0.04 * along, 0.04 * along, 0.04 * along + 0.02 * across, -0.04 * along + 0.02 * across]
    )
    assert contact_point([polygon], pipe) == pytest.approx(edge)


def test_a_trajectorys_beams_are_those_that_the_laser_would_read() -> None:
    env = CornerEnv(pipes=["d=100,angle=80,turn=right"], options={"threads": 1})
    env.reset(seed=0)
    for _ in range(6):
        env.step(np.array([1.0, 0.2, 0.1, 0.3], np.float32))
    batch, episodes = env.batch, env._episodes.episodes[0]
    header = TrajectoryHeader(robot="basic", pipe=episodes.pipes[0], base_m=float(episodes.base[0]), stage="reach")
    shown = film.scene_of(Trajectory(header, ROBOT, batch.q), 0)
    assert shown.ranges == pytest.approx(batch.snapshot.ranges[0, ::-1])
    env.close()
