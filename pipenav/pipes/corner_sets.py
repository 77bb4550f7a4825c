"""Sets of single corners: shipped ones by name, a TOML file, or one corner typed as `d=90,angle=60,turn=right`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from pipenav.errors import PipenavError, UnknownName, shown
from pipenav.pipes.bend_radius import bend_radius_mm
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.set_file import MAX_CORNERS, MAX_TURNS, Values, read_as, too_large, values_of
from pipenav.pipes.tee import TeePassage, TeeSetFile, tee
from pipenav.storage import shipped
from pipenav.storage.text_files import read_toml


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
        raise UnknownName("pipe set", text, [*corner_set_names(), "FILE.toml", "d=90,angle=60"])
    return _read(shipped.pipes_dir() / f"{text}.toml")


def _typed_corner(text: str) -> PipeCorner:
    defaults = {"d": None, "turn": "left"}
    corner, fitting = {"angle": None, "bend_radius": "0"}, {"tee": None, "way": "straight"}
    values = {}
    for part in text.split(","):
        key, _, value = part.partition("=")
        if key.strip() not in defaults | corner | fitting:
            raise UnknownName(f"pipe key in {shown(text)}", key.strip(), [*defaults, *corner, *fitting])
        values[key.strip()] = value.strip()
    is_tee = "tee" in values
    if strange := sorted(values.keys() & (corner if is_tee else fitting).keys()):
        kinds = ("tee", "corner") if is_tee else ("corner", "tee")
        raise PipenavError(
            f"pipe {shown(text)} has {', '.join(strange)} of a {kinds[1]} in a {kinds[0]}: leave it out, or give "
            f"{'angle in place of tee' if is_tee else 'tee in place of angle'}."
        )
    given = {**defaults, **(fitting if is_tee else corner), **values}
    try:
        diameter, angle = (float(given[key] or "missing") for key in ("d", "tee" if is_tee else "angle"))
    except ValueError:
        raise PipenavError(f"pipe {shown(text)} is incomplete: write it as d=90,angle=60[,turn=right].") from None
    turn = given["turn"] or "left"
    if is_tee:
        return tee(diameter, angle, TeePassage(given["way"] or "missing", turn))
    return PipeCorner.of(diameter, angle, turn, bend_radius_mm(given["bend_radius"] or "missing", diameter))


def _read(path: Path) -> list[PipeCorner]:
    kind: type[CornerSetFile | TeeSetFile] = TeeSetFile if "tee_angles_deg" in read_toml(path) else CornerSetFile
    return read_as(kind, path).make()
