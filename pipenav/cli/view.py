"""`pipenav view`."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, NamedTuple

import typer

from pipenav.cli.option_groups import OptionGroup, takes_option_groups
from pipenav.cli.options import SIMULATOR, SettingsOption
from pipenav.cli.terminal import progress_console, refuse_ignored, say
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from pipenav.cli.view_drawings import Drawing
    from pipenav.cli.view_sources import Wanted
    from pipenav.recording.film import Progress
    from pipenav.recording.record import RecordingSettings

TABLE = ".csv"
DEFAULT_PIPE = "d=90,angle=60"
DEFAULT_BACKEND = "mujoco"
SOURCE, EPISODE, OUTPUT = "One of", "Which episode", "Output"

POLICY_HELP = (
    "Draw an episode of a policy: best.zip, a shipped policy's name, or baseline: and a name as for `pipenav eval`."
)
BEHAVIOUR_HELP = "Draw how the robot finds a target itself; see `pipenav locate-target`."
TRAJECTORY_HELP = "Draw a recorded trajectory; repeatable: one after another."
EVAL_HELP = "Draw an episode of this evaluation folder, run again from its seed; with --episode, its number there."
PIPES_HELP = f"Pipe set, a route as runs-level:3, FILE.toml or d=90,angle=60; repeatable. Default: {DEFAULT_PIPE}."
ROBOT_HELP = "Robot of a behaviour (basic) or baseline, or of a trajectory whose robot is not shipped."
EPISODE_HELP = "Number of one of the episodes that `pipenav eval` runs in each pipe, from 0."
OUT_HELP = "Picture .png (a strip), film .gif or .mp4, or trajectory .csv; repeatable."
TELEMETRY_HELP = "Convert a telemetry of `pipenav run-real` or `pipenav drive`, for --rerun or --mcap."
RERUN_HELP = "Recording .rrd for the Rerun viewer; needs pip install 'pipenav[rerun]'."
MCAP_HELP = "Recording .mcap of a --telemetry for Foxglove; needs pip install 'pipenav[mcap]'."
RECORDED = "a trajectory is recorded already and brings its own pipe"
EVALUATED = "an evaluation folder says all of this itself"
LOGGED = "a telemetry is only converted, see `pipenav replay --draw` for its picture"
LIVE_HELP = "Open the simulator's own viewer and run in real time, with beams, forces, target and a line of text."


PolicyOption = Annotated[str | None, typer.Option(help=POLICY_HELP)]
BehaviourOption = Annotated[Literal["locate:map", "locate:thesis"] | None, typer.Option(help=BEHAVIOUR_HELP)]
EvalOption = Annotated[Path | None, typer.Option("--eval", help=EVAL_HELP)]
TrajectoryOption = Annotated[list[Path] | None, typer.Option(help=TRAJECTORY_HELP)]
TelemetryOption = Annotated[Path | None, typer.Option(help=TELEMETRY_HELP)]
RobotOption = Annotated[str | None, typer.Option(help=ROBOT_HELP, rich_help_panel=EPISODE)]
PipesOption = Annotated[list[str] | None, typer.Option(help=PIPES_HELP, rich_help_panel=EPISODE)]
SeedOption = Annotated[
    int | None,
    typer.Option(
        min=0, help="Seed of start and target, as in `pipenav eval`.", show_default="0", rich_help_panel=EPISODE
    ),
]
EpisodeOption = Annotated[int | None, typer.Option(min=0, help=EPISODE_HELP, show_default="0", rich_help_panel=EPISODE)]
BackendOption = Annotated[
    str | None,
    typer.Option(
        help="Simulator backend; see `pipenav backends`.", show_default=DEFAULT_BACKEND, rich_help_panel=SIMULATOR
    ),
]
OutOption = Annotated[list[Path] | None, typer.Option(help=OUT_HELP, rich_help_panel=OUTPUT)]
LiveOption = Annotated[bool, typer.Option("--live", help=LIVE_HELP, rich_help_panel=OUTPUT)]
RerunOption = Annotated[Path | None, typer.Option(metavar="FILE", help=RERUN_HELP)]
McapOption = Annotated[Path | None, typer.Option(metavar="FILE", help=MCAP_HELP)]


@dataclass(frozen=True)
class SourceOptions(OptionGroup):
    """The one thing that is drawn."""

    panel: ClassVar[str] = SOURCE
    policy: PolicyOption = None
    behaviour: BehaviourOption = None
    trajectory: TrajectoryOption = None
    evaluation: EvalOption = None
    telemetry: TelemetryOption = None


@dataclass(frozen=True)
class ViewerOptions(OptionGroup):
    """Recordings for viewers."""

    panel: ClassVar[str] = OUTPUT
    rerun: RerunOption = None
    mcap: McapOption = None

    @property
    def files(self) -> list[Path]:
        """The files that are wanted."""
        return [path for path in (self.rerun, self.mcap) if path is not None]


@takes_option_groups
def view(
    source: SourceOptions,
    viewers: ViewerOptions,
    robot: RobotOption = None,
    pipes: PipesOption = None,
    seed: SeedOption = None,
    episode: EpisodeOption = None,
    backend: BackendOption = None,
    option: SettingsOption = None,
    out: OutOption = None,
    live: LiveOption = False,
) -> None:
    """Draw what a policy, a behaviour or a trajectory file does, from above: links, beams, target, contact forces.

    Examples:

        pipenav view --policy arm --pipes d=90,angle=60
        pipenav view --policy arm --pipes d=90,angle=60,turn=right --episode 7 --out film.mp4 --out front.csv
        pipenav view --trajectory front.csv --trajectory rear.csv --out passage.gif
        pipenav view --behaviour locate:map --robot high-fidelity --pipes d=70,angle=120
        pipenav view --policy pirate --pipes runs-level:3 --out route.gif
        pipenav view --policy pirate --pipes runs-rolled:3 --out roll.png
        pipenav view --policy baseline:centreline --live
        pipenav view --eval runs/shipped-arm/eval --episode 12 --out failed.png
        pipenav view --policy arm --pipes d=90,angle=60 --rerun arm.rrd
        pipenav view --telemetry runs/real-1/telemetry.jsonl --rerun mission.rrd --mcap mission.mcap
    """
    from pipenav.cli import view_sources as sources

    _check_one_source({f"--{name.replace('evaluation', 'eval')}": value for name, value in vars(source).items()})
    trajectory = source.trajectory or []
    inputs = [*trajectory, *(Path(path) for path in (source.policy, source.telemetry) if path)]
    outputs = _checked_outputs(out or [], viewers, inputs)
    simulation = {"--backend": backend, "--option": option}
    which = {"--pipes": pipes, "--seed": seed, "--robot": robot, "--live": live}
    if source.telemetry:
        refuse_ignored(which | simulation | {"--out": out, "--episode": episode}, LOGGED)
        _convert(source.telemetry, viewers)
        return
    refuse_ignored({"--mcap": viewers.mcap}, "it holds a --telemetry")
    if source.evaluation:
        refuse_ignored(which | simulation, EVALUATED)
        _draw_evaluated(source.evaluation, episode or 0, outputs, viewers.rerun)
        return
    wanted = sources.Wanted(pipes or [DEFAULT_PIPE], robot, seed or 0, episode or 0, outputs)
    if trajectory:
        refuse_ignored({"--pipes": pipes, "--seed": seed, "--episode": episode}, RECORDED)
        refuse_ignored({} if live else simulation, RECORDED)
        _check_for_files(outputs + viewers.files, live)
    _draw_recorded(source, wanted, _Simulation(backend or DEFAULT_BACKEND, option or [], live), viewers.rerun)


class _Simulation(NamedTuple):
    """A simulator as it was asked for, and whether it is watched live."""

    backend: str
    option: list[str]
    live: bool


def _draw_recorded(source: SourceOptions, wanted: Wanted, simulation: _Simulation, rerun: Path | None) -> None:
    """Draw what a policy, a behaviour or trajectory files do."""
    from pipenav.cli import view_sources as sources

    name = source.policy or source.behaviour or " ".join(path.stem for path in source.trajectory or [])
    with sources.opened_simulator(*simulation) as simulator:
        drawing = _drawing(source, wanted, simulator)
    outputs = wanted.outputs
    if not (outputs or simulation.live or rerun):
        outputs = [_default_picture(drawing.name, name, wanted, [simulation.backend, *simulation.option])]
    _write(drawing, outputs, rerun)


def _drawing(source: SourceOptions, wanted: Wanted, simulator: RecordingSettings) -> Drawing:
    """The drawing of a source, told in sentences too."""
    from pipenav.cli import view_sources as sources

    if source.trajectory:
        drawing = sources.from_files(source.trajectory, wanted.robot, simulator)
    elif source.behaviour:
        drawing = sources.of_behaviour(source.behaviour, wanted, simulator)
    else:
        drawing = sources.of_policy(source.policy or "", wanted, simulator)
    for sentence in drawing.sentences:
        say(sentence)
    return drawing


def _convert(log: Path, viewers: ViewerOptions) -> None:
    """Convert a telemetry for viewers."""
    from pipenav.deployment.telemetry import read_telemetry
    from pipenav.recording.mcap_file import write_mcap
    from pipenav.recording.posed_telemetry import posed_telemetry, robot_of
    from pipenav.recording.rerun_file import write_rerun

    if not viewers.files:
        raise PipenavError("a telemetry is converted for a viewer: give --rerun FILE.rrd or --mcap FILE.mcap.")
    recording = read_telemetry(log)
    robot = robot_of(log, recording.header)
    motion = None if robot is None else posed_telemetry(recording, robot)
    if viewers.rerun is not None:
        if motion is None:
            raise PipenavError(f"{log} has no pose of a robot that is known here: Rerun would show nothing.")
        write_rerun(viewers.rerun, [motion])
        say(f"written: {viewers.rerun}")
    if viewers.mcap is not None:
        write_mcap(viewers.mcap, recording, robot, motion)
        say(f"written: {viewers.mcap}")


def _draw_evaluated(folder: Path, episode: int, outputs: list[Path], rerun: Path | None) -> None:
    """Draw an episode of an evaluation folder."""
    from pipenav.cli.view_evaluation import of_evaluation
    from pipenav.evaluation.folder import label

    drawing = of_evaluation(folder, episode)
    for sentence in drawing.sentences:
        say(sentence)
    if not (outputs or rerun):
        outputs = [Path(f"{label(['view', folder.resolve().name, f'episode{episode}'])}.png")]
    _write(drawing, outputs, rerun)


def _write(drawing: Drawing, paths: Sequence[Path], rerun: Path | None) -> None:
    for path in paths:
        with _drawing_bar(path) as progress:
            drawing.write(path, progress)
        say(f"written: {path}")
    if rerun is not None:
        from pipenav.recording.rerun_file import write_rerun

        write_rerun(rerun, drawing.posed())
        say(f"written: {rerun}")


def _default_picture(pipe: str, source: str, wanted: Wanted, simulator: Sequence[str]) -> Path:
    """Default name of a picture: policy, pipe and every option that is not the default."""
    from pipenav.evaluation.folder import label

    parts = ["view", source.removesuffix(".zip").removeprefix("./"), pipe]
    if len(wanted.pipes) > 1:
        parts += [f"and-{len(wanted.pipes) - 1}-more"]
    parts += [wanted.robot] if wanted.robot else []
    parts += [f"seed{wanted.seed}"] if wanted.seed else []
    parts += [f"episode{wanted.episode}"] if wanted.episode else []
    return Path(f"{label([*parts, *(part for part in simulator if part != DEFAULT_BACKEND)])}.png")


def _check_one_source(sources: dict[str, object]) -> None:
    """Refuse anything but one of the sources that a drawing can come from, by the names of their options."""
    given = [name for name, source in sources.items() if source]
    if len(given) != 1:
        problem = f"{' and '.join(given)} are several things to draw" if given else "there is nothing to draw"
        raise PipenavError(f"{problem}: give one of --policy, --behaviour, --trajectory, --eval and --telemetry.")


def _checked_outputs(paths: list[Path], viewers: ViewerOptions, inputs: list[Path]) -> list[Path]:
    """The files to draw. All files must be of kinds that can be written, before any work is done for them."""
    from pipenav.recording.film_files import SUFFIXES, check_suffix
    from pipenav.recording.mcap_file import check_mcap
    from pipenav.recording.rerun_file import check_rerun
    from pipenav.storage.atomic_files import check_outputs

    for path in paths:
        if path.suffix.lower() != TABLE:
            check_suffix(path, [*SUFFIXES, TABLE])
    if viewers.rerun is not None:
        check_rerun(viewers.rerun)
    if viewers.mcap is not None:
        check_mcap(viewers.mcap)
    check_outputs([*paths, *viewers.files], inputs)
    return paths


def _check_for_files(outputs: Sequence[Path], live: bool) -> None:
    """Refuse options that say nothing about trajectories, which are recorded already and bring their own pipe."""
    for path in outputs:
        if path.suffix.lower() == TABLE:
            raise PipenavError(
                f"{path}: a trajectory is recorded from a --policy or --behaviour, and --trajectory only draws one: "
                "give --out a name ending in .png, .gif or .mp4."
            )
    if live and outputs:
        raise PipenavError("--live shows a trajectory and writes nothing: give it without --out, or --out without it.")


@contextmanager
def _drawing_bar(path: Path) -> Iterator[Progress]:
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = progress_console()
    shown = (TextColumn("{task.description}", markup=False), BarColumn(), TextColumn("{task.percentage:>3.0f}%"))
    columns = (*shown, TextColumn("left"), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"drawing {path.name}")
        yield lambda done, total: bar.update(task, completed=done, total=total)
