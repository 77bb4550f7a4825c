"""Sets of single corners: shipped ones by name, a TOML file, or one corner typed as `d=90,angle=60,turn=right`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from pipenav.errors import ConfigError, PipenavError, UnknownName, shown
from pipenav.pipes.bend_radius import bend_radius_mm
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.set_file import MAX_CORNERS, MAX_TURNS, Range, Values, read_as, too_large, values_of
from pipenav.pipes.tee import TeePassage, TeeSetFile, tee
from pipenav.storage import shipped
from pipenav.storage.text_files import read_toml

ROUTE_KEYS = {"corners", "s_bend", "reducers_mm", "nodes"}
"""Keys by which a file of routes is told from one of corners."""

SINGLE = "give single corners here, such as thesis or d=90,angle=60; whole robots pass routes in train, eval and view"
"""Advice where routes are named and only single corners will do."""

TYPED = "write it as d=90,angle=60[,turn=right] or d=90,tee=90[,way=into], in mm and deg without the units"
"""Advice on how a corner is typed."""


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
            raise too_large(count)
        return [
            PipeCorner.of(d, angle, turn, self.bend_radius_mm + times * d)
            for turn in self.turns
            for d in diameters
            for angle in angles
            for times in radii_d
        ]


class CornersOfAngle(BaseModel):
    """Corners of one angle: every diameter that is named with it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    angle_deg: float
    diameters_mm: Values


class CornerListFile(BaseModel):
    """A set of corners as TOML: for each angle diameters of its own, each with every turn."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    description: str
    rows: list[CornersOfAngle] = Field(min_length=1, max_length=MAX_CORNERS)
    turns: list[str] = Field(["left"], min_length=1, max_length=MAX_TURNS)

    def make(self) -> list[PipeCorner]:
        """The corners in the order of the rows, first to one side, then to the other."""
        rows = [(row.angle_deg, values_of(row.diameters_mm)) for row in self.rows]
        if (count := len(self.turns) * sum(len(diameters) for _, diameters in rows)) > MAX_CORNERS:
            raise too_large(count)
        return [PipeCorner.of(d, angle, turn) for turn in self.turns for angle, diameters in rows for d in diameters]


def corner_set_names() -> list[str]:
    """Names of the shipped sets of corners."""
    return sorted(path.stem for path in shipped.pipes_dir().glob("*.toml"))


def parse_corners(given: Sequence[str]) -> list[PipeCorner]:
    """All single corners of the given sets, in order, each once.

    `pipenav.pipes.route_sets.parse_pipes` takes routes too.

    Args:
        given: shipped names, TOML files, `d=90,angle=60[,turn=right][,bend_radius=100]` (mm, deg; radius also 1.5D),
            or a tee, `d=90,tee=90[,way=into][,turn=right]`.

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
    return _shipped_set(text)


@cache  # a training reads each of its sets a dozen times
def _shipped_set(name: str) -> list[PipeCorner]:
    return _read(shipped.pipes_dir() / f"{name}.toml")


def _typed_corner(text: str) -> PipeCorner:
    common = {"d": "", "turn": "left"}
    corner, fitting = {"angle": "", "bend_radius": "0"}, {"tee": "", "way": "straight"}
    values: dict[str, str] = {}
    for part in text.split(","):
        key, equals, value = (word.strip() for word in part.partition("="))
        if not equals:
            raise PipenavError(f"pipe {shown(text)} has {shown(part)} in it, which is no key=value: {TYPED}.")
        if key not in common | corner | fitting:
            raise PipenavError(f"pipe {shown(text)}: {UnknownName('key', key, [*common, *corner, *fitting])}")
        if key in values:
            raise PipenavError(f"pipe {shown(text)} says {key} twice: say it once.")
        values[key] = value
    is_tee = "tee" in values
    if strange := sorted(values.keys() & (corner if is_tee else fitting).keys()):
        kind, advice = ("tee", "angle in place of tee") if is_tee else ("corner", "tee in place of angle")
        raise PipenavError(f"pipe {shown(text)} is a {kind}, which has no {' or '.join(strange)}: give {advice}.")
    given = common | (fitting if is_tee else corner) | values
    diameter, angle = (_typed_number(text, key, given[key]) for key in ("d", "tee" if is_tee else "angle"))
    if is_tee:
        return tee(diameter, angle, TeePassage(given["way"], given["turn"]))
    return PipeCorner.of(diameter, angle, given["turn"], bend_radius_mm(given["bend_radius"], diameter))


def _typed_number(text: str, key: str, value: str) -> float:
    if not value:
        raise PipenavError(f"pipe {shown(text)} is incomplete, without {key}: {TYPED}.")
    try:
        return float(value)
    except ValueError:
        raise PipenavError(f"pipe {shown(text)}: {key} {shown(value)} is no number: {TYPED}.") from None


def _read(path: Path) -> list[PipeCorner]:
    table = read_toml(path)
    if ROUTE_KEYS & table.keys():
        raise ConfigError(f"{path} holds routes: {SINGLE}.")
    kind: type[CornerSetFile | CornerListFile | TeeSetFile] = CornerSetFile
    if "tee_angles_deg" in table:
        kind = TeeSetFile
    elif "rows" in table:
        kind = CornerListFile
    file = read_as(kind, path, CornersOfAngle if kind is CornerListFile else Range)
    try:
        return file.make()
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error
