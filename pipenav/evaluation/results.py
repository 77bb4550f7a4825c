"""What an evaluation found, as written to eval.json. docs/evaluation-folder.md describes the format."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    JsonValue,
    ValidationError,
    computed_field,
    model_validator,
)

from pipenav.errors import ConfigError, FileProblem
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.thesis import is_thesis_set

Z_95 = 1.959963984540054
"""The normal distribution's 97.5 % quantile, for two-sided 95 % intervals."""

Typed = Annotated[float, AfterValidator(lambda value: round(value, 6))]
"""A number that people type: free of what a way through radians and back leaves in the last digits."""

Share = Annotated[float, Field(ge=0, le=1)]
Amount = Annotated[float, Field(ge=0)]
Count = Annotated[int, Field(ge=0)]
Positive = Annotated[int, Field(ge=1)]


class Interval(NamedTuple):
    """A 95 % interval of a share, both ends in [0, 1]."""

    low: float
    high: float


def wilson(successes: int, n: int) -> Interval:
    """Wilson's 95 % score interval of a share of which `successes` of `n` trials were seen; without trials, [0, 1].

    Source: E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal of the
    American Statistical Association 22 (1927) 209-212; without continuity correction (method 3 of R. G. Newcombe,
    Statistics in Medicine 17 (1998) 857-872). It holds up where the textbook's interval collapses: at 0 and n.
    """
    if not 0 <= successes <= n:
        raise ValueError(f"{successes} successes of {n} trials")
    if n == 0:
        return Interval(0.0, 1.0)
    share, z2 = successes / n, Z_95**2
    centre = share + z2 / (2 * n)
    half = Z_95 * math.sqrt(share * (1 - share) / n + z2 / (4 * n * n))
    # Both ends are exact where nothing, or everything, succeeded; rounding would leave 1e-17 there.
    low = 0.0 if successes == 0 else (centre - half) / (1 + z2 / n)
    high = 1.0 if successes == n else (centre + half) / (1 + z2 / n)
    return Interval(low, high)


def _todays_key(key: str) -> str:
    key = EARLIER_KEYS.get(key, key)
    return f"reach_{key.removeprefix('front_')}" if key.startswith("front_") else key


EARLIER_KEYS = {"run": "route", "min_clearance_m": "min_range_m"}
"""Keys of schema 1 that have another name in schema 2; besides, `front_` was what is `reach_` today."""


class _Record(BaseModel):
    # Unknown keys are skipped, so that a file of a later version that only adds keys can still be read.
    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False, populate_by_name=True)

    @model_validator(mode="before")
    @classmethod
    def _todays_keys(cls, given: Any) -> Any:
        """Keys of schema 1 as those of today."""
        if not isinstance(given, dict):
            return given
        return {_todays_key(key): value for key, value in given.items()}


class PipeRecord(_Record):
    """All episodes in one pipe. Counts of a stage that was not run, and what was not measured, are None.

    Attributes:
        diameter_mm: inner diameter [mm].
        angle_deg: interior corner angle [deg]; None of a run.
        turn: side of the corner, seen by the robot; None of a run.
        route: name of a route, as `PipeRoute.name`; None of a single corner.
        episodes: episodes run.
        located: episodes in which the robot found a target itself.
        reach_attempts: front passages begun.
        reach_successes: front passages that reached their target.
        rear_attempts, rear_successes: the same of rear passages, which succeed by leaving the corner.
        traverse_attempts, traverse_successes: the same of whole robots, which succeed once their tail is through.
        failures: how many episodes ended by each reason other than success.
        mean_steps: mean control steps of a successful front passage or traverse, or of finding a target where neither
            was run; None without one.
        min_range_m: smallest laser reading of all episodes [m].
        max_penetration_m: deepest overlap of robot and wall of all episodes [m].
        peak_force_n: largest contact force of all episodes [N].
        contact_time_share: share of the time in contact with the wall, mean over episodes.
    """

    diameter_mm: Typed
    angle_deg: Typed | None
    turn: Literal["left", "right"] | None
    route: str | None = None
    episodes: Positive
    located: Count | None = None
    reach_attempts: Count | None = None
    reach_successes: Count | None = None
    rear_attempts: Count | None = None
    rear_successes: Count | None = None
    traverse_attempts: Count | None = None
    traverse_successes: Count | None = None
    failures: dict[str, Count] = Field(default_factory=dict)
    mean_steps: Amount | None = None
    min_range_m: float | None = None
    max_penetration_m: float | None = None
    peak_force_n: Amount | None = None
    contact_time_share: Share | None = None

    @model_validator(mode="after")
    def _counts_fit(self) -> Self:
        """Every stage begins with what the stage before left."""
        given = [value is not None for value in (self.angle_deg, self.turn)]
        if given != [self.route is None] * 2:
            raise ValueError("a corner has angle_deg and turn, and a route has neither but its name in route")
        left = self.episodes
        for name in ("located", "reach_attempts", "reach_successes", "rear_attempts", "rear_successes"):
            count = getattr(self, name)
            if count is not None and count > left:
                raise ValueError(f"{name} is {count}, more than the {left} before it")
            left = left if count is None else count
        if self.traverse_attempts is not None and not (self.traverse_successes or 0) <= self.traverse_attempts <= left:
            raise ValueError(f"traverse_attempts must lie between traverse_successes and the {left} episodes")
        for stage in ("reach", "rear", "traverse"):
            if (getattr(self, f"{stage}_attempts") is None) != (getattr(self, f"{stage}_successes") is None):
                raise ValueError(f"{stage}_attempts and {stage}_successes must be given together")
        return self

    @computed_field  # type: ignore[prop-decorator]  # mypy knows no decorated properties
    @property
    def reach_success_low(self) -> float | None:
        """Lower end of the 95 % interval of the front's success."""
        return self.reach_interval and self.reach_interval.low

    @computed_field  # type: ignore[prop-decorator]
    @property
    def reach_success_high(self) -> float | None:
        """Upper end of the 95 % interval of the front's success."""
        return self.reach_interval and self.reach_interval.high

    @property
    def reach_interval(self) -> Interval | None:
        if self.reach_attempts is None or self.reach_successes is None:
            return None
        return wilson(self.reach_successes, self.reach_attempts)

    @property
    def successes(self) -> int:
        """Episodes that passed every stage that was run."""
        counts = (self.traverse_successes, self.rear_successes, self.reach_successes, self.located)
        return next((count for count in counts if count is not None), 0)

    @property
    def success(self) -> float:
        """Share of the episodes that passed every stage that was run."""
        return self.successes / self.episodes


class DiameterRecord(_Record):
    """All pipes of one diameter.

    Attributes:
        diameter_mm: inner diameter [mm].
        pipes: number of pipes.
        episodes: episodes in all of them.
        located_share: share of the episodes in which a target was found.
        reach_success: share of the front attempts that succeeded, mean over the pipes (as the thesis takes it over
            the angles).
        reach_success_low, reach_success_high: its 95 % interval, over all attempts together.
        rear_success: share of the rear attempts that succeeded, mean over the pipes that had any.
        traverse_success: share of the traverses that succeeded, mean over the pipes.
        traverse_success_low, traverse_success_high: its 95 % interval, over all of them together.
        thesis_percent: the thesis's best front success [percent]; None unless the pipes are those of the thesis.
    """

    diameter_mm: Typed
    pipes: Positive
    episodes: Positive
    located_share: Share | None = None
    reach_success: Share | None = None
    reach_success_low: Share | None = None
    reach_success_high: Share | None = None
    rear_success: Share | None = None
    traverse_success: Share | None = None
    traverse_success_low: Share | None = None
    traverse_success_high: Share | None = None
    thesis_percent: float | None = None

    @classmethod
    def of(cls, records: Sequence[PipeRecord], thesis_percent: float | None = None) -> Self:
        """The sum of pipes of one diameter.

        Args:
            records: at least one, all of the same diameter.
            thesis_percent: the thesis's figure for this diameter, kept only if the angles are the thesis's.
        """
        fronts = [(r.reach_successes, r.reach_attempts) for r in records]
        traverses = [(r.traverse_successes, r.traverse_attempts) for r in records]
        front, traverse = _pooled_interval(fronts), _pooled_interval(traverses)
        located = [r.located for r in records if r.located is not None]
        episodes = sum(r.episodes for r in records)
        return cls(
            diameter_mm=records[0].diameter_mm,
            pipes=len(records),
            episodes=episodes,
            located_share=sum(located) / episodes if located else None,
            reach_success=_mean_rate(fronts),
            reach_success_low=front and front.low,
            reach_success_high=front and front.high,
            rear_success=_mean_rate((r.rear_successes, r.rear_attempts) for r in records),
            traverse_success=_mean_rate(traverses),
            traverse_success_low=traverse and traverse.low,
            traverse_success_high=traverse and traverse.high,
            thesis_percent=thesis_percent if is_thesis_set(r.angle_deg for r in records) else None,
        )


class Evaluation(_Record):
    """One evaluation; `Evaluation.of` counts it from the pipes' records.

    Attributes:
        schema_version: version of the format; the key is `schema`.
        config: everything that decided what was computed, its stage named.
        robot: name of the robot.
        success: share of all episodes that passed every stage that was run.
        success_low, success_high: ends of its 95 % interval.
        penetration_p99_m: 99th percentile over the episodes of the deepest overlap [m].
        pipes: one record for each pipe, in the order they were given.
        diameters: one record for each diameter, widest first.
    """

    schema_version: Literal[1, 2] = Field(2, alias="schema")
    config: EvaluationConfig
    robot: str
    success: Share
    success_low: Share
    success_high: Share
    penetration_p99_m: float | None = None
    pipes: tuple[PipeRecord, ...] = Field(min_length=1)
    diameters: tuple[DiameterRecord, ...] = Field(min_length=1)

    @model_validator(mode="before")
    @classmethod
    def _config_of_schema_1(cls, given: Any) -> Any:
        """The configuration from the single keys that schema 1 had; which pipes were asked for it does not say."""
        if not isinstance(given, dict) or "config" in given or "stage" not in given:
            return given
        policy, pipes = str(given.get("policy")), given.get("pipes")
        names = [_typed_pipe(record) for record in pipes] if isinstance(pipes, list | tuple) else []
        config = {
            "policy": None if policy.startswith("locate:") else policy,
            "variant": policy.removeprefix("locate:") if policy.startswith("locate:") else "map",
            "pipes": names,
            "episodes": given.get("episodes_per_pipe"),
            **{key: given[key] for key in ("seed", "stage", "backend", "options", "disturb") if key in given},
        }
        return {**given, "config": config}

    @classmethod
    def of(
        cls,
        pipes: Sequence[PipeRecord],
        *,
        config: EvaluationConfig,
        robot: str,
        penetration_p99_m: float | None = None,
        thesis: Mapping[float, float] | None = None,
    ) -> Self:
        """An evaluation of at least one pipe; `thesis` holds figures [percent] to compare with, by diameter [mm]."""
        successes, episodes = sum(r.successes for r in pipes), sum(r.episodes for r in pipes)
        diameters = [DiameterRecord.of(group, (thesis or {}).get(d)) for d, group in by_diameter(pipes).items()]
        low, high = wilson(successes, episodes)
        return cls(
            config=config,
            robot=robot,
            success=successes / episodes,
            success_low=low,
            success_high=high,
            penetration_p99_m=penetration_p99_m,
            pipes=tuple(pipes),
            diameters=tuple(diameters),
        )

    @computed_field  # type: ignore[prop-decorator]  # mypy knows no decorated properties
    @property
    def policy(self) -> str:
        """What was evaluated, as in schema 1: a policy's name, or the behaviour that locates a target."""
        return self.config.subject

    @computed_field  # type: ignore[prop-decorator]
    @property
    def backend(self) -> str:
        """Name of the backend, as in schema 1."""
        return self.config.backend

    @computed_field  # type: ignore[prop-decorator]
    @property
    def stage(self) -> str:
        """What was run, as in schema 1."""
        return str(self.config.stage)

    @computed_field  # type: ignore[prop-decorator]
    @property
    def seed(self) -> int:
        """Seed of starts and targets, as in schema 1."""
        return self.config.seed

    @computed_field  # type: ignore[prop-decorator]
    @property
    def episodes_per_pipe(self) -> int:
        """Episodes in every pipe, as in schema 1."""
        return self.config.episodes

    @computed_field  # type: ignore[prop-decorator]
    @property
    def options(self) -> dict[str, JsonValue]:
        """The simulator's settings, as in schema 1."""
        return self.config.options

    @computed_field  # type: ignore[prop-decorator]
    @property
    def disturb(self) -> str | None:
        """Name or file of what went wrong on purpose, as in schema 1."""
        return self.config.disturb

    @property
    def episodes(self) -> int:
        return sum(record.episodes for record in self.pipes)

    def to_json(self) -> str:
        return self.model_dump_json(by_alias=True, indent=2) + "\n"


def _typed_pipe(record: Any) -> str:
    """A record of schema 1 as a person names its pipe; a route by its name."""
    if not isinstance(record, dict) or record.get("run"):
        return str(record.get("run")) if isinstance(record, dict) else "?"
    return f"d={record.get('diameter_mm')},angle={record.get('angle_deg')},turn={record.get('turn')}"


def by_diameter(pipes: Sequence[PipeRecord]) -> dict[float, list[PipeRecord]]:
    """The records of each diameter [mm], widest first."""
    diameters = sorted({record.diameter_mm for record in pipes}, reverse=True)
    return {d: [record for record in pipes if record.diameter_mm == d] for d in diameters}


def read_evaluation(path: Path) -> Evaluation:
    """The evaluation in a folder, or in a file of the format of eval.json.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it is not an evaluation, or one of another version.
    """
    file = path / "eval.json" if path.is_dir() else path
    try:
        return Evaluation.model_validate_json(file.read_bytes())
    except OSError as error:
        raise FileProblem(file, "read", error) from error
    except ValidationError as error:
        raise ConfigError.from_validation(str(file), error, Evaluation.model_fields) from error


def _pooled_interval(counts: Sequence[tuple[int | None, int | None]]) -> Interval | None:
    """95 % interval of successes and attempts of all pipes together; None where there were none."""
    known = [(successes, attempts) for successes, attempts in counts if successes is not None and attempts is not None]
    return wilson(sum(s for s, _ in known), sum(a for _, a in known)) if known else None


def _mean_rate(counts: Iterable[tuple[int | None, int | None]]) -> float | None:
    """Mean of successes / attempts over the pipes that had attempts."""
    rates = [successes / attempts for successes, attempts in counts if successes is not None and attempts]
    return sum(rates) / len(rates) if rates else None
