"""Sets of single corners: shipped ones by name, a TOML file, or one corner typed as `d=90,angle=60,turn=right`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Self, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from pipenav.errors import ConfigError, PipenavError, UnknownName, first_problem, shown
from pipenav.pipes.bend_radius import bend_radius_mm
from pipenav.pipes.corner import PipeCorner
from pipenav.storage import shipped
from pipenav.storage.text_files import read_toml

_File = TypeVar("_File", bound=BaseModel)

MAX_STEPS = 1000
"""Most steps of a range: more is a slip of the keyboard."""


ROUTE_KEYS = {"corners", "s_bend", "reducers_mm"}
"""Keys by which a file of routes is told from one of corners."""

SINGLE = "give single corners, such as thesis or d=90,angle=60; only a whole robot passes routes"
"""Advice where routes are named and only single corners will do."""

MAX_CORNERS = 10_000
"""Most corners of a set: several times the largest that is shipped."""

TYPED = "write it as d=90,angle=60[,turn=right], in mm and deg without the units"
"""Advice on how a corner is typed."""

MAX_TURNS = 100
"""Most entries in a list of turns."""


class _Range(BaseModel):
    """Evenly spaced values, both ends included."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    start: float
    stop: float
    step: float = Field(gt=0)

    @model_validator(mode="after")
    def _whole_steps(self) -> _Range:
        steps = (self.stop - self.start) / self.step
        if not 0 <= steps <= MAX_STEPS or abs(steps - round(steps)) > 1e-6:
            raise PydanticCustomError(
                "whole_steps",
                f"from {self.start:g} up to {self.stop:g} must be a whole number of steps of {self.step:g}, "
                f"at most {MAX_STEPS}",
            )
        return self

    def values(self) -> list[float]:
        count = round((self.stop - self.start) / self.step) + 1
        return [round(float(x), 6) for x in np.linspace(self.start, self.stop, count)]


_List = Annotated[list[float], Field(min_length=1, max_length=MAX_STEPS + 1)]
Values = Annotated[
    Annotated[_List, Tag("<list>")] | Annotated[_Range, Tag("<range>")],
    Discriminator(lambda given: "<range>" if isinstance(given, dict | _Range) else "<list>"),
]
"""Numbers in a set's file: a list, or a range with both ends. Only the kind that was meant reports a problem."""


class CornerSetFile(BaseModel):
    """A set of corners as TOML: every diameter with every angle, turn and bend radius."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    description: str
    diameters_mm: Values
    angles_deg: Values
    turns: list[str] = Field(["left"], min_length=1, max_length=MAX_TURNS)
    bend_radius_mm: float = 0.0
    bend_radii_d: Values | None = None

    @model_validator(mode="after")
    def _one_way_to_say_it(self) -> Self:
        if self.bend_radii_d is not None and self.bend_radius_mm:
            raise PydanticCustomError("bend_twice", "give bend_radius_mm or bend_radii_d, not both")
        return self

    def make(self) -> list[PipeCorner]:
        """The corners: every diameter with every angle and bend radius, first to one side, then to the other."""
        diameters, angles = values_of(self.diameters_mm), values_of(self.angles_deg)
        radii_d = [0.0] if self.bend_radii_d is None else values_of(self.bend_radii_d)
        if (count := len(diameters) * len(angles) * len(self.turns) * len(radii_d)) > MAX_CORNERS:
            raise ConfigError(f"a set of {count:,} corners is too large: give it {MAX_CORNERS:,} at most.")
        return [
            PipeCorner.of(d, angle, turn, self.bend_radius_mm + times * d)
            for turn in self.turns
            for d in diameters
            for angle in angles
            for times in radii_d
        ]


def values_of(given: Values) -> list[float]:
    """The numbers that were given, one by one."""
    return given.values() if isinstance(given, _Range) else given


def corner_set_names() -> list[str]:
    """Names of the shipped sets of corners."""
    return sorted(path.stem for path in shipped.pipes_dir().glob("*.toml"))


def parse_corners(given: Sequence[str]) -> list[PipeCorner]:
    """All single corners of the given sets, in order, each once.

    `pipenav.pipes.route_sets.parse_pipes` takes routes too.

    Args:
        given: shipped names, TOML files, or `d=90,angle=60[,turn=right][,bend_radius=100]` (mm, deg; radius also 1.5D).

    Raises:
        PipenavError: something that is none of these, or a pipe that is out of range.
    """
    corners = [corner for text in given for corner in _parse_one(text)]
    return list(dict.fromkeys(corners))


def _parse_one(text: str) -> list[PipeCorner]:
    if text.endswith(".toml"):
        return _read(Path(text))
    if "=" in text:
        return [_typed_corner(text)]
    if text not in corner_set_names():
        if (shipped.pipes_dir() / "runs" / f"{text.partition(':')[0]}.toml").is_file():
            raise PipenavError(f"{shown(text)} names routes: {SINGLE}.")
        raise UnknownName("pipe set", text, [*corner_set_names(), "FILE.toml", "d=90,angle=60"])
    return _read(shipped.pipes_dir() / f"{text}.toml")


def _typed_corner(text: str) -> PipeCorner:
    allowed = {"d": "", "angle": "", "turn": "left", "bend_radius": "0"}
    values: dict[str, str] = {}
    for part in text.split(","):
        key, equals, value = (word.strip() for word in part.partition("="))
        if not equals:
            raise PipenavError(f"pipe {shown(text)} has {shown(part)} in it, which is no key=value: {TYPED}.")
        if key not in allowed:
            raise PipenavError(f"pipe {shown(text)}: {UnknownName('key', key, allowed)}")
        if key in values:
            raise PipenavError(f"pipe {shown(text)} says {key} twice: say it once.")
        values[key] = value
    given = {**allowed, **values}
    diameter, angle = (_typed_number(text, key, given[key]) for key in ("d", "angle"))
    return PipeCorner.of(diameter, angle, given["turn"], bend_radius_mm(given["bend_radius"], diameter))


def _typed_number(text: str, key: str, value: str) -> float:
    if not value:
        raise PipenavError(f"pipe {shown(text)} is incomplete, without {key}: {TYPED}.")
    try:
        return float(value)
    except ValueError:
        raise PipenavError(f"pipe {shown(text)}: {key} {shown(value)} is no number: {TYPED}.") from None


def _read(path: Path) -> list[PipeCorner]:
    if ROUTE_KEYS & read_toml(path).keys():
        raise ConfigError(f"{path} holds routes: {SINGLE}.")
    file = read_as(CornerSetFile, path)
    try:
        return file.make()
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error


def read_as(kind: type[_File], path: Path, inner: type[BaseModel] = _Range) -> _File:
    """A TOML file as a model.

    Args:
        kind: model of the whole file.
        path: the file.
        inner: model of the tables in it, for the keys that a message suggests.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no TOML, or does not fit.
    """
    table = read_toml(path)
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        prefix = [str(part) for part in first_problem(error)["loc"][:-1]]
        fields = (inner if prefix else kind).model_fields
        known = [".".join([*prefix, field.alias or name]) for name, field in fields.items()]
        raise ConfigError.from_validation(str(path), error, known) from error
