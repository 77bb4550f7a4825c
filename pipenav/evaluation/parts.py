"""A part of an evaluation: some of its episodes in a row, which any process on any machine can run."""

from __future__ import annotations

import io
import platform
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.errors import PipenavError
from pipenav.evaluation.audit import Auditor, AuditRows
from pipenav.evaluation.config import StageName
from pipenav.evaluation.passage import EpisodePlan, Passages, StageResult
from pipenav.jobs import JobControl
from pipenav.locating.locator import Variant
from pipenav.policies.controller import AnyController
from pipenav.policies.header import installed_versions
from pipenav.tasks.outcome import Outcome, PassageStage
from pipenav.tasks.registry import task_of

REAR_FOLLOWS = ("reach-rear", "passage")
"""Stages of an evaluation that end with the rear half's passage, which needs the motions of those before."""

AUDIT = "audit"
"""Name of the arrays of audits, in the file of a part."""

CPU = "cpu"
"""Name of the array, in the file of a part, that says what kind of processor computed it."""


@cache
def _versions() -> Mapping[str, str]:
    return installed_versions()


@dataclass(frozen=True)
class EvaluationPart:
    """Some episodes of an evaluation, with everything that they need.

    Attributes:
        plan: the episodes; its pipes are only those that they run in.
        begin: number of the plan's first episode in the whole evaluation.
        controller: the controller; None for the stage locate.
        stage: stage to run, with those before it.
        variant: how a target is located.
        audit: share of the successful episodes to audit; None for none.
        versions: versions of everything that decides results, where the driver runs.
    """

    plan: EpisodePlan
    begin: int
    controller: AnyController | None
    stage: StageName
    variant: Variant
    audit: float | None = None
    versions: Mapping[str, str] = field(default_factory=_versions)


class StageRows(NamedTuple):
    """Results of a stage's episodes in order, as `EpisodeResults` has them, without the poses at the end.

    Attributes:
        jobs: numbers of the episodes in the whole evaluation, (k,).
        outcome: how each episode ended, an `Outcome` each, (k,).
        steps: control steps, (k,).
        min_range: smallest laser reading, (k,) [m].
        penetration: deepest overlap with the wall, (k,) [m].
        force: peak contact force, (k,) [N].
        contact_share: share of the time in contact, (k,).
    """

    jobs: Ints
    outcome: NDArray[np.int8]
    steps: Ints
    min_range: Floats
    penetration: Floats
    force: Floats
    contact_share: Floats

    @property
    def passed(self) -> Flags:
        """Whether each episode succeeded, (k,)."""
        return np.asarray(self.outcome == Outcome.REACHED)

    def between(self, first: int, end: int) -> StageRows:
        """Rows of the episodes from `first` to the one before `end`."""
        low, high = np.searchsorted(self.jobs, (first, end))
        return StageRows(*(column[low:high] for column in self))  # type: ignore[arg-type]  # every column alike

    @classmethod
    def joined(cls, parts: list[StageRows]) -> StageRows:
        """Rows of several parts in a row as one."""
        return parts[0] if len(parts) == 1 else cls(*map(np.concatenate, zip(*parts, strict=True)))


PartRows = dict[PassageStage, StageRows]
"""Results of a part by stage, in the order in which the stages run."""


class PartResult(NamedTuple):
    """Results of a part, the kind of processor that computed them, and audits where they were asked for."""

    rows: PartRows
    cpu: str
    audits: AuditRows | None = None

    def between(self, first: int, end: int) -> PartResult:
        """Results of the episodes from `first` to the one before `end`."""
        rows = {stage: rows.between(first, end) for stage, rows in self.rows.items()}
        return PartResult(rows, self.cpu, self.audits and self.audits.of_jobs(first, end))

    def to_bytes(self) -> bytes:
        """The results as an npz file."""
        arrays: dict[str, NDArray[Any]] = {CPU: np.array(self.cpu)}
        for stage, rows in self.rows.items():
            arrays |= {f"{stage}.{name}": column for name, column in rows._asdict().items()}
        if self.audits is not None:
            arrays |= {f"{AUDIT}.{name}": column for name, column in self.audits._asdict().items()}
        file = io.BytesIO()
        np.savez(file, allow_pickle=False, **arrays)
        return file.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes) -> PartResult:
        """Results from the bytes that `to_bytes` gave.

        Raises:
            PipenavError: they are something else.
        """
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as file:
                tables = dict.fromkeys(name.partition(".")[0] for name in file.files if name != CPU)
                stages = [PassageStage(table) for table in tables if table != AUDIT]
                rows = {s: StageRows(*(file[f"{s}.{column}"] for column in StageRows._fields)) for s in stages}
                if AUDIT not in tables:
                    return cls(rows, str(file[CPU]))
                audits = AuditRows(*(file[f"{AUDIT}.{column}"] for column in AuditRows._fields))
                return cls(rows, str(file[CPU]), audits)
        except (OSError, EOFError, ValueError, KeyError, AttributeError, TypeError, zipfile.BadZipFile) as error:
            raise PipenavError(f"a kept part of the evaluation is damaged ({error}): remove its folder.") from error


def kind_of_cpu() -> str:
    """Kind of this machine's processor, as far as results depend on it: the features that numpy makes use of."""
    try:
        features = import_module("numpy._core._multiarray_umath").__cpu_features__
    except (ImportError, AttributeError):  # it is numpy's own business where it keeps them
        return platform.machine()
    return " ".join([platform.machine(), *sorted(name for name, there in features.items() if there)])


def run_part(part: EvaluationPart, control: JobControl) -> bytes:
    """Run a part: the function of an evaluation's jobs; it reports (stage, episodes, done, successes).

    Raises:
        PipenavError: versions differ from those where the driver runs.
    """
    _require_versions(part.versions)

    def report(stage: str, total: int, done: int, successes: int) -> None:
        control.report((stage, total, done, successes))

    plan = part.plan.on(part.plan.simulator.on_cores(control.cores))
    auditor = None if part.audit is None else Auditor(plan.robot, plan.task, part.audit, part.begin)
    passages = Passages(plan, report, part.stage in REAR_FOLLOWS, auditor)
    rows = {stage: _rows(result, part.begin) for stage, result in _stages(part, passages)}
    return PartResult(rows, kind_of_cpu(), None if auditor is None else auditor.rows).to_bytes()


def _stages(part: EvaluationPart, passages: Passages) -> Iterator[tuple[PassageStage, StageResult]]:
    """Run the stages one after the other."""
    located = reached = None
    if part.stage in ("locate", "passage"):
        located = passages.locate(part.variant)
        yield PassageStage.LOCATE, located
    if part.controller is not None:
        reached = passages.task(part.controller, located)
        yield task_of(part.plan.task).stage, reached
    if part.stage in REAR_FOLLOWS:
        assert reached is not None
        yield PassageStage.REAR, passages.rear(reached, located)


def _rows(result: StageResult, begin: int) -> StageRows:
    results = result.results
    columns = {name: getattr(results, name) for name in StageRows._fields if name != "jobs"}
    return StageRows(jobs=result.jobs + begin, **columns)


def _require_versions(versions: Mapping[str, str]) -> None:
    """Refuse to compute with versions of which results may depend."""
    here = _versions()
    for name, version in versions.items():
        if here.get(name) != version:
            raise PipenavError(
                f"{platform.node()} has {name} {here.get(name, 'not installed')}, and the machine that drives the jobs "
                f"{version}: install the same versions on every machine."
            )
