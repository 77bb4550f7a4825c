"""Routes from the entries to the far ends that the robot sees, as files that gen-pipe, eval and view take."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.networks.model import BORE_STEP
from pipenav.pipes.network import NetworkNode, NetworkPipe, PipeNetwork
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import MAX_CORNERS, CrossesItself
from pipenav.survey.features import CORNER_DEG
from pipenav.survey.reach import Label, way_to
from pipenav.survey.survey import Survey
from pipenav.units import m_to_mm, rad_to_deg

SHORTENED = (1.5, 3.0, 6.0, 12.0)
"""Lengths to which straights are shortened [m]: the first at which no two legs meet."""


class FarRoute(NamedTuple):
    """A route to a far end.

    Attributes:
        name: name of its file.
        text: content of its file; empty where it cannot be made.
        problem: why it cannot be made.
    """

    name: str
    text: str
    problem: str


def far_routes(result: Survey) -> list[FarRoute]:
    """A route for each end of the robot's ways; ways without a corner are left out."""
    made = {}
    for label in _last_labels(result):
        points, bores = _corners_of(result, label)
        if len(points) < 3:
            continue
        name = _file_name(f"{result.graph.name_of(points[0])}-to-{result.graph.name_of(points[-1])}")
        try:
            route = shortened_route(result, points, bores)
            way = f"from {result.graph.name_of(points[0])} to {result.graph.name_of(points[-1])}"
            text = route_toml(route, f"{way}, straights shortened, no branches")
            made[name] = FarRoute(name, text, "")
        except PipenavError as error:
            made.setdefault(name, FarRoute(name, "", str(error)))
    return list(made.values())


def _last_labels(result: Survey) -> Iterator[Label]:
    """Labels whose segment is seen to its end and from which no way goes on."""
    gone_on = {
        id(label.before) for labels in result.reach.labels.values() for label in labels if label.before is not None
    }
    for directed, labels in result.reach.labels.items():
        whole = result.reach.far[directed] >= result.graph.length[directed >> 1] - 1e-6
        if whole and id(labels[0]) not in gone_on:
            yield labels[0]


def _corners_of(result: Survey, label: Label) -> tuple[list[int], list[float]]:
    """Points of a way at which it bends or changes its bore, ends included, and the bore of each leg [m]."""
    graph, way = result.graph, way_to(label)
    points = [int(graph.ends[directed >> 1, directed & 1]) for directed in way]
    last = int(way[-1])
    points.append(int(graph.ends[last >> 1, 1 - (last & 1)]))
    all_bores = [float(graph.diameter[directed >> 1]) for directed in way]
    kept, bores = [points[0]], [all_bores[0]]
    for i in range(1, len(points) - 1):
        before, after = graph.position[points[i]] - graph.position[kept[-1]], graph.position[points[i + 1]]
        turn = _angle(before, after - graph.position[points[i]])
        if turn >= math.radians(CORNER_DEG) or abs(all_bores[i] - bores[-1]) >= BORE_STEP:
            kept.append(points[i])
            bores.append(all_bores[i])
    return [*kept, points[-1]], bores


def _angle(one: Floats, other: Floats) -> float:
    return math.atan2(float(np.linalg.norm(np.cross(one, other))), float(one @ other))


def shortened_route(result: Survey, points: list[int], bores: list[float]) -> PipeRoute:
    """The route through some points with straights no longer than a robot needs.

    Args:
        result: the survey.
        points: points of the graph, ends included.
        bores: inner diameters of the legs [m].

    Raises:
        PipenavError: it is no route that can be made.
    """
    if len(points) - 2 > MAX_CORNERS:
        raise PipenavError(f"it has {len(points) - 2} corners, more than the {MAX_CORNERS} of a route.")
    steps = np.diff(result.graph.position[points], axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    names = [f"p{i}" for i in range(len(points))]
    for longest in SHORTENED:
        scale = np.minimum(longest / lengths, 1.0)
        places = np.concatenate([np.zeros((1, 3)), np.cumsum(steps * scale[:, None], axis=0)])
        nodes = {
            name: NetworkNode(position=tuple(place.tolist()), bend_radius=_radius(result, point, bores[i - 1 : i + 1]))
            for i, (name, place, point) in enumerate(zip(names, places, points, strict=True))
        }
        pipes = [NetworkPipe(start=a, end=b, diameter=d) for a, b, d in zip(names[:-1], names[1:], bores, strict=True)]
        try:
            return PipeNetwork(nodes=nodes, pipes=tuple(pipes)).route(names)
        except CrossesItself:
            if longest == SHORTENED[-1]:
                raise
    raise AssertionError("the last length returns or raises")


def _radius(result: Survey, point: int, beside: list[float]) -> float:
    """Radius of the bend at a point [m]; a reducer, and an end, have none."""
    if len(beside) < 2 or abs(beside[0] - beside[1]) >= BORE_STEP:
        return 0.0
    return float(result.fittings.features[point].radius)


def route_toml(route: PipeRoute, description: str) -> str:
    """A route without branches as a route file (docs/formats/route-folder.md), in tenths: no map knows more."""
    lines = [
        "schema = 3",
        f"description = {_quoted(description)}",
        f"diameter_mm = {_tenths(m_to_mm(route.diameter))}",
        f"slope_deg = {_tenths(rad_to_deg(route.slope))}",
        f"first_straight_mm = {_tenths(m_to_mm(route.straights[0]))}",
    ]
    for corner, straight in zip(route.corners, route.straights[1:], strict=True):
        lines.append("\n[[corners]]")
        if corner.reducer and corner.to_diameter is not None:
            lines += [f"to_diameter_mm = {_tenths(m_to_mm(corner.to_diameter))}"]
        else:
            lines += [f"angle_deg = {_tenths(rad_to_deg(corner.angle))}", f'turn = "{corner.turn}"']
            lines += [
                f"roll_deg = {_tenths(rad_to_deg(corner.roll))}",
                f"bend_radius_mm = {_tenths(m_to_mm(corner.bend_radius))}",
            ]
        lines.append(f"straight_mm = {_tenths(m_to_mm(straight))}")
    return "\n".join(lines) + "\n"


def _tenths(value: float) -> str:
    return f"{round(value, 1) + 0.0:g}"  # no -0


def _quoted(text: str) -> str:
    return '"' + re.sub(r'["\\\x00-\x1f\x7f]', "?", text) + '"'


def _file_name(text: str) -> str:
    return re.sub(r"[^\w.+-]+", "-", text).strip("-.")[:100] + ".toml"
