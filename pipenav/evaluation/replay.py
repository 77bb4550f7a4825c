"""Episodes of an evaluation run again from its seed: what they did, and how and when they ended."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.parts import REAR_FOLLOWS
from pipenav.evaluation.passage import EpisodePlan, Passages, StageResult
from pipenav.pipes.pipe import Pipe
from pipenav.policies.controller import AnyController
from pipenav.policies.named import RandomController
from pipenav.robots import frames
from pipenav.tasks.outcome import Outcome, PassageStage
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.registry import task_of

AT_ONCE = 128
"""Most episodes whose motions are kept at once: some tens of megabytes."""


class Replayed(NamedTuple):
    """An episode that was run again.

    Attributes:
        number: its number in the evaluation: all of the first pipe have the lowest ones, then those of the next.
        pipe: its pipe.
        stage: last stage that was run, the one that failed where one did.
        outcome: how that stage ended.
        steps: control steps of that stage.
        moved: last stage whose motion was kept; a rear half's is not.
        base: x of the robot's frame in the pipe's frame [m].
        q: configurations of that stage, in the robot's own frame, (rows, coordinates); no rows where the
            robot leaves the plane.
        target: target in the pipe's frame [m]; None where there is none.
    """

    number: int
    pipe: Pipe
    stage: PassageStage
    outcome: Outcome
    steps: int
    moved: PassageStage
    base: float
    q: Floats
    target: tuple[float, float] | None

    @property
    def passed(self) -> bool:
        """Whether it passed every stage."""
        return self.outcome is Outcome.REACHED


class Replayer:
    """Runs episodes of an evaluation again.

    Args:
        checked: the evaluation.
    """

    def __init__(self, checked: CheckedEvaluation) -> None:
        self._parts, self._config = checked.parts, checked.config
        self._numbered = checked.parts.episodes.numbered()

    @property
    def quick(self) -> bool:
        """Whether an episode can be run alone; else all episodes of its part are, which its results depend on."""
        return self._parts.robots_are_independent

    def run(self, numbers: Sequence[int]) -> Iterator[Replayed]:
        """Run episodes again, by number, in order of their numbers."""
        wanted = sorted(set(numbers))
        if not self.quick:
            yield from self._by_part(wanted)
            return
        for first in range(0, len(wanted), AT_ONCE):
            group = wanted[first : first + AT_ONCE]
            yield from self._run(replace(self._parts.episodes, chosen=group), group)

    def _by_part(self, wanted: Sequence[int]) -> Iterator[Replayed]:
        """Run the parts that episodes belong to."""
        bounds = self._parts.bounds
        for index in range(self._parts.count):
            inside = [number for number in wanted if bounds[index] <= number < bounds[index + 1]]
            if inside:
                part = self._parts.part(index, index + 1)
                every = list(range(bounds[index], bounds[index + 1]))
                found = self._run(part.plan, every, _as_new(part.controller, self._config.seed, index))
                yield from (one for one in found if one.number in inside)

    def _run(
        self, plan: EpisodePlan, numbers: Sequence[int], controller: AnyController | None = None
    ) -> Iterator[Replayed]:
        """Run a plan's episodes, which have these numbers in the evaluation."""
        stages = self._stages(Passages(plan), controller or self._parts.controller)
        for job, number in enumerate(numbers):
            yield self._episode(number, job, stages)

    def _stages(self, passages: Passages, controller: AnyController | None) -> dict[PassageStage, StageResult]:
        """Results of all stages, in order."""
        found: dict[PassageStage, StageResult] = {}
        located = None
        if self._config.stage in ("locate", "passage"):
            located = found[PassageStage.LOCATE] = passages.locate(self._config.variant)
        if controller is not None:
            task = task_of(self._parts.episodes.task).stage
            found[task] = passages.task(controller, located)
            if self._config.stage in REAR_FOLLOWS:
                found[PassageStage.REAR] = passages.rear(found[task], located)
        return found

    def _episode(self, number: int, job: int, stages: dict[PassageStage, StageResult]) -> Replayed:
        robot = self._parts.episodes.robot
        given = self._numbered(number)
        base, q, target = float(given.base[0]), np.zeros((0, robot.coordinates)), None
        if isinstance(given, ReachEpisodes) and PassageStage.LOCATE not in stages:
            target = _in_pipe(given.target[0], given)
        stage, outcome, steps = next(iter(stages)), Outcome.RUNNING, 0
        moved = stage
        for name, result in stages.items():
            rows = np.flatnonzero(result.jobs == job)
            if not len(rows):
                break
            row = int(rows[0])
            stage, outcome = name, Outcome(result.results.outcome[row])
            steps = int(result.results.steps[row])
            if result.motions:
                q, moved = result.motions[row], name
            if isinstance(given, ReachEpisodes) and np.isfinite(result.targets[row]).all():
                target = _in_pipe(result.targets[row], given)
        return Replayed(number, given.pipes[0], stage, outcome, steps, moved, base, q, target)


def _as_new(controller: AnyController | None, seed: int, index: int) -> AnyController | None:
    """A part's controller as it was before the part ran: one that draws begins its draws again."""
    if isinstance(controller, RandomController):
        return controller.seeded([seed, index] if index else seed)
    return controller


def _in_pipe(target: Floats, given: ReachEpisodes) -> tuple[float, float]:
    """A target of the canonical frame in the pipe's."""
    x, y = frames.canonical_to_pipe(target, given.turn_sign[0], given.base[0])
    return float(x), float(y)
