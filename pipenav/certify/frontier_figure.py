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
        known = [(point.angle_deg, point.passable_mm) for point in frontier.points if point.passable_mm is not None]
        angles, passable = [angle for angle, _ in known], [bore for _, bore in known]
        colour = COLOURS[number % len(COLOURS)]
        axes.plot(angles, passable, color=colour, marker=MARKERS[number], markersize=5, label=frontier.robot)
        proven = {point.angle_deg: point.impossible_mm for point in frontier.points if point.impossible_mm is not None}
        both = [(angle, proven[angle], bore) for angle, bore in known if angle in proven]
        low, high = [least for _, least, _ in both], [most for _, _, most in both]
        axes.fill_between([angle for angle, _, _ in both], low, high, color=colour, alpha=0.25, linewidth=0)
    plain(axes)
    axes.set(xlabel="interior angle [deg]", ylabel="bore [mm]")
    axes.legend(frameon=False)
    heading(axes, title, text)
    return figure
