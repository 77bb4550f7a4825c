"""Draw docs/guides/push-lemma.png: python docs/draw_push_lemma.py

The picture of docs/guides/certify.md: three links of the whole robot in a mitre, free and pushed into the corner.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pipenav.certify.model import Model
from pipenav.certify.motion_check import walls_seen
from pipenav.certify.push import pushed
from pipenav.drawing.style import INK, MAIN, MUTED, SECOND, png
from pipenav.pipes import PipeCorner
from pipenav.robots import load_robot
from pipenav.storage.atomic_files import atomic_write

PICTURE = Path(__file__).resolve().parent / "guides" / "push-lemma.png"
ALONG_S, ALONG_T = 0.025, 0.012
"""Distances over both legs' walls by which the free chain lies away from the pushed one [m]."""


def draw() -> Figure:
    """The figure."""
    model = Model(load_robot("pirate"), PipeCorner.of(85, 75))
    turn = model.turn
    shapes = model.shapes(proof=True).stretch(2, 4)
    headings = np.array([[0.1 * turn, 0.45 * turn, 0.95 * turn]])
    place = pushed(model, shapes, headings).origin[0]
    # Heights over the walls are s = y and t = -x sin(turn) + y cos(turn); this is the way back.
    away = np.linalg.solve([[0.0, 1.0], [-math.sin(turn), math.cos(turn)]], [ALONG_S, ALONG_T])
    figure = Figure((7.0, 5.2), facecolor="white", layout="constrained")
    axes = figure.subplots()
    walls = 1e3 * walls_seen(model, 0.0, 0.3).segments
    for (x1, y1), (x2, y2) in walls:
        axes.plot([x1, x2], [y1, y2], color=INK, linewidth=2.5)
    for start, colour, label in ((place + away, MUTED, "free"), (place, MAIN, "pushed: it touches both outer walls")):
        _draw_chain(axes, shapes, start, headings[0], (colour, label))
    middle = 1e3 * (place + away) + [90, 45]
    axes.annotate("", 1e3 * place + [90, 45], middle, arrowprops={"arrowstyle": "->", "color": SECOND, "linewidth": 2})
    edge, apex = walls[2][1], walls[0][1]
    axes.annotate("inner edge: s = t = r", edge, edge + np.array([-150, 30]), color=INK, arrowprops={"arrowstyle": "-"})
    axes.annotate(
        "outer corner: s = t = -r", apex, apex + np.array([-140, -22]), color=INK, arrowprops={"arrowstyle": "-"}
    )
    axes.annotate("s: height over this wall", (-270, walls[0][0][1] + 6), color=INK)
    axes.set(aspect="equal", xlim=(-290, 110), ylim=(-75, 190))
    axes.axis("off")
    axes.legend(loc="upper left", frameon=False)
    return figure


def _draw_chain(axes, shapes, start, headings, style) -> None:
    colour, label = style
    at = np.array(start)
    for link, (heading, length) in enumerate(zip(headings, shapes.lengths, strict=True)):
        axis = np.array([math.cos(heading), math.sin(heading)])
        turned = np.array([axis, [-axis[1], axis[0]]])
        for i in np.flatnonzero(shapes.boxes.link == link):
            square = shapes.boxes.centre[i] + shapes.boxes.half[i] * [[1, 1], [-1, 1], [-1, -1], [1, -1]]
            name = label if link == 0 else None
            axes.fill(*(1e3 * (at + square @ turned)).T, facecolor=colour, alpha=0.5, edgecolor=colour, label=name)
        for i in np.flatnonzero(shapes.discs.link == link):
            phi = np.linspace(0, 2 * math.pi, 60)
            ring = shapes.discs.radius[i] * np.stack([np.cos(phi), np.sin(phi)], axis=1)
            axes.fill(*(1e3 * (at + shapes.discs.centre[i] @ turned + ring)).T, facecolor=colour, alpha=0.5)
        at = at + length * axis


if __name__ == "__main__":
    atomic_write(PICTURE, png(draw()))
