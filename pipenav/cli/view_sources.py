"""Sources of `pipenav view`: an episode of a policy, an episode of a behaviour, or trajectory files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, cast

from pipenav.cli.options import recording_settings
from pipenav.cli.view_drawings import TABLE, Drawing, PlaneDrawing, SpaceDrawing
from pipenav.errors import PipenavError
from pipenav.locating.locator import Variant
from pipenav.motions.trajectory_file import read_trajectory
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import as_route
from pipenav.policies.named import open_controller
from pipenav.recording.film import MAX_ROWS, MOST_IN_STRIP
from pipenav.recording.film_files import SUFFIXES, check_suffix
from pipenav.recording.live import live_window, play
from pipenav.recording.record import RecordingSettings, record_locate, record_task
from pipenav.recording.record_rolling import record_in_space
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import task_of

STRIP = ".png"


class Wanted(NamedTuple):
    """The episodes to record, and the files that are wanted of them.

    Attributes:
        pipes: pipes, as a person names them.
        robot: robot of a behaviour or a baseline, if one is named.
        seed: seed of starts and targets.
        episode: number of the episode in each pipe, from 0.
        outputs: files to write.
    """

    pipes: Sequence[str]
    robot: str | None
    seed: int
    episode: int
    outputs: Sequence[Path]


@contextmanager
def opened_simulator(backend: str, options: list[str], live: bool) -> Iterator[RecordingSettings]:
    """A simulator's settings, with its window where the episodes are to be seen live."""
    settings = recording_settings(backend, options)
    if not live:
        yield settings
        return
    with live_window() as window:
        yield settings._replace(watch=window)


def from_files(paths: Sequence[Path], robot: str | None, simulator: RecordingSettings) -> Drawing:
    """Trajectories that were recorded earlier."""
    spec = None if robot is None else load_robot(robot)
    motions = [read_trajectory(path, spec) for path in paths]
    if simulator.watch is not None:
        play(motions, simulator)
    return PlaneDrawing(motions)


def of_behaviour(name: str, wanted: Wanted, simulator: RecordingSettings) -> Drawing:
    """Episodes in which the robot finds a target itself, `locate:` and the variant."""
    robot, variant = load_robot(wanted.robot or "basic"), cast("Variant", name.removeprefix("locate:"))
    pipes = parse_corners(wanted.pipes)
    _check_few(pipes, wanted.outputs, drawn=simulator.watch is None)
    located = [record_locate(robot, variant, pipe, wanted.seed, wanted.episode, simulator) for pipe in pipes]
    return PlaneDrawing([one.trajectory for one in located])


def of_policy(name: str, wanted: Wanted, simulator: RecordingSettings) -> Drawing:
    """Episodes of a policy or a baseline; in a route that leaves the plane only one."""
    controller = open_controller(name, wanted.robot, wanted.seed)
    pipes = task_of(controller.task).parse_pipes(wanted.pipes)
    _check_few(pipes, wanted.outputs, drawn=simulator.watch is None)
    if not any(pipe.in_space for pipe in pipes):
        return PlaneDrawing(
            [record_task(controller, name, pipe, wanted.seed, wanted.episode, simulator) for pipe in pipes]
        )
    if len(pipes) > 1:
        raise PipenavError("a picture in space shows one route: name one, for example runs-rolled:3.")
    for path in wanted.outputs:
        check_suffix(path, SUFFIXES)
    route = as_route(pipes[0])
    return SpaceDrawing(record_in_space(controller, name, route, wanted.seed, wanted.episode, simulator))


def _check_few(pipes: Sequence[Pipe], outputs: Sequence[Path], drawn: bool) -> None:
    """Refuse more pipes than a picture or a trajectory file can hold, before they are simulated.

    Args:
        pipes: the pipes.
        outputs: files that are wanted.
        drawn: whether a picture is drawn where no file is named.
    """
    if len(pipes) > MAX_ROWS:
        raise PipenavError(f"{len(pipes)} pipes are too many to look at: name at most {MAX_ROWS}.")
    in_strips = (drawn and not outputs) or any(path.suffix.lower() == STRIP for path in outputs)
    if in_strips and len(pipes) > MOST_IN_STRIP:
        raise PipenavError(
            f"{len(pipes)} pipes are too many for one strip: name at most {MOST_IN_STRIP}, or give --out a name ending "
            "in .gif or .mp4."
        )
    for path in outputs:
        if path.suffix.lower() == TABLE and len(pipes) > 1:
            raise PipenavError(f"{path}: a trajectory file holds one motion: name one pipe.")
