"""Drawings with dimensions: colours, dimension lines, arrows, callouts, the frame around all of it."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WALL = "#4a5560"
FREE = "#eaf0f6"
CENTRE = "#8796a5"
DIMENSION = "#1b4f8a"
EDGE = "#c62828"
ROBOT = "#2e7d32"
INK = "#20262c"

WIDTH_IN = 8.6
TALLEST_IN = 10.0
DPI = 160

TITLE_LETTERS = 62
"""Most letters in a line of a title."""


class Frame(NamedTuple):
    """Lower left and upper right corner of a picture, in coordinates of its axes, (2,) each [mm]."""

    low: Floats
    high: Floats


class DimensionedDrawing:
    """Dimensions and texts on axes in millimetres; `unit` is about a hundredth of the drawing's width.

    Points are given in the coordinates of a left turn and mirrored about the x axis for a right one.

    Args:
        axes: axes to draw on.
        outline: points of what is drawn, in coordinates of the axes, (k, 2) [mm].
        turn_sign: +1 for a left turn, -1 for a right one.
    """

    def __init__(self, axes: Axes, outline: Floats, turn_sign: float = 1.0) -> None:
        self.axes, self.turn_sign = axes, turn_sign
        self.unit = float(np.ptp(outline, axis=0).max()) / 75
        self.drawn = [outline]

    def frame(self) -> Frame:
        """Frame around all that was drawn, with a margin."""
        points = np.concatenate(self.drawn)
        return Frame(points.min(axis=0) - 4 * self.unit, points.max(axis=0) + 4 * self.unit)

    def to_axes(self, points: Any) -> Floats:
        """Given points (..., 2) in coordinates of the axes [mm]; `frame` will go around them."""
        drawn: Floats = np.asarray(points, float) * np.array([1.0, self.turn_sign])
        self.drawn.append(np.atleast_2d(drawn))
        return drawn

    def line(self, start: Any, end: Any) -> None:
        """Draw a thin line between two points."""
        self.axes.plot(*self.to_axes([start, end]).T, color=DIMENSION, linewidth=0.6, zorder=4)

    def double_arrow(self, start: Any, end: Any) -> None:
        """Draw an arrow with a head at either end, as of a dimension."""
        self.arrow(start, end, DIMENSION, 1.0, style="<|-|>")

    def arrow(self, start: Any, end: Any, colour: str, width: float, style: str = "-|>") -> None:
        """Draw an arrow from `start` to `end`, by default with a head at its end."""
        arrow = {"arrowstyle": style, "color": colour, "linewidth": width, "mutation_scale": 8 + 4 * width}
        head, tail = tuple(self.to_axes(end)), tuple(self.to_axes(start))
        self.axes.annotate("", head, tail, arrowprops={**arrow, "shrinkA": 0, "shrinkB": 0}, zorder=5)

    def callout(self, tip: Floats, foot: Floats, text: str) -> None:
        """Draw an arrow to `tip`, with text at its foot, on the side that leads away from the tip."""
        self.arrow(foot, tip, DIMENSION, 0.9)
        away, up = (foot - tip) * [1.0, self.turn_sign] / float(np.linalg.norm(foot - tip))
        ha = "center" if abs(away) < 0.3 else "left" if away > 0 else "right"
        va = "center" if abs(up) < 0.3 else "bottom" if up > 0 else "top"
        self.text(foot, f" {text} ", ha=ha, va=va, box="white")
        self.to_axes(foot + np.array([math.copysign(10 * self.unit, away), 0.0]))  # room for the text

    def text(
        self, at: Any, text: str, ha: str = "center", va: str = "center", box: str | None = None, tilt: float = 0.0
    ) -> None:
        """Write text at a point, in a box of a colour if asked, tilted [deg]."""
        frame = {"boxstyle": "round,pad=0.2", "facecolor": box, "edgecolor": "none"} if box else None
        x, y = self.to_axes(at)
        self.axes.text(x, y, text, color=DIMENSION, fontsize=10, ha=ha, va=va, bbox=frame, rotation=tilt, zorder=7)


def frame_axes(axes: Axes, low: Floats, high: Floats) -> float:
    """Set limits, grid and ticks of a drawing in millimetres; return its height at a width of `WIDTH_IN` [in]."""
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.grid(color="#e3e7eb", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(color="#b4bec8", labelcolor=INK, labelsize=8)
    for spine in axes.spines.values():
        spine.set_color("#b4bec8")
    return float((high[1] - low[1]) / (high[0] - low[0])) * WIDTH_IN


def write_title(axes: Axes, title: str, facts: str) -> None:
    """Write a title above the axes, in lines that fit above a narrow drawing, and a line of facts between the two."""
    title = "\n".join(textwrap.wrap(title, TITLE_LETTERS, break_on_hyphens=False))
    axes.set_title(title, loc="left", fontsize=14, fontweight="bold", color=INK, pad=26)
    axes.annotate(facts, (0, 1), (0, 9), xycoords="axes fraction", textcoords="offset points", fontsize=9.5, color=INK)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure into a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=DPI, bbox_inches="tight", pad_inches=0.2)


def number(mm: float) -> str:
    """Text of a length for people, to a tenth of a millimetre."""
    return f"{round(mm, 1):g}"
