"""`pipenav train`."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipenav.cli.option_groups import takes_option_groups
from pipenav.cli.progress_bars import percentage_bar
from pipenav.cli.signals import Interrupted, StopRequest, stop_signals
from pipenav.cli.terminal import progress_console, refuse_ignored, say
from pipenav.cli.train_options import FolderOptions, SeedsOptions
from pipenav.cli.train_progress import TrainingRows
from pipenav.cli.train_seeds import train_seeds
from pipenav.errors import PipenavError, shown
from pipenav.learning.config import DEFAULT_PRESET, TrainConfig, load_config, preset_below

if TYPE_CHECKING:
    from rich.console import Console

    from pipenav.learning.train import TrainingSummary
    from pipenav.learning.training_folder import TrainingFolder

CONFIG_HELP = 'TOML file whose keys override the preset; extends = "PRESET" in it stands for --preset.'
RECIPE = "Recipe"

BackendOption = Annotated[
    str | None, typer.Option(help="Backend to train on; see `pipenav backends`.", rich_help_panel=RECIPE)
]
PresetOption = Annotated[
    str | None,
    typer.Option(help=f"Shipped recipe; see `pipenav presets`. Default: {DEFAULT_PRESET}.", rich_help_panel=RECIPE),
]
ConfigOption = Annotated[Path | None, typer.Option(help=CONFIG_HELP, rich_help_panel=RECIPE)]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="key=value that overrides both, in all stages; stages.NAME.key in one; repeatable.",
        rich_help_panel=RECIPE,
    ),
]
StepsOption = Annotated[
    int | None, typer.Option(help="Control steps of all robots together, in all stages.", rich_help_panel=RECIPE)
]
SeedOption = Annotated[int | None, typer.Option(help="Seed of everything random.", rich_help_panel=RECIPE)]
RobotOption = Annotated[str | None, typer.Option(help="Robot; see `pipenav robots`.", rich_help_panel=RECIPE)]
ControlOption = Annotated[str | None, typer.Option(help="torque or position.", rich_help_panel=RECIPE)]
PipesOption = Annotated[
    list[str] | None,
    typer.Option(help="Pipe set, file or d=90,angle=60; repeatable.", rich_help_panel=RECIPE),
]


@takes_option_groups
def train(
    folders: FolderOptions,
    several: SeedsOptions,
    backend: BackendOption = None,
    preset: PresetOption = None,
    config: ConfigOption = None,
    set_: SetOption = None,
    steps: StepsOption = None,
    seed: SeedOption = None,
    robot: RobotOption = None,
    control: ControlOption = None,
    pipes: PipesOption = None,
) -> None:
    """Train a policy by PPO and save it as one file, best.zip.

    Examples:

        pipenav train --backend mujoco
        pipenav train --preset thesis-position --seed 1 --out runs/position-1
        pipenav train --pipes d=90,angle=60 --steps 50000 --set learner.epochs=4
        pipenav train --from runs/arm --pipes d=75,angle=58 --out runs/mine
        pipenav train --from-recordings runs/drive-1,runs/drive-2 --out runs/taught
        pipenav train --resume runs/arm
        pipenav train --preset thesis-position --seeds 8 --jobs 4 --out runs/position
    """
    several.refuse_place_alone()
    folders.refuse_two_starts()
    options = {
        "backend": backend,
        "steps": steps,
        "seed": seed,
        "robot": robot,
        "task.control": control,
        "pipes": pipes,
        "recordings.folders": folders.recordings,
    }
    recipe = _Recipe(preset, config, set_ or [], options)
    if several.seeds is None:
        _train_one(recipe, folders)
        return
    given = {"--resume": folders.resume, "--from": folders.start}
    refuse_ignored(given, "--seeds begins new trainings, and goes on with its own")
    _train_seeds(recipe, folders.out, several)


def _train_one(recipe: _Recipe, folders: FolderOptions) -> None:
    """Train, or go on; leaves with 128 + the signal where it is stopped."""
    from pipenav.storage.lock import one_writer

    out, start, resume = folders.out, folders.start, folders.resume
    path = _new_path(recipe, out, start) if resume is None else _path_to_resume(recipe, resume, out, start)
    with one_writer(path):
        training = _new_training(recipe, path, start) if resume is None else _resumed_training(recipe, path)
        say(
            f"training {training.name} on {training.config.backend}: {_steps_in_words(training.config)}, "
            f"training folder {training.folder.path}"
        )
        with stop_signals() as stopped:
            summary = _run(progress_console(), training, stopped)
            _conclude(training.folder, summary)
    if summary.stopped:
        raise typer.Exit(stopped.exit_code)


def _train_seeds(recipe: _Recipe, out: Path | None, several: SeedsOptions) -> None:
    from pipenav.learning.rehearsal import rehearse

    config = recipe.config()
    _check_names(config)
    _check_recordings(config)
    rehearse(config)
    train_seeds(config, out or Path("runs") / f"{recipe.name}-seeds", several)


@dataclass(frozen=True)
class _Recipe:
    """The parts of a configuration, as they were typed."""

    preset: str | None
    file: Path | None
    settings: list[str]
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the preset below it all."""
        return preset_below(self.preset, self.file)

    def config(self) -> TrainConfig:
        """The whole configuration.

        Raises:
            PipenavError: a key is set twice, or anything else that `load_config` refuses.
        """
        given = [key for key, value in self.options.items() if value is not None]
        for text in self.settings:
            key = text.partition("=")[0].strip()
            if key in given:
                raise PipenavError(f"{key} is set twice, again by --set {shown(text, quoted=False)}: set it once.")
            given.append(key)
        return load_config(self.name, self.file, self.settings, self.options)


@dataclass(frozen=True)
class _Training:
    """A training that can begin, or go on.

    Attributes:
        name: preset or folder, for messages.
        folder: folder of the training.
        config: its configuration.
        resumed: whether it goes on.
        start: folder of another training, from whose weights it starts.
    """

    name: str
    folder: TrainingFolder
    config: TrainConfig
    resumed: bool = False
    start: Path | None = None


def _new_path(recipe: _Recipe, out: Path | None, start: Path | None) -> Path:
    """The folder of a new training that has been checked; nothing has been made yet."""
    from pipenav.learning.rehearsal import rehearse
    from pipenav.learning.training_folder import TrainingFolder, default_training_path

    config = recipe.config()
    _check_names(config)
    if start is not None:
        _check_start(start, config)
    _check_recordings(config)
    path = out or default_training_path(recipe.name)
    TrainingFolder(path).refuse_other_training()
    rehearse(config)
    return path


def _new_training(recipe: _Recipe, path: Path, start: Path | None) -> _Training:
    """A new training in a folder of its own."""
    from pipenav.learning.training_folder import TrainingFolder
    from pipenav.storage.lock import current_command

    config = recipe.config()
    return _Training(recipe.name, TrainingFolder.create(path, config, current_command()), config, start=start)


def _check_recordings(config: TrainConfig) -> None:
    """Refuse recordings that cannot be learned from, before a folder is made, and say how many there are."""
    if config.recordings.folders:
        from pipenav.learning.recordings import load_lessons

        lessons = load_lessons(config)
        say(f"a supervised start from {lessons.episodes:,} episodes, {len(lessons.actions):,} control steps")


def _steps_in_words(config: TrainConfig) -> str:
    """The length of a training: `160,000 steps in 2 stages (coarse, fine)`."""
    names = [stage.name for stage in config.stages]
    return f"{config.steps:,} steps" + (f" in {len(names)} stages ({', '.join(names)})" if names else "")


def _path_to_resume(recipe: _Recipe, path: Path, out: Path | None, start: Path | None) -> Path:
    """The folder of a training to go on with, of which only the number of steps may change."""
    from pipenav.learning.training_folder import TrainingFolder

    given = [recipe.preset, recipe.file, out, start, *recipe.settings]
    given += [value for key, value in recipe.options.items() if key != "steps"]
    if any(value is not None for value in given):
        raise PipenavError(f"--resume {path} goes on with that training's own settings: give only --steps with it.")
    TrainingFolder.open(path)
    return path


def _resumed_training(recipe: _Recipe, path: Path) -> _Training:
    """A training to go on with, as it is on the disk now that no other process writes it."""
    from pipenav.learning.training_folder import TrainingFolder

    folder, config = TrainingFolder.open(path)
    steps = recipe.options["steps"]
    if steps is not None:
        from pipenav.learning.checkpoint import steps_done
        from pipenav.learning.stages import with_steps

        config = with_steps(config, steps)
        if (done := steps_done(folder.checkpoint)) > steps:
            raise PipenavError(f"{path} has {done:,} steps behind it, given --steps {steps}: give more than that.")
    return _Training(str(path), folder, config, resumed=True)


def _check_names(config: TrainConfig) -> None:
    """Refuse unknown names, and a robot or a backend that cannot do it, before a folder is made for them."""
    from pipenav.backends.registry import check_options
    from pipenav.backends.simulators import load_simulator
    from pipenav.learning.stages import require_one_interface, training_stages
    from pipenav.robots.robot import load_robot
    from pipenav.tasks.registry import task_of

    require_one_interface(config)
    for stage in training_stages(config):
        task = task_of(stage.config.task)
        task.check_robot(load_robot(config.robot))
        task.parse_training_pipes(stage.config.pipes)
        check_options(config.backend, load_simulator(config.backend), stage.config.options)


def _check_start(start: Path, config: TrainConfig) -> None:
    """Refuse a training whose weights do not fit the new one, before a folder is made for it."""
    from pipenav.learning.stages import interface
    from pipenav.learning.training_folder import TrainingFolder

    other = TrainingFolder.open(start).config
    if interface(config) != interface(other):
        raise PipenavError(
            f"{start} was trained with another network, observation or control (robot {other.robot!r}, "
            f"{other.task.kind}, {other.task.observation}, {other.task.control}, network.policy "
            f"{list(other.network.policy)}): give --from a training that has the new one's."
        )


def _run(console: Console, training: _Training, stopped: StopRequest) -> TrainingSummary:
    config = training.config
    with _removed_if_unsaved(training.folder), percentage_bar(console) as bar:
        rows = TrainingRows(bar, config.steps)
        from pipenav.learning.train import train as run_training

        rows.loaded()
        return run_training(config, training.folder, training.resumed, rows.report, stopped, training.start)


@contextmanager
def _removed_if_unsaved(folder: TrainingFolder) -> Iterator[None]:
    """Remove the training folder if an interrupt comes before the first save."""
    try:
        yield
    except Interrupted:
        folder.remove_unsaved()
        raise


def _conclude(folder: TrainingFolder, summary: TrainingSummary) -> None:
    """Say how the training ended, and what can be done with it."""
    if summary.stopped:
        resume = shlex.join(["pipenav", "train", "--resume", str(folder.path)])
        say(f"stopped after {summary.steps:,} steps and saved; continue with: {resume}\nreport   {folder.page}")
        return
    measure = shlex.join(["pipenav", "eval", "--policy", str(folder.best)])
    say(
        f"trained {summary.steps:,} steps in {summary.seconds:.0f} s; best check {summary.check_success:.1%} success\n"
        f"policy   {folder.best}\npicture  {folder.plot}\nreport   {folder.page}\nmeasure it: {measure}"
    )
