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


def pooled(pipes: Sequence[PipeRecord]) -> dict[float, Cell]:
    """Episodes of single corners by angle [deg], ascending, turns together."""
    cells: dict[float, Cell] = {}
    for record in pipes:
        if record.angle_deg is not None:
            before = cells.get(record.angle_deg, Cell(0, 0))
            cells[record.angle_deg] = Cell(before.successes + record.successes, before.episodes + record.episodes)
    return dict(sorted(cells.items()))


def numbered_routes(evaluation: Evaluation) -> dict[float, list[NumberedRoute]]:
    """Routes of each diameter [mm], widest first, in the order given."""
    records = (record for record in evaluation.pipes if record.route is not None)
    routes = [NumberedRoute(number, record) for number, record in enumerate(records, 1)]
    diameters = sorted({route.record.diameter_mm for route in routes}, reverse=True)
    return {d: [route for route in routes if route.record.diameter_mm == d] for d in diameters}
