"""Pictures of frontiers: the bore that robots need over the angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pipenav.certify.frontier import Frontier
from pipenav.drawing.style import MAIN, MARKERS, MUTED, SECOND, THIRD, heading, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = (MAIN, SECOND, THIRD, MUTED)


def frontier_figure(frontiers: Sequence[Frontier], title: str, text: str) -> Figure:
    """Smallest passable bore over the angle, with the band down to the largest impossible one.

    Args:
        frontiers: frontiers of one kind of bore and bend.
        title: title of the picture.
        text: what it shows, under the title.
    """
    from matplotlib.figure import Figure

    figure = Figure((7.0, 5.0), facecolor="white", layout="constrained")
    axes = figure.subplots()
    for number, frontier in enumerate(frontiers):
        known = [point for point in frontier.points if point.passable_mm is not None]
        angles = [point.angle_deg for point in known]
        passable = [point.passable_mm for point in known]
        colour = COLOURS[number % len(COLOURS)]
        axes.plot(angles, passable, color=colour, marker=MARKERS[number], markersize=5, label=frontier.robot)
        both = [point for point in known if point.impossible_mm is not None]
        low, high = [point.impossible_mm for point in both], [point.passable_mm for point in both]
        axes.fill_between([point.angle_deg for point in both], low, high, color=colour, alpha=0.25, linewidth=0)
    plain(axes)
    axes.set(xlabel="interior angle [deg]", ylabel="bore [mm]")
    axes.legend(frameon=False)
    heading(axes, title, text)
    return figure
