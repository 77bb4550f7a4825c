"""`pipenav eval`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from pipenav.cli.options import SIMULATOR, BackendOption, SettingsOption, checked_options
from pipenav.cli.percentages import share_of
from pipenav.cli.terminal import progress_console, refuse_ignored, say, show
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import TaskID

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
DISTURB_HELP = "Disturbances, by name or as FILE.toml; see `pipenav list disturbances`."
SUBJECT, EPISODES, RESULT = "What is measured", "Episodes", "Result"

PolicyOption = Annotated[str | None, typer.Option(help=POLICY_HELP, rich_help_panel=SUBJECT)]
# The names of StageName, with the older ones, and of Variant, whose import would slow down --help.
StageOption = Annotated[
    Literal["locate", "reach", "reach-rear", "passage", "traverse", "front", "front-rear"] | None,
    typer.Option(help=STAGE_HELP, metavar="STAGE", rich_help_panel=SUBJECT),
]
VariantOption = Annotated[
    Literal["map", "thesis"] | None, typer.Option(help=VARIANT_HELP, show_default="map", rich_help_panel=SUBJECT)
]
RobotOption = Annotated[str | None, typer.Option(help=ROBOT_HELP, rich_help_panel=SUBJECT)]
PipesOption = Annotated[list[str] | None, typer.Option(help=PIPES_HELP, rich_help_panel=EPISODES)]
EpisodesOption = Annotated[int, typer.Option(min=1, max=100_000, help="Episodes per pipe.", rich_help_panel=EPISODES)]
SeedOption = Annotated[int, typer.Option(min=0, help="Seed of starts and targets.", rich_help_panel=EPISODES)]
DisturbOption = Annotated[str | None, typer.Option(help=DISTURB_HELP, rich_help_panel=SIMULATOR)]
OutOption = Annotated[
    Path | None, typer.Option(help="Evaluation folder; default beside the policy.", rich_help_panel=RESULT)
]
RequireOption = Annotated[
    str | None, typer.Option(metavar="PERCENT", help="Exit code 1 below this success, for CI.", rich_help_panel=RESULT)
]


def evaluate(
    policy: PolicyOption = None,
    stage: StageOption = None,
    variant: VariantOption = None,
    robot: RobotOption = None,
    pipes: PipesOption = None,
    episodes: EpisodesOption = 20,
    seed: SeedOption = 0,
    backend: BackendOption = "mujoco",
    option: SettingsOption = None,
    disturb: DisturbOption = None,
    out: OutOption = None,
    require: RequireOption = None,
) -> None:
    """Measure in which pipes a policy passes: success with 95 % intervals, failures, ranges, contact, pictures.

    Every stage begins where the one before ended. Success of `rear` is a share of the episodes whose front half
    reached its target.

    Examples:

        pipenav eval --policy runs/arm/best.zip
        pipenav eval --policy arm --pipes thesis --episodes 100
        pipenav eval --policy arm --stage passage --episodes 50
        pipenav eval --stage locate --robot high-fidelity --pipes thesis
        pipenav eval --policy baseline:centreline --pipes d=90,angle=60 --pipes d=90,angle=60,turn=right
        pipenav eval --policy pirate --pipes runs-level --option timestep=0.001
        pipenav eval --policy arm --disturb real-world --require 90%
    """
    from pipenav.evaluation.config import EvaluationConfig, todays_stage

    required = None if require is None else share_of(require, "--require")
    if stage not in ("locate", "passage"):
        refuse_ignored({"--variant": variant}, "it says how --stage locate or passage locates a target")
    config = EvaluationConfig(
        policy=policy,
        pipes=tuple(pipes or ["working-range"]),
        episodes=episodes,
        seed=seed,
        stage=todays_stage(stage),
        robot=robot,
        variant=variant or "map",
        backend=backend,
        options=checked_options(backend, option or []),
        disturb=disturb,
    )
    evaluation = _measured(config, out)
    if required is not None and evaluation.success < required:
        raise PipenavError(f"success {100 * evaluation.success:.6g}% is below the required {require}.")


def _measured(config: EvaluationConfig, out: Path | None) -> Evaluation:
    """Run an evaluation, write its folder and show it."""
    from pipenav.evaluation.evaluate import CheckedEvaluation
    from pipenav.evaluation.folder import check_folder, default_folder
    from pipenav.evaluation.report import FILES, evaluation_table, write_evaluation
    from pipenav.storage.lock import one_writer

    checked = CheckedEvaluation(config)
    with one_writer(out or default_folder(checked.config)) as folder:
        check_folder(folder, checked.config)
        evaluation = _run(progress_console(), checked)
        write_evaluation(folder, evaluation)
    show(evaluation_table(evaluation))
    say(f"evaluation folder {folder}: {', '.join(FILES)}")
    return evaluation


def _run(console: Console, checked: CheckedEvaluation) -> Evaluation:
    """Run an evaluation under a bar for each of its stages."""
    from pipenav.cli.progress_bars import episode_bar

    with episode_bar(console) as bar:
        bars: dict[str, TaskID] = {}

        def report(stage: str, total: int, done: int, successes: int) -> None:
            if stage not in bars:
                bars[stage] = bar.add_task(stage, total=total)
            bar.update(bars[stage], completed=done, description=f"{stage}: success {successes / done:.1%}")

        return checked.run(report)
