"""Texts of figures, and whether they can be read."""

from __future__ import annotations

from itertools import combinations

import matplotlib.text
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def texts(figure: Figure) -> list[str]:
    """All texts of a figure."""
    figure.draw_without_rendering()
    return [text.get_text() for text in figure.findobj(matplotlib.text.Text) if text.get_text()]


def overlapping(figure: Figure, axes: Axes) -> list[tuple[str, str]]:
    """Pairs of texts in axes whose letters lie over each other, drawn as large as they are saved.

    Tilted texts have large boxes, so they are compared with none.
    """
    FigureCanvasAgg(figure).draw()
    shown = [text for text in axes.texts if text.get_text().strip() and text.get_rotation() % 90 < 1]
    for text in shown:
        text.set_bbox(None)  # a white box may reach below another text
    boxes = [(text.get_text(), text.get_window_extent()) for text in shown]
    return [(one, other) for (one, a), (other, b) in combinations(boxes, 2) if a.overlaps(b)]
