"""`pipenav train`."""

from __future__ import annotations

import shlex
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from pipenav.cli.signals import stop_signals
from pipenav.errors import PipenavError
from pipenav.learning.config import DEFAULT_PRESET, TrainConfig, load_config, validate_config

if TYPE_CHECKING:
    from pipenav.learning.callback import Progress as TrainingProgress
    from pipenav.learning.train import TrainingSummary
    from pipenav.learning.training_folder import TrainingFolder


def train(
    backend: Annotated[str | None, typer.Option(help="Backend to train on; see `pipenav backends`.")] = None,
    preset: Annotated[
        str | None, typer.Option(help=f"Shipped recipe; see `pipenav presets`. Default: {DEFAULT_PRESET}.")
    ] = None,
    config: Annotated[Path | None, typer.Option(help="TOML file laid over the preset.")] = None,
    set_: Annotated[list[str] | None, typer.Option("--set", help="key=value laid over both; repeatable.")] = None,
    steps: Annotated[int | None, typer.Option(help="Control steps of all robots together.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of everything random.")] = None,
    robot: Annotated[str | None, typer.Option(help="Robot; see `pipenav robots`.")] = None,
    control: Annotated[str | None, typer.Option(help="torque or position.")] = None,
    pipes: Annotated[list[str] | None, typer.Option(help="Pipe set, file or d=90,angle=60; repeatable.")] = None,
    out: Annotated[Path | None, typer.Option(help="Run folder; default runs/PRESET.")] = None,
    start: Annotated[
        Path | None, typer.Option("--from", help="Run folder of another training, to start from its weights.")
    ] = None,
    resume: Annotated[Path | None, typer.Option(help="Run folder to go on with.")] = None,
) -> None:
    """Train a policy by PPO and save it as one file, best.zip.

    Examples:

        pipenav train --backend mujoco

        pipenav train --preset thesis-position --seed 1 --out runs/position-1

        pipenav train --pipes d=90,angle=60 --steps 50000 --set learner.epochs=4

        pipenav train --preset pirate-gravity-runs --from runs/pirate-gravity

        pipenav train --resume runs/arm
    """
    options = {
        "backend": backend,
        "steps": steps,
        "seed": seed,
        "robot": robot,
        "task.control": control,
        "pipes": pipes,
    }
    folder, resolved, where = _prepare(preset, config, set_ or [], options, out, start, resume)
    console = Console()
    console.print(f"training {where} on {resolved.backend}: {resolved.steps:,} steps, run folder {folder.path}")
    outcome = _run(console, resolved, folder, resume is not None, start)
    _tell(console, folder, outcome)
    if outcome.stopped:
        raise typer.Exit(130)


def _prepare(
    preset: str | None,
    config: Path | None,
    settings: list[str],
    options: dict[str, Any],
    out: Path | None,
    start: Path | None,
    resume: Path | None,
) -> tuple[TrainingFolder, TrainConfig, str]:
    """The run folder and its configuration, new or to be resumed."""
    from pipenav.learning.training_folder import TrainingFolder, default_training_path

    if resume is not None:
        given = [preset, config, out, start, *settings, *(value for key, value in options.items() if key != "steps")]
        if any(value is not None for value in given):
            raise PipenavError("--resume goes on with a run as it was configured: only --steps can be given with it.")
        folder, resolved = TrainingFolder.open(resume)
        if options["steps"] is not None:
            resolved = validate_config(resolved.model_dump() | {"steps": options["steps"]}, "--steps")
            folder.write_config(resolved)
        return folder, resolved, str(resume)
    preset = preset or DEFAULT_PRESET
    resolved = load_config(preset, config, settings, options)
    _check_names(resolved)
    if start is not None:
        _check_start(start, resolved)
    command = shlex.join(["pipenav", *sys.argv[1:]])
    return TrainingFolder.create(out or default_training_path(preset), resolved, command), resolved, preset


def _check_names(config: TrainConfig) -> None:
    """Refuse unknown names, and a robot or a backend that cannot do it, before a folder is made for them."""
    from pipenav.backends.registry import check_options
    from pipenav.backends.simulators import load_simulator
    from pipenav.robots.robot import load_robot
    from pipenav.tasks.registry import task_of

    kind = task_of(config.task)
    kind.check_robot(load_robot(config.robot))
    kind.parse_training_pipes(config.pipes)
    check_options(config.backend, load_simulator(config.backend), config.options)


def _check_start(start: Path, config: TrainConfig) -> None:
    """Refuse a run whose weights do not fit the new one, before a folder is made for it."""
    from pipenav.learning.training_folder import TrainingFolder
    from pipenav.robots.robot import load_robot
    from pipenav.tasks.registry import task_of

    def interface(run: TrainConfig) -> tuple[object, ...]:
        scale = task_of(run.task).observation_scale(load_robot(run.robot)).tolist()
        return run.network, run.task.kind, run.task.observation, run.task.control, scale

    _, other = TrainingFolder.open(start)
    if interface(config) != interface(other):
        raise PipenavError(
            f"{start} was trained with another network, observation or control (robot {other.robot!r}, "
            f"{other.task.kind}, {other.task.observation}, {other.task.control}, network.policy "
            f"{list(other.network.policy)}): --from takes a run that has the new one's."
        )


def _run(
    console: Console, config: TrainConfig, folder: TrainingFolder, resumed: bool, start: Path | None
) -> TrainingSummary:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f}%"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with stop_signals() as stopped, Progress(*columns, console=console) as bar:  # from here on a stop is not lost
        task = bar.add_task("loading the learner", total=config.steps)
        from pipenav.learning.train import train as run_training

        bar.update(task, description="starting")
        last_line = [0.0]

        def report(progress: TrainingProgress) -> None:
            text = (
                f"{progress.steps_per_s:,.0f} steps/s, success {progress.success:.1%}, "
                f"clearance {progress.min_range * 1e3:.0f} mm"
            )
            bar.update(task, completed=progress.steps, description=text)
            if not console.is_terminal and time.monotonic() - last_line[0] > 10:
                last_line[0] = time.monotonic()
                console.print(f"{progress.steps:>9,} of {config.steps:,} steps: {text}")

        return run_training(config, folder, resumed, report, stopped, start)


def _tell(console: Console, folder: TrainingFolder, outcome: TrainingSummary) -> None:
    if outcome.stopped:
        console.print(
            f"stopped after {outcome.steps:,} steps and saved; go on with: pipenav train --resume {folder.path}"
        )
        return
    console.print(
        f"trained {outcome.steps:,} steps in {outcome.seconds:.0f} s; best check {outcome.check_success:.1%} success\n"
        f"policy   {folder.best}\npicture  {folder.plot}\nmeasure it: pipenav eval --policy {folder.best}"
    )
