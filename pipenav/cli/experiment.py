"""`pipenav experiment`: the thesis's experiments (a)-(f), trained, measured and reported."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from pipenav.experiments.runner import ExperimentPlan, Job


def experiment(
    name: Annotated[str, typer.Argument(metavar="a|b|c|d|e|f|all", help="One experiment of the thesis, or all.")],
    seeds: Annotated[int, typer.Option(min=1, help="Seeds 0, 1, ... that every agent is trained with.")] = 3,
    steps: Annotated[
        int | None, typer.Option(min=1, help="Control steps of each training.", show_default="the thesis's 120,000")
    ] = None,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes per pipe, agent and seed.")] = 25,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Trainings at a time.", show_default="one for each core")
    ] = None,
    backend: Annotated[str, typer.Option(help="Simulator backend; see `pipenav backends`.")] = "mujoco",
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Where results and report go.")] = Path(
        "runs/experiments"
    ),
) -> None:
    """Train and evaluate the thesis's experiments (a)-(f), and report them beside its tables.

    What is there already is kept: after Ctrl-C the same command goes on where it was stopped.

    Examples:

        pipenav experiment all --seeds 3

        pipenav experiment a --seeds 1 --steps 20000 --episodes 4 --out runs/quick-look
    """
    from pipenav.backends.simulators import load_simulator
    from pipenav.cli.signals import stop_signals
    from pipenav.experiments.definition import chosen
    from pipenav.experiments.report import write_report
    from pipenav.experiments.runner import Settings, add_elapsed, evaluation_jobs, open_plan, training_jobs

    experiments = chosen(name)
    load_simulator(backend)
    plan = open_plan(experiments, seeds, Settings(steps=steps, episodes=episodes, backend=backend), out)
    cores = os.cpu_count() or 1
    processes = jobs or cores
    threads = max(1, cores // processes)
    console = Console()
    rounds: Sequence[tuple[str, Callable[[ExperimentPlan], list[Job]]]] = (
        ("training", lambda p: training_jobs(p, threads)),
        ("measuring the fronts", lambda p: evaluation_jobs(p, threads, ("reach",))),
        # These may need the best agent of the fronts.
        ("measuring passages", lambda p: evaluation_jobs(p, threads, ("reach-rear", "locate", "passage"))),
    )
    with stop_signals() as stopped:
        for what, jobs_of in rounds:
            complete, seconds = _run_round(console, what, jobs_of(plan), processes, stopped)
            add_elapsed(plan, seconds)
            if not complete:
                console.print(f"stopped and saved in {out}; the same command goes on from there")
                raise typer.Exit(130)
    files = write_report(plan)
    console.print(f"report   {out / 'report.html'}\n         {out / 'report.md'}, {len(files) - 2} pictures beside it")


def _run_round(
    console: Console, what: str, jobs: list[Job], processes: int, stopped: Callable[[], bool]
) -> tuple[bool, float]:
    """Run a round's jobs under a progress bar: whether all were done, and the seconds that they took."""
    from pipenav.experiments.runner import run_jobs

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f}%"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    taken = [0.0]
    with Progress(*columns, console=console, speed_estimate_period=600.0) as bar:
        task = bar.add_task(f"{what}: {len(jobs)} jobs", total=1.0)

        def report(message: str, share: float, seconds: float) -> None:
            taken[0] = seconds
            bar.update(task, completed=share)
            if message:
                bar.console.print(f"{seconds:6.0f} s  {message}", highlight=False)

        complete = run_jobs(jobs, processes, report, stopped)
        bar.update(task, completed=1.0 if complete else None)
    return complete, taken[0]
