"""Failed episodes of an evaluation, one by one: how each ended, where along the pipe, and in which pose."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field, ValidationError

from pipenav.arrays import Table
from pipenav.errors import ConfigError
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.parts import PartResult
from pipenav.evaluation.replay import Replayed
from pipenav.jobs import Store
from pipenav.pipes.centre_lines import CentreLines
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.storage.text_files import checked_json, read_text
from pipenav.tasks.outcome import Outcome
from pipenav.units import m_to_mm

FILE = "failures.json"

MAX_FILE = 64 << 20
"""Largest file that is read [bytes]: that of 200,000 failures."""

NEAR = 1.0
"""Distance from a corner, in diameters, within which a tip counts as at the corner."""


class Pose(Table):
    """Pose in which an episode ended.

    Attributes:
        tip_mm: tip along the centre line, from the first corner on, negative before it [mm].
        rear_mm: rear end of the first link, likewise [mm].
        corner: number of the corner next to the tip, from 1.
        side: where the tip is: before that corner, at it (within a diameter), or past it.
        q: configuration in the robot's own frame [m, rad].
    """

    tip_mm: float
    rear_mm: float
    corner: int = Field(ge=1)
    side: Literal["before", "at", "past"]
    q: tuple[float, ...] = Field(strict=False)


class Failure(Table):
    """A failed episode.

    Attributes:
        number: its number in the evaluation, as `pipenav view --eval FOLDER --episode` takes it.
        pipe: number of its pipe in eval.json, from 0.
        stage: stage that failed.
        outcome: how it ended.
        steps: control steps of that stage.
        pose: pose at the end; None where the episode was not run again, or leaves the plane.
    """

    number: int = Field(ge=0)
    pipe: int = Field(ge=0)
    stage: str
    outcome: str
    steps: int = Field(ge=0)
    pose: Pose | None = None

    @property
    def kind(self) -> str:
        """Class of the failure: how it ended and where the tip was."""
        where = "" if self.pose is None else f", tip {self.pose.side} corner {self.pose.corner}"
        return f"{self.stage}: {self.outcome}{where}"


class Failures(Table):
    """All failed episodes of an evaluation, in order of their numbers."""

    schema_version: Literal[1] = Field(alias="schema")
    failures: tuple[Failure, ...] = Field(strict=False)

    def to_json(self) -> str:
        return self.model_dump_json(by_alias=True) + "\n"


def failed_episodes(checked: CheckedEvaluation, store: Store) -> list[Failure]:
    """The failed episodes of an evaluation whose parts are all in a store, without poses."""
    failures, each = list[Failure](), checked.parts.episodes.episodes
    for index in range(checked.parts.count):
        content = store.read(checked.parts.key(index))
        assert content is not None, "the evaluation was merged from these parts"
        for stage, rows in PartResult.from_bytes(content).rows.items():
            for row in np.flatnonzero(~rows.passed):
                number = int(rows.jobs[row])
                ended, steps = Outcome(rows.outcome[row]).label, int(rows.steps[row])
                failures.append(
                    Failure(number=number, pipe=number // each, stage=str(stage), outcome=ended, steps=steps)
                )
    return sorted(failures, key=lambda failure: failure.number)


def with_poses(failures: Sequence[Failure], replayed: Iterable[Replayed], robot: RobotSpec) -> list[Failure]:
    """The failures, those with a pose that were run again and ended alike."""
    again = {one.number: one for one in replayed}
    return [
        failure.model_copy(update={"pose": pose_of(again[failure.number], robot)})
        if failure.number in again and same_end(failure, again[failure.number])
        else failure
        for failure in failures
    ]


def same_end(failure: Failure, replayed: Replayed) -> bool:
    """Whether an episode that was run again ended as it did the first time, at the same step."""
    ended = (str(replayed.stage), replayed.outcome.label, replayed.steps)
    return ended == (failure.stage, failure.outcome, failure.steps)


def pose_of(replayed: Replayed, robot: RobotSpec) -> Pose | None:
    """The pose at the end of an episode; None where none was kept."""
    if not len(replayed.q) or not np.isfinite(replayed.q[-1]).all():
        return None
    points = frames.robot_to_pipe(kinematics.waypoints(robot, replayed.q[-1:])[0], replayed.base)
    lines = CentreLines.of([replayed.pipe])
    rear, tip = lines.distance(points[None, [0, -1]])[0].tolist()
    corners = np.asarray(lines.offset[0, 1 : len(replayed.pipe.interior_angles) + 1])
    nearest = int(np.argmin(np.abs(corners - tip)))
    away = tip - float(corners[nearest])
    side: Literal["before", "at", "past"] = "at"
    if abs(away) > NEAR * replayed.pipe.diameter:
        side = "before" if away < 0 else "past"
    q = tuple(round(value, 5) for value in replayed.q[-1].tolist())
    return Pose(tip_mm=_mm(tip), rear_mm=_mm(rear), corner=nearest + 1, side=side, q=q)


def _mm(metres: float) -> float:
    return round(m_to_mm(metres), 1)


def read_failures(folder: Path) -> dict[int, Failure] | None:
    """Failed episodes of an evaluation folder by number; None where the folder has no list of them.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is something else.
    """
    file = folder / FILE
    if not file.is_file():
        return None
    try:
        found = Failures.model_validate_json(checked_json(read_text(file, MAX_FILE), str(file)))
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error, Failures.model_fields) from error
    return {failure.number: failure for failure in found.failures}
