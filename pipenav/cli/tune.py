"""`pipenav tune`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from pipenav.cli.option_groups import takes_option_groups
from pipenav.cli.place_options import PlaceOptions
from pipenav.cli.progress_bars import percentage_bar
from pipenav.cli.terminal import progress_console, say, show
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from rich.table import Table

    from pipenav.jobs import Place
    from pipenav.tuning.search import Search, SearchNews

SEARCHED, TRAINED = "What is searched", "Trainings"

SHOWN_ROWS = 10
"""Rows of the table that the terminal shows; the report has all."""

SpaceOption = Annotated[
    str,
    typer.Option(help="Search space, by name or as FILE.toml; see `pipenav list spaces`.", rich_help_panel=SEARCHED),
]
TrialsOption = Annotated[int, typer.Option(min=1, max=100_000, help="Settings to try.", rich_help_panel=SEARCHED)]
ObjectiveOption = Annotated[
    Literal["steps", "seconds", "success"],
    typer.Option(help="Steps or seconds before the first success, or success at the end.", rich_help_panel=SEARCHED),
]
SuccessOption = Annotated[
    str, typer.Option(metavar="PERCENT", help="Success of a check that counts as one.", rich_help_panel=SEARCHED)
]
AgainOption = Annotated[
    int,
    typer.Option(
        min=0, max=100, help="Other seeds with which the best and the preset are trained.", rich_help_panel=SEARCHED
    ),
]
ConfigOption = Annotated[
    Path | None, typer.Option(help="TOML file over the space's preset, as train takes it.", rich_help_panel=TRAINED)
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", help="key=value for all trials, as train takes it; repeatable.", rich_help_panel=TRAINED),
]
StepsOption = Annotated[int | None, typer.Option(help="Control steps of each trial.", rich_help_panel=TRAINED)]
SeedOption = Annotated[
    int, typer.Option(min=0, max=2**32 - 1, help="Seed of suggestions and trainings.", rich_help_panel=TRAINED)
]
OutOption = Annotated[
    Path | None, typer.Option(metavar="FOLDER", help="Folder; default runs/tune-SPACE.", rich_help_panel=TRAINED)
]


@takes_option_groups
def tune(
    where: PlaceOptions,
    space: SpaceOption = "arm",
    trials: TrialsOption = 24,
    objective: ObjectiveOption = "steps",
    success: SuccessOption = "99%",
    again: AgainOption = 2,
    config: ConfigOption = None,
    set_: SetOption = None,
    steps: StepsOption = None,
    seed: SeedOption = 0,
    out: OutOption = None,
) -> None:
    """Search for better settings of a training, by many short trainings that tell where to look next.

    After Ctrl-C, or a kill, the same command goes on where it stopped. More --trials go on with a search that is done.

    Examples:

        pipenav tune --trials 24 --jobs 2
        pipenav tune --space pirate --objective seconds --success 95% --jobs 2
        pipenav tune --space my-space.toml --objective success --steps 60000
        pipenav train --config runs/tune-arm/best.toml
    """
    from pipenav.cli.percentages import share_of
    from pipenav.storage.lock import one_writer
    from pipenav.tuning.objective import Objective
    from pipenav.tuning.plan import BaseTraining, checked_plan
    from pipenav.tuning.search import Search
    from pipenav.tuning.space import load_space
    from pipenav.tuning.study import require_optuna

    require_optuna()
    place = where.place()
    base = BaseTraining(load_space(space), config, set_ or [], steps, seed)
    aim = Objective(name=objective, success=share_of(success, "--success"))
    folder = out or Path("runs") / f"tune-{Path(space).stem}"
    plan = checked_plan(base, aim, trials, again, folder)
    with one_writer(folder):
        _run(Search(plan), place)


def _run(search: Search, place: Place) -> None:
    """Run a search under a progress bar, and report it; leaves with 128 + the signal where it is stopped."""
    from pipenav.cli.signals import stop_signals
    from pipenav.tuning.report import BEST_FILE, REPORT_FILE, verdict, write_report

    plan, complete = search.plan, False
    say(
        f"searching {len(plan.space.space)} settings for {plan.objective.title} by {plan.trials} trials on {place.name}"
    )
    with stop_signals() as stopped:
        try:
            with percentage_bar(progress_console(), speed_estimate_period=600.0) as bar:
                task = bar.add_task("training", total=1.0)

                def told(news: SearchNews) -> None:
                    bar.update(task, completed=news.share)
                    if news.ended:
                        say(news.ended, console=bar.console)

                complete = search.run(place, told, stopped)
        except PipenavError:
            if search.preset() is not None:
                write_report(search)  # of what is done, where a job was lost or settings cannot be trained
            raise
        if not complete:
            say(f"stopped and saved in {plan.out}; the same command goes on from there")
            raise typer.Exit(stopped.exit_code)
    write_report(search)
    show(_table(search))
    say(f"{verdict(search)}\nreport   {plan.out / REPORT_FILE}")
    if search.best() is not None:
        settings = plan.out / BEST_FILE
        say(f"settings {settings}\ntrain with them: {shlex.join(['pipenav', 'train', '--config', str(settings)])}")


def _table(search: Search) -> Table:
    """The best trials, a row each."""
    from rich.table import Table
    from rich.text import Text

    from pipenav.tuning.report import trial_rows

    table = Table(box=None, pad_edge=False)
    settings = [key.rpartition(".")[2] for key in search.plan.space.space]
    for heading in ("trial", search.plan.objective.title, "success [%]", "seconds", "", *settings):
        table.add_column(Text(heading))
    for row in trial_rows(search)[:SHOWN_ROWS]:
        table.add_row(*map(Text, (row.name, row.value, row.success, row.seconds, row.state, *row.settings)))
    return table
