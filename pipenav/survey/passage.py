"""Passages through a network as a robot with a cable meets them: rates, lengths, turns and slopes for a search."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.certify.verdict import Kind
from pipenav.robots.cable import CABLE_WEIGHT, PVC_FRICTION
from pipenav.robots.robot import RobotSpec
from pipenav.survey.classes import FittingClass, nominal_bore, nominal_incline
from pipenav.survey.features import Fittings, Geometry, Movement
from pipenav.survey.findings import Cause, Finding
from pipenav.survey.possible import part_too_large
from pipenav.survey.trained import Trained
from pipenav.survey.trials import Verdict

LIFTED = ("tether", "bends", "tees", "reducers", "bores", "slopes", "confidence", "policy", "unknown")
"""Limits that can be lifted, to see what each of them costs; `policy`: its failures where a shape can pass."""


class Tether(NamedTuple):
    """The cable that the robot pulls.

    Attributes:
        cable: length of the cable [m]; infinite without one.
        pull: force by which the robot pulls [N].
        friction: coefficient of friction of the cable in the pipe.
        weight: weight of the cable [N/m].
    """

    cable: float = 250.0
    pull: float = 14.0
    friction: float = PVC_FRICTION
    weight: float = CABLE_WEIGHT

    @property
    def lifted(self) -> Tether:
        """No cable at all."""
        return self._replace(cable=math.inf, weight=0.0)


class Judged(NamedTuple):
    """Judgement of a passage through a fitting.

    Attributes:
        rate: probability of passing; NaN where it is unknown, 0 where no policy passes.
        low: lower end of the 95 % interval of that probability; as `rate` where there is none.
        verdict: the word for it.
        worst: class that decides; None where there is none.
        reason: why it is not navigable, in words.
        cause: why, in one word.
        geometry: geometry's word on the class that decides.
    """

    rate: float
    low: float
    verdict: Verdict
    worst: FittingClass | None
    reason: str
    cause: Cause = ""
    geometry: Kind = "undecided"


def judgements_of(
    movements: Iterable[Movement], findings: Mapping[FittingClass, Finding], confidence: float
) -> list[Judged]:
    """The judgements of movements; those of the same classes have the same one."""
    known: dict[tuple[tuple[FittingClass, ...], str], Judged] = {}
    made = []
    for movement in movements:
        key = (movement.classes, movement.reason)
        if key not in known:
            known[key] = judged(movement, findings, confidence)
        made.append(known[key])
    return made


def judged(movement: Movement, findings: Mapping[FittingClass, Finding], confidence: float) -> Judged:
    """The judgement of a movement: by the worst class within its error; a reducer beside a bend multiplies."""
    if not movement.classes:
        return Judged(math.nan, math.nan, "unknown", None, movement.reason, "map")
    reducers = [kind for kind in movement.classes if kind.kind == "reducer"]
    others = [kind for kind in movement.classes if kind.kind != "reducer"]
    groups = [_worst(group, findings, confidence) for group in (reducers, others) if group]
    for word in ("not navigable", "unknown"):
        for kind in groups:
            if findings[kind].verdict(confidence) == word:
                return _stopped(movement, kind, findings[kind], confidence)
    rate, low = 1.0, 1.0
    for kind in groups:
        trial = findings[kind].trial
        rate, low = rate * trial.successes / trial.episodes, low * (1.0 if trial.assumed else trial.interval.low)
    decisive = min(groups, key=lambda kind: findings[kind].trial.rate or 0.0)
    return Judged(rate, low, "navigable", decisive, "", "", findings[decisive].geometry.kind)


def _worst(group: list[FittingClass], findings: Mapping[FittingClass, Finding], confidence: float) -> FittingClass:
    """The worst of some classes, the first of which is the likeliest: impossible, not navigable, unknown, seldom."""
    order = {"not navigable": 0, "unknown": 1, "navigable": 2}

    def place(kind: FittingClass) -> tuple[bool, int, bool, float, float]:
        finding = findings[kind]
        trial = finding.trial
        untried, rate = not trial.episodes, trial.rate or 0.0
        proven = finding.geometry.kind == "impossible"
        return (not proven, order[finding.verdict(confidence)], not untried, rate, trial.interval.low)

    return min(group, key=place)


def _stopped(movement: Movement, kind: FittingClass, finding: Finding, confidence: float) -> Judged:
    """The judgement of a movement that a class stops."""
    cause, trial = finding.cause(confidence), finding.trial
    likeliest = next(other for other in movement.classes if (other.kind == "reducer") == (kind.kind == "reducer"))
    within = "" if kind == likeliest else f"at {kind.angle_deg:g} deg, within the map's error: "
    verdict = finding.verdict(confidence)
    rate = 0.0 if cause == "impossible" else math.nan if trial.rate is None else trial.rate
    low = rate if math.isnan(rate) or cause == "impossible" or trial.assumed else trial.interval.low
    return Judged(rate, low, verdict, kind, within + finding.reason(confidence), cause, finding.geometry.kind)


class Ways(NamedTuple):
    """Everything that a search for reach asks, for 2 s directed segments and m movements.

    Attributes:
        length: length of each segment, (s,) [m].
        climb: sine of each segment's inclination in its own direction, (s,).
        passable: whether a robot may drive in the segment, (s,).
        unknown: reasons why nobody knows whether it may, by segment.
        impossible: reasons why no robot of its shape can, by segment.
        onward: movements out of each directed segment: (directed segment, movement).
        cost: minus the logarithm of each movement's rate; infinite where it is not passed, (m,).
        turn: change of direction in each movement [rad], (m,).
        point: point of each movement, (m,).
        leaving: directed segments away from each point.
    """

    length: list[float]
    climb: list[float]
    passable: Flags
    unknown: dict[int, str]
    impossible: dict[int, str]
    onward: list[list[tuple[int, int]]]
    cost: list[float]
    turn: list[float]
    point: list[int]
    leaving: list[list[int]]

    def lifted(self, fittings: Fittings, judgements: list[Judged], limit: str) -> Ways:
        """The ways as they would be without one limit, see `LIFTED`; the tether is none of the ways'."""
        kinds = {"bends": ("bend",), "tees": ("tee", "cross"), "reducers": ("reducer",)}.get(limit, ())
        cost, passable = list(self.cost), self.passable
        if kinds:
            for i, movement in enumerate(fittings.movements):
                if any(kind.kind in kinds and not kind.straight for kind in movement.classes):
                    cost[i] = 0.0
        if limit in ("unknown", "policy"):
            for i, judgement in enumerate(judgements):
                if limit == (judgement.cause if limit == "policy" else judgement.verdict):
                    cost[i] = 0.0
        if limit in ("bores", "slopes", "unknown"):
            passable = passable.copy()
            passable[[s for s, reason in self.unknown.items() if _is_of(limit, reason)]] = True
            cost = [
                0.0 if judgement.verdict == "unknown" and _is_of(limit, judgement.reason) else c
                for c, judgement in zip(cost, judgements, strict=True)
            ]
        return self._replace(cost=cost, passable=passable)


def _is_of(limit: str, reason: str) -> bool:
    """Whether something is unknown because of a limit of `LIFTED`."""
    if limit == "bores":
        return reason.startswith(("a bore of", "its bore"))
    return limit == "unknown" or "climbs by" in reason


def ways_of(fittings: Fittings, judgements: list[Judged], trained: Trained, robot: RobotSpec, accuracy: float) -> Ways:
    """The ways through a network.

    Args:
        fittings: its fittings.
        judgements: judgements of their movements.
        trained: what the policy was trained in.
        robot: its robot.
        accuracy: standard deviation of a position [m].
    """
    graph = fittings.graph
    climb = graph.directions()[:, 2]
    impossible = _impossible_segments(graph.diameter, robot)
    unknown = _unknown_segments(graph.diameter, climb, graph.length, trained, accuracy)
    unknown = {s: reason for s, reason in unknown.items() if s not in impossible}
    passable = np.ones(len(graph.length), bool)
    passable[[*unknown, *impossible]] = False
    onward: list[list[tuple[int, int]]] = [[] for _ in range(2 * len(graph.length))]
    for i, movement in enumerate(fittings.movements):
        onward[movement.into].append((movement.out, i))
    leaving: dict[int, list[int]] = defaultdict(list)
    for segment, (start, end) in enumerate(graph.ends.tolist()):
        leaving[start].append(2 * segment)
        leaving[end].append(2 * segment + 1)
    return Ways(
        graph.length.tolist(),
        climb.tolist(),
        passable,
        unknown,
        impossible,
        onward,
        [cost_of(judgement.rate, judgement.verdict) for judgement in judgements],
        [movement.turn for movement in fittings.movements],
        [movement.point for movement in fittings.movements],
        [leaving[point] for point in range(len(graph.position))],
    )


def cost_of(rate: float, verdict: Verdict = "navigable") -> float:
    """Minus the logarithm of a rate; infinite where the robot does not pass, or nobody knows."""
    return -math.log(rate) if verdict == "navigable" and rate > 0 else math.inf


def _impossible_segments(diameter: Floats, robot: RobotSpec) -> dict[int, str]:
    """Segments into which no robot of a shape fits, and why."""
    reasons = {bore: part_too_large(robot, bore) for bore in set(diameter[~np.isnan(diameter)].tolist())}
    return {s: reasons[bore] for s, bore in enumerate(diameter.tolist()) if reasons.get(bore)}


def _unknown_segments(
    diameter: Floats, climb: Floats, length: Floats, trained: Trained, accuracy: float
) -> dict[int, str]:
    """Segments in which nobody knows whether the robot drives, and why."""
    low, high = trained.bores_mm
    unknown: dict[int, str] = {}
    steep = np.degrees(np.arcsin(np.clip(np.abs(climb), 0, 1)))
    steep = np.maximum(steep - np.degrees(accuracy * math.sqrt(2) / np.maximum(length, 1e-6)), 0.0)
    for s, bore in enumerate(diameter.tolist()):
        if math.isnan(bore):
            unknown[s] = "its bore is not known"
        elif not low <= nominal_bore(bore) <= high:
            unknown[s] = f"a bore of {bore * 1e3:.4g} mm: the policy was trained in {low:g}-{high:g} mm"
        elif not trained.inclined and nominal_incline(float(steep[s])):
            unknown[s] = f"it climbs by {steep[s]:.1f} deg: the policy was trained in level pipes"
    return unknown


def geometry_accuracy(geometry: Geometry, fabricated: bool) -> float:
    """Accuracy of positions: none is assumed of a map that was drawn to be built from [m]."""
    return 0.0 if fabricated else geometry.accuracy
