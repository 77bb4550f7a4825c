"""`pipenav experiment`: the thesis's experiments (a)-(f), trained, measured and reported."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from pipenav.cli.progress_bars import percentage_bar
from pipenav.cli.terminal import progress_console, say
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rich.console import Console

    from pipenav.experiments.jobs import Job
    from pipenav.experiments.plan import ExperimentPlan

OUT = Path("runs/experiments")
MEASURED, DONE = "What is measured", "Settings"


class _Round(NamedTuple):
    """Jobs that need the results of the round before.

    Attributes:
        doing: words for the progress bar.
        jobs_of: gives the jobs that are left to do.
    """

    doing: str
    jobs_of: Callable[[ExperimentPlan], list[Job]]


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
JobsOption = Annotated[
    int | None,
    typer.Option(min=1, help="Trainings at a time.", show_default="one for each core", rich_help_panel=DONE),
]
OutOption = Annotated[Path, typer.Option(metavar="FOLDER", help="Where results and report go.", rich_help_panel=DONE)]


def experiment(
    name: NameArgument,
    seeds: SeedsOption = 3,
    steps: StepsOption = None,
    episodes: EpisodesOption = 25,
    backend: BackendOption = "mujoco",
    jobs: JobsOption = None,
    out: OutOption = OUT,
) -> None:
    """Train and evaluate the thesis's experiments (a)-(f), and report them beside its tables.

    Finished parts are kept: after Ctrl-C the same command continues where it stopped.

    Examples:

        pipenav experiment all --seeds 3
        pipenav experiment a --seeds 1 --steps 20000 --episodes 4 --out runs/quick-look
    """
    from pipenav.backends.simulators import load_simulator
    from pipenav.experiments.definition import agents_of, chosen
    from pipenav.experiments.plan import ExperimentSettings, open_plan
    from pipenav.experiments.report import write_report
    from pipenav.storage.lock import one_writer

    experiments = chosen(name)
    if steps is not None and not agents_of(list(experiments)):
        raise PipenavError(f"experiment {name} trains nothing, so --steps would do nothing: leave it out.")
    load_simulator(backend)
    settings = ExperimentSettings(steps=steps, episodes=episodes, backend=backend)
    with one_writer(out):
        plan = open_plan(experiments, seeds, settings, out)
        _run_rounds(progress_console(), plan, jobs or os.cpu_count() or 1)
        files = write_report(plan)
    say(f"report   {out / 'report.html'}\n         {out / 'report.md'}, {len(files) - 2} pictures beside it")


def _run_rounds(console: Console, plan: ExperimentPlan, processes: int) -> None:
    """Train and measure what is missing; leaves with 128 + the signal where it is stopped."""
    from pipenav.cli.signals import stop_signals
    from pipenav.experiments.plan import add_elapsed

    threads = max(1, (os.cpu_count() or 1) // processes)
    with stop_signals() as stopped:
        for this in _rounds(threads):
            end = _run_round(console, this.doing, this.jobs_of(plan), processes, stopped)
            add_elapsed(plan, end.seconds)
            if not end.complete:
                say(f"stopped and saved in {plan.out}; the same command goes on from there")
                raise typer.Exit(stopped.exit_code)


def _rounds(threads: int) -> Sequence[_Round]:
    from pipenav.experiments.jobs import evaluation_jobs, training_jobs

    return (
        _Round("training", lambda plan: training_jobs(plan, threads)),
        _Round("measuring the front halves", lambda plan: evaluation_jobs(plan, threads, ("reach",))),
        # These may need the agent that reached most targets.
        _Round("measuring passages", lambda plan: evaluation_jobs(plan, threads, ("reach-rear", "locate", "passage"))),
    )


def _run_round(console: Console, doing: str, jobs: list[Job], processes: int, stopped: Callable[[], bool]) -> _RoundEnd:
    """Run a round's jobs under a progress bar."""
    from pipenav.experiments.runner import run_jobs

    taken = [0.0]
    with percentage_bar(console, speed_estimate_period=600.0) as bar:
        task = bar.add_task(f"{doing}: {len(jobs)} jobs", total=1.0)

        def report(message: str, share: float, seconds: float) -> None:
            taken[0] = seconds
            bar.update(task, completed=share)
            if message:
                say(f"{seconds:6.0f} s  {message}", console=bar.console)

        complete = run_jobs(jobs, processes, report, stopped)
        bar.update(task, completed=1.0 if complete else None)
    return _RoundEnd(complete, taken[0])
