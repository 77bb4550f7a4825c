"""`pipenav eval`."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console
from rich.progress import TaskID

from pipenav.cli.options import SIMULATOR, BackendOption, SettingsOption, parse_options
from pipenav.cli.progress_bars import episode_bar
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.evaluation.config import EvaluationConfig
    from pipenav.evaluation.evaluate import CheckedEvaluation
    from pipenav.evaluation.results import Evaluation

POLICY_HELP = "best.zip, a shipped policy's name, or baseline:random, :centreline, :sequence, :sequence-line."
STAGE_HELP = (
    "reach: a policy reaches a given target; reach-rear: then the rear half follows; "
    "locate: the robot finds a target itself; passage: locate, reach and rear; "
    "traverse: a whole robot goes through. Default: what the policy was trained for."
)
VARIANT_HELP = "How a target is located: map, or thesis for the method exactly as printed."
ROBOT_HELP = "Robot of --stage locate (basic) or of a baseline; a policy brings its own."
PIPES_HELP = (
    "Shipped set, FILE.toml or d=90,angle=60[,turn=right]; for a whole robot also sets and files of routes; repeatable."
)
DISTURB_HELP = "Disturbances, by name (docs/guides/disturbances.md) or as FILE.toml."
SUBJECT, EPISODES, RESULT = "What is measured", "In which episodes", "Result"

UNNAMED_STAGES = (None, "reach", "traverse")
"""Stages that the name of an evaluation folder leaves out: the policy's own task."""


PolicyOption = Annotated[str | None, typer.Option(help=POLICY_HELP, rich_help_panel=SUBJECT)]
# The names of StageName, with the older ones, and of Variant, whose import would slow down --help.
StageOption = Annotated[
    Literal["locate", "reach", "reach-rear", "passage", "traverse", "front", "front-rear"] | None,
    typer.Option(help=STAGE_HELP, metavar="STAGE", rich_help_panel=SUBJECT),
]
VariantOption = Annotated[Literal["map", "thesis"], typer.Option(help=VARIANT_HELP, rich_help_panel=SUBJECT)]
RobotOption = Annotated[str | None, typer.Option(help=ROBOT_HELP, rich_help_panel=SUBJECT)]
PipesOption = Annotated[list[str] | None, typer.Option(help=PIPES_HELP, rich_help_panel=EPISODES)]
EpisodesOption = Annotated[int, typer.Option(min=1, help="Episodes per pipe.", rich_help_panel=EPISODES)]
SeedOption = Annotated[int, typer.Option(min=0, help="Seed of starts and targets.", rich_help_panel=EPISODES)]
DisturbOption = Annotated[str | None, typer.Option(help=DISTURB_HELP, rich_help_panel=SIMULATOR)]
OutOption = Annotated[
    Path | None, typer.Option(help="Evaluation folder; default beside the policy.", rich_help_panel=RESULT)
]


def evaluate(
    policy: PolicyOption = None,
    stage: StageOption = None,
    variant: VariantOption = "map",
    robot: RobotOption = None,
    pipes: PipesOption = None,
    episodes: EpisodesOption = 20,
    seed: SeedOption = 0,
    backend: BackendOption = "mujoco",
    option: SettingsOption = None,
    disturb: DisturbOption = None,
    out: OutOption = None,
) -> None:
    """Measure in which pipes a policy passes: success with 95 % intervals, failures, ranges, contact, pictures.

    Every stage begins where the one before ended. The rear's share is one of the successful fronts.

    Examples:

        pipenav eval --policy runs/arm/best.zip
        pipenav eval --policy arm --pipes thesis --episodes 100
        pipenav eval --policy arm --stage passage --episodes 50
        pipenav eval --stage locate --robot high-fidelity --pipes thesis
        pipenav eval --policy baseline:centreline --pipes d=90,angle=60 --pipes d=90,angle=60,turn=right
        pipenav eval --policy pirate --pipes runs-level --option timestep=0.001
        pipenav eval --policy arm --disturb real-world
    """
    from pipenav.evaluation.config import EvaluationConfig, todays_stage
    from pipenav.evaluation.evaluate import CheckedEvaluation
    from pipenav.evaluation.report import evaluation_table, write_evaluation

    config = EvaluationConfig(
        policy=policy,
        pipes=tuple(pipes or ["working-range"]),
        episodes=episodes,
        seed=seed,
        stage=todays_stage(stage),
        robot=robot,
        variant=variant,
        backend=backend,
        options=parse_options(option or []),
        disturb=disturb,
    )
    checked = CheckedEvaluation(config)
    console = Console()
    with _evaluation_folder(out or _default_folder(config)) as folder:
        evaluation = _run(console, checked)
    write_evaluation(folder, evaluation)
    console.print(evaluation_table(evaluation))
    console.print(f"evaluation folder {folder}: eval.json, eval.csv, success.png, map.png")


@contextmanager
def _evaluation_folder(path: Path) -> Iterator[Path]:
    """A folder that can be written into; a new one goes again where an error ends the work that it is for."""
    from pipenav.storage.atomic_files import prepare_folder

    fresh = not path.exists()
    prepare_folder(path)
    try:
        yield path
    except PipenavError:
        if fresh:
            with suppress(OSError):
                os.removedirs(path)  # with the empty folders above it
        raise


def _run(console: Console, checked: CheckedEvaluation) -> Evaluation:
    """Run an evaluation under a bar for each of its stages."""
    with episode_bar(console) as bar:
        bars: dict[str, TaskID] = {}

        def report(stage: str, total: int, done: int, successes: int) -> None:
            if stage not in bars:
                bars[stage] = bar.add_task(stage, total=total)
            bar.update(bars[stage], completed=done, description=f"{stage}: success {successes / done:.1%}")

        return checked.run(report)


def _default_folder(config: EvaluationConfig) -> Path:
    """`eval-<stage>-<pipes>` beside a policy file, under `runs/` otherwise."""
    names = [*config.pipes, *([config.disturb] if config.disturb else [])]
    label = "-".join(Path(name).stem.replace("=", "").replace(",", "-").replace(":", "-") for name in names)
    if config.policy is None:
        return Path("runs") / f"{config.robot or 'basic'}-{config.variant}" / f"eval-{config.stage}-{label}"
    folder = f"eval-{label}" if config.stage in UNNAMED_STAGES else f"eval-{config.stage}-{label}"
    path = Path(config.policy)
    return path.parent / folder if path.suffix == ".zip" else Path("runs") / config.policy.replace(":", "-") / folder
