"""Verdicts: passable with a motion, impossible with a proof and a reason, or undecided."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.arm import ArmSpans, Ends, can_be_certified
from pipenav.certify.arm_path import arm_path
from pipenav.certify.cell_search import MOST_WORK, search
from pipenav.certify.model import Model
from pipenav.certify.whole_motion import whole_motion
from pipenav.certify.whole_proof import LinkProof, prove, prove_by_link
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.units import rad_to_deg

MARGIN = 1.5e-4
"""Distance that motions keep to the walls [m]: what the coarser of the two tests needs, and half of it again."""

STRAIGHT = math.radians(0.5)
"""Change of heading below which a pipe counts as straight [rad]."""

SOON, SOON_WORK = math.radians(1.0), 20_000
"""Width of the smallest cells of a proof that is found soon or not at all [rad], and most cells that it looks at."""

Kind = Literal["passable", "impossible", "undecided"]


class Proof(NamedTuple):
    """Proof that a pipe is impossible.

    Attributes:
        links: names of the links that cannot pass; all of an arm's.
        headings: headings of a single link at which the pipe has no room, one for each way round [rad].
        finest: width of the smallest cells, where cells were searched; 0 where none were [rad].
    """

    links: tuple[str, ...]
    headings: tuple[float, ...]
    finest: float


class Verdict(NamedTuple):
    """Verdict on one pipe or episode.

    Attributes:
        kind: passable, impossible or undecided.
        reason: why, in words.
        proof: proof, where it is impossible.
        motion: configurations of a motion in the robot's own frame, (rows, coordinates), where it is passable.
        base: x of the robot's frame in the pipe's frame, for the motion [m].
        ends: starts and targets with the one that an arm's motion joins.
        finest: width of the smallest cells that were looked at, 0 where none were [rad].
    """

    kind: Kind
    reason: str
    proof: Proof | None = None
    motion: Floats | None = None
    base: float = 0.0
    ends: Ends | None = None
    finest: float = 0.0


def certify(model: Model, ends: Ends | None, resolution: float) -> Verdict:
    """The verdict on a corner.

    Args:
        model: robot, pipe, kind of bore and allowed overlap.
        ends: starts and targets of an arm; by default all that the task draws. A whole robot has none.
        resolution: width of the smallest cells [rad].
    """
    if why := not_covered(model):
        return Verdict("undecided", why)
    if model.robot.free:
        return _whole(model, resolution)
    return _arm(model, ends or Ends.of_task(model, ReachConfig()), resolution)


def not_covered(model: Model) -> str:
    """Reason why the method says nothing about a pipe or a robot; empty where it does."""
    if model.pipe.branches:
        return "a tee has branches that open the walls: the method knows corners without branches"
    if model.turn < STRAIGHT:
        return "the pipe is straight: there is no corner to pass"
    if not model.robot.free and not can_be_certified(model.robot):
        return "the arm is not a slide followed by up to three hinges: the method knows no others"
    return ""


def passable(model: Model, ends: Ends | None) -> Verdict | None:
    """The verdict that a motion passes the corner, free by both tests; None where none was found.

    Args:
        model: what is certified, covered by the method.
        ends: starts and targets of an arm; by default all that the task draws. A whole robot has none.
    """
    if model.robot.free:
        q = whole_motion(model, MARGIN, TraverseConfig(kind="traverse"))
        return None if q is None else Verdict("passable", "a motion of the whole robot is free", motion=q)
    ends = ends or Ends.of_task(model, ReachConfig())
    for aimed in (ends, *ends.further):
        if (q := arm_path(ArmSpans(model, aimed, MARGIN))) is not None:
            return Verdict("passable", "a motion brings the tip to a target", None, q, aimed.base, aimed)
    return None


def proof_of(model: Model, ends: Ends | None, resolution: float, most_work: int = MOST_WORK) -> Proof | None:
    """A proof that nothing passes the corner; None where none was found.

    Args:
        model: what is certified, covered by the method.
        ends: starts and targets of an arm; by default all that the task draws. A whole robot has none.
        resolution: width of the smallest cells [rad].
        most_work: most cells of an arm that are looked at, those of every round counted.
    """
    if model.robot.free:
        found = prove_by_link(model) or prove(model, resolution)
        return None if found is None else _named(model, found)
    spans = ArmSpans(model, ends or Ends.of_task(model, ReachConfig()), MARGIN)
    searched = search(spans, spans.axes, resolution, most_work)
    return Proof(tuple(link.name for link in model.robot.links), (), searched.finest) if searched.proven else None


def _whole(model: Model, resolution: float) -> Verdict:
    proof = prove_by_link(model)
    if proof is None:
        if (found := passable(model, None)) is not None:
            return found
        proof = prove(model, resolution)
    if proof is None:
        why = "no motion was found among those tried, and no proof that one or two links cannot pass"
        return Verdict("undecided", why, finest=resolution)
    return Verdict("impossible", _why_not(model, proof), _named(model, proof), finest=proof.finest)


def _why_not(model: Model, proof: LinkProof) -> str:
    names = _named(model, proof).links
    if len(names) == 1:
        angles = " and ".join(f"{rad_to_deg(heading):.0f}" for heading in proof.headings)
        return f"width: {names[0]} alone does not fit at headings of {angles} deg, and has no way around both"
    return f"joint limit: {' and '.join(names)} cannot turn together with the joint between them"


def _named(model: Model, proof: LinkProof) -> Proof:
    links = model.robot.links[proof.first : proof.last + 1]
    return Proof(tuple(link.name for link in links), proof.headings, proof.finest)


def _arm(model: Model, ends: Ends, resolution: float) -> Verdict:
    if (verdict := passable(model, ends)) is not None:
        return verdict
    spans = ArmSpans(model, ends, MARGIN)
    found = search(spans, spans.axes, resolution)
    if not found.proven:
        width = rad_to_deg(found.finest)
        return Verdict("undecided", f"neither a motion nor a proof with cells of {width:.2g} deg", finest=found.finest)
    proof = Proof(tuple(link.name for link in model.robot.links), (), found.finest)
    return Verdict("impossible", _arm_reason(model, ends), proof, finest=found.finest)


class Freed(NamedTuple):
    """A joint without whose limits there is a motion: its number, and the verdict with that motion."""

    number: int
    verdict: Verdict


def freed_joint(model: Model, ends: Ends) -> Freed | None:
    """The first joint of an arm whose limits alone keep it from a target; None where there is none such."""
    if _too_narrow(model, ends):
        return None
    for number in range(len(model.robot.joints)):
        if (found := passable(model._replace(freed=(number,)), ends)) is not None:
            return Freed(number, found)
    return None


def _too_narrow(model: Model, ends: Ends) -> bool:
    """Whether a proof is soon found that no limits of joints keep an arm from its targets, but the walls alone."""
    free = model._replace(freed=tuple(range(len(model.robot.joints))))
    travel = free.limits[1][0] - model.limits[1][0]
    low, high = ends.slide
    spans = ArmSpans(free, ends._replace(slide=(low - travel, high + travel)), MARGIN)
    return search(spans, spans.axes, SOON, SOON_WORK).proven


def _arm_reason(model: Model, ends: Ends) -> str:
    """Limit without which there would be a motion: the slide's, a hinge's, or none, so that the pipe is too narrow."""
    found = freed_joint(model, ends)
    if found is None:
        return f"width: the links of {model.robot.name} have no room to turn, also with other joints' limits"
    joint = model.robot.joints[found.number]
    if not found.number:
        return f"reach: the slide {joint.name} is too short, with more travel there is a motion"
    return f"joint limit: {joint.name} does not turn far enough, without its limits there is a motion"


def tightest(model: Model, motion: Floats, base: float) -> int:
    """Row of a motion at which the robot is nearest to a wall."""
    from pipenav.certify.motion_check import clearances

    return int(clearances(model, motion, base).argmin())


def timed(model: Model, motion: Floats) -> Floats:
    """Rows of a motion, one for each control period, with no joint faster than its motor, (rows, coordinates)."""
    from pipenav.backends.backend import CONTROL_PERIOD

    robot, change = model.robot, np.abs(np.diff(motion, axis=0))
    joints = change[:, -len(robot.joints) :] / (SLOWER * robot.speed_limits * CONTROL_PERIOD)
    ticks = joints.max(axis=1)
    if robot.free:
        ticks = np.maximum(ticks, np.hypot(change[:, 0], change[:, 1]) / (FREE_SPEED * CONTROL_PERIOD))
    at = np.concatenate([[0.0], np.cumsum(ticks)])
    when = np.unique(np.concatenate([at, np.linspace(0.0, at[-1], math.ceil(at[-1]) + 1)]))
    return np.stack([np.interp(when, at, column) for column in motion.T], axis=1)


SLOWER = 0.5
"""Share of the motors' speed at which motions are written down."""

FREE_SPEED = 0.05
"""Speed of a free robot's first link in motions that are written down [m/s]."""
