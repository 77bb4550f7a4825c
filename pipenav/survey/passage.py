"""Passages through a network as a robot with a cable meets them: rates, lengths, turns and slopes for a search."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.robots.cable import CABLE_WEIGHT, PVC_FRICTION
from pipenav.survey.classes import FittingClass, nominal_bore, nominal_incline
from pipenav.survey.features import Fittings, Geometry, Movement
from pipenav.survey.trials import Trained, Trial, Verdict

LIFTED = ("tether", "bends", "tees", "reducers", "bores", "slopes", "confidence", "unknown")
"""Limits that can be lifted, to see what each of them costs."""


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
        rate: probability of passing; NaN where it is unknown.
        low: lower end of the 95 % interval of that probability; NaN where it is unknown.
        verdict: the word for it.
        worst: class that decides; None where there is none.
        reason: why it is unknown, in words.
    """

    rate: float
    low: float
    verdict: Verdict
    worst: FittingClass | None
    reason: str


def judged(movement: Movement, trials: Mapping[FittingClass, Trial], confidence: float) -> Judged:
    """The judgement of a movement: by the worst class within its error; a reducer beside a bend multiplies."""
    if not movement.classes:
        return Judged(math.nan, math.nan, "unknown", None, movement.reason)
    groups = [[kind for kind in movement.classes if kind.kind == "reducer"]]
    groups.append([kind for kind in movement.classes if kind.kind != "reducer"])
    rate, low, verdicts, decisive = 1.0, 1.0, set(), None
    for group in filter(None, groups):
        tried = [kind for kind in group if trials[kind].episodes]
        if not trials[group[0]].episodes or len(tried) < len(group):
            kind = next(kind for kind in group if not trials[kind].episodes)
            failing = [k for k in tried if trials[k].verdict(confidence) == "not navigable"]
            if not failing:
                return Judged(math.nan, math.nan, "unknown", kind, trials[kind].reason)
        worst = min(tried, key=lambda kind: (trials[kind].successes / trials[kind].episodes, trials[kind].interval.low))
        trial = trials[worst]
        rate, low = rate * trial.successes / trial.episodes, low * (1.0 if worst.straight else trial.interval.low)
        verdicts.add(trial.verdict(confidence))
        if decisive is None or trial.successes < trial.episodes:
            decisive = worst
    word: Verdict = "navigable"
    word = "not navigable" if "not navigable" in verdicts else "unknown" if "unknown" in verdicts else word
    reason = "" if word != "unknown" else "its trials leave open whether it passes often enough: try more --episodes"
    return Judged(rate, low, word, decisive, reason)


class Ways(NamedTuple):
    """Everything that a search for reach asks, for 2 s directed segments and m movements.

    Attributes:
        length: length of each segment, (s,) [m].
        climb: sine of each segment's inclination in its own direction, (s,).
        passable: whether a robot may drive in the segment, (s,).
        unknown: reasons why it may not, by segment.
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
    onward: list[list[tuple[int, int]]]
    cost: list[float]
    turn: list[float]
    point: list[int]
    leaving: list[list[int]]

    def lifted(self, fittings: Fittings, judgements: list[Judged], limit: str) -> Ways:
        """The ways as they would be without one limit, see `LIFTED`; the tether is none of the ways'."""
        kinds = {"bends": ("bend",), "tees": ("tee", "cross"), "reducers": ("reducer",)}
        cost, passable = list(self.cost), self.passable
        for i, (movement, judgement) in enumerate(zip(fittings.movements, judgements, strict=True)):
            lifted = {kind.kind for kind in movement.classes if not kind.straight} & set(kinds.get(limit, ()))
            if lifted or (limit == "unknown" and judgement.verdict == "unknown"):
                cost[i] = 0.0
        if limit in ("bores", "slopes", "unknown"):
            named = {"bores": "bore", "slopes": "climbs", "unknown": ""}[limit]
            passable = passable.copy()
            passable[[s for s, reason in self.unknown.items() if named in reason]] = True
            cost = [
                0.0 if judgement.verdict == "unknown" and named in judgement.reason else c
                for c, judgement in zip(cost, judgements, strict=True)
            ]
        return self._replace(cost=cost, passable=passable)


def ways_of(fittings: Fittings, judgements: list[Judged], trained: Trained, accuracy: float) -> Ways:
    """The ways through a network."""
    graph = fittings.graph
    climb = graph.directions()[:, 2]
    unknown = _unknown_segments(graph.diameter, climb, graph.length, trained, accuracy)
    passable = np.ones(len(graph.length), bool)
    passable[list(unknown)] = False
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
        onward,
        [cost_of(judgement.rate, judgement.verdict) for judgement in judgements],
        [movement.turn for movement in fittings.movements],
        [movement.point for movement in fittings.movements],
        [leaving[point] for point in range(len(graph.position))],
    )


def cost_of(rate: float, verdict: Verdict = "navigable") -> float:
    """Minus the logarithm of a rate; infinite where the robot does not pass, or nobody knows."""
    return -math.log(rate) if verdict == "navigable" and rate > 0 else math.inf


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
