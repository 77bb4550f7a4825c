"""Text around pictures of motions: a title and details that are broken into lines, and a scale of lengths."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.down import LEVEL, SIGN_IN, down_sign
from pipenav.drawing.style import INK, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE_PT, DETAILS_PT = 12.0, 9.5
"""Sizes of the title's and the details' letters [pt]."""

TITLE_LINE_IN, DETAILS_LINE_IN = 0.23, 0.19
"""Heights of a line of the title and of the details [in]."""

LETTER = 0.68
"""Width of a letter at most, on average over a line, as a share of its size; bold ones are the widest."""

EDGE_IN = 0.12
"""Room beside and above a caption [in]."""

UNBROKEN = "\N{NO-BREAK SPACE}"

LENGTHS_MM = (1000, 500, 200, 100, 50, 20, 10, 5, 2, 1)
"""Lengths that a scale may have [mm]."""

MOST_SCALE = 0.22
"""Longest scale, as a share of the picture's width."""


class Caption(NamedTuple):
    """Lines of a title, lines of details below it, and the direction downwards.

    Attributes:
        title: lines of the title.
        details: lines of the details.
        down: direction downwards in the pictures, to the right, upwards and to the viewer, (3,), which a sign at the
            right end shows; None where nothing weighs, or it is not known.
    """

    title: list[str]
    details: list[str]
    down: Floats | None = None

    @property
    def height(self) -> float:
        """Height of all lines with the room above and below them [in]."""
        return 2 * EDGE_IN + TITLE_LINE_IN * len(self.title) + DETAILS_LINE_IN * len(self.details)


def caption_of(title: str, details: str, width: float, gravity: Floats | None = None) -> Caption:
    """Title and details broken into lines.

    Args:
        title: the title.
        details: the details.
        width: width of the whole [in].
        gravity: gravity in the pictures, to the right, upwards and to the viewer, (3,) [m/s^2], zeros where nothing
            weighs; None where it is not known.
    """
    down = gravity if gravity is not None and np.any(gravity) else None
    if gravity is not None and down is None:
        details = " · ".join(part for part in (details, LEVEL) if part)
    if down is not None:
        down, width = down / np.linalg.norm(down), width - SIGN_IN

    def lines(text: str, separator: str, size: float) -> list[str]:
        whole = separator.join(part.replace(" ", UNBROKEN) for part in text.split(separator))
        broken = textwrap.wrap(whole, int((width - 2 * EDGE_IN) * 72 / (LETTER * size)))
        return [line.replace(UNBROKEN, " ") for line in broken]

    return Caption(lines(title, ", ", TITLE_PT), lines(details, " · ", DETAILS_PT), down)


def draw_caption(figure: Any, caption: Caption, width: float, height: float) -> None:
    """Draw a caption at the top of a figure or a part of one.

    Args:
        figure: the figure or subfigure.
        caption: the caption.
        width: its width [in].
        height: its height [in].
    """
    x, y = EDGE_IN / width, height - EDGE_IN
    for text in caption.title:
        figure.text(x, y / height, text, fontsize=TITLE_PT, fontweight="bold", color=INK, va="top")
        y -= TITLE_LINE_IN
    for text in caption.details:
        figure.text(x, y / height, text, fontsize=DETAILS_PT, color=MUTED, va="top")
        y -= DETAILS_LINE_IN
    if caption.down is not None:
        corner = 1 - EDGE_IN / width, 1 - EDGE_IN / height
        figure.add_artist(down_sign(caption.down, figure.transSubfigure, corner))


def details_of(
    controller: str | None, robot: str, backend: str | None, options: Mapping[str, Any], seed: int | None
) -> str:
    """Controller, robot, backend with its settings, and seed, in words; unknown parts are left out."""
    settings = ", ".join(f"{name} {value}" for name, value in options.items())
    parts = [controller or "", f"{robot} robot", backend and f"{backend} ({settings or 'default settings'})"]
    return " · ".join(part for part in [*parts, "" if seed is None else f"seed {seed}"] if part)


def draw_scale(axes: Axes, left: float, y: float, width: float, fontsize: float) -> None:
    """Draw a scale of lengths with its text to the right, both with a white rim, as a pipe may lie below them.

    Args:
        axes: axes in millimetres.
        left: left end of the scale [mm].
        y: height of the scale [mm].
        width: width of the picture [mm].
        fontsize: size of its text [pt].
    """
    from matplotlib.patheffects import Normal, Stroke

    length = next(length for length in LENGTHS_MM if length <= max(MOST_SCALE * width, 1))
    rim = [Stroke(linewidth=3.5, foreground="white"), Normal()]
    style: dict[str, Any] = {"marker": "|", "markersize": 6, "zorder": 9, "path_effects": rim}
    axes.plot([left, left + length], [y, y], color=INK, linewidth=1.6, **style)
    text = axes.text(left + length, y, f"  {length} mm", color=INK, fontsize=fontsize, va="center", zorder=9)
    text.set_path_effects(rim)
