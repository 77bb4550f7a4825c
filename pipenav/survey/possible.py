"""Geometry's word on classes of fittings: whether any policy can pass with the robot's shape in a round bore.

A corner is certified by `pipenav.certify`. A tee, a cross and a reducer hold a simpler pipe within them: the corner of
the narrower of the two bores, or the straight pipe of the narrower bore. A motion through that is one through the
fitting, so that they can be passable; proofs know no open walls, so that they are impossible only where a part of the
robot is larger than the bore.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pipenav
from pipenav.arrays import Table
from pipenav.certify.certificate import shape_hash
from pipenav.certify.corner_walls import width_seen
from pipenav.certify.model import Model
from pipenav.certify.shapes import shapes_of
from pipenav.certify.verdict import Kind, certify, passable
from pipenav.jobs import Done, Event, Job, JobControl, Place, run_jobs
from pipenav.jobs.here import HerePlace
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_checks import DIAMETER_RANGE_MM
from pipenav.pipes.pipe import Turn
from pipenav.robots.parts import BoxPart
from pipenav.robots.robot import RobotSpec
from pipenav.survey.class_store import ClassStore
from pipenav.survey.classes import BORE_STEP_MM, FittingClass
from pipenav.survey.trials import Report
from pipenav.units import deg_to_rad, m_to_mm, mm_to_m

RESOLUTION_DEG = 0.5
"""Width of the smallest cells of a proof: what is undecided with them is mostly within 2 mm of the frontier."""

WIDEST_MM = 200.0
"""Bore in which motions are looked for where there is more room: a motion in a bore is one in every wider bore."""

TURNS: tuple[Turn, ...] = ("left", "right")


class Possibility(Table):
    """Geometry's word on a class.

    Attributes:
        kind: `passable` where a motion was found in its bore, `impossible` where its widest bore is proven too narrow.
        reason: why it is not passable, in words.
    """

    kind: Kind
    reason: str = ""


class Question(NamedTuple):
    """A robot and a class of fittings."""

    robot: RobotSpec
    kind: FittingClass


def decide(question: Question, _control: JobControl) -> bytes:
    """Decide about a class: the function of the jobs."""
    return possibility(*question).model_dump_json().encode()


def possibility(robot: RobotSpec, kind: FittingClass) -> Possibility:
    """Geometry's word on a class; a slope makes no difference to shapes.

    Args:
        robot: the robot.
        kind: the class, whose bores are within half of `BORE_STEP_MM` of its own.
    """
    bore = min(kind.bore_mm, kind.to_mm or kind.bore_mm)
    if part := part_too_large(robot, mm_to_m(bore + BORE_STEP_MM / 2)):
        return Possibility(kind="impossible", reason=part)
    if kind.straight or kind.kind == "reducer" or kind.way == "straight":
        if fits_straight(robot, mm_to_m(bore)):
            return Possibility(kind="passable")
        return Possibility(kind="undecided", reason="stretched out, the robot does not fit into its narrower bore")
    words = [_corner(robot, kind, bore, turn) for turn in TURNS]
    if len({word.kind for word in words}) == 1:
        return words[0]
    other = next(word for word in words if word.kind != "passable")
    return Possibility(kind="undecided", reason=f"not the same to both sides: {other.reason}")


def _corner(robot: RobotSpec, kind: FittingClass, bore: float, turn: Turn) -> Possibility:
    """Geometry's word on a corner to one side, with or without branches.

    The bore of the proof is the class's widest one, in which there is most room, that of the motion its own.
    """

    def model(diameter: float) -> Model:
        return Model(robot, PipeCorner.of(diameter, kind.angle_deg, turn, kind.radius * diameter), "round")

    if kind.kind == "bend":
        wide = certify(model(max(bore + BORE_STEP_MM / 2, DIAMETER_RANGE_MM[0])), None, deg_to_rad(RESOLUTION_DEG))
        if wide.kind != "passable":
            return Possibility(kind=wide.kind, reason=wide.reason)
    if bore >= DIAMETER_RANGE_MM[0] and passable(model(min(bore, WIDEST_MM)), None) is not None:
        return Possibility(kind="passable")
    if kind.kind == "bend":
        return Possibility(kind="undecided", reason=f"of its bores, the wider ones are passable, {bore:g} mm is open")
    return Possibility(
        kind="undecided", reason="without the room of its branches no motion was found, and proofs know no branches"
    )


def part_too_large(robot: RobotSpec, diameter: float) -> str:
    """Words for a part of a robot that fits into no straight round bore of a diameter [m]; empty where all do."""
    for link in robot.links:
        for part in link.outline:
            across = min(part.width, part.length) if isinstance(part, BoxPart) else part.width
            if math.hypot(across, part.height) > diameter:
                size = f"{m_to_mm(across):.0f} by {m_to_mm(part.height):.0f} mm"
                return (
                    f"width: a part of {link.name} is {size} across and fits into no bore of {m_to_mm(diameter):g} mm"
                )
    return ""


def fits_straight(robot: RobotSpec, diameter: float) -> bool:
    """Whether a robot, stretched out, fits into a straight round bore of a diameter [m]."""
    shapes = shapes_of(robot)
    across = [*shapes.boxes.half[:, 1].tolist(), *shapes.discs.radius.tolist()]
    beside = [*shapes.boxes.centre[:, 1].tolist(), *shapes.discs.centre[:, 1].tolist()]
    heights = [*shapes.boxes.height.tolist(), *shapes.discs.height.tolist()]
    room = [
        float(width_seen(diameter, height, "round")) / 2 - half for height, half in zip(heights, across, strict=True)
    ]
    if min(room) < 0 or (robot.lower > 0).any() or (robot.upper < 0).any():
        return False
    low: float = max(y - r for y, r in zip(beside, room, strict=True))
    high: float = min(y + r for y, r in zip(beside, room, strict=True))
    return low <= high


class Possibilities:
    """Geometry's words on classes for one robot, from the cache where they are in it.

    Args:
        robot: the robot.
        folder: folder in which they are kept.
        place: where they are found, by default this process.
    """

    def __init__(self, robot: RobotSpec, folder: Path, place: Place | None = None) -> None:
        self._robot, self._place = robot, place or HerePlace()
        self._shapes = shape_hash(robot)
        self._store = ClassStore(folder, "geometry", Possibility)
        self._known: dict[FittingClass, Possibility] = {}

    def results(self, classes: Iterable[FittingClass], report: Report | None = None) -> dict[FittingClass, Possibility]:
        """Geometry's words on classes; those that are not in the cache are found, and kept as soon as they are.

        Raises:
            JobsLost: some were lost every time that they were tried; all others are kept.
            PipenavError: the cache cannot be written.
        """
        level = {kind: kind._replace(incline_deg=0.0) for kind in classes}
        missing = [kind for kind in dict.fromkeys(level.values()) if kind not in self._known and not self._kept(kind)]
        if missing:
            self._find(missing, report or (lambda _done, _total, _name: None))
        return {kind: self._known[flat] for kind, flat in level.items()}

    def _kept(self, kind: FittingClass) -> bool:
        if (kept := self._store.read(kind, self._key(kind))) is not None:
            self._known[kind] = kept
        return kept is not None

    def _key(self, kind: FittingClass) -> Mapping[str, Any]:
        return {
            "schema": 1,
            "pipenav": pipenav.__version__,
            "class": kind._asdict(),
            "shapes": self._shapes,
            "resolution_deg": RESOLUTION_DEG,
        }

    def _find(self, classes: list[FittingClass], report: Report) -> None:
        by_key, done = {f"geometry-{kind.name}": kind for kind in classes}, 0

        def hear(event: Event) -> None:
            nonlocal done
            if isinstance(event, Done):
                kind, word = by_key[event.job.key], Possibility.model_validate_json(event.content)
                self._known[kind] = word
                self._store.keep(kind, self._key(kind), word)
                done += 1
                report(done, len(classes), kind.name if done < len(classes) else "")

        report(0, len(classes), classes[0].name)
        jobs = (
            Job(key, f"geometry of {kind.name}", decide, Question(self._robot, kind)) for key, kind in by_key.items()
        )
        run_jobs(self._place, jobs, hear)
