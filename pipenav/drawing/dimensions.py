"""What technical drawings have in common: colours, dimension lines, arrows, callouts, the frame around all of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

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


class Drawing:
    """Dimensions and texts on axes in millimetres; `unit` is about a hundredth of the drawing's width.

    Args:
        axes: where to draw.
        outline: points of what is drawn, as it will stand there, (k, 2) [mm].
        side: -1 where all that is given lies mirrored about the x axis.
    """

    def __init__(self, axes: Axes, outline: Floats, side: float = 1.0) -> None:
        self.axes, self.side = axes, side
        self.unit = float(np.ptp(outline, axis=0).max()) / 75
        self.drawn = [outline]

    def frame(self) -> tuple[Floats, Floats]:
        """The corners of all that was drawn, with a margin [mm]."""
        points = np.concatenate(self.drawn)
        return points.min(axis=0) - 4 * self.unit, points.max(axis=0) + 4 * self.unit

    def place(self, points: Any) -> Floats:
        """Points as given, where they come to stand."""
        placed: Floats = np.asarray(points, float) * np.array([1.0, self.side])
        self.drawn.append(np.atleast_2d(placed))
        return placed

    def line(self, start: Any, end: Any) -> None:
        self.axes.plot(*self.place([start, end]).T, color=DIMENSION, linewidth=0.6, zorder=4)

    def double_arrow(self, start: Any, end: Any) -> None:
        self.arrow(start, end, DIMENSION, 1.0, style="<|-|>")

    def arrow(self, start: Any, end: Any, colour: str, width: float, style: str = "-|>") -> None:
        arrow = {"arrowstyle": style, "color": colour, "linewidth": width, "mutation_scale": 8 + 4 * width}
        head, tail = tuple(self.place(end)), tuple(self.place(start))
        self.axes.annotate("", head, tail, arrowprops={**arrow, "shrinkA": 0, "shrinkB": 0}, zorder=5)

    def callout(self, tip: Floats, foot: Floats, text: str) -> None:
        """An arrow to `tip`, with text at its foot, on the side that leads away from the tip."""
        self.arrow(foot, tip, DIMENSION, 0.9)
        away, up = (foot - tip) * [1.0, self.side] / float(np.linalg.norm(foot - tip))
        ha = "center" if abs(away) < 0.3 else "left" if away > 0 else "right"
        va = "center" if abs(up) < 0.3 else "bottom" if up > 0 else "top"
        self.text(foot, f" {text} ", ha=ha, va=va, box="white")
        self.place(foot + np.array([math.copysign(10 * self.unit, away), 0.0]))  # room for the text

    def text(
        self, at: Any, text: str, ha: str = "center", va: str = "center", box: str | None = None, tilt: float = 0.0
    ) -> None:
        """Text at a place, in a box of a colour if asked, tilted [deg]."""
        frame = {"boxstyle": "round,pad=0.2", "facecolor": box, "edgecolor": "none"} if box else None
        x, y = self.place(at)
        self.axes.text(x, y, text, color=DIMENSION, fontsize=10, ha=ha, va=va, bbox=frame, rotation=tilt, zorder=7)


def frame_axes(axes: Axes, low: Floats, high: Floats) -> float:
    """Limits, grid and ticks of a drawing in millimetres; returns its height where it is `WIDTH_IN` wide [in]."""
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.grid(color="#e3e7eb", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(color="#b4bec8", labelcolor=INK, labelsize=8)
    for spine in axes.spines.values():
        spine.set_color("#b4bec8")
    return float((high[1] - low[1]) / (high[0] - low[0])) * WIDTH_IN


def write_title(axes: Axes, title: str, facts: str) -> None:
    """A title above the axes, and a line of facts between the two."""
    axes.set_title(title, loc="left", fontsize=14, fontweight="bold", color=INK, pad=26)
    axes.annotate(facts, (0, 1), (0, 9), xycoords="axes fraction", textcoords="offset points", fontsize=9.5, color=INK)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure into a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=DPI, bbox_inches="tight", pad_inches=0.2)


def number(mm: float) -> str:
    """A length for people: to a tenth of a millimetre."""
    return f"{round(mm, 1):g}"
