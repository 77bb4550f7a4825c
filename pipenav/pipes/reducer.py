"""A reducer between two straights, and sets of them."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from pipenav.pipes.pipe import DEFAULT_WALL
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import reducer_corner
from pipenav.pipes.set_file import Values, values_of
from pipenav.units import mm_to_m

MAX_PAIRS = 1000
"""Most pairs of diameters in a set."""

Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
"""Diameter before and behind a reducer [mm]."""


class ReducerSetFile(BaseModel):
    """A set of reducers as TOML: one of every length for every pair of diameters."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    description: str
    reducers_mm: list[Pair] = Field(min_length=1, max_length=MAX_PAIRS)
    lengths_d: Values = [1.0]
    ends_mm: float | None = None

    def draw(self) -> list[PipeRoute]:
        """The reducers, pair by pair, with lengths in the larger diameter."""
        return [
            reducer(before, behind, times * max(before, behind), self.ends_mm)
            for before, behind in self.reducers_mm
            for times in values_of(self.lengths_d)
        ]


def reducer(
    diameter_mm: float,
    to_diameter_mm: float,
    length_mm: float | None = None,
    leg_mm: float | None = None,
    wall_mm: float | None = None,
) -> PipeRoute:
    """A straight pipe, a reducer, and a straight pipe of another diameter.

    Args:
        diameter_mm: inner diameter before it.
        to_diameter_mm: inner diameter behind it.
        length_mm: its length along the centre line, 0 for a step; by default the larger diameter.
        leg_mm: length of either straight to the reducer's middle; by default what a robot needs.
        wall_mm: wall thickness.

    Raises:
        OutOfRange: a number outside its allowed range.
    """
    length = max(diameter_mm, to_diameter_mm) if length_mm is None else length_mm
    wall = DEFAULT_WALL if wall_mm is None else mm_to_m(wall_mm)
    corners = (reducer_corner(to_diameter_mm, length),)
    return PipeRoute.with_default_straights(mm_to_m(diameter_mm), corners, [leg_mm, leg_mm], wall)
