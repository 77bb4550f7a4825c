"""Style of every picture: colours, axes, headings, PNG."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


INK, MUTED, GRID = "#20262c", "#66727e", "#e3e7eb"

MAIN, SECOND, THIRD = "#0072b2", "#d55e00", "#009e73"
"""Blue, vermilion and green of Okabe and Ito's palette, which the colour-blind can tell apart."""

MARKERS = "osD^vP*X"

DPI = 150


def png(figure: Figure) -> bytes:
    """A figure as the content of a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, bbox_inches="tight", pad_inches=0.2)
    return buffer.getvalue()


def plain(axes: Axes) -> None:
    """Style axes with two thin lines and a pale grid behind the data."""
    axes.grid(color=GRID, linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(color="#b4bec8", labelcolor=INK, labelsize=9)
    axes.xaxis.label.set_color(INK)
    axes.yaxis.label.set_color(INK)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color("#b4bec8")


def heading(axes: Axes, title: str, text: str) -> None:
    """Write a title above the axes, and a text of one or more lines between the two."""
    lines = text.count("\n") + 1
    axes.set_title(title, loc="left", fontsize=14, fontweight="bold", color=INK, pad=12 + 14 * lines)
    note = axes.annotate(text, (0, 1), (0, 8), xycoords="axes fraction", textcoords="offset points", color=MUTED)
    note.set(fontsize=9.5, linespacing=1.35)
