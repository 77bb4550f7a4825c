"""Episodes of an evaluation counted for its pictures: by angle in single corners, one by one in routes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.results import Evaluation


class Cell(NamedTuple):
    """Episodes of one diameter and angle, or of one route: how many there were, how many succeeded."""

    successes: int
    episodes: int

    @property
    def share(self) -> float:
        return self.successes / self.episodes


class NumberedRoute(NamedTuple):
    """A route's record and its number among all routes of the evaluation, from 1."""

    number: int
    record: PipeRecord

    @property
    def cell(self) -> Cell:
        return Cell(self.record.successes, self.record.episodes)


def total(cells: Iterable[Cell]) -> Cell:
    """All episodes of some cells together."""
    successes, episodes = zip(*cells, strict=True)
    return Cell(sum(successes), sum(episodes))


class Fitting(NamedTuple):
    """Shape of a single corner, in the order in which pictures show them.

    Attributes:
        kind: empty for a corner without branches, else `tee` or `cross` and the way through it.
        angle_deg: interior angle; of a tee or a cross that of its branch [deg].
        bend_d: bend radius in diameters; 0 for a mitre.
    """

    kind: str
    angle_deg: float
    bend_d: float

    @property
    def label(self) -> str:
        """Angle, and in lines of their own a bend's radius, or the kind."""
        lines = [f"{self.bend_d:g} D"] if self.bend_d else self.kind.split()
        return "\n".join([f"{self.angle_deg:g}", *lines])


KINDS = ("", *(f"{name} {way}" for name in ("tee", "cross") for way in ("straight", "into", "out")))
"""Kinds of fittings in the order in which pictures show them."""


def fitting_of(record: PipeRecord) -> Fitting | None:
    """Shape of a record's corner; None for a route."""
    if record.angle_deg is None:
        return None
    if record.fitting is None:
        return Fitting("", record.angle_deg, round(record.bend_radius_mm / record.diameter_mm, 3))
    name, angle, way = record.fitting.split()
    return Fitting(f"{name} {way}", float(angle), 0.0)


def in_order(fittings: Iterable[Fitting]) -> list[Fitting]:
    """Fittings each once: corners, then tees and crosses way by way, by angle and bend radius."""
    return sorted(set(fittings), key=lambda one: (KINDS.index(one.kind), one[1:]))


def records_by_fitting(pipes: Sequence[PipeRecord]) -> dict[Fitting, list[PipeRecord]]:
    """Records of single corners by shape, in order, turns together."""
    groups: dict[Fitting, list[PipeRecord]] = {}
    for record in pipes:
        if fitting := fitting_of(record):
            groups.setdefault(fitting, []).append(record)
    return {fitting: groups[fitting] for fitting in in_order(groups)}


def cell_of(records: Sequence[PipeRecord]) -> Cell:
    """Episodes of some pipes together."""
    return total(Cell(record.successes, record.episodes) for record in records)


def by_fitting(pipes: Sequence[PipeRecord]) -> dict[Fitting, Cell]:
    """Episodes of single corners by shape, in order, turns together."""
    return {fitting: cell_of(records) for fitting, records in records_by_fitting(pipes).items()}


def by_angle(pipes: Sequence[PipeRecord]) -> dict[str, dict[float, Cell]]:
    """Episodes of single corners by kind and angle [deg], both in order, turns and bend radii together."""
    cells: dict[str, dict[float, list[Cell]]] = {}
    for fitting, cell in by_fitting(pipes).items():
        cells.setdefault(fitting.kind, {}).setdefault(fitting.angle_deg, []).append(cell)
    return {kind: {angle: total(parts) for angle, parts in line.items()} for kind, line in cells.items()}


def numbered_routes(evaluation: Evaluation) -> dict[float, list[NumberedRoute]]:
    """Routes of each diameter [mm], widest first, in the order given."""
    records = (record for record in evaluation.pipes if record.route is not None)
    groups: dict[float, list[NumberedRoute]] = {}
    for number, record in enumerate(records, 1):
        groups.setdefault(record.diameter_mm, []).append(NumberedRoute(number, record))
    return {d: groups[d] for d in sorted(groups, reverse=True)}
