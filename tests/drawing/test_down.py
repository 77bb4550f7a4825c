"""The sign that says which way is down."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch

from pipenav.drawing.down import down_sign
from pipenav.drawing.projection import View

DOWN = np.array([0.0, 0.0, -1.0])


def sign(down: np.ndarray) -> Figure:
    figure = Figure()
    figure.add_artist(down_sign(down, figure.transFigure, (1.0, 1.0)))
    return figure


@given(st.floats(-math.pi, math.pi), st.floats(-0.9, 0.9))
def test_the_arrow_points_down(direction: float, towards: float) -> None:
    down = np.array([math.cos(direction), math.sin(direction), towards])
    (arrow,) = sign(down / np.linalg.norm(down)).findobj(FancyArrowPatch)
    tail, head = np.array(arrow._posA_posB)
    step = (head - tail) / np.linalg.norm(head - tail)
    np.testing.assert_allclose(step, down[:2] / np.linalg.norm(down[:2]), atol=1e-9)


@pytest.mark.parametrize(("towards", "crosses", "circles"), [(-1.0, 2, 1), (1.0, 0, 2)])
def test_down_into_the_picture_is_a_crossed_circle_and_out_of_it_a_dotted_one(
    towards: float, crosses: int, circles: int
) -> None:
    figure = sign(np.array([0.0, 0.0, towards]))
    assert not figure.findobj(FancyArrowPatch)
    assert len(figure.findobj(Line2D)) == crosses
    assert len(figure.findobj(Circle)) == circles


@pytest.mark.parametrize("view", [View.from_above(), View.towards(1.0)])
def test_down_in_a_view_is_where_lower_things_are_drawn(view: View) -> None:
    drop = view.flat(np.array([0.0, 0.0, -1.0]))
    np.testing.assert_allclose(view.seen(DOWN)[:2], drop, atol=1e-12)
    assert view.seen(DOWN)[2] < 0
