"""`pipenav eval`."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from pipenav.cli.options import parse_options
from pipenav.errors import PipenavError

STAGE_HELP = (
    "reach: a policy reaches a given target; reach-rear: then the rear half follows; "
    "locate: the robot finds a target itself; passage: locate, reach and rear; "
    "traverse: a whole robot goes through. Default: what the policy was trained for."
)
VARIANT_HELP = "How a target is located: map, or thesis for the method exactly as printed."


def evaluate(
    policy: Annotated[
        str | None,
        typer.Option(
            help="best.zip, a shipped policy's name, or baseline:random, :centreline, :sequence, :sequence-line."
        ),
    ] = None,
    # The names of StageName and pipenav.locating.locator.Variant, whose import would slow down --help.
    stage: Annotated[
        Literal["locate", "reach", "reach-rear", "passage", "traverse", "front", "front-rear"] | None,
        typer.Option(help=STAGE_HELP, metavar="STAGE"),
    ] = None,
    backend: Annotated[str, typer.Option(help="Simulator backend; see `pipenav backends`.")] = "mujoco",
    pipes: Annotated[
        list[str] | None,
        typer.Option(
            help="Shipped set, FILE.toml or d=90,angle=60[,turn=right], of a whole robot runs too; repeatable."
        ),
    ] = None,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes per pipe.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Seed of starts and targets.")] = 0,
    robot: Annotated[
        str | None, typer.Option(help="Robot of --stage locate (basic) or of a baseline; a policy brings its own.")
    ] = None,
    variant: Annotated[Literal["map", "thesis"], typer.Option(help=VARIANT_HELP)] = "map",
    option: Annotated[list[str] | None, typer.Option(help="Backend setting, key=value; repeatable.")] = None,
    disturb: Annotated[
        str | None, typer.Option(help="What goes wrong, by name (docs/disturbances.md) or as FILE.toml.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Evaluation folder; default beside the policy.")] = None,
) -> None:
    """Measure in which pipes a policy passes: success with 95 % intervals, failures, clearance, contact, pictures.

    Every stage begins where the one before ended. The rear's share is one of the successful fronts.

    Examples:

        pipenav eval --policy runs/arm/best.zip

        pipenav eval --policy arm --pipes thesis --episodes 100

        pipenav eval --policy arm --stage passage --episodes 50

        pipenav eval --stage locate --robot high-fidelity --pipes thesis

        pipenav eval --policy baseline:centreline --pipes d=90,angle=60 --pipes d=90,angle=60,turn=right

        pipenav eval --policy arm --option timestep=0.001

        pipenav eval --policy pirate --pipes d=70,angle=60

        pipenav eval --policy baseline:sequence --pipes d=90,angle=90

        pipenav eval --policy pirate --pipes runs-level

        pipenav eval --policy pirate --pipes runs-rolled

        pipenav eval --policy arm --disturb real-world
    """
    from pipenav.evaluation.config import EvaluationConfig, todays_stage
    from pipenav.evaluation.evaluate import CheckedEvaluation
    from pipenav.evaluation.report import evaluation_table, write_evaluation
    from pipenav.storage.atomic_files import prepare_folder

    names = pipes or ["working-range"]
    options = parse_options(option or [])
    config = EvaluationConfig(
        policy=policy,
        pipes=tuple(names),
        episodes=episodes,
        seed=seed,
        stage=todays_stage(stage),
        robot=robot,
        variant=variant,
        backend=backend,
        options=options,
        disturb=disturb,
    )
    run = CheckedEvaluation(config)
    folder = out or _default_folder(policy, stage, robot or "basic", variant, [*names, *([disturb] if disturb else [])])
    fresh = not folder.exists()
    prepare_folder(folder)
    console = Console()
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed} of {task.total} episodes"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        bars: dict[str, TaskID] = {}

        def report(part: str, total: int, done: int, successes: int) -> None:
            if part not in bars:
                bars[part] = bar.add_task(part, total=total)
            bar.update(bars[part], completed=done, description=f"{part}: success {successes / done:.1%}")

        try:
            evaluation = run.run(report)
        except PipenavError:
            if fresh:
                with suppress(OSError):
                    os.removedirs(folder)  # with the empty folders above it
            raise
    write_evaluation(folder, evaluation)
    console.print(evaluation_table(evaluation))
    console.print(f"evaluation folder {folder}: eval.json, eval.csv, success.png, map.png")


def _default_folder(policy: str | None, stage: str | None, robot: str, variant: str, pipes: list[str]) -> Path:
    """`eval-<stage>-<pipes>` beside a policy file, under `runs/` otherwise; the task's own has no stage in its name."""
    label = "-".join(Path(name).stem.replace("=", "").replace(",", "-").replace(":", "-") for name in pipes)
    if policy is None:
        return Path("runs") / f"{robot}-{variant}" / f"eval-{stage}-{label}"
    folder = f"eval-{label}" if stage in (None, "reach", "traverse") else f"eval-{stage}-{label}"
    path = Path(policy)
    return path.parent / folder if path.suffix == ".zip" else Path("runs") / policy.replace(":", "-") / folder
