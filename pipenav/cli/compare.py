"""`pipenav compare`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.cli.terminal import say, show
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from pipenav.driving.comparison import DriverRow, MeanInterval


def compare(
    folders: Annotated[
        list[Path], typer.Argument(metavar="FOLDER...", help="Drive folders, the first to compare with.")
    ],
) -> None:
    """Put drivers beside each other on the same numbered pipes: by hand, a policy, a baseline, shared control.

    pipenav drive --policy pirate-strong --operator none --out alone

    pipenav drive --policy pirate-strong --operator scripted --out shared

    pipenav compare alone shared
    """
    from pipenav.driving.comparison import compare as compared
    from pipenav.driving.records import read_records

    if len(folders) < 2:
        raise PipenavError("one folder alone has nothing to be compared with: name two or more.")
    rows = compared([read_records(folder) for folder in folders])
    show(_table(rows))
    say(
        f"{rows[0].episodes} episodes that all of them drove. Time: of those that passed. Force: the peak "
        "of an episode. In brackets: 95 % interval of the mean. + and -: episodes that this driver passed and the "
        "first one did not, and the other way round."
    )


def _table(rows: Sequence[DriverRow]) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in (
        "driver",
        "passed",
        "success %",
        "95 %",
        "time s",
        "take-overs",
        "by hand %",
        "force N",
        "+",
        "-",
    ):
        table.add_column(column, justify="left" if column == "driver" else "right")
    for row in rows:
        disturbed = f", disturbed by {row.disturb}" if row.disturb else ""
        table.add_row(
            row.driver + disturbed,
            f"{row.passed} of {row.episodes}",
            f"{100 * row.passed / row.episodes:.1f}",
            f"{100 * row.success.low:.1f}-{100 * row.success.high:.1f}",
            _mean(row.seconds),
            _mean(row.takeovers),
            f"{100 * row.person_share:.0f}",
            _mean(row.force),
            str(row.gained),
            str(row.lost),
        )
    return table


def _mean(value: MeanInterval) -> str:
    if math.isnan(value.mean):
        return "-"
    return f"{value.mean:.1f} ({value.low:.1f}-{value.high:.1f})"
