"""The report of `pipenav gen-pipe`: files that were made, and dimensions that decide whether a robot fits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pipenav.units import m_to_mm, rad_to_deg

if TYPE_CHECKING:
    from pipenav.pipes.corner import PipeCorner
    from pipenav.pipes.network import PipeNetwork
    from pipenav.pipes.route import PipeRoute
    from pipenav.pipes.route_corner import Corner


class Dimension(NamedTuple):
    """A line about a dimension: its name, its value with the unit, and what it means."""

    name: str
    value: str
    meaning: str


def report(folder: Path, purposes: dict[str, str], dimensions: list[Dimension]) -> None:
    """Say what was made.

    Args:
        folder: folder of the pipe.
        purposes: files of the folder, each with one line that says what it is for.
        dimensions: dimensions of the pipe.
    """
    from rich.table import Table
    from rich.text import Text

    from pipenav.cli.terminal import say, show

    say(f"Made {folder}", "bold")
    files = Table.grid(padding=(0, 2))
    for name, purpose in purposes.items():
        files.add_row("", Text(name, style="cyan"), purpose)
    show(files, "")
    sizes = Table.grid(padding=(0, 2))
    for dimension in dimensions:
        value = Text(dimension.value, style="bold", justify="right")
        sizes.add_row("", dimension.name, value, dimension.meaning)
    show(sizes)


def corner_dimensions(pipe: PipeCorner) -> list[Dimension]:
    """Dimensions of a corner that decide whether a robot fits."""
    bend = f"{m_to_mm(pipe.bend_radius):.1f} mm" if pipe.bend_radius else "none"
    return [
        Dimension("diameter", f"{m_to_mm(pipe.diameter):.1f} mm", "inside"),
        Dimension("angle", f"{rad_to_deg(pipe.angle):.1f} deg", _heading(pipe)),
        Dimension("bend radius", bend, "of the centre line" if pipe.bend_radius else "a mitre"),
        Dimension("leg", f"{m_to_mm(pipe.leg):.1f} mm", "each, from the crossing of the centre lines"),
        Dimension("wall", f"{m_to_mm(pipe.wall):.1f} mm", "outside of the diameter"),
        Dimension("gap", f"{m_to_mm(pipe.gap):.1f} mm", "across the corner, from wall to wall"),
        Dimension(
            "inner edge", f"{m_to_mm(pipe.inner_edge):.1f} mm", "before the corner, where the inner wall begins to turn"
        ),
    ]


def _heading(pipe: PipeCorner) -> str:
    change = abs(rad_to_deg(pipe.heading_change))
    return f"interior: the heading changes by {change:g} deg to the {pipe.turn}" if change else "a straight pipe"


def route_dimensions(route: PipeRoute) -> list[Dimension]:
    """Dimensions of a route and of every corner in it that decide whether a robot fits."""
    plane = "in one plane" if route.planar else "in space"
    dimensions = [
        Dimension("diameter", f"{m_to_mm(route.diameter):.1f} mm", "inside"),
        Dimension("wall", f"{m_to_mm(route.wall):.1f} mm", "outside of the diameter"),
        Dimension("length", f"{sum(route.straights):.2f} m", f"along the centre line, {plane}"),
        Dimension("start", f"{m_to_mm(route.straights[0]):.1f} mm", "to the first corner"),
    ]
    for i, (corner, straight) in enumerate(zip(route.corners, route.straights[1:], strict=True), 1):
        what = f"{_kind(corner)} {i}"
        dimensions.append(Dimension(what, _size(corner), f"{_course(corner)}, then {m_to_mm(straight):.1f} mm"))
        for branch in corner.branches:
            long = f"{m_to_mm(branch.length):.1f} mm long{', capped' if branch.closed else ''}"
            dimensions.append(Dimension("  branch", f"{m_to_mm(branch.diameter):.1f} mm", f"{branch.course}, {long}"))
    if route.capped:
        dimensions.append(Dimension("end", "cap", "closes the far end"))
    return dimensions


def _kind(corner: Corner) -> str:
    if corner.branches:
        return "tee" if len(corner.branches) == 1 else "cross"
    return "reducer" if corner.reducer else "corner"


def _size(corner: Corner) -> str:
    """The number that says most about a corner: its angle, or the bore behind a reducer."""
    if corner.reducer and corner.to_diameter is not None:
        return f"{m_to_mm(corner.to_diameter):.1f} mm"
    return f"{rad_to_deg(corner.angle):.1f} deg"


def _course(corner: Corner) -> str:
    if corner.reducer:
        return f"over {m_to_mm(corner.length):g} mm" if corner.length else "in a step"
    roll = f" after a roll of {rad_to_deg(corner.roll):g} deg" if corner.roll else ""
    bend = f" in a bend of {m_to_mm(corner.bend_radius):g} mm" if corner.bend_radius else ""
    to = f" into {m_to_mm(corner.to_diameter):g} mm" if corner.to_diameter is not None else ""
    side = "straight on" if corner.branches and corner.straight_on else f"to the {corner.turn}"
    return f"{side}{to}{bend}{roll}"


def network_dimensions(network: PipeNetwork) -> list[Dimension]:
    """Numbers of a network: its bores, its length, its fittings and its ends."""
    bores = sorted({pipe.diameter for pipe in network.pipes})
    count = [len(network.pipes_at(name)) for name in network.nodes]
    caps = sum(node.capped for node in network.nodes.values())
    words = (("bend, mitre or reducer", 2), ("tee", 3), ("cross", 4))
    return [
        Dimension("diameters", f"{', '.join(f'{m_to_mm(bore):g}' for bore in bores)} mm", "inside"),
        Dimension("wall", f"{m_to_mm(network.wall):.1f} mm", "outside of the diameters"),
        Dimension("length", f"{network.length:.2f} m", f"of {len(network.pipes)} pipes, from node to node"),
        *(Dimension(word, str(count.count(meeting)), f"{meeting} pipes meet there") for word, meeting in words),
        Dimension("ends", str(count.count(1)), f"{caps} of them capped" if caps else "all open"),
    ]
