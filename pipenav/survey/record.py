"""The record of a survey, `survey.json`, as plain tables. docs/formats/survey.md describes it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

import pipenav
from pipenav.networks.model import Origin
from pipenav.survey.classes import FittingClass
from pipenav.survey.features import Feature
from pipenav.survey.findings import Finding
from pipenav.survey.passage import Judged
from pipenav.survey.reach import Label
from pipenav.survey.sensitivity import Sensitivity
from pipenav.survey.survey import Survey
from pipenav.survey.trials import Trials

SCHEMA = 2

PARTLY_SEEN = 0.01
"""Length from which a pipe counts as partly seen [m]."""


class Subject(NamedTuple):
    """Origin of a survey: its map and its trials.

    Attributes:
        file: file of the network.
        trials: the policy's trials.
        sensitivity: rows of the table.
    """

    file: str
    trials: Trials
    sensitivity: Sequence[Sensitivity]


def survey_record(result: Survey, subject: Subject) -> dict[str, Any]:
    """All of a survey; numbers that are not known are None."""
    order = {kind: i for i, kind in enumerate(result.findings)}
    return {
        "schema": SCHEMA,
        "pipenav": pipenav.__version__,
        "network": {"file": subject.file, "format": result.graph.network.source},
        **_settings(result, subject.trials),
        "totals_m": {name: round(value, 3) for name, value in result.totals._asdict().items()},
        "entries": _entries(result),
        "without_limit_m": {name: round(value, 3) for name, value in result.without.items()},
        "sensitivity": [{key: _finite(value) for key, value in row._asdict().items()} for row in subject.sensitivity],
        "classes": [_class(kind, finding, result.config.confidence) for kind, finding in result.findings.items()],
        "blockers": [
            {
                "feature": blocker.point,
                "behind_m": round(blocker.behind, 3),
                "verdict": blocker.judgement.verdict,
                "class": None if blocker.judgement.worst is None else blocker.judgement.worst.name,
                "cause": blocker.judgement.cause,
                "geometry": blocker.judgement.geometry,
                "reason": blocker.judgement.reason,
            }
            for blocker in result.blockers
        ],
        "notes": [{**note._asdict(), "examples": list(note.examples)} for note in result.notes],
        "features": _features(result, order),
        "segments": _segments(result),
    }


def _settings(result: Survey, trials: Trials) -> dict[str, Any]:
    """The policy, the simulation and the settings of a survey."""
    config, tether = result.config, result.config.tether
    return {
        "policy": {
            "name": trials.config.policy,
            "sha256": trials.policy_hash,
            "robot": trials.robot.name,
            "ideal": trials.config.ideal,
            "trained_bores_mm": list(trials.trained.bores_mm),
            "trained_sharpest_deg": round(trials.trained.sharpest_deg, 3),
        },
        "simulation": {
            "backend": trials.config.backend,
            "options": dict(trials.config.options),
            "episodes": trials.config.episodes,
            "seed": trials.config.seed,
        },
        "settings": {
            "accuracy_m": config.geometry.accuracy,
            "bend_radius_bores": config.geometry.bend_radius,
            "confidence": config.confidence,
            "cable_m": _finite(tether.cable),
            "pull_n": tether.pull,
            "friction": tether.friction,
            "cable_weight_n_per_m": tether.weight,
        },
    }


def _class(kind: FittingClass, finding: Finding, confidence: float) -> dict[str, Any]:
    """A class with its trial, which a straight pipe has none of, and geometry's word."""
    trial = finding.trial
    tried = trial.episodes > 0 and not trial.assumed
    return {
        "name": kind.name,
        **kind._asdict(),
        "episodes": trial.episodes if tried else 0,
        "successes": trial.successes if tried else 0,
        "interval": [round(end, 4) for end in trial.interval] if tried else None,
        "failures": trial.failures,
        "trial_reason": trial.reason,
        "geometry": finding.geometry.kind,
        "geometry_reason": finding.geometry.reason,
        "verdict": finding.verdict(confidence),
        "cause": finding.cause(confidence),
        "reason": finding.reason(confidence),
    }


def _entries(result: Survey) -> dict[str, Any]:
    proposal = result.proposal
    points = [
        {"feature": point, "node": result.graph.name_of(point), "position_m": _position(result, point)}
        for point in result.entries
    ]
    if proposal is None:
        return {"given": True, "points": points}
    for point, seen in zip(points, proposal.seen, strict=True):
        point["seen_with_all_so_far_m"] = round(seen, 3)
    return {
        "given": False,
        "points": points,
        "target_m": None if proposal.target is None else round(proposal.target, 3),
        "target_met": proposal.reached,
        "least_possible": proposal.least,
        "candidates": proposal.candidates,
    }


def _features(result: Survey, order: dict[Any, int]) -> list[dict[str, Any]]:
    passages: list[list[tuple[int, Judged]]] = [[] for _ in result.fittings.features]
    for i, judgement in enumerate(result.judgements):
        passages[result.fittings.movements[i].point].append((i, judgement))
    distances = arrivals(result)
    made = []
    for feature in result.fittings.features:
        here = passages[feature.point]
        arrival = distances.get(feature.point)
        worst = _worst([judgement for _, judgement in here])
        made.append(
            {
                "id": feature.point,
                "name": result.graph.name_of(feature.point),
                "kind": feature.kind,
                "position_m": _position(result, feature.point),
                "height": _height_origin(result, feature.point),
                "angle_deg": round(feature.angle_deg, 2),
                "angle_error_deg": round(feature.error_deg, 2),
                "radius_mm": round(feature.radius * 1e3, 1),
                "radius": feature.radius_origin.label,
                "bores_mm": [_rounded(bore * 1e3, 1) for bore in feature.bores],
                "legs_m": [round(leg, 2) for leg in feature.legs],
                "incline_deg": round(feature.incline_deg, 2),
                "taps": feature.taps,
                "verdict": worst.verdict,
                "cause": worst.cause,
                "reason": worst.reason,
                "distance_m": None if arrival is None else round(arrival.distance, 2),
                "entry": None if arrival is None else arrival.entry,
                "passages": _passages(result, feature, here, order),
            }
        )
    return made


def _passages(
    result: Survey, feature: Feature, here: list[tuple[int, Judged]], order: dict[Any, int]
) -> list[dict[str, Any]]:
    """The different passages through a fitting; a joint's need no words."""
    if feature.kind == "joint" and all(judgement.verdict == "navigable" for _, judgement in here):
        return []
    made: list[dict[str, Any]] = []
    for i, judgement in here:
        movement = result.fittings.movements[i]
        if movement.into >> 1 > movement.out >> 1 and feature.kind == "bend":
            continue  # the same bend from its other side
        made.append(
            {
                "from": movement.into >> 1,
                "to": movement.out >> 1,
                "turn_deg": round(math.degrees(movement.turn), 1),
                "verdict": judgement.verdict,
                "cause": judgement.cause,
                "geometry": judgement.geometry,
                "rate": _rounded(judgement.rate, 4),
                "rate_low": _rounded(judgement.low, 4),
                "class": None if judgement.worst is None else order[judgement.worst],
                "classes": [order[kind] for kind in movement.classes],
                "reason": judgement.reason,
            }
        )
    return made


def _segments(result: Survey) -> list[dict[str, Any]]:
    graph, network = result.graph, result.graph.network
    length, seen = graph.length.tolist(), result.seen.tolist()
    return [
        {
            "line": network.line_names[line],
            "ends": graph.ends[s].tolist(),
            "length_m": round(length[s], 3),
            "length": Origin(int(network.length_origin[line])).label,
            "bore_mm": _rounded(graph.diameter[s] * 1e3, 1),
            "bore": Origin(int(network.diameter_origin[line])).label,
            "seen_m": round(seen[s], 3),
            "status": status(result, s),
            "reason": result.ways.unknown.get(s) or result.ways.impossible.get(s, ""),
            "cause": "untried" if s in result.ways.unknown else "impossible" if s in result.ways.impossible else "",
        }
        for s, line in enumerate(graph.line.tolist())
    ]


def status(result: Survey, segment: int) -> str:
    """`inspectable`, `partly`, `unknown` or `blocked`: what a pipe is on the map."""
    length, seen = float(result.graph.length[segment]), float(result.seen[segment])
    if seen >= length - PARTLY_SEEN:
        return "inspectable"
    if seen > PARTLY_SEEN:
        return "partly"
    might = float(result.optimistic[segment]) > PARTLY_SEEN or segment in result.ways.unknown
    return "unknown" if might else "blocked"


class Arrival(NamedTuple):
    """Length of cable at which the robot comes to a point [m], and the point at which it went in."""

    distance: float
    entry: int


def arrivals(result: Survey) -> dict[int, Arrival]:
    """The shortest way to each point that the robot comes to."""
    found = {point: Arrival(0.0, point) for point in result.entries}
    ends = result.graph.ends
    for directed, labels in result.reach.labels.items():
        segment = directed >> 1
        if result.reach.far[directed] < result.graph.length[segment] - PARTLY_SEEN:
            continue
        point = int(ends[segment, 1 - (directed & 1)])
        label = labels[0]
        distance = label.distance + float(result.graph.length[segment])
        if point not in found or distance < found[point].distance:
            found[point] = Arrival(distance, _root(label, ends))
    return found


def _root(label: Label, ends: Any) -> int:
    while label.before is not None:
        label = label.before
    return int(ends[label.directed >> 1, label.directed & 1])


END = Judged(1.0, 1.0, "navigable", None, "", "", "passable")
"""Judgement that stands for a fitting without passages: an end."""


def _worst(judgements: list[Judged]) -> Judged:
    """The worst of some judgements: impossible before all, then what the policy does not pass, then what is unknown."""
    order = {"not navigable": 1, "unknown": 2, "navigable": 3}
    return min(
        judgements,
        key=lambda judgement: 0 if judgement.cause == "impossible" else order[judgement.verdict],
        default=END,
    )


def _height_origin(result: Survey, point: int) -> str:
    node = int(result.graph.node[point])
    return "derived" if node < 0 else Origin(int(result.graph.network.height_origin[node])).label


def _position(result: Survey, point: int) -> list[float]:
    return [round(value, 3) for value in result.graph.position[point].tolist()]


def _rounded(value: float, digits: int) -> float | None:
    return round(float(value), digits) if np.isfinite(value) else None


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
