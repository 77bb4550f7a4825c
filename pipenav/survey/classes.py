"""Classes of fittings: a bore, an angle and what else decides whether a robot passes, in steps that can be tried."""

from __future__ import annotations

from typing import Literal, NamedTuple

from pipenav.pipes.branch_pipes import BRANCH_ANGLE_RANGE_DEG
from pipenav.pipes.corner_checks import ANGLE_RANGE_DEG

BORE_STEP_MM, ANGLE_STEP_DEG, TEE_STEP_DEG, INCLINE_STEP_DEG, RADIUS_STEP = 5.0, 5.0, 15.0, 15.0, 0.5
"""Steps of classes: of bores, of angles of bends and of branches, of inclinations, and of bend radii in bores."""

LEVEL_DEG = 5.0
"""Inclination up to which a pipe counts as level."""

LARGEST_RADIUS = 20.0
"""Bend radius from which a bend counts as a straight pipe [bores]: no robot link of a bore's length tells it apart."""

ClassKind = Literal["bend", "reducer", "tee", "cross"]


class FittingClass(NamedTuple):
    """A class of fittings, as the robot passes them.

    Attributes:
        kind: kind of the fitting.
        bore_mm: bore of the pipe that it comes by, of the run in a tee or cross.
        angle_deg: interior angle; in a tee or cross that of the branch, see `pipenav.pipes.tee.tee`.
        to_mm: bore behind a reducer, or of the branch; 0 where there is none.
        radius: radius of a bend [bores], 0 for a mitre.
        way: way through a tee or a cross.
        incline_deg: inclination of the pipe, 0 for level.
    """

    kind: ClassKind
    bore_mm: float
    angle_deg: float = 180.0
    to_mm: float = 0.0
    radius: float = 0.0
    way: str = ""
    incline_deg: float = 0.0

    @property
    def name(self) -> str:
        """`bend-d100-a135` and the like, usable in a file name."""
        parts = [self.kind, f"d{self.bore_mm:g}"]
        parts += [f"to{self.to_mm:g}"] if self.to_mm else []
        parts += [f"a{self.angle_deg:g}"] if self.kind != "reducer" else []
        parts += [f"r{self.radius:g}D"] if self.radius else []
        parts += [self.way] if self.way else []
        parts += [f"i{self.incline_deg:g}"] if self.incline_deg else []
        return "-".join(parts)

    @property
    def straight(self) -> bool:
        """Whether it is a straight pipe, which needs no trial."""
        return self.kind == "bend" and (self.angle_deg >= 180 or self.radius >= LARGEST_RADIUS)

    def toml(self, turn: str) -> str:
        """The fitting as a route file (docs/formats/route-folder.md), with its turn or its branch on one side."""
        other = "right" if turn == "left" else "left"
        lines = ["schema = 3", f"diameter_mm = {self._first_mm:g}", f"slope_deg = {self.incline_deg:g}", "[[corners]]"]
        angle, back = f"{self.angle_deg:g}", f"{180 - self.angle_deg:g}"
        if self.kind == "reducer":
            lines.append(f"to_diameter_mm = {self.to_mm:g}")
        elif self.kind == "bend":
            lines += [f"angle_deg = {angle}", f'turn = "{turn}"', f"bend_radius_mm = {self.radius * self.bore_mm:g}"]
        elif self.way == "straight":
            branches = [_branch(angle, turn, self.to_mm)]
            branches += [_branch(back, other, self.to_mm)] if self.kind == "cross" else []
            lines.append(f"branches = [{', '.join(branches)}]")
        else:
            lines += [f"angle_deg = {angle}", f'turn = "{turn}"']
            last = self.to_mm if self.way == "into" else self.bore_mm
            lines += [f"to_diameter_mm = {last:g}"] if last != self._first_mm else []
            run = _branch("180", turn, self.bore_mm) if self.way == "into" else _branch(back, other, self.bore_mm)
            branches = [run]
            if self.kind == "cross":  # the branch on the other side
                far = _branch(back, other, self.to_mm) if self.way == "into" else _branch("180", turn, self.to_mm)
                branches.append(far)
            lines.append(f"branches = [{', '.join(branches)}]")
        return "\n".join(lines) + "\n"

    @property
    def _first_mm(self) -> float:
        return self.to_mm if self.way == "out" else self.bore_mm


def _branch(angle: str, turn: str, diameter_mm: float) -> str:
    return f'{{ angle_deg = {angle}, turn = "{turn}", diameter_mm = {diameter_mm:g} }}'


def nominal_bore(diameter: float) -> float:
    """Bore of the class that an inner diameter [m] belongs to [mm]."""
    return round(diameter * 1e3 / BORE_STEP_MM) * BORE_STEP_MM


def nominal_incline(incline_deg: float) -> float:
    """Inclination of the class that one belongs to [deg]."""
    if abs(incline_deg) <= LEVEL_DEG:
        return 0.0
    return max(round(abs(incline_deg) / INCLINE_STEP_DEG), 1) * INCLINE_STEP_DEG


def nominal_radius(bores: float) -> float:
    """Bend radius of the class that one belongs to [bores]; the least that is no mitre is one bore."""
    if bores >= LARGEST_RADIUS:
        return LARGEST_RADIUS
    return max(round(bores / RADIUS_STEP) * RADIUS_STEP, 1.0) if bores > RADIUS_STEP else 0.0


def angles_within(angle_deg: float, error_deg: float, tee: bool = False) -> list[float]:
    """Angles of the classes that an interior angle with an error can belong to, the likeliest first [deg]."""
    step = TEE_STEP_DEG if tee else ANGLE_STEP_DEG
    low, high = BRANCH_ANGLE_RANGE_DEG if tee else ANGLE_RANGE_DEG
    nominal = round(min(max(angle_deg, low), high) / step)
    first, last = round(max(angle_deg - error_deg, low) / step), round(min(angle_deg + error_deg, high) / step)
    numbers = [nominal, *(k for k in range(first, last + 1) if k != nominal)]
    return [k * step for k in numbers if low <= k * step <= high]
