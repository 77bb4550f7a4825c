"""Sets of routes as TOML: a rule by which they are drawn, always the same. Format: docs/formats/route-folder.md."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Annotated, Literal, NamedTuple, Self, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from pipenav.errors import PipenavError
from pipenav.pipes.pipe import DEFAULT_WALL
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import MAX_CORNERS, CrossesItself
from pipenav.pipes.route_corner import Corner, corner_of, reducer_corner
from pipenav.pipes.route_ends import RouteEnds
from pipenav.pipes.set_file import MAX_TURNS, Values, values_of
from pipenav.pipes.tee import TeePassage, TeeSize, Way, tee_corner
from pipenav.units import deg_to_rad, mm_to_m

T = TypeVar("T")

MAX_ROUTES = 1000
"""Most routes of a set."""

MAX_DRAWS = 1000
"""Draws of a route that crosses itself, until its set is refused."""

MAX_WORK = 100_000
"""Draws of a whole set times the square of its corners, as the time of a draw grows: some seconds."""

Count = Annotated[int, Field(ge=0, le=MAX_ROUTES)]
"""Number of fittings of a kind among those of a mix."""


class Mix(BaseModel):
    """Numbers of fittings among which each one of a route is drawn: the proportions of a real network."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    corners: Count = 1
    tees: Count = 0
    reducers: Count = 0

    @model_validator(mode="after")
    def _something(self) -> Self:
        if not self.kinds:
            raise PydanticCustomError("empty_mix", "a mix needs at least one corner, tee or reducer")
        return self

    @property
    def kinds(self) -> list[str]:
        """The kind of each fitting of the mix."""
        return ["corner"] * self.corners + ["tee"] * self.tees + ["reducer"] * self.reducers


class RouteSetFile(BaseModel):
    """A set of routes as TOML: a rule by which they are drawn, always the same ones."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    schema_: Literal[1, 2, 3] = Field(alias="schema")
    description: str
    routes: int = Field(alias="runs", ge=1, le=MAX_ROUTES)
    seed: int
    corners: int = Field(ge=1, le=MAX_CORNERS)
    diameters_mm: Values
    angles_deg: Values
    turns: list[str] = Field(["left", "right"], min_length=1, max_length=MAX_TURNS)
    rolls_deg: Values = [0.0]
    bend_radii_d: Values = [0.0]
    straights_mm: Values
    ends_mm: float
    slopes_deg: Values = [0.0]
    mix: Mix = Mix()
    tee_angles_deg: Values = [90.0]
    ways: list[str] = Field(list(get_args(Way)), min_length=1, max_length=MAX_TURNS)
    lengths_d: Values = [1.0]

    def draw(self) -> list[PipeRoute]:
        """The routes of the set: diameters follow each other in order, all else is drawn.

        A route that would cross itself is drawn anew.

        Raises:
            PipenavError: a number out of range, or routes that cross themselves again and again.
        """
        stream = _Stream(random.Random(self.seed).random)  # the one stream that Python promises never to change
        diameters = values_of(self.diameters_mm)
        draws = iter(range(MAX_WORK // self.corners**2))
        return [self._draw_one(diameters[i % len(diameters)], stream, draws) for i in range(self.routes)]

    def _draw_one(self, diameter_mm: float, stream: _Stream, draws: Iterator[int]) -> PipeRoute:
        for _ in range(MAX_DRAWS):
            if next(draws, None) is None:
                raise PipenavError(
                    f"a set of {self.routes} routes of {self.corners} corners takes too many draws: choose fewer "
                    "routes or corners, or wider angles, with which fewer routes cross themselves."
                )
            with suppress(CrossesItself):
                return self._drawn(diameter_mm, stream)
        raise PipenavError(
            f"{MAX_DRAWS} routes of {self.corners} corners drawn one after the other cross themselves: "
            "choose wider angles, other straights or fewer corners."
        )

    def _drawn(self, diameter_mm: float, stream: _Stream) -> PipeRoute:
        """The next route, which may cross itself.

        What a set leaves no choice of is not drawn, so that older sets have the routes that they always had.
        """
        angles, rolls, straights = (values_of(given) for given in (self.angles_deg, self.rolls_deg, self.straights_mm))
        turns = [(stream.of(angles), stream.of(self.turns), stream.of(rolls)) for _ in range(self.corners)]
        turns[0] = (*turns[0][:2], 0.0)  # the first corner's plane is the x-y plane
        lengths = [self.ends_mm, *(stream.of(straights) for _ in turns[1:]), self.ends_mm]
        radii_d = [stream.choice(values_of(self.bend_radii_d)) for _ in turns]
        corners: list[Corner] = []
        now_mm = diameter_mm
        for (angle, turn, roll), times in zip(turns, radii_d, strict=True):
            kind = stream.choice(self.mix.kinds)
            if kind == "tee":
                passage = TeePassage(stream.choice(self.ways), turn)
                tee_angle, bore = deg_to_rad(stream.choice(values_of(self.tee_angles_deg))), mm_to_m(now_mm)
                corners.append(tee_corner(TeeSize(bore, bore, tee_angle, DEFAULT_WALL), passage, deg_to_rad(roll)))
            elif kind == "reducer":
                now_mm, before_mm = stream.choice(self._next_bores(now_mm)), now_mm
                times = stream.choice(values_of(self.lengths_d))
                corners.append(reducer_corner(now_mm, times * max(now_mm, before_mm)))
            else:
                corners.append(corner_of(angle, turn, roll, now_mm * times))
        ends = RouteEnds(slope=deg_to_rad(stream.choice(values_of(self.slopes_deg))))
        return PipeRoute.with_default_straights(mm_to_m(diameter_mm), tuple(corners), lengths, DEFAULT_WALL, ends)

    def _next_bores(self, now_mm: float) -> list[float]:
        """The next smaller and the next larger of the set's diameters, as far as there are such."""
        bores = sorted(values_of(self.diameters_mm))
        smaller, larger = [bore for bore in bores if bore < now_mm], [bore for bore in bores if bore > now_mm]
        if not smaller + larger:
            raise PipenavError("a set with reducers needs two diameters_mm or more: give another one.")
        return smaller[-1:] + larger[:1]


class _Stream(NamedTuple):
    """Draws from a stream of numbers in [0, 1)."""

    draw: Callable[[], float]

    def of(self, values: Sequence[T]) -> T:
        """A value of some, drawn even where there is only one."""
        return values[int(self.draw() * len(values))]

    def choice(self, values: Sequence[T]) -> T:
        """A value of some; where all are equal, nothing is drawn."""
        return values[0] if len(set(values)) == 1 else self.of(values)
