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
    """Shape of a single corner: its interior angle [deg], and its bend radius in diameters, 0 for a mitre."""

    angle_deg: float
    bend_d: float

    @property
    def label(self) -> str:
        return f"{self.angle_deg:g}" + (f"\n{self.bend_d:g} D" if self.bend_d else "")


def by_fitting(pipes: Sequence[PipeRecord]) -> dict[Fitting, Cell]:
    """Episodes of single corners by angle and bend radius, ascending, turns together."""
    cells: dict[Fitting, Cell] = {}
    for record in pipes:
        if record.angle_deg is not None:
            fitting = Fitting(record.angle_deg, round(record.bend_radius_mm / record.diameter_mm, 3))
            before = cells.get(fitting, Cell(0, 0))
            cells[fitting] = Cell(before.successes + record.successes, before.episodes + record.episodes)
    return dict(sorted(cells.items()))


def by_angle(pipes: Sequence[PipeRecord]) -> dict[float, Cell]:
    """Episodes of single corners by angle [deg], ascending, turns and bend radii together."""
    cells: dict[float, list[Cell]] = {}
    for fitting, cell in by_fitting(pipes).items():
        cells.setdefault(fitting.angle_deg, []).append(cell)
    return {angle: total(parts) for angle, parts in cells.items()}


def numbered_routes(evaluation: Evaluation) -> dict[float, list[NumberedRoute]]:
    """Routes of each diameter [mm], widest first, in the order given."""
    records = (record for record in evaluation.pipes if record.route is not None)
    routes = [NumberedRoute(number, record) for number, record in enumerate(records, 1)]
    diameters = sorted({route.record.diameter_mm for route in routes}, reverse=True)
    return {d: [route for route in routes if route.record.diameter_mm == d] for d in diameters}
