"""`pipenav eval`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import typer

from pipenav.cli.option_groups import OptionGroup, takes_option_groups
from pipenav.cli.options import SIMULATOR, BackendOption, SettingsOption, checked_options
from pipenav.cli.percentages import audited_share, share_of
from pipenav.cli.place_options import ShardedPlaceOptions
from pipenav.cli.signals import Interrupted
from pipenav.cli.terminal import progress_console, refuse_ignored, say, show
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import TaskID

    from pipenav.evaluation.config import EvaluationConfig
    from pipenav.evaluation.evaluate import CheckedEvaluation
    from pipenav.evaluation.part_plan import Shard
    from pipenav.evaluation.results import Evaluation
    from pipenav.jobs import JobStore, Place

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
TETHER_HELP = "Length of cable behind a whole robot at the start, in straight, level pipe [m]: 0-100000."
CABLE_HELP = "Friction of that cable in the pipe: 0.3 for PVC, 0.6 for corroded steel."
FORCE_HELP = "Largest contact force on any one link [N]: an episode with more has failed."
SENSORS_HELP = (
    "Sensors of a whole robot: ideal, or mems with the errors of a consumer part. Default: as it was trained."
)
RECOVER_HELP = "A whole robot that is stuck in the plane rolls back by itself and tries again; in space it does anyway."
STARTS_HELP = "Starts in which robots are stuck, by name (stuck-starts) or as FILE.json: brings its pipes and episodes."
DISTURB_HELP = "Disturbances, by name or as FILE.toml; see `pipenav list disturbances`."
AUDIT_HELP = "Replay this share of the successful episodes, 10% or 0.1, by geometry alone, without the simulator."
CERTIFY_HELP = "Decide by geometry which episodes were possible at all, as `pipenav certify` does, in the plane."
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
TetherOption = Annotated[float | None, typer.Option(help=TETHER_HELP, min=0, max=100_000, rich_help_panel=EPISODES)]
CableOption = Annotated[
    float | None, typer.Option(help=CABLE_HELP, min=0, max=3, show_default="0.3", rich_help_panel=EPISODES)
]
ForceOption = Annotated[float | None, typer.Option(help=FORCE_HELP, min=0.001, max=1e6, rich_help_panel=EPISODES)]
SensorsOption = Annotated[
    Literal["ideal", "mems"] | None, typer.Option(help=SENSORS_HELP, metavar="GRADE", rich_help_panel=EPISODES)
]
StartsOption = Annotated[str | None, typer.Option(help=STARTS_HELP, rich_help_panel=EPISODES)]
RecoverOption = Annotated[bool, typer.Option("--recover", help=RECOVER_HELP, rich_help_panel=EPISODES)]
OutOption = Annotated[Path | None, typer.Option(help="Evaluation folder; default beside the policy.")]
RequireOption = Annotated[str | None, typer.Option(metavar="PERCENT", help="Exit code 1 below this success, for CI.")]
AuditOption = Annotated[str | None, typer.Option(metavar="SHARE", help=AUDIT_HELP)]
CertifyOption = Annotated[bool, typer.Option("--certify", help=CERTIFY_HELP)]


@dataclass(frozen=True)
class SimulatorOptions(OptionGroup):
    """The choice of a simulator."""

    panel: ClassVar[str] = SIMULATOR
    backend: BackendOption = "mujoco"
    option: SettingsOption = None


@dataclass(frozen=True)
class LoadOptions(OptionGroup):
    """Loads that make episodes harder."""

    panel: ClassVar[str] = EPISODES
    disturb: DisturbOption = None
    tether: TetherOption = None
    cable_friction: CableOption = None
    max_force: ForceOption = None
    sensors: SensorsOption = None
    starts: StartsOption = None
    recover: RecoverOption = False


@dataclass(frozen=True)
class ResultOptions(OptionGroup):
    """Result of an evaluation: its folder, what it must reach, and what geometry says of it."""

    panel: ClassVar[str] = RESULT
    out: OutOption = None
    require: RequireOption = None
    audit: AuditOption = None
    certify: CertifyOption = False


@takes_option_groups
def evaluate(
    simulator: SimulatorOptions,
    loads: LoadOptions,
    result: ResultOptions,
    where: ShardedPlaceOptions,
    policy: PolicyOption = None,
    stage: StageOption = None,
    variant: VariantOption = None,
    robot: RobotOption = None,
    pipes: PipesOption = None,
    episodes: EpisodesOption = 20,
    seed: SeedOption = 0,
) -> None:
    """Measure in which pipes a policy passes: success with 95 % intervals, failures, ranges, contact, pictures.

    Every stage begins where the one before ended. Success of `rear` is a share of the episodes whose front half reached
    its target. The result is the same wherever it runs. After Ctrl-C the same command goes on from what is finished.

    Examples:

        pipenav eval --policy runs/arm/best.zip
        pipenav eval --policy arm --pipes thesis --episodes 100 --jobs 2
        pipenav eval --policy arm --stage passage --episodes 50
        pipenav eval --stage locate --robot high-fidelity --pipes thesis
        pipenav eval --policy pirate --pipes runs-level --option timestep=0.001
        pipenav eval --policy arm --disturb real-world --require 90%
        pipenav eval --policy pirate --starts stuck-starts --recover
        pipenav eval --policy pirate --pipes d=100,angle=90 --tether 100 --max-force 100
        pipenav eval --policy pirate --pipes d=60,angle=55 --certify --audit 10%
    """
    from pipenav.evaluation.config import EvaluationConfig, todays_stage

    required = _required_share(result.require, where)
    _refuse_ignored(stage, variant, loads.starts, pipes)
    config = EvaluationConfig(
        policy=policy,
        pipes=tuple(pipes or ["working-range"]),
        episodes=episodes,
        seed=seed,
        stage=todays_stage(stage),
        robot=robot,
        variant=variant or "map",
        backend=simulator.backend,
        options=checked_options(simulator.backend, simulator.option or []),
        **vars(loads),
        audit=None if result.audit is None else audited_share(result.audit),
        certify=result.certify,
    )
    if (evaluation := _measured(config, result.out, where)) and evaluation.success < required:
        raise PipenavError(f"success {100 * evaluation.success:.6g}% is below the required {result.require}.")


def _refuse_ignored(stage: str | None, variant: str | None, starts: str | None, pipes: list[str] | None) -> None:
    """Refuse options that do nothing beside the others."""
    if stage not in ("locate", "passage"):
        refuse_ignored({"--variant": variant}, "it says how --stage locate or passage locates a target")
    if starts is not None:
        refuse_ignored({"--pipes": pipes}, "--starts brings its own pipes")


def _measured(config: EvaluationConfig, out: Path | None, where: ShardedPlaceOptions) -> Evaluation | None:
    """Run an evaluation, write its folder and show it; None after a share of it."""
    from pipenav.evaluation.evaluate import CheckedEvaluation
    from pipenav.evaluation.folder import UNFINISHED, check_folder, default_folder
    from pipenav.evaluation.report import FILES, MORE_FILES, evaluation_table, write_evaluation
    from pipenav.jobs import JobStore
    from pipenav.storage.lock import one_writer

    place, shard = where.place(), where.shard_numbers()
    checked = CheckedEvaluation(config)
    with one_writer(out or default_folder(checked.config), shared=shard is not None) as folder:
        check_folder(folder, checked.config)
        store = JobStore(folder / UNFINISHED, checked.parts.request())
        with _kept(checked, store):
            if shard is not None:
                _run_shard(checked, store, place, shard)
                return None
            _run(progress_console(), checked, store, place)
            evaluation = _merged(progress_console(), checked, store, place)
            more = _atlas(progress_console(), checked, evaluation, store)
        write_evaluation(folder, evaluation, more)
        store.remove()
    show(evaluation_table(evaluation))
    if len(checked.cpus) > 1:
        say(f"parts were computed by {len(checked.cpus)} kinds of processors: their last digits may differ", "yellow")
    say(f"evaluation folder {folder}: {', '.join([*FILES, *MORE_FILES])}")
    return evaluation


def _merged(console: Console, checked: CheckedEvaluation, store: JobStore, place: Place) -> Evaluation:
    """Merge the parts, under a bar where geometry decides about the pipes."""
    from pipenav.cli.progress_bars import percentage_bar

    if not checked.config.certify:
        return checked.merged(store)
    with percentage_bar(console) as bar:
        task = bar.add_task("deciding pipes by geometry", total=len(checked.parts.episodes.pipes))
        return checked.merged(store, place, lambda total, done: bar.update(task, total=total, completed=done))


def _atlas(console: Console, checked: CheckedEvaluation, evaluation: Evaluation, store: JobStore) -> dict[str, bytes]:
    """Files for which some episodes are run again, under a bar."""
    from pipenav.cli.progress_bars import episode_bar
    from pipenav.evaluation.atlas import atlas_files

    with episode_bar(console) as bar:
        task = bar.add_task("report: some run again", total=None)
        return atlas_files(
            checked,
            evaluation,
            store,
            store.folder.parent,
            lambda done, total: bar.update(task, completed=done, total=total),
        )


@contextmanager
def _kept(checked: CheckedEvaluation, store: JobStore) -> Iterator[None]:
    """Say what is kept of an evaluation that ends early."""
    try:
        yield
    except BaseException as error:
        parts = checked.parts.count
        done = parts - checked.missing(store)
        if not done:
            store.remove()
        elif isinstance(error, Interrupted):
            say(f"{done} of {parts} parts are kept in {store.folder}; the same command goes on from there")
        raise


def _run_shard(checked: CheckedEvaluation, store: JobStore, place: Place, numbers: tuple[int, int]) -> None:
    """Run a share of an evaluation's parts, and say what the other shares have left."""
    from pipenav.evaluation.part_plan import Shard
    from pipenav.storage.lock import one_writer

    shard = Shard(*numbers)
    with one_writer(store.folder / f"shard-{shard.number}-of-{shard.of}"):
        _run(progress_console(), checked, store, place, shard)
    missing = checked.missing(store)
    left = f"{missing} of {checked.parts.count} parts are missing" if missing else "all parts are there"
    say(f"share {shard} is done in {store.folder}: {left}; the same command without --shard writes the evaluation")


def _required_share(text: str | None, where: ShardedPlaceOptions) -> float:
    """The share of successes that is required, from a percentage as it was typed; 0 where none is."""
    if text is None:
        return 0.0
    if where.shard is not None:
        refuse_ignored({"--require": text}, "a share of an evaluation has no success yet")
    return share_of(text, "--require")


def _run(
    console: Console, checked: CheckedEvaluation, store: JobStore, place: Place, shard: Shard | None = None
) -> None:
    """Run the parts of an evaluation that are missing under a bar for each of its stages."""
    from pipenav.cli.progress_bars import episode_bar

    kept = checked.parts.count - checked.missing(store)
    if kept:
        say(f"{kept} of {checked.parts.count} parts are there already, in {store.folder}", console=console)
    with episode_bar(console) as bar:
        bars: dict[str, TaskID] = {}

        def report(stage: str, total: int, done: int, successes: int) -> None:
            if stage not in bars:
                bars[stage] = bar.add_task(stage, total=total)
            bar.update(bars[stage], total=total, completed=done, description=f"{stage}: success {successes / done:.1%}")

        checked.run_parts(store, report, place, shard)
