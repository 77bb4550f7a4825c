"""Tables for the terminal, and the texts of their cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.summary import percent, route_corners

if TYPE_CHECKING:
    from rich.table import Table

MISSING = "-"


def empty_table(title: str, numbers: Sequence[str], words: Sequence[str]) -> Table:
    """An empty table with right-aligned columns of numbers, then left-aligned ones of words."""
    from rich import box
    from rich.table import Table

    table = Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for heading in numbers:
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in words:
        table.add_column(heading, min_width=max(map(len, heading.splitlines())))
    return table


class CornerCells(NamedTuple):
    """Angle and turn of a pipe, as a table shows them."""

    angle: str
    turn: str


def corner_cells(record: PipeRecord) -> CornerCells:
    """Angle and turn of a corner, of a tee the way too; for a route its first corners, as its name has them."""
    if record.route is not None:
        return CornerCells("route", route_corners(record))
    if record.fitting is not None:
        name, angle, way = record.fitting.split()
        return CornerCells(f"{name} {angle}", f"{way} {record.turn}")
    bend = f", R {record.bend_radius_mm:g}" if record.bend_radius_mm else ""
    return CornerCells(f"{record.angle_deg:g}", f"{record.turn}{bend}")


def percent_text(share: float | None) -> str:
    """A share in percent, or the sign of a missing one."""
    return MISSING if share is None else percent(share)


def interval_text(low: float | None, high: float | None) -> str:
    """An interval in percent, or the sign of a missing one."""
    return MISSING if low is None or high is None else f"{percent_text(low)}-{percent_text(high)}"
