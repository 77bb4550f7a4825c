"""Passability of the pipes of an evaluation by geometry, and of the episodes that failed in them.

An episode that succeeded was possible. For a whole robot the pipe decides about the others; for an arm, which of its
targets it reaches depends on the start, so that every failed episode is certified by itself.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from pipenav.certify.arm import Ends
from pipenav.certify.model import Model
from pipenav.certify.verdict import Kind, Verdict, certify
from pipenav.errors import PipenavError
from pipenav.evaluation.episode_runner import random_start
from pipenav.jobs import JobControl
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.registry import TaskConfig
from pipenav.units import deg_to_rad

RESOLUTION = deg_to_rad(0.5)
"""Width of the smallest cells of headings [rad]: what is undecided with them is mostly within 2 mm of the frontier."""

Chance = Literal["possible", "with_overlap", "undecided", "impossible"]
"""Chance that an episode had: rigid bodies have a motion; only bodies that overlap as far as the task allows have one;
neither motion nor proof was found; or it is proven that there is none even with that overlap."""

ROUTE = "a route of several corners: the method knows single corners"


@dataclass(frozen=True)
class Question:
    """A pipe of an evaluation, with the episodes that failed in it.

    Attributes:
        robot: the robot.
        task: settings of its task, with the starts of the episodes.
        pipe: the pipe.
        episodes: number of episodes in each pipe.
        seed: seed of starts and targets.
        failed: numbers of the episodes that failed, within the pipe.
    """

    robot: RobotSpec
    task: TaskConfig
    pipe: Pipe
    episodes: int
    seed: int
    failed: tuple[int, ...]


class Answer(NamedTuple):
    """Verdict of geometry on a pipe.

    Attributes:
        verdict: verdict on the pipe for rigid bodies.
        verdict_with_overlap: verdict on the pipe with the overlap that the task allows.
        reason: reason of the verdict, in words; of an impossible pipe with overlap, that of the proof with overlap.
        failed: number of failed episodes by the chance that they had.
    """

    verdict: Kind
    verdict_with_overlap: Kind
    reason: str
    failed: Mapping[Chance, int]

    def to_bytes(self) -> bytes:
        """The answer as JSON."""
        return json.dumps(self._asdict()).encode()

    @classmethod
    def from_bytes(cls, content: bytes | None) -> Answer:
        """The answer from the bytes that `to_bytes` gave.

        Raises:
            PipenavError: they are something else, or there are none.
        """
        try:
            return cls(**json.loads(content or b""))
        except (ValueError, TypeError) as error:
            raise PipenavError("a kept verdict of the evaluation is missing: give the command again.") from error


def answer(question: Question, _control: JobControl) -> bytes:
    """Decide about a pipe and its failed episodes: the function of an evaluation's jobs of geometry."""
    pipe = question.pipe.corner
    if pipe is None:
        failed: Counter[Chance] = Counter({"undecided": len(question.failed)})
        return Answer("undecided", "undecided", ROUTE, failed).to_bytes()
    rigid = _verdict(question, pipe, 0.0)
    soft = rigid if rigid.kind == "passable" else _verdict(question, pipe, question.task.max_penetration)
    chances = _chances(question, pipe, rigid.kind, soft.kind)
    reason = soft.reason if soft.kind == "impossible" else rigid.reason
    return Answer(rigid.kind, soft.kind, reason, Counter(chances)).to_bytes()


def _verdict(question: Question, pipe: PipeCorner, overlap: float) -> Verdict:
    """Verdict on all episodes that the task draws in a pipe."""
    model, task = Model(question.robot, pipe, "plane", overlap), question.task
    return certify(model, Ends.of_task(model, task) if isinstance(task, ReachConfig) else None, RESOLUTION)


def _chances(question: Question, pipe: PipeCorner, rigid: Kind, soft: Kind) -> Sequence[Chance]:
    """Chance of each failed episode."""
    same = _chance(rigid, soft)
    if isinstance(question.task, ReachConfig) and soft != "impossible":
        start = random_start(question.robot, question.task, [pipe], question.episodes, question.seed)
        return [_episode(question, pipe, start(number), rigid) for number in question.failed]
    return [same] * len(question.failed)


def _episode(question: Question, pipe: PipeCorner, drawn: ReachEpisodes, pipe_is: Kind) -> Chance:
    """Chance of one episode of an arm; where no episode of the pipe is possible for rigid bodies, this one is not."""
    task = question.task
    assert isinstance(task, ReachConfig)

    def kind(overlap: float) -> Kind:
        model = Model(question.robot, pipe, "plane", overlap)
        ends = Ends.of_episode(model, task, drawn.q[0], float(drawn.base[0]), drawn.target[0])
        return certify(model, ends, RESOLUTION).kind

    rigid = pipe_is if pipe_is == "impossible" else kind(0.0)
    return _chance(rigid, rigid if rigid == "passable" else kind(task.max_penetration))


def _chance(rigid: Kind, soft: Kind) -> Chance:
    """Chance of an episode from the verdicts without and with overlap."""
    if rigid == "passable":
        return "possible"
    return "with_overlap" if soft == "passable" else soft


def check_certified_stage(stage: str) -> None:
    """Refuse to certify what has no given target, or goes on after it.

    Raises:
        PipenavError: the stage is another than reach or traverse.
    """
    if stage not in ("reach", "traverse"):
        raise PipenavError(
            f"--certify decides about given targets and whole robots, and stage {stage} goes on from what a robot "
            "found: choose stage reach, or leave out --certify."
        )
