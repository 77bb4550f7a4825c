"""map.png: success by diameter and corner angle, or by diameter and route, as numbers in cells."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from pipenav.drawing.style import INK, heading
from pipenav.evaluation.cells import NumberedRoute, cell_of, in_order, numbered_routes, records_by_fitting
from pipenav.evaluation.coarse import coarse
from pipenav.evaluation.passability_cells import BARE, CertifiedCell, legend
from pipenav.evaluation.pipe_results import PipeRecord, by_diameter
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.success_figure import CORNER_AXIS
from pipenav.evaluation.summary import circumstances, headline, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

ROUTE_AXIS = "routes of this diameter in the order given; small: number among all routes"

MOST_COLUMNS = 24
"""Most routes of a diameter side by side; more go on in the next row."""

CELL_IN = (0.56, 0.42)
"""Width and height of a cell [in]."""

CERTIFIED_CELL_IN = (0.78, 0.62)
"""Width and height of a cell that says besides what geometry found [in]."""


class _Panel(NamedTuple):
    """A panel of cells.

    Attributes:
        name: what its pipes are, such as `left turn`.
        rows: labels of the rows.
        columns: labels of the columns.
        records: records of the pipes by row and column.
        numbers: numbers of the routes by row and column; empty for corners.
    """

    name: str
    rows: list[str]
    columns: list[str]
    records: dict[tuple[int, int], list[PipeRecord]]
    numbers: dict[tuple[int, int], int]


def map_figure(evaluation: Evaluation) -> Figure:
    """Success with the numbers in the cells, one panel for each turn and one for routes."""
    from matplotlib.figure import Figure

    evaluation, rounded = coarse(evaluation)
    panels = _panels(evaluation)
    corners = any(not panel.numbers for panel in panels)
    every = (records for panel in panels for records in panel.records.values())
    certified = [cell for cell in map(CertifiedCell.of, every) if cell]
    cell_width, cell_height = CERTIFIED_CELL_IN if certified else CELL_IN
    heights = [cell_height * len(panel.rows) + 0.9 for panel in panels]
    width = max(cell_width * max(len(panel.columns) for panel in panels) + 2.2, 8.5)
    figure = Figure((width, sum(heights) + 1.4), facecolor="white", layout="constrained")
    grid = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
    for number, (panel, axes) in enumerate(zip(panels, grid, strict=True), 1):
        image = _draw_map(axes, panel)
        axes.set_ylabel(f"{panel.name}\ndiameter [mm]", color=INK)
        if panel.numbers or number == len(panels) or panels[number].numbers:
            axes.set_xlabel(ROUTE_AXIS if panel.numbers else _corner_axis(panel.columns), color=INK)
    bar = figure.colorbar(image, ax=list(grid), label="success [%]", fraction=0.05, pad=0.015, aspect=12 * len(panels))
    bar.outline.set_visible(False)
    tees = any(record.fitting for record in evaluation.pipes)
    kinds = "angle of corner or branch" if tees else "corner angle"
    title = f"Success by diameter and {kinds}" if corners else "Success by diameter and route"
    shown = f"percent of the episodes{', their 95 % interval, episodes that failed' * bool(certified)}"
    note = f"{shown}; empty: not run{'; ' * bool(rounded)}{rounded}"
    heading(grid[0], title, f"{headline(evaluation)}\n{circumstances(evaluation)}\n{note}")
    legend(figure, certified)
    return figure


def _corner_axis(columns: list[str]) -> str:
    """Meaning of the columns of single corners."""
    bends, tees = any("D" in column for column in columns), any("\n" in c and "D" not in c for c in columns)
    return CORNER_AXIS + ", bend radius" * bends + "; of a tee its branch's angle and the robot's way" * tees


def _panels(evaluation: Evaluation) -> list[_Panel]:
    """Panels of the turns and of the routes that were run."""
    turns = {
        turn: {
            d: records_by_fitting(group)
            for d, group in by_diameter([r for r in evaluation.pipes if r.turn == turn]).items()
        }
        for turn in ("left", "right")
    }
    turns = {turn: lines for turn, lines in turns.items() if lines}
    fittings = in_order(fitting for lines in turns.values() for line in lines.values() for fitting in line)
    diameters = sorted({d for lines in turns.values() for d in lines}, reverse=True)
    panels = []
    for turn, lines in turns.items():
        records = {
            (diameters.index(d), fittings.index(fitting)): group
            for d, line in lines.items()
            for fitting, group in line.items()
        }
        labels = [one.label for one in fittings]
        panels.append(_Panel(f"{turn} turn", [f"{d:g}" for d in diameters], labels, records, {}))
    groups = numbered_routes(evaluation)
    return [*panels, _routes_panel(groups)] if groups else panels


def _routes_panel(groups: dict[float, list[NumberedRoute]]) -> _Panel:
    """Panel of routes: a row for each diameter, or several where it has many routes."""
    columns = min(MOST_COLUMNS, max(map(len, groups.values())))
    panel = _Panel("routes", [], [str(column + 1) for column in range(columns)], {}, {})
    for diameter, routes in groups.items():
        for start in range(0, len(routes), columns):
            for column, route in enumerate(routes[start : start + columns]):
                panel.records[len(panel.rows), column] = [route.record]
                panel.numbers[len(panel.rows), column] = route.number
            panel.rows.append("" if start else f"{diameter:g}")
    return panel


def _draw_map(axes: Axes, panel: _Panel) -> AxesImage:
    """Draw one panel; returns its image."""
    from matplotlib.colors import to_hex, to_rgb

    shares = [[math.nan] * len(panel.columns) for _ in panel.rows]
    colours = _map_colours()
    for (row, column), records in panel.records.items():
        cell, certified = cell_of(records), CertifiedCell.of(records)
        if certified is None or not certified.bare:
            shares[row][column] = 100 * cell.share
        face = to_hex(colours(cell.share)) if certified is None or not certified.bare else BARE
        ink = "white" if _is_dark(to_rgb(face)) else INK
        if certified is None:
            axes.text(column, row, percent(cell.share, 0), ha="center", va="center", fontsize=9, color=ink)
        else:
            certified.draw(axes, (row, column), face, ink)
        if panel.numbers:
            corner = (column - 0.44, row - 0.4)
            axes.annotate(str(panel.numbers[row, column]), corner, fontsize=6, color=ink, va="top")
    image = axes.imshow(shares, cmap=colours, vmin=0, vmax=100, aspect="auto")
    axes.set_xticks(range(len(panel.columns)), [""] * len(panel.columns) if panel.numbers else panel.columns)
    axes.set_yticks(range(len(panel.rows)), panel.rows)
    axes.set_xticks([i - 0.5 for i in range(1, len(panel.columns))], minor=True)
    axes.set_yticks([i - 0.5 for i in range(1, len(panel.rows))], minor=True)
    axes.grid(which="minor", color="white", linewidth=2)
    axes.tick_params(which="both", length=0, labelcolor=INK, labelsize=9)
    axes.set_facecolor("#f4f6f8")
    for spine in axes.spines.values():
        spine.set_visible(False)
    return image


def _map_colours() -> Colormap:
    """Colours of the map: dark red over orange to pale, blue only at the very top, so that failures draw the eye.

    Red and blue ends also differ in lightness, so that the map reads without colour vision and in grey.
    """
    from matplotlib.colors import LinearSegmentedColormap

    stops = [
        (0.0, "#6b1d0e"),
        (0.4, "#c8511b"),
        (0.75, "#f2a65a"),
        (0.93, "#fbe3bf"),
        (0.975, "#eef4f8"),
        (1.0, "#b9d7ec"),
    ]
    return LinearSegmentedColormap.from_list("success", stops, N=512)


def _is_dark(colour: tuple[float, float, float]) -> bool:
    red, green, blue = colour
    return 0.299 * red + 0.587 * green + 0.114 * blue < 0.55
