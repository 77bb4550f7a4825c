"""The results of an evaluation, as written to eval.json. docs/formats/evaluation-folder.md describes the format."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self

from pydantic import Field, JsonValue, ValidationError, computed_field, model_validator

from pipenav.errors import ConfigError
from pipenav.evaluation.audit_record import AuditRecord
from pipenav.evaluation.config import EvaluationConfig, not_given
from pipenav.evaluation.earlier_schema import todays_evaluation
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.passability_record import Passability
from pipenav.evaluation.pipe_results import DiameterRecord, PipeRecord, by_diameter
from pipenav.evaluation.record import Record, Share
from pipenav.storage.text_files import checked_json, read_text

MAX_EVALUATION = 256 << 20
"""Largest eval.json that is read [bytes]; that of 100,000 pipes has 71 MB."""


class Extremes(NamedTuple):
    """99th percentiles over the episodes of an evaluation.

    Attributes:
        penetration: of the deepest overlap [m].
        force: of the peak contact force [N].
    """

    penetration: float
    force: float


class Evaluation(Record):
    """Results of an evaluation; `Evaluation.of` counts them from the pipes' records.

    Attributes:
        schema_version: version of the format, 2 once it is read; the key is `schema`.
        config: everything that decided what was computed, its stage named.
        robot: name of the robot.
        success: share of all episodes that passed every stage that was run.
        success_low, success_high: ends of the 95 % interval of that share.
        penetration_p99_m: 99th percentile over the episodes of the deepest overlap [m].
        force_p99_n: 99th percentile over the episodes of the peak contact force [N].
        pipes: one record for each pipe, in the order in which they were given.
        diameters: one record for each diameter, widest first.
        audit: the audit of successful episodes; None and left out of the file where nobody asked for one.
        passability: chances that geometry gave the episodes; None and left out of the file likewise.
    """

    schema_version: Literal[1, 2] = Field(2, alias="schema")
    config: EvaluationConfig
    robot: str
    success: Share
    success_low: Share
    success_high: Share
    penetration_p99_m: float | None = None
    force_p99_n: float | None = None
    pipes: tuple[PipeRecord, ...] = Field(min_length=1)
    diameters: tuple[DiameterRecord, ...] = Field(min_length=1)
    audit: AuditRecord | None = Field(None, exclude_if=not_given)
    passability: Passability | None = Field(None, exclude_if=not_given)

    @model_validator(mode="before")
    @classmethod
    def _todays_schema(cls, given: Any) -> Any:
        return todays_evaluation(given)

    @classmethod
    def of(
        cls,
        pipes: Sequence[PipeRecord],
        *,
        config: EvaluationConfig,
        robot: str,
        extremes: Extremes | None = None,
        thesis: Mapping[float, float] | None = None,
        audit: AuditRecord | None = None,
    ) -> Self:
        """An evaluation of at least one pipe; `thesis` holds figures [percent] to compare with, by diameter [mm]."""
        successes, episodes = sum(r.successes for r in pipes), sum(r.episodes for r in pipes)
        diameters = [DiameterRecord.of(group, (thesis or {}).get(d)) for d, group in by_diameter(pipes).items()]
        low, high = wilson(successes, episodes)
        certified = [record.passability for record in pipes if record.passability is not None]
        return cls(
            config=config,
            robot=robot,
            success=successes / episodes,
            success_low=low,
            success_high=high,
            penetration_p99_m=None if extremes is None else extremes.penetration,
            force_p99_n=None if extremes is None else extremes.force,
            pipes=tuple(pipes),
            diameters=tuple(diameters),
            audit=audit,
            passability=Passability.of(certified) if certified else None,
        )

    @computed_field  # type: ignore[prop-decorator]  # mypy knows no decorated properties
    @property
    def policy(self) -> str:
        """Name of the policy, or of the behaviour that locates a target; a key of schema 1."""
        return self.config.subject

    @computed_field  # type: ignore[prop-decorator]
    @property
    def backend(self) -> str:
        """Name of the backend; a key of schema 1."""
        return self.config.backend

    @computed_field  # type: ignore[prop-decorator]
    @property
    def stage(self) -> str:
        """Name of the stage that was run; a key of schema 1."""
        return str(self.config.stage)

    @computed_field  # type: ignore[prop-decorator]
    @property
    def seed(self) -> int:
        """Seed of starts and targets; a key of schema 1."""
        return self.config.seed

    @computed_field  # type: ignore[prop-decorator]
    @property
    def episodes_per_pipe(self) -> int:
        """Episodes in every pipe; a key of schema 1."""
        return self.config.episodes

    @computed_field  # type: ignore[prop-decorator]
    @property
    def options(self) -> dict[str, JsonValue]:
        """The simulator's own settings; a key of schema 1."""
        return self.config.options

    @computed_field  # type: ignore[prop-decorator]
    @property
    def disturb(self) -> str | None:
        """Name or file of the disturbances; a key of schema 1."""
        return self.config.disturb

    @property
    def episodes(self) -> int:
        return sum(record.episodes for record in self.pipes)

    def to_json(self) -> str:
        return self.model_dump_json(by_alias=True, indent=2) + "\n"


def read_evaluation(path: Path) -> Evaluation:
    """The evaluation in a folder, or in a file of the format of eval.json.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is no evaluation, or has a schema that is not known.
    """
    file = path / "eval.json" if path.is_dir() else path
    try:
        return Evaluation.model_validate_json(checked_json(read_text(file, MAX_EVALUATION), str(file)))
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error, Evaluation.model_fields) from error
