"""The pictures of an evaluation, in percent, millimetres and degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from pipenav.drawing.style import INK, MARKERS, heading, plain
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.pipe_results import PipeRecord, by_diameter
from pipenav.evaluation.results import Evaluation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage


SINGLE_ANGLE_DODGE = 0.9
"""Sideways step [deg] between the diameters where all stand at one angle and would hide each other."""


MOST_TICKS = 24
"""Most positions along an axis that are all written on it."""

CORNER_AXIS = "interior corner angle [deg] (smaller is sharper)"
ROUTE_AXIS = "number of the route, in the order given"


class Cell(NamedTuple):
    """Episodes of one diameter and angle, or of one route: how many there were, how many succeeded."""

    successes: int
    episodes: int

    @property
    def share(self) -> float:
        return self.successes / self.episodes


def headline(evaluation: Evaluation) -> str:
    """Subject and success of an evaluation, in one line."""
    low, high = evaluation.success_low, evaluation.success_high
    return (
        f"{evaluation.policy}: {percent(evaluation.success)} % of {evaluation.episodes:,} episodes "
        f"(95 % interval {percent(low)}–{percent(high)})"
    )


def circumstances(evaluation: Evaluation) -> str:
    """Circumstances of an evaluation, in one line."""
    pipes = len(evaluation.pipes)
    settings = ", ".join(f"{name} {value}" for name, value in evaluation.options.items())
    return (
        f"stage {evaluation.stage}, {pipes} pipe{'s' if pipes > 1 else ''} × {evaluation.episodes_per_pipe} episodes, "
        f"{evaluation.robot} robot, backend {evaluation.backend}{settings and f' ({settings})'}, "
        f"seed {evaluation.seed}"
    )


def percent(share: float, decimals: int = 1) -> str:
    """A share in percent; it reads 100 and 0 only where nothing, or everything, failed."""
    if share in (0.0, 1.0):
        return f"{share * 100:.0f}"
    least = 10.0**-decimals
    return f"{min(max(share * 100, least), 100 - least):.{decimals}f}"


def pooled(pipes: Sequence[PipeRecord]) -> dict[float, Cell]:
    """Episodes of single corners by angle [deg], ascending, turns together."""
    cells: dict[float, Cell] = {}
    for record in pipes:
        if record.angle_deg is not None:
            before = cells.get(record.angle_deg, Cell(0, 0))
            cells[record.angle_deg] = Cell(before.successes + record.successes, before.episodes + record.episodes)
    return dict(sorted(cells.items()))


def route_cells(evaluation: Evaluation) -> dict[float, dict[float, Cell]]:
    """Episodes in routes, by diameter [mm], widest first, and by the route's number among all routes, from 1."""
    routes = [record for record in evaluation.pipes if record.route is not None]
    numbers = {id(record): number for number, record in enumerate(routes, 1)}
    return {
        diameter: {float(numbers[id(r)]): Cell(r.successes, r.episodes) for r in group}
        for diameter, group in by_diameter(routes).items()
    }


def success_figure(evaluation: Evaluation) -> Figure:
    """Success over the corner angle, one line per diameter with its Wilson 95 % band, left and right together.

    Routes have no one angle: where nothing else was evaluated it is success over the route's number, as points.
    """
    from matplotlib import colormaps
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    figure = Figure((9.0, 5.4), facecolor="white", layout="constrained")
    axes = figure.add_subplot()
    plain(axes)
    corners = [record for record in evaluation.pipes if record.route is None]
    lines = {d: pooled(records) for d, records in by_diameter(corners).items()} if corners else route_cells(evaluation)
    angles = sorted({angle for line in lines.values() for angle in line})
    shades = colormaps["viridis"]
    lowest = 1.0
    for i, (diameter, line) in enumerate(lines.items()):
        colour = shades(0.86 * (1 - i / (len(lines) - 1)) if len(lines) > 1 else 0.3)  # narrow, hence hard, is dark
        dodge = (i - (len(lines) - 1) / 2) * SINGLE_ANGLE_DODGE if len(angles) == 1 else 0.0
        # Lines at 100 % cover each other: the first ones are the thicker, and stay visible below the later ones.
        weight = 1.0 + 1.2 * (1 - i / (len(lines) - 1)) if len(lines) > 1 else 1.0
        style = _Style(colour, MARKERS[i % len(MARKERS)], weight, dodge)
        lowest = min(lowest, _draw_line(axes, f"{diameter:g} mm", line, style, joined=bool(corners)))
    floor = 5 * math.floor((100 * lowest - 2) / 5)
    bottom = floor if floor >= 50 else 0  # a cut axis shows small differences; it must not flatter a poor policy
    axes.set(ylim=(bottom - (100 - bottom) * 0.02, 100 + (100 - bottom) * 0.03), ylabel="success [%]")
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10], integer=True))
    margin = 0.025 * (angles[-1] - angles[0]) or 5.0
    label = CORNER_AXIS if corners else ROUTE_AXIS
    axes.set(xlabel=label, xlim=(angles[0] - margin, angles[-1] + margin))
    if len(angles) <= MOST_TICKS:
        axes.set_xticks(angles, [f"{angle:g}" for angle in angles])
    beside = (1.0, 0.5)
    axes.legend(title="pipe diameter", loc="center left", bbox_to_anchor=beside, frameon=False, labelcolor=INK)
    given = {record.turn for record in corners}
    turns = "left and right turns together" if len(given) > 1 else f"{given.pop()} turns" if given else "routes"
    title = "Success over the corner angle" if corners else "Success of every route"
    _title(axes, title, evaluation, f"{turns}; Wilson 95 % intervals")
    return figure


class _Style(NamedTuple):
    """Style of one diameter: `weight` scales its line, `dodge` moves it sideways [deg]."""

    colour: tuple[float, float, float, float]
    marker: str
    weight: float
    dodge: float


def _draw_line(axes: Axes, label: str, line: dict[float, Cell], style: _Style, joined: bool) -> float:
    """Draw one diameter; returns the lowest end of its intervals."""
    x = [angle + style.dodge for angle in line]
    share = [100 * cell.share for cell in line.values()]
    intervals = [wilson(*cell) for cell in line.values()]
    low, high = [100 * interval.low for interval in intervals], [100 * interval.high for interval in intervals]
    if len(line) == 1 or not joined:  # a band of no width would not be seen
        error = [[y - end for y, end in zip(share, low, strict=True)]]
        error += [[end - y for y, end in zip(share, high, strict=True)]]
        artist = axes.errorbar(x, share, error, color=style.colour, capsize=4, lw=1.6, label=label, clip_on=False)[0]
        artist.set(marker=style.marker, markersize=7, linestyle="-" if joined else "")
    else:
        axes.fill_between(x, low, high, color=style.colour, alpha=0.09, linewidth=0)
        artist = axes.plot(x, share, color=style.colour, lw=1.6 * style.weight, label=label, clip_on=False)[0]
        artist.set(marker=style.marker, markersize=4.5 * style.weight**0.7, markeredgecolor="white")
    return min(low) / 100


def map_figure(evaluation: Evaluation) -> Figure:
    """Success by diameter and angle with the numbers in the cells, one panel for each turn and one for routes."""
    from matplotlib.figure import Figure

    maps: dict[str, dict[float, dict[float, Cell]]] = {}
    for turn in ("left", "right"):
        groups = by_diameter([record for record in evaluation.pipes if record.turn == turn])
        maps[f"{turn} turn"] = {diameter: pooled(group) for diameter, group in groups.items()}
    angles = sorted({angle for cells in maps.values() for line in cells.values() for angle in line})
    maps["routes"] = route_cells(evaluation)
    numbers = sorted(number for line in maps["routes"].values() for number in line)
    maps = {name: cells for name, cells in maps.items() if cells}
    rows = len(evaluation.diameters)
    columns = max(len(angles), len(numbers))
    width, height = max(0.56 * columns + 2.2, 6.5), len(maps) * (0.42 * rows + 0.75) + 1.2 + 0.3 * ("routes" in maps)
    figure = Figure((width, height), facecolor="white", layout="constrained")
    panels = figure.subplots(len(maps), 1, squeeze=False)[:, 0]
    for (name, cells), axes in zip(maps.items(), panels, strict=True):
        ticks = numbers if name == "routes" else angles
        image = _draw_map(axes, cells, ticks, [row.diameter_mm for row in evaluation.diameters])
        axes.set_ylabel(f"{name}\ndiameter [mm]", color=INK)
        if name == list(maps)[-1] or "routes" in maps:
            axes.set_xlabel(ROUTE_AXIS if name == "routes" else CORNER_AXIS, color=INK)
    bar = figure.colorbar(image, ax=list(panels), label="success [%]", fraction=0.05, pad=0.015, aspect=12 * len(maps))
    bar.outline.set_visible(False)
    title = "Success by diameter and corner angle" if angles else "Success by diameter and route"
    _title(panels[0], title, evaluation, "percent of the episodes; empty: not run")
    return figure


def _draw_map(
    axes: Axes, cells: dict[float, dict[float, Cell]], ticks: list[float], diameters: list[float]
) -> AxesImage:
    """Draw one panel: rows are diameters, widest on top, columns are angles or routes; returns its image."""
    shares = [[math.nan] * len(ticks) for _ in diameters]
    colours = _map_colours()
    for diameter, line in cells.items():
        for tick, cell in line.items():
            row, column = diameters.index(diameter), ticks.index(tick)
            shares[row][column] = 100 * cell.share
            ink = "white" if _is_dark(colours(cell.share)) else INK
            axes.text(column, row, percent(cell.share, 0), ha="center", va="center", fontsize=9, color=ink)
    image = axes.imshow(shares, cmap=colours, vmin=0, vmax=100, aspect="auto")
    axes.set_xticks(range(len(ticks)), [f"{tick:g}" for tick in ticks])
    axes.set_yticks(range(len(diameters)), [f"{diameter:g}" for diameter in diameters])
    axes.set_xticks([i - 0.5 for i in range(1, len(ticks))], minor=True)
    axes.set_yticks([i - 0.5 for i in range(1, len(diameters))], minor=True)
    axes.grid(which="minor", color="white", linewidth=2)
    axes.tick_params(which="both", length=0, labelcolor=INK, labelsize=9)
    axes.set_facecolor("#f4f6f8")
    for spine in axes.spines.values():
        spine.set_visible(False)
    return image


def _map_colours() -> Colormap:
    """From dark red over orange to pale where little fails, blue only at the very top: failures draw the eye.

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


def _title(axes: Axes, title: str, evaluation: Evaluation, note: str) -> None:
    heading(axes, title, f"{headline(evaluation)}\n{circumstances(evaluation)}\n{note}")
