"""`pipenav experiment`: the thesis's experiments (a)-(f), trained, measured and reported."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from pipenav.cli.option_groups import takes_option_groups
from pipenav.cli.place_options import PlaceOptions
from pipenav.cli.progress_bars import percentage_bar
from pipenav.cli.terminal import progress_console, say
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rich.console import Console

    from pipenav.experiments.jobs import Task
    from pipenav.experiments.plan import ExperimentPlan
    from pipenav.jobs import Place

OUT = Path("runs/experiments")
MEASURED, DONE = "What is measured", "Settings"


class _Round(NamedTuple):
    """Jobs that need the results of the round before.

    Attributes:
        doing: words for the progress bar.
        tasks_of: gives the trainings or evaluations that are left to do.
    """

    doing: str
    tasks_of: Callable[[ExperimentPlan], list[Task]]


class _RoundEnd(NamedTuple):
    """End of a round: whether all its jobs were done, and the seconds that they took."""

    complete: bool
    seconds: float


NameArgument = Annotated[str, typer.Argument(metavar="a|b|c|d|e|f|all", help="One experiment of the thesis, or all.")]
SeedsOption = Annotated[
    int, typer.Option(min=1, help="Seeds 0, 1, ... that every agent is trained with.", rich_help_panel=MEASURED)
]
StepsOption = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="Control steps of each training.",
        show_default="the thesis's 120,000",
        rich_help_panel=MEASURED,
    ),
]
EpisodesOption = Annotated[
    int, typer.Option(min=1, max=100_000, help="Episodes per pipe, agent and seed.", rich_help_panel=MEASURED)
]
BackendOption = Annotated[
    str, typer.Option(help="Simulator backend; see `pipenav backends`.", rich_help_panel=MEASURED)
]
OutOption = Annotated[Path, typer.Option(metavar="FOLDER", help="Where results and report go.", rich_help_panel=DONE)]


@takes_option_groups
def experiment(
    name: NameArgument,
    where: PlaceOptions,
    seeds: SeedsOption = 3,
    steps: StepsOption = None,
    episodes: EpisodesOption = 25,
    backend: BackendOption = "mujoco",
    out: OutOption = OUT,
) -> None:
    """Train and evaluate the thesis's experiments (a)-(f), and report them beside its tables.

    Finished parts are kept: after Ctrl-C the same command continues where it stopped. By default there is a process for
    each core.

    Examples:

        pipenav experiment all --seeds 3
        pipenav experiment all --seeds 3 --jobs 8
        pipenav experiment a --seeds 1 --steps 20000 --episodes 4 --out runs/quick-look
    """
    from pipenav.backends.simulators import load_simulator
    from pipenav.experiments.definition import agents_of, chosen
    from pipenav.experiments.plan import ExperimentSettings, open_plan
    from pipenav.experiments.report import write_report
    from pipenav.processes.cores import usable_cores
    from pipenav.storage.lock import one_writer

    experiments = chosen(name)
    if steps is not None and not agents_of(list(experiments)):
        raise PipenavError(f"experiment {name} trains nothing, so --steps would do nothing: leave it out.")
    load_simulator(backend)
    settings = ExperimentSettings(steps=steps, episodes=episodes, backend=backend)
    with one_writer(out):
        plan = open_plan(experiments, seeds, settings, out)
        _run_rounds(progress_console(), plan, where.place(default_jobs=usable_cores()))
        files = write_report(plan)
    say(f"report   {out / 'report.html'}\n         {out / 'report.md'}, {len(files) - 2} pictures beside it")


def _run_rounds(console: Console, plan: ExperimentPlan, place: Place) -> None:
    """Train and measure what is missing; leaves with 128 + the signal where it is stopped."""
    from pipenav.cli.signals import stop_signals
    from pipenav.experiments.plan import add_elapsed
    from pipenav.experiments.report import write_unfinished_report

    with stop_signals() as stopped:
        for this in _rounds():
            end = _run_round(console, this, plan, place, stopped)
            add_elapsed(plan, end.seconds)
            if not end.complete:
                say(f"stopped and saved in {plan.out}; the same command goes on from there")
                if complete := write_unfinished_report(plan):
                    say(f"report   {plan.out / 'report.html'} of {', '.join(complete)}, which are complete")
                raise typer.Exit(stopped.exit_code)


def _rounds() -> Sequence[_Round]:
    from pipenav.experiments.jobs import measurements, trainings

    return (
        _Round("training", trainings),
        _Round("measuring the front halves", lambda plan: measurements(plan, ("reach",))),
        # These may need the agent that reached most targets.
        _Round("measuring passages", lambda plan: measurements(plan, ("reach-rear", "locate", "passage"))),
    )


def _run_round(
    console: Console, this: _Round, plan: ExperimentPlan, place: Place, stopped: Callable[[], bool]
) -> _RoundEnd:
    """Run a round's trainings or evaluations under a progress bar."""
    from pipenav.experiments.runner import run_tasks

    taken, tasks = [0.0], this.tasks_of(plan)
    with percentage_bar(console, speed_estimate_period=600.0) as bar:
        task = bar.add_task(f"{this.doing}: {len(tasks)} jobs", total=1.0)

        def report(message: str, share: float, seconds: float) -> None:
            taken[0] = seconds
            bar.update(task, completed=share)
            if message:
                say(f"{seconds:6.0f} s  {message}", console=bar.console)

        complete = run_tasks(tasks, place, report, stopped)
        bar.update(task, completed=1.0 if complete else None)
    return _RoundEnd(complete, taken[0])
