"""map.png: success by diameter and corner angle, or by diameter and route, as numbers in cells."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from pipenav.drawing.style import INK, heading
from pipenav.evaluation.cells import Cell, NumberedRoute, by_fitting, in_order, numbered_routes
from pipenav.evaluation.coarse import coarse
from pipenav.evaluation.pipe_results import by_diameter
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


class _Panel(NamedTuple):
    """A panel of cells.

    Attributes:
        name: what its pipes are, such as `left turn`.
        rows: labels of the rows.
        columns: labels of the columns.
        cells: episodes by row and column.
        numbers: numbers of the routes by row and column; empty for corners.
    """

    name: str
    rows: list[str]
    columns: list[str]
    cells: dict[tuple[int, int], Cell]
    numbers: dict[tuple[int, int], int]


def map_figure(evaluation: Evaluation) -> Figure:
    """Success with the numbers in the cells, one panel for each turn and one for routes."""
    from matplotlib.figure import Figure

    evaluation, rounded = coarse(evaluation)
    panels = _panels(evaluation)
    corners = any(not panel.numbers for panel in panels)
    heights = [0.42 * len(panel.rows) + 0.9 for panel in panels]
    width = max(0.56 * max(len(panel.columns) for panel in panels) + 2.2, 8.5)
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
    note = f"percent of the episodes; empty: not run{'; ' * bool(rounded)}{rounded}"
    heading(grid[0], title, f"{headline(evaluation)}\n{circumstances(evaluation)}\n{note}")
    return figure


def _corner_axis(columns: list[str]) -> str:
    """Meaning of the columns of single corners."""
    bends, tees = any("D" in column for column in columns), any("\n" in c and "D" not in c for c in columns)
    return CORNER_AXIS + ", bend radius" * bends + "; of a tee its branch's angle and the robot's way" * tees


def _panels(evaluation: Evaluation) -> list[_Panel]:
    """Panels of the turns and of the routes that were run."""
    turns = {
        turn: {
            d: by_fitting(group) for d, group in by_diameter([r for r in evaluation.pipes if r.turn == turn]).items()
        }
        for turn in ("left", "right")
    }
    turns = {turn: lines for turn, lines in turns.items() if lines}
    fittings = in_order(fitting for lines in turns.values() for line in lines.values() for fitting in line)
    diameters = sorted({d for lines in turns.values() for d in lines}, reverse=True)
    panels = []
    for turn, lines in turns.items():
        cells = {
            (diameters.index(d), fittings.index(fitting)): cell
            for d, line in lines.items()
            for fitting, cell in line.items()
        }
        panels.append(_Panel(f"{turn} turn", [f"{d:g}" for d in diameters], [one.label for one in fittings], cells, {}))
    groups = numbered_routes(evaluation)
    return [*panels, _routes_panel(groups)] if groups else panels


def _routes_panel(groups: dict[float, list[NumberedRoute]]) -> _Panel:
    """Panel of routes: a row for each diameter, or several where it has many routes."""
    columns = min(MOST_COLUMNS, max(map(len, groups.values())))
    panel = _Panel("routes", [], [str(column + 1) for column in range(columns)], {}, {})
    for diameter, routes in groups.items():
        for start in range(0, len(routes), columns):
            for column, route in enumerate(routes[start : start + columns]):
                panel.cells[len(panel.rows), column] = route.cell
                panel.numbers[len(panel.rows), column] = route.number
            panel.rows.append("" if start else f"{diameter:g}")
    return panel


def _draw_map(axes: Axes, panel: _Panel) -> AxesImage:
    """Draw one panel; returns its image."""
    shares = [[math.nan] * len(panel.columns) for _ in panel.rows]
    colours = _map_colours()
    for (row, column), cell in panel.cells.items():
        shares[row][column] = 100 * cell.share
        ink = "white" if _is_dark(colours(cell.share)) else INK
        axes.text(column, row, percent(cell.share, 0), ha="center", va="center", fontsize=9, color=ink)
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


def _is_dark(rgba: tuple[float, float, float, float]) -> bool:
    red, green, blue, _ = rgba
    return 0.299 * red + 0.587 * green + 0.114 * blue < 0.55
