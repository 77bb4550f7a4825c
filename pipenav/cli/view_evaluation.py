"""An episode of an evaluation folder for `pipenav view`, run again from its seed."""

from __future__ import annotations

from pathlib import Path

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.cli.terminal import say
from pipenav.cli.view_drawings import Drawing, PlaneDrawing, SpaceDrawing
from pipenav.errors import PipenavError
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.failures import Failure, read_failures
from pipenav.evaluation.replay import Replayed, Replayer
from pipenav.evaluation.results import read_evaluation
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.pipes.route import as_route
from pipenav.policies.named import open_controller
from pipenav.recording.record import RecordingSettings
from pipenav.recording.record_rolling import record_in_space


def of_evaluation(folder: Path, number: int) -> Drawing:
    """An episode of an evaluation by its number; says whether it ended as it did then.

    Raises:
        PipenavError: the folder holds no evaluation, it has fewer episodes, or its policy is not there any more.
    """
    config = read_evaluation(folder).config
    checked = CheckedEvaluation(config)
    plan = checked.parts.episodes
    if number >= checked.parts.total:
        raise PipenavError(
            f"--episode {number} is none of the {checked.parts.total} episodes in {folder}: choose 0 to "
            f"{checked.parts.total - 1}."
        )
    index, episode = divmod(number, plan.episodes)
    known = read_failures(folder)
    failure = None if known is None else known.get(number)
    if plan.pipes[index].in_space:
        assert config.policy is not None  # only a policy goes through pipes that leave the plane
        controller = open_controller(config.policy, config.robot, config.seed)
        settings = RecordingSettings(config.backend, config.options, task=plan.task)
        moved = record_in_space(controller, config.policy, as_route(plan.pipes[index]), config.seed, episode, settings)
        if known is not None:
            _say_whether_alike(failure, "traverse", moved.outcome, len(moved.points) - 1)
        return SpaceDrawing(moved)
    (replayed,) = Replayer(checked).run([number])
    if known is not None:
        _say_whether_alike(failure, str(replayed.stage), replayed.outcome.label, replayed.steps)
    if not len(replayed.q):
        raise PipenavError(f"episode {number} in {folder} has no motion to draw: choose another one.")
    return PlaneDrawing([_trajectory(replayed, checked)])


def _say_whether_alike(failure: Failure | None, stage: str, outcome: str, steps: int) -> None:
    """Say whether an episode ended as the evaluation has it."""
    now = f"{stage}: {outcome} after {CONTROL_PERIOD * steps:.1f} s"
    if failure is None:
        alike, then = outcome == "reached", "it succeeded"
    else:
        alike = (stage, outcome, steps) == (failure.stage, failure.outcome, failure.steps)
        then = f"{failure.stage}: {failure.outcome} after {CONTROL_PERIOD * failure.steps:.1f} s"
    if alike:
        say(f"{now}, as in the evaluation")
    else:
        say(f"{now}; in the evaluation, {then}: another version, simulator or processor may be the reason", "yellow")


def _trajectory(replayed: Replayed, checked: CheckedEvaluation) -> Trajectory:
    """The motion of an episode; contact forces are not kept."""
    config, robot = checked.config, checked.parts.episodes.robot
    ended = replayed.outcome.label if replayed.moved is replayed.stage else "reached"
    header = TrajectoryHeader(
        robot=robot.name,
        pipe=replayed.pipe,  # type: ignore[arg-type]  # a corner or a route, as every pipe of an evaluation
        base_m=replayed.base,
        goal_m=replayed.target,
        stage=replayed.moved,
        outcome=ended,
        backend=config.backend,
        controller=config.subject,
        options=dict(config.options),
        seed=config.seed,
    )
    return Trajectory(header, robot, replayed.q, None, None)
