"""success.png: success over the corner angle in a panel for each diameter, or of each route in a row."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from pipenav.drawing.style import INK, MAIN, MUTED, SECOND, plain
from pipenav.evaluation.cells import KINDS, Cell, NumberedRoute, by_angle, numbered_routes, total
from pipenav.evaluation.coarse import coarse
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.pipe_results import by_diameter
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.success_axis import SUCCESS_LABEL, limits, widen
from pipenav.evaluation.summary import circumstances, headline, percent, route_corners

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CORNER_AXIS = "interior corner angle [deg] (smaller is sharper)"

KEY = "bars: Wilson 95 % intervals; orange: with failures; the axis widens towards 100 %"

TEE_AXIS = "interior angle of corner or branch [deg] (smaller is sharper)"

KIND_MARKS = dict(zip(KINDS, ("o", "s", "^", "v", "P", "<", ">"), strict=True))
"""Mark of each kind of fitting."""

APART = 0.025
"""Distance between the marks of two kinds at one angle, as a share of all angles, so that none hides another."""

LEGEND_IN = 0.62
"""Height of the axis's name with the legend of marks below it [in]."""

COLUMNS = 3
PANEL_IN = (3.5, 2.5)
"""Width and height of a panel [in]."""

HEADING_IN = 1.15
"""Height of title and circumstances [in]."""

MOST_TICKS = 8
"""Most angles along a panel that are all written on it."""

MOST_ROUTES = 60
"""Most routes in a picture; of more, the ones in which most episodes failed are shown."""

ROUTE_IN = 0.24
"""Height of a route's row [in]."""


def success_figure(evaluation: Evaluation) -> Figure:
    """Success with Wilson 95 % intervals: a panel for each diameter, or where only routes were run a row for each."""
    evaluation, rounded = coarse(evaluation)
    corners = [record for record in evaluation.pipes if record.route is None]
    if not corners:
        return _routes_figure(evaluation)
    given = {record.turn for record in corners}
    turns = "left and right turns together" if len(given) > 1 else f"{given.pop()} turns"
    if len({record.bend_radius_mm / record.diameter_mm for record in corners}) > 1:
        turns += ", all bend radii together (see map.png)"
    more = "; routes: see map.png" if len(corners) < len(evaluation.pipes) else ""
    lines = {diameter: by_angle(records) for diameter, records in by_diameter(corners).items()}
    return _corners_figure(
        evaluation,
        lines,
        f"{turns}; {KEY}{more}{'; ' * bool(rounded)}{rounded}",
    )


def _corners_figure(evaluation: Evaluation, lines: dict[float, dict[str, dict[float, Cell]]], note: str) -> Figure:
    from matplotlib.figure import Figure

    columns = 2 if len(lines) == 4 else min(COLUMNS, len(lines))
    rows = math.ceil(len(lines) / columns)
    width, height = max(columns * PANEL_IN[0], 8.5), rows * PANEL_IN[1] + HEADING_IN + 0.4
    figure = Figure((width, height), facecolor="white", layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat
    cells = [cell for kinds in lines.values() for line in kinds.values() for cell in line.values()]
    lowest = min(100 * wilson(*cell).low for cell in cells)
    angles = sorted({angle for kinds in lines.values() for line in kinds.values() for angle in line})
    apart = APART * (angles[-1] - angles[0])
    for axes, (diameter, kinds) in zip(panels, lines.items(), strict=False):
        plain(axes)
        _panel_title(axes, f"{diameter:g} mm", total(cell for line in kinds.values() for cell in line.values()))
        shifts = _shifts(kinds, apart)
        for kind, line in kinds.items():
            _draw_cells(axes, [angle + shifts[kind] for angle in line], list(line.values()), kind)
    first = figure.axes[0]
    most = max(len(kinds) for kinds in lines.values())
    margin = 0.04 * (angles[-1] - angles[0]) + apart * (most - 1) / 2 or 5.0
    for axes in figure.axes:
        widen(axes, lowest)
    first.set(ylim=limits(lowest), xlim=(angles[0] - margin, angles[-1] + margin))
    ticks = angles[:: math.ceil(len(angles) / MOST_TICKS)]
    first.set_xticks(ticks, [f"{angle:g}" for angle in ticks])
    for number, axes in enumerate(figure.axes):
        axes.set_visible(number < len(lines))
        axes.tick_params(labelbottom=number + columns >= len(lines))
        axes.set_ylabel("" if number % columns else SUCCESS_LABEL, color=INK)
    used = [kind for kind in KINDS if any(kind in kinds for kinds in lines.values())]
    figure.supxlabel(CORNER_AXIS, fontsize=10, color=INK)
    title = "Success over the corner angle" if used == [""] else "Success over the angle of corner or branch"
    _heading(figure, title, evaluation, note)
    if used != [""]:
        _kinds_legend(figure, used)
    return figure


def _shifts(kinds: Iterable[str], apart: float) -> dict[str, float]:
    """Distances of the kinds' marks from their angle, `apart` from each other, by kind [deg]."""
    known = list(kinds)
    return {kind: apart * (i - (len(known) - 1) / 2) for i, kind in enumerate(known)}


def _kinds_legend(figure: Figure, kinds: Sequence[str]) -> None:
    """Draw the marks of corners and of the ways through tees and crosses below all panels."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=MAIN, marker=KIND_MARKS[kind], label=_kind_words(kind), linestyle="") for kind in kinds
    ]
    height = figure.get_figheight()
    figure.set_figheight(height + LEGEND_IN)
    share = LEGEND_IN / (height + LEGEND_IN)
    engine: Any = figure.get_layout_engine()
    left, bottom, width, tall = engine.get()["rect"]
    engine.set(rect=(left, bottom + share, width, tall * (1 - share)))
    figure.supxlabel(TEE_AXIS, y=share / 2, fontsize=10, color=INK)
    figure.legend(handles=handles, loc="lower center", ncols=4, fontsize=9, frameon=False, labelcolor=INK)


def _kind_words(kind: str) -> str:
    """`tee, out of the branch`; a corner without branches is a corner."""
    name, _, way = kind.partition(" ")
    words = {"straight": "straight on past the branch", "into": "into the branch", "out": "out of the branch"}
    return f"{name}, {words[way]}" if name else "corner"


def _draw_cells(
    axes: Axes, places: Sequence[float], cells: Sequence[Cell], kind: str = "", across: bool = False
) -> None:
    """Draw shares with their intervals, upwards or, for routes, to the right; a tee's marks have their own shape."""
    shares = [100 * cell.share for cell in cells]
    if not across and len(cells) > 1:
        axes.plot(places, shares, color=MAIN, linewidth=1.2, alpha=0.45, zorder=2)
    for colour, failed in ((MAIN, False), (SECOND, True)):
        chosen = [i for i, cell in enumerate(cells) if (cell.successes < cell.episodes) is failed]
        at, share = [places[i] for i in chosen], [shares[i] for i in chosen]
        ends = [wilson(*cells[i]) for i in chosen]
        error = [
            [max(0.0, y - 100 * end.low) for y, end in zip(share, ends, strict=True)],
            [max(0.0, 100 * end.high - y) for y, end in zip(share, ends, strict=True)],
        ]
        mark = KIND_MARKS[kind] if kind else "D" if failed else "o"
        style: dict[str, Any] = {"fmt": mark, "color": colour, "markersize": 4.5 + bool(kind), "elinewidth": 1.0}
        if across:
            axes.errorbar(share, at, xerr=error, **style)
        elif chosen:
            axes.errorbar(at, share, yerr=error, **style)


def _panel_title(axes: Axes, name: str, cell: Cell) -> None:
    failed = cell.episodes - cell.successes
    axes.set_title(name, loc="left", fontsize=11, fontweight="bold", color=INK)
    text = f"{percent(cell.share)} %, {failed:,} of {cell.episodes:,} failed"
    axes.set_title(text, loc="right", fontsize=9, color=SECOND if failed else MUTED)


def _routes_figure(evaluation: Evaluation) -> Figure:
    """A row for each route, with its corners, in a panel for each diameter."""
    from matplotlib.figure import Figure

    groups = numbered_routes(evaluation)
    routes = [route for group in groups.values() for route in group]
    note = f"named by corners and number; {KEY}"
    if len(routes) > MOST_ROUTES:
        worst = sorted(routes, key=lambda route: route.cell.share)[:MOST_ROUTES]
        shown = {route.number for route in worst}
        groups = {d: [route for route in group if route.number in shown] for d, group in groups.items()}
        groups = {d: group for d, group in groups.items() if group}
        note += f"; the {MOST_ROUTES} worst of {len(routes)} routes"
    rows = [len(group) for group in groups.values()]
    heights = [count * ROUTE_IN + 0.42 for count in rows]
    figure = Figure((9.0, sum(heights) + HEADING_IN + 0.5), facecolor="white", layout="constrained")
    panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    lowest = min(100 * wilson(*route.cell).low for route in routes)
    for axes, (diameter, group) in zip(panels, groups.items(), strict=True):
        plain(axes)
        _panel_title(axes, f"{diameter:g} mm", total(route.cell for route in group))
        _draw_routes(axes, group)
    for axes in panels:
        widen(axes, lowest, across=True)
    panels[-1].set(xlim=limits(lowest))
    panels[-1].set_xlabel(SUCCESS_LABEL, color=INK)
    _heading(figure, "Success of every route", evaluation, note)
    return figure


def _draw_routes(axes: Axes, group: Sequence[NumberedRoute]) -> None:
    places = range(len(group))
    _draw_cells(axes, places, [route.cell for route in group], across=True)
    axes.set_yticks(places, [f"{route_corners(route.record)}  {route.number:>3}" for route in group])
    axes.set_ylim(len(group) - 0.5, -0.5)


def _heading(figure: Figure, title: str, evaluation: Evaluation, note: str) -> None:
    """Write title, subject, circumstances and a note above all panels."""
    text = f"{headline(evaluation)}\n{circumstances(evaluation)}\n{note}"
    height = figure.get_figheight()
    figure.text(0.01, 1 - 0.08 / height, title, fontsize=14, fontweight="bold", color=INK, va="top")
    figure.text(0.01, 1 - 0.36 / height, text, fontsize=9.5, color=MUTED, va="top", linespacing=1.35)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0, 0, 1, 1 - HEADING_IN / height), hspace=0.03)
