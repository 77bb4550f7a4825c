"""`pipenav train --seeds N`: the same training with several seeds, side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from pipenav.cli.progress_bars import percentage_bar
from pipenav.cli.signals import StopRequest, stop_signals
from pipenav.cli.terminal import progress_console, say
from pipenav.cli.train_options import SeedsOptions
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.experiments.jobs import Task
    from pipenav.jobs import Place
    from pipenav.learning.config import TrainConfig

SEEDS_FILE = "seeds.json"
"""File in a folder of several trainings with their configuration."""


def train_seeds(config: TrainConfig, folder: Path, options: SeedsOptions) -> None:
    """Train every seed that is not trained yet; the same command goes on after it was stopped.

    Raises:
        PipenavError: the folder holds trainings of another configuration, or a training failed.
    """
    from pipenav.experiments.jobs import Training
    from pipenav.experiments.plan import TRAINED_FILE
    from pipenav.processes.cores import usable_cores
    from pipenav.storage.lock import one_writer

    seeds = range(config.seed, config.seed + (options.seeds or 1))
    place = options.place(default_jobs=min(len(seeds), usable_cores()))
    with one_writer(folder):
        _require_same(folder / SEEDS_FILE, config)
        folders = {seed: folder / f"seed-{seed}" for seed in seeds}
        tasks: list[Task] = [
            Training(f"seed {seed}", config.model_copy(update={"seed": seed}), path)
            for seed, path in folders.items()
            if not (path / TRAINED_FILE).exists()
        ]
        say(f"training {len(seeds)} seeds in {place.name}, {len(seeds) - len(tasks)} of them done before: {folder}")
        with stop_signals() as stopped:
            if not _run(tasks, place, stopped):
                say(f"stopped and saved in {folder}; the same command goes on from there")
                raise typer.Exit(stopped.exit_code)
    say(f"trained  {', '.join(str(path / 'best.zip') for path in folders.values())}")


def _require_same(file: Path, config: TrainConfig) -> None:
    """Keep the configuration of a folder's trainings, or refuse another one."""
    from pipenav.storage.atomic_files import atomic_write
    from pipenav.storage.text_files import read_json

    table = config.model_dump(mode="json", exclude={"seed"})
    if not file.exists():
        atomic_write(file, json.dumps(table, indent=1) + "\n")
    elif (earlier := read_json(file)) != table:
        differs = [key for key in table if not isinstance(earlier, dict) or earlier.get(key) != table[key]]
        raise PipenavError(
            f"{file.parent} holds trainings that differ in {', '.join(differs)}: give the same settings, or another "
            "--out."
        )


def _run(tasks: list[Task], place: Place, stopped: StopRequest) -> bool:
    """Run the trainings under a progress bar."""
    from pipenav.experiments.runner import run_tasks

    with percentage_bar(progress_console(), speed_estimate_period=600.0) as bar:
        line = bar.add_task(f"training {len(tasks)} seeds", total=1.0)

        def report(message: str, share: float, seconds: float) -> None:
            bar.update(line, completed=share)
            if message:
                say(f"{seconds:6.0f} s  {message}", console=bar.console)

        complete = run_tasks(tasks, place, report, stopped)
        bar.update(line, completed=1.0 if complete else None)
    return complete
