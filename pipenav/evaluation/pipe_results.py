"""The numbers of one pipe, and of all pipes of one diameter. docs/formats/evaluation-folder.md describes them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, computed_field, model_validator

from pipenav.evaluation.config import not_given
from pipenav.evaluation.interval import Interval, wilson
from pipenav.evaluation.passability_record import PipePassability
from pipenav.evaluation.record import Amount, Count, Positive, Record, Share, Typed
from pipenav.evaluation.thesis import is_thesis_set

FITTING = r"^(tee|cross) \d+(\.\d+)?(e-?\d+)? (straight|into|out)$"
"""Text of a record's fitting, such as `tee 90 into`."""


class PipeRecord(Record):
    """All episodes in one pipe. Counts of a stage that was not run, and values that were not measured, are None.

    Attributes:
        diameter_mm: inner diameter [mm].
        angle_deg: interior corner angle [deg]; None for a route.
        turn: side that the corner turns to, seen by the robot; None for a route.
        bend_radius_mm: radius of the corner's bend [mm]; 0 for a mitre and for a route.
        fitting: what a corner with branches is, the angle of its branch [deg], and the way through it, see
            `pipenav.pipes.tee.fitting_of`; None for a corner without branches and for a route.
        route: name of a route, as `PipeRoute.name`; None for a single corner.
        episodes: episodes that were run.
        located: episodes in which the robot found a target itself.
        reach_attempts: episodes in which the stage reach began.
        reach_successes: episodes in which the front half reached its target.
        rear_attempts, rear_successes: rear passages begun, and those that left the corner.
        traverse_attempts, traverse_successes: traverses begun, and those in which the whole robot came through.
        failures: number of episodes that ended by each reason other than success.
        mean_steps: mean control steps of a successful stage reach or traverse, or of finding a target where neither was
            run; None without one.
        min_range_m: smallest laser reading of all episodes [m].
        max_penetration_m: deepest overlap of robot and wall of all episodes [m].
        peak_force_n: largest contact force of all episodes [N].
        contact_time_share: share of the time in contact with the wall, mean over episodes.
        passability: verdict of geometry on the pipe and its episodes; None where nobody asked for it, as the next.
        trained: whether the policy was trained in pipes around this one; None also where that is not known.
    """

    diameter_mm: Typed
    angle_deg: Typed | None
    turn: Literal["left", "right"] | None
    bend_radius_mm: Amount = 0.0
    fitting: Annotated[str | None, Field(pattern=FITTING)] = None
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
    passability: PipePassability | None = Field(None, exclude_if=not_given)
    trained: bool | None = Field(None, exclude_if=not_given)

    @model_validator(mode="after")
    def _counts_fit(self) -> Self:
        """Check that no stage has more attempts than the stage before it had successes."""
        given = [value is not None for value in (self.angle_deg, self.turn)]
        if given != [self.route is None] * 2:
            raise ValueError("a corner has angle_deg and turn, and a route has neither but its name in route")
        if self.fitting is not None and self.route is not None:
            raise ValueError("a route has no fitting: its name in route has them all")
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
        """Lower end of the 95 % interval of the success of the stage reach."""
        return self.reach_interval and self.reach_interval.low

    @computed_field  # type: ignore[prop-decorator]
    @property
    def reach_success_high(self) -> float | None:
        """Upper end of the 95 % interval of the success of the stage reach."""
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


class DiameterRecord(Record):
    """All pipes of one diameter.

    Attributes:
        diameter_mm: inner diameter [mm].
        pipes: number of pipes.
        episodes: episodes in all of them.
        located_share: share of the episodes in which a target was found.
        reach_success: share of the attempts at the stage reach that succeeded, mean over the pipes (as the thesis takes
            it over the angles).
        reach_success_low, reach_success_high: 95 % interval of that share, over all attempts together.
        rear_success: share of the rear attempts that succeeded, mean over the pipes that had any.
        traverse_success: share of the traverses that succeeded, mean over the pipes.
        traverse_success_low, traverse_success_high: 95 % interval of that share, over all of them together.
        thesis_percent: the thesis's best success of the stage reach [percent]; None unless the pipes are those of the
            thesis.
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
            records: records of at least one pipe, all of the same diameter.
            thesis_percent: the thesis's figure for this diameter, kept only if the angles are the thesis's.
        """
        reaches = [(r.reach_successes, r.reach_attempts) for r in records]
        traverses = [(r.traverse_successes, r.traverse_attempts) for r in records]
        reach, traverse = _pooled_interval(reaches), _pooled_interval(traverses)
        located = [r.located for r in records if r.located is not None]
        episodes = sum(r.episodes for r in records)
        return cls(
            diameter_mm=records[0].diameter_mm,
            pipes=len(records),
            episodes=episodes,
            located_share=sum(located) / episodes if located else None,
            reach_success=_mean_rate(reaches),
            reach_success_low=reach and reach.low,
            reach_success_high=reach and reach.high,
            rear_success=_mean_rate((r.rear_successes, r.rear_attempts) for r in records),
            traverse_success=_mean_rate(traverses),
            traverse_success_low=traverse and traverse.low,
            traverse_success_high=traverse and traverse.high,
            thesis_percent=thesis_percent if is_thesis_set(_plain_angle(r) for r in records) else None,
        )


def by_diameter(pipes: Sequence[PipeRecord]) -> dict[float, list[PipeRecord]]:
    """The records of each diameter [mm], widest first."""
    groups: dict[float, list[PipeRecord]] = {}
    for record in pipes:
        groups.setdefault(record.diameter_mm, []).append(record)
    return {d: groups[d] for d in sorted(groups, reverse=True)}


def _plain_angle(record: PipeRecord) -> float | None:
    """The angle of a corner without branches, which alone the thesis has [deg]."""
    return record.angle_deg if record.fitting is None else None


def _pooled_interval(counts: Sequence[tuple[int | None, int | None]]) -> Interval | None:
    """95 % interval of successes and attempts of all pipes together; None where there were none."""
    known = [(successes, attempts) for successes, attempts in counts if successes is not None and attempts is not None]
    return wilson(sum(s for s, _ in known), sum(a for _, a in known)) if known else None


def _mean_rate(counts: Iterable[tuple[int | None, int | None]]) -> float | None:
    """Mean of successes / attempts over the pipes that had attempts."""
    rates = [successes / attempts for successes, attempts in counts if successes is not None and attempts]
    return sum(rates) / len(rates) if rates else None
