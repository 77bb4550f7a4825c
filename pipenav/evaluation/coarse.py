"""Evaluations of very many pipes for pictures and tables: diameters and angles rounded, so that few are left."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import NamedTuple

from pipenav.evaluation.cells import fitting_of
from pipenav.evaluation.pipe_results import DiameterRecord, PipeRecord, by_diameter
from pipenav.evaluation.results import Evaluation

MOST_FITTINGS = 60
"""Most columns of a map: of more, a thousand, the picture took 12.7 GB of memory."""

MOST_DIAMETERS = 24
"""Most rows of a map or a table, and most panels of a picture."""

STEPS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
"""Steps to which diameters [mm] and angles [deg] are rounded, the first that leaves few enough."""


class Coarse(NamedTuple):
    """An evaluation whose single corners have rounded shapes, with a note that says so; empty where none had to be."""

    evaluation: Evaluation
    note: str


class CoarsePipes(NamedTuple):
    """Records whose single corners have rounded shapes, with a note that says so; empty where none had to be."""

    pipes: Sequence[PipeRecord]
    note: str


def coarse(evaluation: Evaluation) -> Coarse:
    """An evaluation with few enough diameters and shapes of corners to be shown; as it is where it has few."""
    pipes, note = coarse_pipes(evaluation.pipes)
    if not note:
        return Coarse(evaluation, "")
    diameters = [DiameterRecord.of(group) for group in by_diameter(pipes).values()]
    return Coarse(evaluation.model_copy(update={"pipes": tuple(pipes), "diameters": tuple(diameters)}), note)


def coarse_pipes(pipes: Sequence[PipeRecord]) -> CoarsePipes:
    """Records of few enough diameters and shapes of corners to be shown, in order; as they are where they have few."""
    corners = [record for record in pipes if record.route is None]
    diameter = _step(lambda step: {_rounded(record.diameter_mm, step) for record in corners}, MOST_DIAMETERS)
    angle = _step(lambda step: {fitting_of(_with_angle(record, step)) for record in _distinct(corners)}, MOST_FITTINGS)
    if not diameter and not angle:
        return CoarsePipes(pipes, "")
    steps = [f"diameters to {diameter:g} mm"] * bool(diameter) + [f"angles to {angle:g} deg"] * bool(angle)
    rounded = [record if record.route else _rounded_record(record, diameter, angle) for record in pipes]
    return CoarsePipes(rounded, f"rounded: {' and '.join(steps)}")


def _step(distinct: Callable[[float], Collection[object]], most: int) -> float:
    """The smallest step of rounding that leaves at most so many values; 0 where there are few without."""
    return next((step for step in (0.0, *STEPS) if len(distinct(step)) <= most), STEPS[-1])


def _distinct(corners: Iterable[PipeRecord]) -> Iterable[PipeRecord]:
    """A record for each shape."""
    return {(r.fitting, r.angle_deg, round(r.bend_radius_mm / r.diameter_mm, 1)): r for r in corners}.values()


def _rounded(value: float, step: float) -> float:
    return round(value / step) * step if step else value


def _with_angle(record: PipeRecord, step: float) -> PipeRecord:
    """A record with its angle, or its branch's, rounded; its bend's radius to a tenth of the diameter."""
    if not step or record.angle_deg is None:
        return record
    update: dict[str, object] = {"angle_deg": _rounded(record.angle_deg, step)}
    if record.fitting is not None:
        name, angle, way = record.fitting.split()
        update["fitting"] = f"{name} {_rounded(float(angle), step):g} {way}"
    update["bend_radius_mm"] = round(record.bend_radius_mm / record.diameter_mm, 1) * record.diameter_mm
    return record.model_copy(update=update)


def _rounded_record(record: PipeRecord, diameter: float, angle: float) -> PipeRecord:
    """A record of a single corner with a rounded shape; its bend keeps its radius in diameters."""
    record = _with_angle(record, angle)
    rounded = max(_rounded(record.diameter_mm, diameter), diameter)
    bend = record.bend_radius_mm / record.diameter_mm * rounded
    return record.model_copy(update={"diameter_mm": rounded, "bend_radius_mm": bend})
