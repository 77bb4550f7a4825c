"""Senses of a robot between corners in several planes: its plane, its heading, and the end of the straight."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.rolling import ROBOT, clamped
from hypothesis import given
from hypothesis import strategies as st

from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.rotations import about_x
from pipenav.robots import laser
from pipenav.tasks.rolling import senses
from pipenav.tasks.rolling.clamp import axle_offset, nearest_zigzag


@pytest.mark.parametrize("third", [1.0, -1.0])
@pytest.mark.parametrize("diameter", [0.07, 0.12])
def test_in_a_zigzag_the_rear_half_heads_along_the_pipe(diameter: float, third: float) -> None:
    bends = clamped(diameter / 2, third)
    links = senses.link_vectors(ROBOT, bends[None])  # the first one lies along the axis
    assert senses.angle_between(links[:, 0], links[:, 1:3].sum(axis=1)) == pytest.approx(0.0, abs=1e-9)
    assert nearest_zigzag(bends[None]) == third


@given(st.floats(-1.0, 1.0), st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6))
def test_the_divided_links_heading_counts_from_the_rear_half(turn: float, bends: list[float]) -> None:
    """A bend of the third joint turns the divided link and leaves the rear half, however the robot is bent."""
    before = np.array(bends)
    after = before + np.array([0, 0, turn, 0, 0, 0])
    first, second = senses.heading_from_rear_half(ROBOT, np.array([before, after]))
    assert second - first == pytest.approx(turn, abs=1e-9)


@given(st.floats(-math.pi, math.pi), st.floats(-1.2, 1.2), st.floats(-0.6, 0.6))
def test_a_plane_is_known_from_the_weight_unless_the_straight_is_too_steep(
    plane: float, slope: float, swing: float
) -> None:
    """It holds in any pose of the joints: the accelerometers' link may head elsewhere than the straight."""
    c, s = math.cos(slope), math.sin(slope)
    axes = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])  # climbs by the slope
    bends = clamped(0.045, 1.0) + np.array([0, 0, swing, -swing, 0, 0])
    links = senses.link_vectors(ROBOT, bends[None])
    heading = float(senses.angle_between(links[:, 1:-1].sum(axis=1), links[:, 3])[0])
    turn = np.array([[math.cos(heading), -math.sin(heading), 0], [math.sin(heading), math.cos(heading), 0], [0, 0, 1]])
    link = axes @ about_x(plane) @ turn
    down = np.array([[[0, 0, -1.0] @ link] * 2])
    (seen,) = senses.plane_angle(ROBOT, bends[None], down, axes[None])
    if math.cos(slope) < senses.STEEPEST:
        assert np.isnan(seen)
    else:
        assert math.remainder(seen - plane, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(senses.plane_angle(ROBOT, bends[None], np.zeros((1, 2, 3)), axes[None]))


@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize("third", [1.0, -1.0])
@pytest.mark.parametrize(("diameter", "angle"), [(70, 55), (70, 125), (90, 90), (120, 55), (120, 125)])
def test_a_clamped_robot_sees_a_straight_end_in_time_and_not_before(
    diameter: int, angle: int, third: float, turn: str
) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    bends = clamped(pipe.radius, third)

    def sees(gap: float) -> bool:
        tip = np.array([[-pipe.inner_edge - gap, -third * axle_offset(ROBOT, pipe.radius)]])
        distances = laser.cast(tip, ROBOT.laser.angles[None], pipe.segments[None])
        ranges, radius = laser.measure(ROBOT.laser, distances), np.array([pipe.radius])
        return bool(senses.sees_end(ROBOT, bends[None], ranges, radius, np.array([third]))[0])

    seen = [gap for gap in np.arange(0.0, 0.4, 0.005) if sees(gap)]
    assert 0.05 <= max(seen) <= 0.215
    assert any(sees(gap) for gap in np.arange(0.04, 0.1, 0.005))
