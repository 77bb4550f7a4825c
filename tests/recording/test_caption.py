"""Text around pictures of motions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.offsetbox import AnchoredOffsetbox

from pipenav.drawing.down import LEVEL
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.recording.caption import caption_of, details_of, draw_caption, draw_scale


@pytest.fixture(scope="module")
def route() -> PipeRoute:
    return parse_routes(["runs-rolled:3"])[0]


@pytest.mark.parametrize("width", [8.0, 13.6])
def test_no_line_of_a_caption_is_cut_or_lies_on_another(width: float, route: PipeRoute) -> None:
    details = details_of("runs/some-policy-of-mine/best.zip", "pirate", "mujoco", {"timestep": 0.001, "threads": 1}, 3)
    caption = caption_of(f"{route.label}: whole robot", f"{details} · film 5 times as fast as the robot", width)
    figure = Figure((width, caption.height))
    canvas = FigureCanvasAgg(figure)
    draw_caption(figure, caption, width, caption.height)
    canvas.draw()
    boxes = [text.get_window_extent() for text in figure.texts]
    assert len(boxes) >= 3
    assert all(box.x1 <= figure.bbox.x1 and box.y0 >= 0 and box.y1 <= figure.bbox.y1 for box in boxes)
    assert not any(one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[:i])


@given(st.lists(st.text(st.characters(categories=["L", "N"]), min_size=1, max_size=30), min_size=1, max_size=40))
def test_a_broken_title_keeps_every_word(words: list[str]) -> None:
    title = ", ".join(words)
    assert "".join("".join(caption_of(title, "", 8.0).title).split()) == "".join(title.split())


def test_details_leave_out_what_is_not_known() -> None:
    assert details_of(None, "basic", None, {}, None) == "basic robot"
    assert details_of("arm", "basic", "mujoco", {}, 0) == "arm · basic robot · mujoco (default settings) · seed 0"
    assert "mujoco (timestep 0.001)" in details_of("arm", "basic", "mujoco", {"timestep": 0.001}, 0)


@pytest.mark.parametrize(("width", "said"), [(5000, "1000 mm"), (700, "100 mm"), (4, "1 mm")])
def test_a_scale_is_as_long_as_it_says(width: float, said: str) -> None:
    axes = Figure().add_subplot()
    draw_scale(axes, 10.0, 0.0, width, 8)
    left, right = axes.lines[0].get_xdata()
    assert f"{right - left:g} mm" == axes.texts[0].get_text().strip() == said


@pytest.mark.parametrize("width", [8.0, 13.6])
def test_a_caption_with_a_sign_keeps_its_lines_beside_it(width: float, route: PipeRoute) -> None:
    caption = caption_of(
        f"{route.label}: whole robot", "some policy · pirate robot", width, np.array([0.0, -9.81, 0.0])
    )
    figure = Figure((width, caption.height))
    canvas = FigureCanvasAgg(figure)
    draw_caption(figure, caption, width, caption.height)
    canvas.draw()
    (sign,) = figure.findobj(AnchoredOffsetbox)
    box = sign.get_window_extent()
    assert not any(text.get_window_extent().overlaps(box) for text in figure.texts)
    assert box.y0 > 0 and box.x1 <= figure.bbox.x1


def test_a_caption_says_where_nothing_weighs() -> None:
    level = caption_of("a pipe", "a policy", 8.0, np.zeros(3))
    assert level.down is None and level.details == [f"a policy · {LEVEL}"]
    assert caption_of("a pipe", "a policy", 8.0) == (["a pipe"], ["a policy"], None)
