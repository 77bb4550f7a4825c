"""Fittings of the mains: bends, joints, reducers, tees, crosses and ends, with angles, errors and classes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations, pairwise
from typing import Literal, NamedTuple

from pipenav.networks.model import BORE_STEP, Origin
from pipenav.pipes.branch_pipes import BRANCH_ANGLE_RANGE_DEG
from pipenav.pipes.corner_checks import ANGLE_RANGE_DEG
from pipenav.survey.classes import (
    ANGLE_STEP_DEG,
    TEE_STEP_DEG,
    FittingClass,
    angles_within,
    nominal_bore,
    nominal_incline,
    nominal_radius,
)
from pipenav.survey.graph import MainsGraph

FeatureKind = Literal["bend", "joint", "reducer", "tee", "cross", "junction", "end"]

CORNER_DEG = 2.5
"""Turn from which two pipes make a bend: half a step of the classes."""

NO_RUN_DEG = 150.0
"""Angle that the two pipes of a run make at least; a fitting without such a pair is no tee that can be tried."""

LARGEST_ERROR_DEG = 60.0
"""Largest error of an angle that is told: beyond, nothing is known of it."""


Vector = Sequence[float]
"""A unit vector, (3,): plain numbers, as numpy takes its time for so few."""


class Geometry(NamedTuple):
    """Settings by which fittings are told from a map.

    Attributes:
        accuracy: standard deviation of a point's position on each axis [m].
        bend_radius: radius of bends whose radius is not stated [bores], 0 for mitres.
    """

    accuracy: float = 0.25
    bend_radius: float = 0.0


class Movement(NamedTuple):
    """A passage through a fitting, from one segment into another.

    Attributes:
        point: point of the fitting.
        into: directed segment by which the robot comes, 2 s or 2 s + 1 where it goes against the segment's direction.
        out: directed segment by which it leaves.
        turn: change of direction [rad].
        classes: classes within the error, the likeliest first; none where the fitting fits no class.
        reason: why there is no class.
    """

    point: int
    into: int
    out: int
    turn: float
    classes: tuple[FittingClass, ...]
    reason: str = ""


class Feature(NamedTuple):
    """A fitting.

    Attributes:
        point: point of the graph.
        kind: kind of the fitting.
        angle_deg: interior angle of a bend; of a tee or cross the one of its branch; 180 for what goes straight on.
        error_deg: standard error of that angle.
        bores: inner diameters of its pipes, NaN where none is known [m].
        legs: lengths of its pipes [m].
        incline_deg: steepest inclination of its pipes, less the standard error of that.
        radius: radius of a bend [m], 0 for a mitre.
        radius_origin: where the radius came from.
        taps: number of services that leave here.
    """

    point: int
    kind: FeatureKind
    angle_deg: float
    error_deg: float
    bores: tuple[float, ...]
    legs: tuple[float, ...]
    incline_deg: float
    radius: float
    radius_origin: Origin
    taps: int


@dataclass(frozen=True)
class Fittings:
    """All fittings of a graph and the passages through them."""

    graph: MainsGraph
    features: tuple[Feature, ...]
    movements: tuple[Movement, ...]


class _At(NamedTuple):
    """The pipes at a point: segments, unit vectors away from it, bores, lengths, and directed segments away."""

    point: int
    segments: list[int]
    away: list[Vector]
    bores: list[float]
    legs: list[float]
    leaving: list[int]


def fittings_of(graph: MainsGraph, geometry: Geometry) -> Fittings:
    """All fittings of a graph."""
    features: list[Feature] = []
    movements: list[Movement] = []
    for at in _pipes_at_points(graph):
        feature = _feature(graph, at, geometry)
        features.append(feature)
        movements += _movements(at, feature)
    return Fittings(graph, tuple(features), tuple(movements))


def _pipes_at_points(graph: MainsGraph) -> Iterator[_At]:
    """The pipes at each point, point by point."""
    near, ends = graph.incidence, graph.ends[:, 0].tolist()
    along = graph.directions()
    directions, against = along.tolist(), (-along).tolist()
    diameter, length = graph.diameter.tolist(), graph.length.tolist()
    for point, (first, last) in enumerate(pairwise(near.first.tolist())):
        segments = near.segments[first:last].tolist()
        forwards = [ends[s] == point for s in segments]
        yield _At(
            point,
            segments,
            [directions[s] if ahead else against[s] for s, ahead in zip(segments, forwards, strict=True)],
            [diameter[s] for s in segments],
            [length[s] for s in segments],
            [2 * s + (not ahead) for s, ahead in zip(segments, forwards, strict=True)],
        )


def _feature(graph: MainsGraph, at: _At, geometry: Geometry) -> Feature:
    count = len(at.segments)
    pair = _run(at) if count > 1 else (0, 0)
    angle = math.degrees(_interior(at.away[pair[0]], at.away[pair[1]])) if count > 1 else 180.0
    kind: FeatureKind = "end" if count == 1 else "junction"
    others = [i for i in range(count) if i not in pair]
    if count == 2:
        changed = abs(at.bores[0] - at.bores[1]) >= BORE_STEP
        kind = "reducer" if changed else "bend" if 180 - angle >= CORNER_DEG else "joint"
    elif count in (3, 4) and angle >= NO_RUN_DEG:
        kind = "tee" if count == 3 else "cross"
    worst = pair if not others else (pair[0], others[0])
    if others:
        angle = math.degrees(_interior(at.away[worst[0]], at.away[worst[1]]))
    radius, origin = _radius(graph, at, geometry)
    incline = _incline(at, geometry.accuracy)
    error = angle_error(at.legs[worst[0]], at.legs[worst[1]], geometry.accuracy) if count > 1 else 0.0
    bores, legs = tuple(at.bores), tuple(at.legs)
    taps = int(graph.taps[at.point])
    return Feature(at.point, kind, angle, error, bores, legs, incline, radius, origin, taps)


def angle_error(one: float, other: float, accuracy: float) -> float:
    """Standard error of the angle between two legs whose three points are off independently, at most 60 [deg].

    The two far points turn their own legs, the common point turns both against each other. To the first order the
    variance is accuracy^2 (1/a^2 + 1/b^2 + (1/a + 1/b)^2) for a straight line, which is the worst case.

    Args:
        one, other: lengths of the legs [m].
        accuracy: standard deviation of a point on each axis [m].
    """
    inverse, more = 1 / max(one, 1e-6), 1 / max(other, 1e-6)
    turned = accuracy * math.sqrt(inverse**2 + more**2 + (inverse + more) ** 2)
    return min(math.degrees(turned), LARGEST_ERROR_DEG)


def _incline(at: _At, accuracy: float) -> float:
    """Steepest inclination of the pipes at a point, less the standard error that two heights put on it [deg]."""
    worst = 0.0
    for away, leg in zip(at.away, at.legs, strict=True):
        steepness = math.degrees(math.asin(min(abs(away[2]), 1.0)))
        worst = max(worst, steepness - math.degrees(accuracy * math.sqrt(2) / max(leg, 1e-6)))
    return worst


def _radius(graph: MainsGraph, at: _At, geometry: Geometry) -> tuple[float, Origin]:
    """Radius of the bend at a point [m], and where it came from."""
    node = int(graph.node[at.point])
    if node >= 0 and not math.isnan(graph.network.bend_radius[node]):
        return float(graph.network.bend_radius[node]), Origin(int(graph.network.radius_origin[node]))
    bore = min(at.bores)
    return (0.0 if math.isnan(bore) else geometry.bend_radius * bore), Origin.ASSUMED


def _interior(one: Vector, other: Vector) -> float:
    """Interior angle between two pipes from the unit vectors away from their point [rad]."""
    (a, b, c), (d, e, f) = one, other
    return math.atan2(math.hypot(b * f - c * e, c * d - a * f, a * e - b * d), a * d + b * e + c * f)


def _run(at: _At) -> tuple[int, int]:
    """The two pipes that are nearest to one line."""
    pairs = combinations(range(len(at.away)), 2)
    return max(pairs, key=lambda pair: _interior(at.away[pair[0]], at.away[pair[1]]))


def _movements(at: _At, feature: Feature) -> Iterable[Movement]:
    """The passages through a fitting, each way."""
    if len(at.segments) == 2:
        return _two_movements(at, feature)
    return _branched_movements(at, feature) if len(at.segments) > 2 else ()


def _two_movements(at: _At, feature: Feature) -> list[Movement]:
    """The passages between two pipes; in one bore, both ways are of the same classes."""
    interior = _interior(at.away[0], at.away[1])
    one = classes = _two_pipes(at, feature, (0, 1), math.degrees(interior))
    if at.bores[0] != at.bores[1]:
        classes = _two_pipes(at, feature, (1, 0), math.degrees(interior))
    (first, last), turn = at.leaving, math.pi - interior
    return [
        Movement(at.point, first ^ 1, last, turn, *one),
        Movement(at.point, last ^ 1, first, turn, *classes),
    ]


def _branched_movements(at: _At, feature: Feature) -> Iterator[Movement]:
    """The passages through a fitting of more than two pipes."""
    run = _run(at)
    for i, leaving in enumerate(at.leaving):
        for j, out in enumerate(at.leaving):
            if i == j:
                continue
            interior = _interior(at.away[i], at.away[j])
            classes, reason = _branched(at, feature, (i, j), run)
            yield Movement(at.point, leaving ^ 1, out, math.pi - interior, classes, reason)


Classes = tuple[tuple[FittingClass, ...], str]


def _two_pipes(at: _At, feature: Feature, way: tuple[int, int], angle: float) -> Classes:
    """Classes of a passage between two pipes: a bend and, where the bore changes, a reducer beside it."""
    before, after = (at.bores[i] for i in way)
    if math.isnan(before) or math.isnan(after):
        return (), "its bore is not known"
    if angle + feature.error_deg < ANGLE_RANGE_DEG[0] - ANGLE_STEP_DEG / 2:
        return (), f"a corner of {angle:.0f} deg cannot be tried, only {ANGLE_RANGE_DEG[0]:g} deg and more"
    incline, narrow = nominal_incline(feature.incline_deg), nominal_bore(min(before, after))
    radius = nominal_radius(feature.radius / min(before, after))
    bends = _bends(narrow, tuple(angles_within(angle, feature.error_deg)), radius, incline)
    first, last = nominal_bore(before), nominal_bore(after)
    if first != last:
        bends = (*bends, FittingClass("reducer", first, to_mm=last, incline_deg=incline))
    return bends, ""


@cache
def _bends(bore: float, angles: tuple[float, ...], radius: float, incline: float) -> tuple[FittingClass, ...]:
    """Classes of bends of one bore and radius; a straight pipe has no radius."""
    return tuple(FittingClass("bend", bore, a, 0.0, radius if a < 180 else 0.0, "", incline) for a in angles)


def _branched(at: _At, feature: Feature, way: tuple[int, int], run: tuple[int, int]) -> Classes:
    """Classes of a passage through a tee or a cross."""
    if feature.kind not in ("tee", "cross"):
        return (), "its pipes make no tee or cross that can be tried"
    if any(math.isnan(bore) for bore in at.bores):
        return (), "its bore is not known"
    others = [k for k in range(len(at.bores)) if k not in run]
    if set(way) == set(others):  # across a cross, from branch to branch: they are a run themselves
        run, others = (others[0], others[1]), list(run)
    trunk = nominal_bore(min(at.bores[k] for k in run))
    branch = others[0] if set(way) == set(run) else next(k for k in way if k in others)
    bore = nominal_bore(max(at.bores[k] for k in others) if set(way) == set(run) else at.bores[branch])
    if bore > trunk:
        return (), "a branch is wider than the run"
    name = "straight" if set(way) == set(run) else "into" if way[1] == branch else "out"
    seen = way[1] if name == "out" else way[0]
    angle = math.degrees(_interior(at.away[seen], at.away[branch]))
    low, high = BRANCH_ANGLE_RANGE_DEG
    if not low - TEE_STEP_DEG / 2 <= angle <= high + TEE_STEP_DEG / 2:
        return (), f"a branch at {angle:.0f} deg cannot be tried, only {low:g} to {high:g} deg"
    kind: Literal["tee", "cross"] = "tee" if feature.kind == "tee" else "cross"
    incline = nominal_incline(feature.incline_deg)
    return tuple(
        FittingClass(kind, trunk, a, to_mm=bore, way=name, incline_deg=incline)
        for a in angles_within(angle, feature.error_deg, tee=True)
    ), ""
