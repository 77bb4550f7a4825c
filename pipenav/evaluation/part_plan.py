"""The parts of an evaluation: which episodes each has, which depends on what is evaluated and on nothing else."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from pydantic import JsonValue

from pipenav.backends.plugins import find_backends
from pipenav.backends.simulators import load_simulator
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.parts import EvaluationPart
from pipenav.evaluation.passage import EpisodePlan
from pipenav.policies.controller import AnyController
from pipenav.policies.header import installed_versions
from pipenav.policies.named import BASELINE, PolicyController, RandomController
from pipenav.policies.policy import resolve_policy

PARTS = 16
"""Parts of an evaluation of usual size: enough to keep several cores busy to the end."""

PART_EPISODES = (64, 1024)
"""Fewest and most episodes of a part: with fewer, robots wait for each other; more are lost with a worker."""

MOST_TOGETHER = 409_600
"""Most control steps, by the task's time limit for a corner, of parts that one process runs in one go, where that changes
no result: a stop loses them."""


def bounds_of(total: int) -> list[int]:
    """Number of the first episode of each part, then the number of all episodes, which alone decides."""
    fewest, most = PART_EPISODES
    size = min(most, max(fewest, -(-total // PARTS)))
    return [*range(0, total, size), total]


class Shard:
    """A share of an evaluation's parts for one of several drivers, `K/N`: every N-th part from the K-th."""

    def __init__(self, number: int, of: int) -> None:
        self.number, self.of = number, of

    def has(self, index: int) -> bool:
        """Whether a part is in the share, by its number from 0."""
        return index % self.of == self.number - 1

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"


@dataclass(frozen=True)
class PartPlan:
    """An evaluation in parts, whose bounds depend on its number of episodes alone.

    PyBullet's robots share worlds, and a random controller draws for all its robots: their results depend on which
    episodes run together. These are those of a part, whichever process runs it.

    Attributes:
        config: what is evaluated, its stage named.
        episodes: all its episodes.
        controller: its controller; None for the stage locate.
    """

    config: EvaluationConfig
    episodes: EpisodePlan
    controller: AnyController | None

    @property
    def total(self) -> int:
        """Number of all episodes."""
        return len(self.episodes.numbers)

    @cached_property
    def bounds(self) -> list[int]:
        """Number of the first episode of each part, then the number of all episodes."""
        return bounds_of(self.total)

    @property
    def count(self) -> int:
        """Number of parts."""
        return len(self.bounds) - 1

    @property
    def robots_are_independent(self) -> bool:
        """Whether an episode's results are the same whichever others run together with it."""
        alone = self.controller is None or isinstance(self.controller, PolicyController)
        return alone and load_simulator(self.config.backend).robots_are_independent

    def part(self, first: int, end: int) -> EvaluationPart:
        """The parts `first` to the one before `end`, as one."""
        begin, to = self.bounds[first], self.bounds[end]
        each = self.episodes.episodes
        inside = slice(begin // each, -(-to // each))
        pipes, starts = self.episodes.pipes[inside], self.episodes.starts[inside]
        plan = replace(self.episodes, pipes=tuple(pipes), starts=starts, first=begin % each, count=to - begin)
        controller = self.controller
        if isinstance(controller, RandomController) and first:
            controller = controller.seeded([self.config.seed, first])
        assert self.config.stage is not None
        config = self.config
        return EvaluationPart(plan, begin, controller, self.config.stage, config.variant, config.audit)

    def missing(self, kept: Sequence[bool], together: bool) -> Iterator[range]:
        """Numbers of the parts that are not kept: each alone, or several in a row as far as they may run together."""
        group = range(0)
        together = together and self.robots_are_independent
        for index, there in enumerate(kept):
            fits = together and group and group.stop == index and self._steps(group.start, index + 1) <= MOST_TOGETHER
            if not there and fits:
                group = range(group.start, index + 1)
                continue
            if group:
                yield group
            group = range(0) if there else range(index, index + 1)
        if group:
            yield group

    def _steps(self, first: int, end: int) -> int:
        """Control steps that the parts `first` to the one before `end` may take, by the time limit for each corner."""
        begin, to = self.bounds[first], self.bounds[end]
        each = self.episodes.episodes
        pipes = self.episodes.pipes[begin // each : -(-to // each)]
        corners = max((len(pipe.turn_signs) for pipe in pipes), default=1)
        return (to - begin) * corners * self.episodes.task.max_steps

    def key(self, index: int) -> str:
        """Name that tells a part, by its number from 0, from those of every other evaluation."""
        return f"part-{index:06d}-{self._digest}"

    def pipe_key(self, number: int) -> str:
        """Name of geometry's verdict on a pipe, by its number from 0, as `key` for parts."""
        return f"pipe-{number:06d}-{self._digest}"

    @cached_property
    def _digest(self) -> str:
        return _digest(json.dumps(self.request()).encode())

    def request(self) -> Mapping[str, JsonValue]:
        """Everything that decides the results: settings, contents of the files that they name, versions."""
        robot, task = self.episodes.robot, self.episodes.task
        policy, starts = self.config.policy, self.episodes.starts
        weights = policy is not None and not policy.startswith(BASELINE)
        by_content = {"pipes", "starts", "disturb", "robot", "certify", *(["policy"] if weights else [])}
        request: dict[str, JsonValue] = {
            **json.loads(self.config.model_dump_json(exclude=by_content)),
            "robot": _digest(robot.model_dump_json().encode()),
            "task": _digest(task.model_dump_json().encode()),
            "disturbance": _digest(self.episodes.disturbance.model_dump_json().encode()),
            "pipes": _digest(*(repr(pipe).encode() for pipe in self.episodes.pipes)),
            **({"starts": _digest(*(one.model_dump_json().encode() for one in starts))} if starts else {}),
            "policy": _digest(resolve_policy(str(policy)).read_bytes()) if weights else None,
            "backend": find_backends()[self.config.backend].origin,
        }
        return request | {f"version of {name}": version for name, version in installed_versions().items()}


def _digest(*contents: bytes) -> str:
    """Number made from contents, which tells them from others."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(content + b"\0")
    return digest.hexdigest()[:16]
