"""Pipe runs from TOML: one run, corner by corner, or a set of runs drawn by a rule. Formats: docs/pipe-run.md."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field

from pipenav.errors import ConfigError, PipenavError, UnknownName
from pipenav.pipes.corner_sets import Values, parse_pipes, pipe_set_names, read_as, values_of
from pipenav.pipes.pipe import DEFAULT_WALL, Pipe
from pipenav.pipes.route import MAX_CORNERS, CrossesItself, PipeRoute
from pipenav.storage import shipped
from pipenav.storage.atomic_files import read_toml
from pipenav.units import m_to_mm

T = TypeVar("T")

MAX_ROUTES = 1000
MAX_DRAWS = 1000
"""How often a run is drawn anew because it crosses itself, until the set is refused."""


class CornerEntry(BaseModel):
    """One corner of a run as TOML, with the straight that follows it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    angle_deg: float
    turn: str
    roll_deg: float = 0.0
    straight_mm: float | None = None


class RouteFile(BaseModel):
    """A run as TOML."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    schema_: Literal[1] = Field(alias="schema")
    description: str = ""
    diameter_mm: float
    wall_mm: float = m_to_mm(DEFAULT_WALL)
    first_straight_mm: float | None = None
    corners: list[CornerEntry] = Field(min_length=1, max_length=MAX_CORNERS)

    def route(self) -> PipeRoute:
        """Raises PipenavError where `PipeRoute.of` does."""
        corners = [(corner.angle_deg, corner.turn, corner.roll_deg) for corner in self.corners]
        straights = [self.first_straight_mm, *(corner.straight_mm for corner in self.corners)]
        return PipeRoute.of(self.diameter_mm, corners, straights, self.wall_mm)


class RouteSetFile(BaseModel):
    """A set of runs as TOML: a rule by which they are drawn, always the same ones."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    schema_: Literal[1] = Field(alias="schema")
    description: str
    routes: int = Field(alias="runs", ge=1, le=MAX_ROUTES)
    seed: int
    corners: int = Field(ge=1, le=MAX_CORNERS)
    diameters_mm: Values
    angles_deg: Values
    turns: list[str] = Field(["left", "right"], min_length=1)
    rolls_deg: Values = [0.0]
    straights_mm: Values
    ends_mm: float

    def draw(self) -> list[PipeRoute]:
        """The diameters take turns; all else of a run is drawn, and drawn anew where the run would cross itself.

        Raises:
            PipenavError: a number out of range, or runs that cross themselves again and again.
        """
        draw = random.Random(self.seed).random  # the one stream that Python promises never to change
        diameters = values_of(self.diameters_mm)
        return [self._draw_one(diameters[i % len(diameters)], draw) for i in range(self.routes)]

    def _draw_one(self, diameter_mm: float, draw: Callable[[], float]) -> PipeRoute:
        def one_of(values: Sequence[T]) -> T:
            return values[int(draw() * len(values))]

        angles, rolls, straights = (values_of(given) for given in (self.angles_deg, self.rolls_deg, self.straights_mm))
        for _ in range(MAX_DRAWS):
            bends = [(one_of(angles), one_of(self.turns), one_of(rolls)) for _ in range(self.corners)]
            bends[0] = (*bends[0][:2], 0.0)  # whose plane is the x-y plane
            lengths = [self.ends_mm, *(one_of(straights) for _ in bends[1:]), self.ends_mm]
            with suppress(CrossesItself):
                return PipeRoute.of(diameter_mm, bends, lengths)
        raise PipenavError(
            f"{MAX_DRAWS} runs of {self.corners} corners drawn one after the other cross themselves: "
            "choose wider angles, other straights or fewer corners."
        )


def route_set_names() -> list[str]:
    """The shipped sets of runs."""
    return sorted(path.stem for path in _folder().glob("*.toml"))


def parse_routes(given: Sequence[str]) -> list[PipeRoute]:
    """All runs of the given sets, in order, each once; a corner counts as a run of one.

    Args:
        given: `runs-level` or another shipped name, `runs-level:3` for its third run, a TOML file of one run, of a set
            of runs or of a set of pipes, or whatever else `pipenav.pipes.corner_sets.parse_pipes` takes.

    Raises:
        PipenavError: something that is none of these, or a run that is not possible.
    """
    pipes = parse_any(given)
    return list(dict.fromkeys(pipe.route for pipe in pipes))


def parse_any(given: Sequence[str]) -> list[Pipe]:
    """As `parse_routes`, but a corner stays a pipe."""
    return list(dict.fromkeys(pipe for text in given for pipe in _parse_one(text)))


def parse_route(text: str) -> tuple[str, PipeRoute]:
    """One run and a name for it: that of its TOML file, or `runs-level-3` for the third run of that shipped set.

    Raises:
        PipenavError: something that is neither, or a run that is not possible.
    """
    name, colon, number = text.partition(":")
    if name in route_set_names():
        if not colon:
            raise PipenavError(f"{text} is a set of runs: choose one of them by its number, as in {text}:1.")
        return f"{name}-{number}", parse_routes([text])[0]
    if not text.endswith(".toml"):
        raise UnknownName("run", text, [*(f"{known}:1" for known in route_set_names()), "FILE.toml"])
    return Path(text).stem, read_route(Path(text))


def read_route(path: Path) -> PipeRoute:
    """The run of a TOML file, corner by corner.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no run, or no possible one.
    """
    if not isinstance(read_toml(path).get("corners"), list):
        raise ConfigError(f"{path} is not one run: that is a file with a [[corners]] table for each corner.")
    file = read_as(RouteFile, path, CornerEntry)
    try:
        return file.route()
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error


def _parse_one(text: str) -> Sequence[Pipe]:
    name, colon, number = text.partition(":")
    if name in route_set_names():
        routes = _read_set(_folder() / f"{name}.toml")
        return [routes[_index(text, number, len(routes))]] if colon else routes
    if text.endswith(".toml"):
        table = read_toml(Path(text))
        if "corners" in table:
            return _read_set(Path(text)) if "runs" in table else [read_route(Path(text))]
    elif "=" not in text and text not in pipe_set_names():
        raise UnknownName(
            "set of pipes or runs", text, [*route_set_names(), *pipe_set_names(), "FILE.toml", "d=90,angle=60"]
        )
    return parse_pipes([text])


def _index(text: str, number: str, count: int) -> int:
    if not (number.isascii() and number.isdigit() and 1 <= int(number) <= count):
        raise PipenavError(f"{text!r} names no run of the set: write a number from 1 to {count} after the colon.")
    return int(number) - 1


def _read_set(path: Path) -> list[PipeRoute]:
    file = read_as(RouteSetFile, path)
    try:
        return file.draw()
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error


def _folder() -> Path:
    return shipped.pipes_dir() / "runs"
