"""The map of a survey as a picture."""

from __future__ import annotations

import io
from typing import Any

COLOURS = {"inspectable": "#1769aa", "partly": "#6fb1e0", "blocked": "#c2410c", "unknown": "#8a8f98"}
"""Colours of pipes by their status."""

ENTRY = "#0f766e"

BLOCKERS = (
    ("impossible", "X", 70, ("impossible",)),
    ("the policy fails", "x", 40, ("policy", "undecided", "episodes")),
    ("stops, unknown", "$?$", 50, ("untried", "map")),
)
"""Marks of the fittings that stop the robot: label, marker, size, and the causes of their judgements."""

MOST_DRAWN = 10
"""Most fittings with one mark: those with most length behind them."""


def map_png(record: dict[str, Any]) -> bytes:
    """The map as a PNG: pipes by their status, entries, and the fittings with most length behind them."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    places = {feature["id"]: feature["position_m"][:2] for feature in record["features"]}
    figure = Figure(figsize=(11, 8), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for status, colour in COLOURS.items():
        some = [segment for segment in record["segments"] if segment["status"] == status]
        lines = [[places[end] for end in segment["ends"]] for segment in some]
        length = sum(segment["seen_m"] if status == "inspectable" else segment["length_m"] for segment in some) / 1e3
        if lines:
            label = f"{status}, {length:.2f} km"
            axes.add_collection(LineCollection(lines, colors=colour, linewidths=1.6, label=label))
    entries = [places[point["feature"]] for point in record["entries"]["points"]]
    if entries:
        axes.scatter(*_columns(entries), marker="v", s=55, color=ENTRY, label="entry", zorder=3)
    for label, marker, size, causes in BLOCKERS:
        some = [places[blocker["feature"]] for blocker in record["blockers"] if blocker["cause"] in causes]
        if some:
            axes.scatter(*_columns(some[:MOST_DRAWN]), marker=marker, s=size, color="#111111", label=label, zorder=3)
    axes.autoscale()
    axes.set_aspect("equal")
    axes.ticklabel_format(useOffset=False, style="plain")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    total = record["totals_m"]
    axes.set_title(
        f"{record['network']['file']}: {total['seen'] / 1e3:.2f} of {total['mains'] / 1e3:.2f} km inspectable, "
        f"{total['unknown'] / 1e3:.2f} km unknown"
    )
    axes.legend(loc="best", frameon=False)
    file = io.BytesIO()
    figure.savefig(file, format="png", metadata={"Software": None})
    return file.getvalue()


def _columns(places: list[list[float]]) -> tuple[list[float], list[float]]:
    """The x and the y of some places [m]."""
    return [place[0] for place in places], [place[1] for place in places]
