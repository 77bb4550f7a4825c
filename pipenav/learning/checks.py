"""The checks of a training, pipe by pipe: checks.json, described in docs/formats/training-folder.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator

from pipenav.arrays import Table
from pipenav.errors import ConfigError
from pipenav.evaluation.pipe_counts import pipe_keys
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.pipes.pipe import Pipe
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.text_files import MAX_RECORD, checked_json, read_text
from pipenav.tasks.outcome import Outcome

MOST_CHECKS = 500
"""Most checks that are kept: the newest ones. With 200 pipes each, a file of them has 1.5 MB."""


class CheckedPipe(Table):
    """A pipe of a check, by the keys of a `PipeRecord`, and its label."""

    label: str
    diameter_mm: float = Field(gt=0)
    angle_deg: float | None
    turn: Literal["left", "right"] | None
    bend_radius_mm: float = Field(ge=0)
    fitting: str | None
    route: str | None

    @classmethod
    def of(cls, pipe: Pipe) -> Self:
        return cls(label=pipe.label, **pipe_keys(pipe))


class Check(Table):
    """A check: the policy without exploration noise, on the same number of episodes in each of its pipes.

    Attributes:
        steps: control steps of the training before it.
        seconds: seconds of training before it.
        stage: number of the training's stage.
        pipes: number of its set of pipes in `Checks`.
        episodes: episodes in each pipe.
        successes: successful episodes in each pipe.
        failures: failed ones by their outcome, in each pipe.
    """

    steps: int = Field(ge=0)
    seconds: float = Field(ge=0)
    stage: int = Field(ge=1)
    pipes: int = Field(ge=0)
    episodes: int = Field(ge=1)
    successes: tuple[int, ...]
    failures: tuple[dict[str, int], ...]

    @property
    def success(self) -> float:
        """Share of the episodes that succeeded."""
        return sum(self.successes) / (self.episodes * len(self.successes))


class Checks(Table):
    """The newest checks of a training, and the sets of pipes that they were made in."""

    schema_version: Literal[1] = Field(1, alias="schema")
    pipe_sets: tuple[tuple[CheckedPipe, ...], ...] = ()
    checks: tuple[Check, ...] = Field((), max_length=MOST_CHECKS)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for check in self.checks:
            count = len(self.pipe_sets[check.pipes]) if check.pipes < len(self.pipe_sets) else 0
            if not count or not len(check.successes) == len(check.failures) == count:
                raise ValueError(f"the check after {check.steps} steps has another number of pipes than its set")
            if not all(0 <= one <= check.episodes for one in check.successes):
                raise ValueError(f"the check after {check.steps} steps has more successes than episodes")
        return self

    def with_check(self, pipes: Sequence[Pipe], outcomes: NDArray[np.int8], **more: Any) -> Checks:
        """These checks and a further one; those that it repeats, of a training that lost its last steps, are left out.

        Args:
            pipes: pipes of the new check.
            outcomes: an `Outcome` for each episode, all of the first pipe, then of the next, (k,).
            more: `steps`, `seconds` and `stage` of a `Check`.
        """
        rows = outcomes.reshape(len(pipes), -1)
        checked = tuple(map(CheckedPipe.of, pipes))
        sets = self.pipe_sets if checked in self.pipe_sets else (*self.pipe_sets, checked)
        failed = [Counter(Outcome(one).label for one in row if one != Outcome.REACHED) for row in rows]
        check = Check(
            pipes=sets.index(checked),
            episodes=rows.shape[1],
            successes=tuple(int(n) for n in (rows == Outcome.REACHED).sum(axis=1)),
            failures=tuple(dict(counts) for counts in failed),
            **more,
        )
        before = [one for one in self.checks if one.steps < check.steps]
        return Checks(pipe_sets=sets, checks=tuple([*before, check][-MOST_CHECKS:]), schema=1)

    def records(self, number: int) -> list[PipeRecord]:
        """The pipes of one of the sets as records without a count, for a map."""
        return [PipeRecord(**one.model_dump(exclude={"label"}), episodes=1) for one in self.pipe_sets[number]]


def read_checks(file: Path) -> Checks:
    """The checks of a training; none where there is no such file, as in folders of earlier versions.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it holds no checks.
    """
    if not file.is_file():
        return Checks(schema=1)
    try:
        return Checks.model_validate_json(checked_json(read_text(file, MAX_RECORD), str(file)))
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error, Checks.model_fields) from error


def write_checks(file: Path, checks: Checks) -> None:
    """Write the checks of a training, whole or not at all."""
    atomic_write(file, checks.model_dump_json(by_alias=True) + "\n")
