"""An oracle of the free space of pipes: signed distances by formulas of its own, from nodes, bores and bends alone.

Nothing of the package's geometry is used: a network gives its nodes and pipes, a route its angles, from which the nodes
follow here. The free space is the union of cylinders cut at mitres, pieces of tori, cones, and halves of cylinders from
the crossing of a fitting's axes. Distances are right in sign, and never larger than the true one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.pipes.network import PipeNetwork
from pipenav.pipes.route import PipeRoute

IN_LINE = 1e-6
"""Angle within which two pipes are in line [rad]."""


class Node(NamedTuple):
    """Position (3,) [m], radius of the bend and length of the reducer there [m], and whether a cap closes it."""

    position: Floats
    bend: float = 0.0
    reducer: float = 0.0
    capped: bool = False


class StraightPipe(NamedTuple):
    """Names of its two nodes, and the radius of its bore [m]."""

    start: str
    end: str
    radius: float


class _End(NamedTuple):
    """Plane that ends a cylinder: a point, the normal outwards, and whether it is a wall rather than a seam."""

    point: Floats
    outwards: Floats
    wall: bool


class _Torus(NamedTuple):
    """Bend: its centre, the directions in which it begins and from the centre to its beginning, and its numbers."""

    centre: Floats
    along: Floats
    away: Floats
    bend: float
    turn: float
    radius: float


class _Cone(NamedTuple):
    """Reducer: its middle, direction from the wide pipe to the narrow one, length, and radii."""

    middle: Floats
    along: Floats
    length: float
    wide: float
    narrow: float


class PipeOracle:
    """Signed distances to the free space of pipes.

    Args:
        nodes: nodes by name.
        pipes: straight pipes between them.
        wall: thickness of the wall [m].
    """

    def __init__(self, nodes: Mapping[str, Node], pipes: Sequence[StraightPipe], wall: float) -> None:
        self.nodes, self.pipes, self.wall = dict(nodes), list(pipes), wall

    @classmethod
    def of_network(cls, network: PipeNetwork) -> PipeOracle:
        """The oracle of a network."""
        nodes = {
            name: Node(np.array(node.position), node.bend_radius, node.length, node.capped)
            for name, node in network.nodes.items()
        }
        pipes = [StraightPipe(pipe.start, pipe.end, pipe.diameter / 2) for pipe in network.pipes]
        return cls(nodes, pipes, network.wall)

    @classmethod
    def of_route(cls, route: PipeRoute) -> PipeOracle:
        """The oracle of a route: walked leg by leg, its first corner at the origin, the first leg along x."""
        along, left, up = np.eye(3)
        at, radius = np.array([-route.straights[0], 0.0, 0.0]), route.diameter / 2
        nodes, pipes = {"0": Node(at)}, []
        for i, (corner, length) in enumerate(zip(route.corners, route.straights, strict=False)):
            at = at + length * along
            here = str(i + 1)
            nodes[here] = Node(at, corner.bend_radius, corner.length)
            pipes.append(StraightPipe(str(i), here, radius))
            for j, branch in enumerate(corner.branches):
                out = _turned((along, left, up), branch.roll, branch.turn, branch.angle)[0]
                nodes[f"{here}-{j}"] = Node(at + branch.length * out, capped=branch.closed)
                pipes.append(StraightPipe(here, f"{here}-{j}", branch.diameter / 2))
            along, left, up = _turned((along, left, up), corner.roll, corner.turn, corner.angle)
            radius = radius if corner.to_diameter is None else corner.to_diameter / 2
        last = len(route.straights)
        nodes[str(last)] = Node(at + route.straights[-1] * along, capped=route.capped)
        pipes.append(StraightPipe(str(last - 1), str(last), radius))
        return cls(nodes, pipes, route.wall)

    def bore(self, points: Floats) -> Floats:
        """Signed distance of points (..., 3) to the free space, negative inside: (...) [m]."""
        return self._distance(np.asarray(points, float), 0.0)

    def outside(self, points: Floats) -> Floats:
        """Signed distance of points (..., 3) to the pipes with their walls and caps: (...) [m]."""
        return self._distance(np.asarray(points, float), self.wall)

    def material(self, points: Floats) -> Floats:
        """Signed distance of points (..., 3) to the wall's material: (...) [m]."""
        return np.maximum(self.outside(points), -self.bore(points))

    def around(self, count: int, rng: np.random.Generator, margin: float = 0.05) -> Floats:
        """Points in and around the pipes, half of them near nodes and half near the bore's surface, (count, 3)."""
        lengths = np.array([self._length(pipe) for pipe in self.pipes])
        chosen = rng.choice(len(self.pipes), count, p=lengths / lengths.sum())
        share = rng.random(count)
        ends = rng.integers(0, 2, count)
        points = np.empty((count, 3))
        for i, pipe in enumerate(self.pipes):
            mine = chosen == i
            start, out = self.nodes[pipe.start].position, self._direction(pipe)
            near = 5 * pipe.radius * share[mine] ** 2
            near = np.where(ends[mine] == 0, near, lengths[i] - near)
            s = np.where(rng.random(mine.sum()) < 0.5, near, share[mine] * (lengths[i] + 2 * margin) - margin)
            normal = rng.normal(size=(mine.sum(), 3))
            normal -= (normal @ out)[:, None] * out
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            surface = rng.normal(pipe.radius + self.wall / 2, self.wall, mine.sum())
            spread = (pipe.radius + 2 * self.wall) * 1.2 * np.sqrt(rng.random(mine.sum()))
            off = np.where(rng.random(mine.sum()) < 0.5, surface, spread)
            points[mine] = start + s[:, None] * out + off[:, None] * normal
        return points

    def wall_volume(self, rng: np.random.Generator, samples: int = 20_000) -> float:
        """Volume of the wall's material [m3]: every part on its own, parts at fittings by samples."""
        total = 0.0
        for node in self.nodes:
            meeting = self._meeting(node)
            if len(meeting) == 1 and self.nodes[node].capped:
                total += math.pi * (meeting[0].radius + self.wall) ** 2 * self.wall
        for torus in self._tori(0.0):  # Pappus
            total += _ring(torus.radius, self.wall) * torus.bend * torus.turn
        for cone in self._cones(0.0):
            mean = (cone.wide + cone.narrow) / 2
            total += _ring(mean, self.wall) * cone.length
        for i, pipe in enumerate(self.pipes):
            if max(len(self._meeting(pipe.start)), len(self._meeting(pipe.end))) > 2:
                total += self._sampled_volume(i, rng, samples)
            else:
                cut = [self._taken(pipe, node) for node in (pipe.start, pipe.end)]
                total += _ring(pipe.radius, self.wall) * (self._length(pipe) - sum(cut))
        return total

    def _sampled_volume(self, number: int, rng: np.random.Generator, samples: int) -> float:
        """Volume of one pipe's wall without the other bores, of which others' walls share what they overlap [m3]."""
        pipe = self.pipes[number]
        start, out, length = self.nodes[pipe.start].position, self._direction(pipe), self._length(pipe)
        beyond = 4 * (pipe.radius + self.wall)  # past a mitre
        s = rng.uniform(-beyond, length + beyond, samples)
        off = np.sqrt(rng.uniform(pipe.radius**2, (pipe.radius + self.wall) ** 2, samples))
        around = rng.uniform(0, 2 * math.pi, samples)
        left = np.cross(out, np.eye(3)[np.abs(out).argmin()])
        left /= np.linalg.norm(left)
        sides = np.cos(around)[:, None] * left + np.sin(around)[:, None] * np.cross(out, left)
        points = start + s[:, None] * out + off[:, None] * sides
        ends = self._ends(pipe, 0.0, seams=False)
        points = points[np.all([(points - end.point) @ end.outwards <= 0 for end in ends], axis=0)]
        shared = np.zeros(len(points))
        for other in self.pipes:
            bore = _cylinder(points, self.nodes[other.start].position, self._direction(other), other.radius)
            within = np.all([(points - end.point) @ end.outwards <= 0 for end in self._ends(other, 0.0, False)], axis=0)
            shared += within & (bore > -1e-12) & (bore <= self.wall + 1e-12)
        material = self.bore(points) >= -1e-12
        share = float((material / np.maximum(shared, 1)).sum()) / samples
        return _ring(pipe.radius, self.wall) * (length + 2 * beyond) * share

    def _distance(self, points: Floats, outside: float) -> Floats:
        nearest = np.full(points.shape[:-1], np.inf)
        for pipe in self.pipes:
            start, out = self.nodes[pipe.start].position, self._direction(pipe)
            value, within = _cylinder(points, start, out, pipe.radius + outside), np.ones(points.shape[:-1], bool)
            for end in self._ends(pipe, outside):
                past = (points - end.point) @ end.outwards
                value = np.maximum(value, past) if end.wall else value
                within &= end.wall | (past <= 0)
            nearest = np.minimum(nearest, np.where(within, value, np.inf))
        for torus in self._tori(outside):
            nearest = np.minimum(nearest, _to_torus(points, torus))
        for cone in self._cones(outside):
            nearest = np.minimum(nearest, _to_cone(points, cone))
        return nearest

    def _ends(self, pipe: StraightPipe, outside: float, seams: bool = True) -> list[_End]:
        return [self._end(pipe, node, outside, seams) for node in (pipe.start, pipe.end)]

    def _end(self, pipe: StraightPipe, name: str, outside: float, seams: bool) -> _End:
        """The end of a pipe at one of its nodes; with seams, a narrow pipe reaches through its reducer."""
        node, out = self.nodes[name], -self._direction(pipe, name)
        others = [other for other in self._meeting(name) if other is not pipe]
        if not others:
            return _End(node.position + (outside if node.capped else 0.0) * out, out, True)
        if len(others) > 1:
            in_line = any(
                _angle(self._direction(other, name), out) < IN_LINE and abs(other.radius - pipe.radius) < 1e-9
                for other in others
            )
            return _End(node.position, out, not in_line)
        (other,) = others
        if other.radius < pipe.radius - 1e-12:
            return _End(node.position - node.reducer / 2 * out, out, True)
        if other.radius > pipe.radius + 1e-12:
            beyond = 0.04 * other.radius + node.reducer / 2 if seams else -node.reducer / 2
            return _End(node.position + beyond * out, out, False)
        onward = self._direction(other, name)
        if node.bend:
            return _End(node.position - node.bend * math.tan(_angle(out, onward) / 2) * out, out, False)
        return _End(node.position, (out + onward) / np.linalg.norm(out + onward), False)

    def _taken(self, pipe: StraightPipe, name: str) -> float:
        """Length that a bend or a reducer takes from a pipe [m]; a mitre's shear keeps volumes."""
        others = [other for other in self._meeting(name) if other is not pipe]
        if not others:
            return 0.0
        turned = _angle(-self._direction(pipe, name), self._direction(others[0], name))
        return self.nodes[name].bend * math.tan(turned / 2) + self.nodes[name].reducer / 2

    def _tori(self, outside: float) -> list[_Torus]:
        tori = []
        for name, node in self.nodes.items():
            if node.bend:
                one, other = self._meeting(name)
                out, onward = -self._direction(one, name), self._direction(other, name)
                turn = _angle(out, onward)
                inwards = onward - (onward @ out) * out
                inwards /= np.linalg.norm(inwards)
                centre = node.position - node.bend * math.tan(turn / 2) * out + node.bend * inwards
                tori.append(_Torus(centre, out, -inwards, node.bend, turn, one.radius + outside))
        return tori

    def _cones(self, outside: float) -> list[_Cone]:
        cones = []
        for name, node in self.nodes.items():
            meeting = sorted(self._meeting(name), key=lambda pipe: pipe.radius)
            if len(meeting) == 2 and node.reducer:
                narrow, wide = meeting
                along = self._direction(narrow, name)
                cones.append(_Cone(node.position, along, node.reducer, wide.radius + outside, narrow.radius + outside))
        return cones

    def _meeting(self, name: str) -> list[StraightPipe]:
        return [pipe for pipe in self.pipes if name in (pipe.start, pipe.end)]

    def _length(self, pipe: StraightPipe) -> float:
        return float(np.linalg.norm(self.nodes[pipe.end].position - self.nodes[pipe.start].position))

    def _direction(self, pipe: StraightPipe, node: str | None = None) -> Floats:
        """Unit vector along a pipe, away from one of its nodes, by default its start."""
        step = self.nodes[pipe.end].position - self.nodes[pipe.start].position
        return step / np.linalg.norm(step) * (-1.0 if node == pipe.end else 1.0)


def _turned(frame: Sequence[Floats], roll: float, turn: str, interior: float) -> list[Floats]:
    """A frame (along, left, up) after a roll about its direction and a turn in its own plane."""
    along, left, up = frame
    left, up = math.cos(roll) * left + math.sin(roll) * up, math.cos(roll) * up - math.sin(roll) * left
    angle = (math.pi - interior) * (1 if turn == "left" else -1)
    turned = math.cos(angle) * along + math.sin(angle) * left
    return [turned, math.cos(angle) * left - math.sin(angle) * along, up]


def _ring(radius: float, wall: float) -> float:
    """Area of a wall's section [m2]."""
    return math.pi * ((radius + wall) ** 2 - radius**2)


def _angle(one: Floats, other: Floats) -> float:
    return math.atan2(float(np.linalg.norm(np.cross(one, other))), float(one @ other))


def _cylinder(points: Floats, start: Floats, out: Floats, radius: float) -> Floats:
    """Distance of points (..., 3) from an endless cylinder: (...) [m]."""
    step = points - start
    return np.linalg.norm(step - (step @ out)[..., None] * out, axis=-1) - radius


def _to_torus(points: Floats, torus: _Torus) -> Floats:
    step = points - torus.centre
    x, y, height = step @ torus.along, step @ torus.away, step @ np.cross(torus.along, torus.away)
    angle = np.arctan2(x, y)
    within: Flags = (angle >= 0) & (angle <= torus.turn)
    return np.where(within, np.hypot(np.hypot(x, y) - torus.bend, height) - torus.radius, np.inf)


def _to_cone(points: Floats, cone: _Cone) -> Floats:
    along = (points - cone.middle) @ cone.along
    off = _cylinder(points, cone.middle, cone.along, 0.0)
    slope = (cone.narrow - cone.wide) / cone.length
    sideways = (off - (cone.wide + cone.narrow) / 2 - slope * along) / math.hypot(1.0, slope)
    return np.maximum(sideways, np.abs(along) - cone.length / 2)
