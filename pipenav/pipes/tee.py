"""A tee between two straights, passed in one of three ways, and sets of them."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, cast, get_args

from pydantic import BaseModel, ConfigDict, Field

from pipenav.errors import PipenavError, shown
from pipenav.pipes.branch import IN_LINE, Branch
from pipenav.pipes.branch_pipes import BRANCH_ANGLE_RANGE_DEG, reaches_of, with_default_branches
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_checks import DIAMETER_RANGE_MM, check_corner, check_range, check_turn, default_leg
from pipenav.pipes.pipe import DEFAULT_WALL, Turn
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner
from pipenav.pipes.set_file import MAX_CORNERS, MAX_TURNS, Values, too_large, values_of
from pipenav.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

Way = Literal["straight", "into", "out"]
"""Way through a tee: straight on along the run, from the run into the branch, or out of the branch into the run."""


class TeePassage(NamedTuple):
    """A passage through a tee: the way, see `Way`, and the side of the branch or, off the run, of the robot's turn."""

    way: str = "straight"
    turn: str = "left"


STRAIGHT_ON = TeePassage()
"""The passage along the run, past a branch to the left."""


class TeeSetFile(BaseModel):
    """A set of tees as TOML: every diameter with every angle, way and turn; all pipes of a tee have one bore."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    description: str
    diameters_mm: Values
    tee_angles_deg: Values
    ways: list[str] = Field(list(get_args(Way)), min_length=1, max_length=MAX_TURNS)
    turns: list[str] = Field(["left", "right"], min_length=1, max_length=MAX_TURNS)

    def make(self) -> list[PipeCorner]:
        """The tees, each once."""
        diameters, angles = values_of(self.diameters_mm), values_of(self.tee_angles_deg)
        if (count := len(diameters) * len(angles) * len(self.ways) * len(self.turns)) > MAX_CORNERS:
            raise too_large(count)
        return [
            tee(diameter, angle, TeePassage(way, turn))
            for diameter in diameters
            for angle in angles
            for way in self.ways
            for turn in self.turns
        ]


def tee(
    diameter_mm: float,
    angle_deg: float,
    passage: TeePassage = STRAIGHT_ON,
    leg_mm: float | None = None,
    wall_mm: float | None = None,
) -> PipeCorner:
    """A tee of one bore as a corner; `tee_route` takes branches that are narrower.

    Args:
        diameter_mm: inner diameter of all its pipes.
        angle_deg: interior angle between the branch and the part of the run on the robot's way: the part by which it
            comes to the branch, or the one into which it goes out of the branch.
        passage: the robot's passage through it.
        leg_mm: length of the robot's two legs; by default what a robot needs.
        wall_mm: wall thickness.

    Raises:
        OutOfRange: a number outside its allowed range.
        PipenavError: an unknown way or turn.
    """
    diameter, wall = mm_to_m(diameter_mm), _wall(wall_mm)
    check_corner(diameter, math.pi, 0.0, wall)  # before the lengths, which follow from these
    corner = tee_corner(TeeSize(diameter, diameter, deg_to_rad(angle_deg), wall), passage)
    shortest = float(reaches_of(corner, diameter, diameter, wall)[:2].max()) + 0.1 * diameter
    leg = default_leg(shortest, diameter) if leg_mm is None else mm_to_m(leg_mm)
    return PipeCorner(
        diameter=diameter, angle=corner.angle, turn=corner.turn, leg=leg, wall=wall, branches=corner.branches
    )


def tee_route(
    diameter_mm: float,
    branch_diameter_mm: float,
    angle_deg: float,
    passage: TeePassage = STRAIGHT_ON,
    leg_mm: float | None = None,
    wall_mm: float | None = None,
) -> PipeRoute:
    """A tee as a route, whose branch can be narrower than its run.

    Args:
        diameter_mm: inner diameter of the run.
        branch_diameter_mm: inner diameter of the branch.
        angle_deg, passage, leg_mm, wall_mm: as for `tee`.

    Raises:
        PipenavError: as `tee`.
    """
    run, branch, wall = mm_to_m(diameter_mm), mm_to_m(branch_diameter_mm), _wall(wall_mm)
    corner = tee_corner(TeeSize(run, branch, deg_to_rad(angle_deg), wall), passage)
    first = branch if passage.way == "out" else run
    return PipeRoute.with_default_straights(first, (corner,), [leg_mm, leg_mm], wall)


def fitting_of(pipe: PipeCorner) -> str | None:
    """`tee 90 into`: what a corner with branches is, the angle [deg] as for `tee`, the way; None without branches."""
    if not pipe.branches:
        return None
    straight_on = pipe.as_route_corner.straight_on
    on_run = any(math.pi - branch.angle < IN_LINE for branch in pipe.branches)
    way: Way = "straight" if straight_on else "into" if on_run else "out"
    angle = pipe.branches[0].angle if straight_on else pipe.angle
    return f"{'tee' if len(pipe.branches) == 1 else 'cross'} {round(rad_to_deg(angle), 6):g} {way}"


def check_way(way: str) -> Way:
    """The way of a name.

    Raises:
        PipenavError: none of the three.
    """
    if way not in get_args(Way):
        raise PipenavError(f"way {shown(way)} through a tee is unknown: choose 'straight', 'into' or 'out'.")
    return cast(Way, way)


def _wall(wall_mm: float | None) -> float:
    return DEFAULT_WALL if wall_mm is None else mm_to_m(wall_mm)


class TeeSize(NamedTuple):
    """Numbers of a tee: diameters of its run and its branch [m], interior angle [rad], wall thickness [m]."""

    run: float
    branch: float
    angle: float
    wall: float


def tee_corner(size: TeeSize, passage: TeePassage, roll: float = 0.0) -> Corner:
    """The tee as a corner of a route.

    Args:
        size: its numbers; the angle is that of `tee`.
        passage: the robot's passage through it.
        roll: angle from the plane of the corner before to its plane [rad].

    Raises:
        OutOfRange: a number outside its allowed range.
        PipenavError: an unknown way or turn.
    """
    run, branch, angle, wall = size
    check_range("angle of the tee", rad_to_deg(angle), *BRANCH_ANGLE_RANGE_DEG, "deg")
    check_range("diameter of the tee's run", m_to_mm(run), *DIAMETER_RANGE_MM, "mm")
    check_range("diameter of the tee's branch", m_to_mm(branch), DIAMETER_RANGE_MM[0], m_to_mm(run), "mm")
    way, turn = check_way(passage.way), check_turn(passage.turn)
    other: Turn = "right" if turn == "left" else "left"
    if way == "straight":
        side = Branch(angle=angle, turn=turn, roll=roll, diameter=branch, length=0.0)
        corner = Corner(angle=math.pi, turn=turn, branches=(side,))
    elif way == "into":
        to = branch if branch != run else None
        side = Branch(angle=math.pi, diameter=run, length=0.0)
        corner = Corner(angle=angle, turn=turn, roll=roll, to_diameter=to, branches=(side,))
    else:
        to = run if branch != run else None
        side = Branch(angle=math.pi - angle, turn=other, roll=roll, diameter=run, length=0.0)
        corner = Corner(angle=angle, turn=turn, roll=roll, to_diameter=to, branches=(side,))
    before, after = (branch if way == "out" else run), (branch if way == "into" else run)
    return with_default_branches(corner, before, after, wall)
