"""The records of pipes, counted from the results of their episodes as parts of an evaluation come in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from pipenav.evaluation.parts import PartRows, StageRows
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.tee import fitting_of
from pipenav.tasks.outcome import Outcome, PassageStage
from pipenav.units import m_to_mm, rad_to_deg

MAIN_STAGES = (PassageStage.REACH, PassageStage.TRAVERSE, PassageStage.LOCATE)
"""Stages whose steps count for an evaluation, the most important one first."""


def pipe_records(parts: Iterable[tuple[int, PartRows]], pipes: Sequence[Pipe], episodes: int) -> Iterator[PipeRecord]:
    """The record of every pipe, in order.

    Args:
        parts: all parts in order: number of the episode after the last one, and results by stage. Only those of a pipe
            whose episodes are not all there yet are kept.
        pipes: all pipes.
        episodes: number of episodes in each.
    """
    waiting: dict[PassageStage, list[StageRows]] = {}
    number = 0
    for end, rows in parts:
        for stage, part in rows.items():
            waiting.setdefault(stage, []).append(part)
        ready = end // episodes
        if ready == number:
            continue
        joined = {stage: StageRows.joined(several) for stage, several in waiting.items()}
        for index in range(number, ready):
            first = index * episodes
            here = {stage: part.between(first, first + episodes) for stage, part in joined.items()}
            yield _pipe_record(pipes[index], here, episodes)
        number = ready
        waiting = {stage: [part.between(number * episodes, end)] for stage, part in joined.items()}


def _pipe_record(pipe: Pipe, here: PartRows, episodes: int) -> PipeRecord:
    """The record of a pipe from all its episodes."""
    parts = list(here.values())
    main = next(here[stage] for stage in MAIN_STAGES if stage in here)
    reached = main.passed
    steps = np.concatenate([part.steps for part in parts])
    shares = np.concatenate([part.contact_share for part in parts])
    return PipeRecord(
        **pipe_keys(pipe),
        episodes=episodes,
        failures=_failures(here),
        mean_steps=float(main.steps[reached].mean()) if reached.any() else None,
        min_range_m=min(float(part.min_range.min(initial=np.inf)) for part in parts),
        max_penetration_m=max(float(part.penetration.max(initial=0.0)) for part in parts),
        peak_force_n=max(float(part.force.max(initial=0.0)) for part in parts),
        contact_time_share=float((steps * shares).sum() / steps.sum()),
        **_counts(here),
    )


def pipe_keys(pipe: Pipe) -> dict[str, Any]:
    """The keys of a `PipeRecord` that say which pipe it is."""
    corner = pipe.corner
    return {
        "diameter_mm": round(m_to_mm(pipe.diameter), 6),
        "angle_deg": None if corner is None else round(rad_to_deg(corner.angle), 6),
        "turn": None if corner is None else corner.turn,
        "bend_radius_mm": 0.0 if corner is None else round(m_to_mm(corner.bend_radius), 6),
        "fitting": None if corner is None else fitting_of(corner),
        "route": pipe.name if corner is None else None,
    }


def _counts(here: PartRows) -> dict[str, int]:
    """Attempts and successes of the stages, by the keys of a `PipeRecord`."""
    counts: dict[str, int] = {}
    for stage, rows in here.items():
        if stage is PassageStage.LOCATE:
            counts["located"] = int(rows.passed.sum())
        else:
            counts |= {f"{stage}_attempts": len(rows.jobs), f"{stage}_successes": int(rows.passed.sum())}
    return counts


def _failures(here: PartRows) -> dict[str, int]:
    """Number of episodes by the reason of their failure; before it the stage, where that is not the main task."""
    failures: dict[str, int] = {}
    for stage, rows in here.items():
        before = "" if stage in (PassageStage.REACH, PassageStage.TRAVERSE) else f"{stage} "
        for outcome in rows.outcome[~rows.passed]:
            reason = before + Outcome(outcome).label
            failures[reason] = failures.get(reason, 0) + 1
    return failures
