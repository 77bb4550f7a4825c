"""A route as TOML, corner by corner. Format: docs/formats/route-folder.md."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from pipenav.errors import ConfigError, PipenavError
from pipenav.pipes.branch import MAX_BRANCHES, Branch
from pipenav.pipes.branch_pipes import with_default_branches
from pipenav.pipes.corner_checks import check_turn
from pipenav.pipes.pipe import DEFAULT_WALL
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import MAX_CORNERS
from pipenav.pipes.route_corner import Corner, corner_of, leg_diameters, reducer_corner
from pipenav.pipes.route_ends import RouteEnds
from pipenav.pipes.set_file import read_as
from pipenav.storage.text_files import read_toml
from pipenav.units import deg_to_rad, m_to_mm, mm_to_m


class BranchEntry(BaseModel):
    """A branch of a tee or a cross as TOML."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    angle_deg: float
    turn: str = "left"
    roll_deg: float = 0.0
    diameter_mm: float | None = None
    length_mm: float | None = Field(None, gt=0)
    capped: bool = False

    def branch(self, diameter: float) -> Branch:
        """The branch; its diameter is by default the one before the corner [m], a length of 0 stands for none."""
        return Branch(
            angle=deg_to_rad(self.angle_deg),
            turn=check_turn(self.turn),
            roll=deg_to_rad(self.roll_deg),
            diameter=diameter if self.diameter_mm is None else mm_to_m(self.diameter_mm),
            length=mm_to_m(self.length_mm or 0.0),
            closed=self.capped,
        )


class CornerEntry(BaseModel):
    """A corner of a route as TOML, with the straight that follows it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    angle_deg: float | None = None
    turn: str | None = None
    roll_deg: float = 0.0
    bend_radius_mm: float = 0.0
    to_diameter_mm: float | None = None
    length_mm: float = 0.0
    branches: list[BranchEntry] = Field([], max_length=MAX_BRANCHES)
    straight_mm: float | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if self.branches:
            if given := sorted(self.model_fields_set & {"bend_radius_mm", "length_mm"}):
                raise PydanticCustomError("fitting_bends", f"a tee or cross has neither: leave out {', '.join(given)}")
            if ("angle_deg" in self.model_fields_set) != ("turn" in self.model_fields_set):
                raise PydanticCustomError("half_a_turn", "give angle_deg and turn, or neither to go straight on")
        elif self.to_diameter_mm is None:
            missing = [key for key in ("angle_deg", "turn") if getattr(self, key) is None]
            if missing:
                add = f"{' and '.join(missing)} missing: add what is, or to_diameter_mm for a reducer"
                raise PydanticCustomError("missing_key", add)
            if "length_mm" in self.model_fields_set:
                add = "a length_mm needs to_diameter_mm, which makes a reducer: add it, or leave out length_mm"
                raise PydanticCustomError("no_reducer", add)
        elif given := sorted(self.model_fields_set - {"to_diameter_mm", "length_mm", "straight_mm"}):
            raise PydanticCustomError("reducer_turns", f"a reducer goes straight on: leave out {', '.join(given)}")
        return self

    def corner(self, diameter: float, wall: float) -> Corner:
        """The corner, the reducer, or the tee or cross.

        Args:
            diameter: inner diameter before it [m].
            wall: wall thickness [m].
        """
        if not self.branches and self.to_diameter_mm is not None:
            return reducer_corner(self.to_diameter_mm, self.length_mm)
        angle, turn = 180.0 if self.angle_deg is None else self.angle_deg, self.turn or "left"
        corner = corner_of(angle, turn, self.roll_deg, self.bend_radius_mm)
        if not self.branches:
            return corner
        after = diameter if self.to_diameter_mm is None else mm_to_m(self.to_diameter_mm)
        fitting = {
            "to_diameter": None if after == diameter else after,
            "branches": tuple(entry.branch(diameter) for entry in self.branches),
        }
        return with_default_branches(corner.model_copy(update=fitting), diameter, after, wall)


class RouteFile(BaseModel):
    """A route as TOML."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    schema_: Literal[1, 2, 3] = Field(alias="schema")
    description: str = ""
    diameter_mm: float
    wall_mm: float = m_to_mm(DEFAULT_WALL)
    first_straight_mm: float | None = None
    capped: bool = False
    slope_deg: float = 0.0
    corners: list[CornerEntry] = Field(min_length=1, max_length=MAX_CORNERS)

    def route(self) -> PipeRoute:
        """The route that the file describes.

        Raises:
            PipenavError: the route is not possible.
        """
        diameter, wall = mm_to_m(self.diameter_mm), mm_to_m(self.wall_mm)
        corners: list[Corner] = []
        for entry in self.corners:
            before = diameter if not corners else float(leg_diameters(diameter, corners)[-1])
            corners.append(entry.corner(before, wall))
        straights = [self.first_straight_mm, *(entry.straight_mm for entry in self.corners)]
        ends = RouteEnds(self.capped, deg_to_rad(self.slope_deg))
        return PipeRoute.with_default_straights(diameter, tuple(corners), straights, wall, ends)


def read_route(path: Path) -> PipeRoute:
    """The route of a TOML file, corner by corner.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no route, or not a possible one.
    """
    if not isinstance(read_toml(path).get("corners"), list):
        raise ConfigError(f"{path} is not one route: give a file with a [[corners]] table for each corner.")
    file = read_as(RouteFile, path, CornerEntry)
    try:
        return file.route()
    except PipenavError as error:
        raise ConfigError(f"{path}: {error}") from error
