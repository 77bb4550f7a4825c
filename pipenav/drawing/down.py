"""The sign that says in a picture which way is down: an arrow, or a circle where down points into the picture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.artist import Artist

DOWN = "#8e1f6a"
"""Colour of the sign, which nothing else in a picture has."""

WORD, LEVEL, WEIGHTLESS = "down", "level: nothing weighs", "nothing weighs"
"""Words of the sign, and for what has none: in a level plane, and in space."""

SIGN_PT = 38.0
"""Side of the square that the sign takes [pt]."""

SIGN_IN = 1.15
"""Room that the sign and its word take at the right end of a caption [in]."""

ACROSS = math.sin(math.radians(10.0))
"""Part of down in the picture's plane below which it counts as square to the picture."""


def down_sign(down: Floats, transform: Any, anchor: tuple[float, float], where: str = "upper right") -> Artist:
    """The sign for a direction, to be added to a figure or axes.

    Args:
        down: unit vector downwards, in the picture to the right, upwards and to the viewer, (3,).
        transform: coordinates of `anchor`.
        anchor: point at which the sign hangs.
        where: the sign's corner there, as matplotlib's `loc`.
    """
    from matplotlib.offsetbox import AnchoredOffsetbox, DrawingArea, HPacker, TextArea
    from matplotlib.patches import Circle, FancyArrowPatch

    area = DrawingArea(SIGN_PT, SIGN_PT)
    middle = SIGN_PT / 2
    in_plane = np.asarray(down[:2], float)
    size = float(np.linalg.norm(in_plane))
    if size > ACROSS:
        step = 0.46 * SIGN_PT * in_plane / size
        head, tail = (middle + step, middle - step)
        style: dict[str, Any] = {"arrowstyle": "simple,head_width=11,head_length=11,tail_width=3.5"}
        arrow = FancyArrowPatch(tuple(tail), tuple(head), mutation_scale=1, color=DOWN, shrinkA=0, shrinkB=0, **style)
        area.add_artist(arrow)
    else:
        radius = 0.3 * SIGN_PT
        area.add_artist(Circle((middle, middle), radius, facecolor="white", edgecolor=DOWN, linewidth=2))
        for mark in _cross(middle, radius) if down[2] < 0 else [Circle((middle, middle), 0.3 * radius, color=DOWN)]:
            area.add_artist(mark)
    style = {"color": DOWN, "fontsize": 10, "fontweight": "bold"}
    packed = HPacker(children=[TextArea(WORD, textprops=style), area], align="center", pad=0, sep=2)
    place: dict[str, Any] = {"bbox_to_anchor": anchor, "bbox_transform": transform}
    hung = AnchoredOffsetbox(where, child=packed, pad=0.15, borderpad=0.0, frameon=True, **place)
    hung.patch.set(facecolor="white", edgecolor="none", alpha=0.8)
    hung.set_zorder(10)
    return hung


def _cross(middle: float, radius: float) -> list[Artist]:
    from matplotlib.lines import Line2D

    ends = radius * math.sqrt(0.5)
    lines = ((-ends, ends), (ends, -ends))
    return [
        Line2D([middle - ends, middle + ends], [middle + low, middle + high], color=DOWN, linewidth=2)
        for low, high in lines
    ]
