"""`pipenav compare-backends`: a table and pictures of how far two simulators agree."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.cli.option_groups import takes_option_groups
from pipenav.cli.place_options import PlaceOptions
from pipenav.cli.terminal import progress_console, say, show

if TYPE_CHECKING:
    from rich.table import Table

    from pipenav.comparison.agreement import Check


@takes_option_groups
def compare_backends(
    where: PlaceOptions,
    reference: Annotated[str, typer.Option(help="Simulator to compare with; see `pipenav backends`.")] = "mujoco",
    other: Annotated[str, typer.Option(help="Simulator to be compared.")] = "pybullet",
    robot: Annotated[str, typer.Option(help="Robot; see `pipenav robots`.")] = "basic",
    out: Annotated[
        Path | None, typer.Option(help="Folder for the pictures; default runs/compare-OTHER-ROBOT.", show_default=False)
    ] = None,
) -> None:
    """Show how far two simulators agree: free motion, laser, passages and contact, as a table and pictures.

    The table names the allowed size of each difference. Exit code 1 if one is larger.

    Examples:

        pipenav compare-backends

        pipenav compare-backends --robot high-fidelity --out compared
    """
    from pipenav.backends.simulators import SimulatorSettings
    from pipenav.comparison.agreement import checks, compare
    from pipenav.comparison.figures import free_motion_figure, passages_figure, walls_figure
    from pipenav.drawing.style import png
    from pipenav.robots.robot import load_robot
    from pipenav.storage.atomic_files import atomic_write_all
    from pipenav.storage.lock import one_writer

    spec, names = load_robot(robot), (reference, other)
    folder = out or _default_folder(reference, other, spec.name)
    with one_writer(folder), progress_console().status(f"running {spec.name} in {reference} and in {other}"):
        agreement = compare(spec, SimulatorSettings(reference), SimulatorSettings(other), where.place())
        figures = {"free-motion": free_motion_figure, "passages": passages_figure, "walls": walls_figure}
        pictures = {folder / f"{name}.png": png(draw(spec, agreement, names)) for name, draw in figures.items()}
        atomic_write_all(pictures)
    found = checks(spec, agreement)
    show(_table(found, spec.name, names))
    say(" ".join(["pictures", *map(str, pictures)]))
    if not all(check.holds for check in found):
        raise typer.Exit(1)


def _default_folder(reference: str, other: str, robot: str) -> Path:
    """`runs/compare-OTHER-ROBOT`, with the reference in the name where it is not the usual one."""
    beside = "" if reference == "mujoco" else f"-with-{reference}"
    return Path("runs") / f"compare-{other}{beside}-{robot}"


def _table(found: list[Check], robot: str, names: tuple[str, str]) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table("difference", box=None, pad_edge=False, title_justify="left", title_style="bold")
    table.title = f"{robot}: {names[1]} against {names[0]}, largest differences"
    for heading in ("found", "allowed"):
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in ("", "why that much is allowed"):
        table.add_column(heading)
    for check in found:
        outcome = Text("holds", "green") if check.holds else Text("too large", "red")
        table.add_row(check.what, f"{check.found:.2f}", f"{check.allowed:g} {check.unit}", outcome, check.reason)
    return table
