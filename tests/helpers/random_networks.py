"""Networks of pipes that grow at random: bends, mitres, reducers, tees, crosses, caps and rings, in space."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.network import NetworkNode, NetworkPipe, PipeNetwork
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import CrossesItself

LEAST = 0.04
"""Least diameter [m]."""


class Stub(NamedTuple):
    """A pipe that has begun: its node, direction, diameter [m], and the length that the fitting there takes [m]."""

    node: str
    direction: Floats
    diameter: float
    taken: float


class GrowingNetwork:
    """Nodes and pipes so far, and the stubs that wait for an end.

    Args:
        rng: where the chances come from.
        level: whether everything lies in one plane.
    """

    def __init__(self, rng: np.random.Generator, level: bool) -> None:
        self.rng, self.level = rng, level
        self.nodes: dict[str, NetworkNode] = {}
        self.pipes: list[NetworkPipe] = []
        self.stubs: list[Stub] = []

    def node(self, position: Floats, **fields: float) -> str:
        """A new node's name."""
        name = f"n{len(self.nodes)}"
        x, y, z = position.tolist()
        self.nodes[name] = NetworkNode(position=(x, y, z), **fields)
        return name

    def pipe(self, start: str, end: str, diameter: float) -> None:
        """Join two nodes."""
        self.pipes.append(NetworkPipe(start=start, end=end, diameter=diameter))

    def towards(self, direction: Floats, turned: float) -> Floats:
        """A direction that differs from another one by an angle [rad], in a plane of chance."""
        around = self.rng.choice([0.0, math.pi]) if self.level else self.rng.uniform(0, 2 * math.pi)
        left = np.cross([0.0, 0.0, 1.0], direction)
        if np.linalg.norm(left) < 1e-3:
            left = np.array([1.0, 0.0, 0.0])
        left /= np.linalg.norm(left)
        side = math.cos(around) * left + math.sin(around) * np.cross(direction, left)
        return math.cos(turned) * direction + math.sin(turned) * side

    def grow(self, stub: Stub) -> None:
        """End a stub in a fitting of chance, from which new ones begin."""
        kind = self.rng.choice(["mitre", "bend", "reducer", "tee", "tee", "branch", "cross", "ring"])
        getattr(self, f"_{kind}")(stub)

    def end(self, stub: Stub) -> None:
        """End a stub openly or in a cap."""
        self._finish(stub, 0.0, capped=bool(self.rng.random() < 0.3))

    def _finish(self, stub: Stub, taken: float, **fields: float) -> str:
        extra = self.rng.uniform(0.5, 3.0) * stub.diameter
        length = stub.taken + taken + extra
        name = self.node(np.array(self.nodes[stub.node].position) + length * stub.direction, **fields)
        self.pipe(stub.node, name, stub.diameter)
        return name

    def _mitre(self, stub: Stub) -> None:
        turned = math.radians(self.rng.uniform(0, 120))
        taken = 0.7 * stub.diameter * math.tan(turned / 2) + 0.02
        name = self._finish(stub, taken)
        self.stubs.append(Stub(name, self.towards(stub.direction, turned), stub.diameter, taken))

    def _bend(self, stub: Stub) -> None:
        turned = math.radians(self.rng.uniform(5, 150))
        most = min(5.0, max(0.75, 4.0 / math.tan(turned / 2)))
        bend = self.rng.uniform(0.751, most + 1e-2) * stub.diameter
        taken = bend * math.tan(turned / 2) + 0.7 * stub.diameter
        name = self._finish(stub, taken, bend_radius=float(bend))
        self.stubs.append(Stub(name, self.towards(stub.direction, turned), stub.diameter, taken))

    def _reducer(self, stub: Stub) -> None:
        diameter = float(np.clip(stub.diameter * self.rng.choice([0.6, 0.75, 1.3, 1.6]), LEAST, 0.2))
        if abs(diameter - stub.diameter) < 1e-6:
            return self._mitre(stub)
        length = float(self.rng.choice([0.0, self.rng.uniform(0.02, 0.2)]))
        name = self._finish(stub, length / 2, length=length)
        self.stubs.append(Stub(name, stub.direction, diameter, length / 2))
        return None

    def _tee(self, stub: Stub) -> None:
        self._fitting(stub, [self.rng.uniform(30, 150)])

    def _cross(self, stub: Stub) -> None:
        self._fitting(stub, list(self.rng.uniform(40, 140, 2)))

    def _fitting(self, stub: Stub, angles_deg: list[float]) -> None:
        """A tee or a cross on a run, with branches as wide as it or narrower."""
        taken = 4.2 * (stub.diameter / 2 + 0.01)
        name = self._finish(stub, taken)
        self.stubs.append(Stub(name, stub.direction, stub.diameter, taken))
        for angle in angles_deg:
            narrower = max(LEAST, float(stub.diameter * self.rng.choice([1.0, 0.8, 0.5])))
            direction = self.towards(stub.direction, math.radians(angle))
            self.stubs.append(Stub(name, direction, narrower, taken))

    def _branch(self, stub: Stub) -> None:
        """A tee that is reached by its branch."""
        run = min(0.2, float(stub.diameter * self.rng.choice([1.0, 1.3, 1.8])))
        taken = 4.2 * (run / 2 + 0.01)
        name = self._finish(stub, taken)
        onward = self.towards(stub.direction, math.radians(self.rng.uniform(30, 150)))
        self.stubs += [Stub(name, sign * onward, run, taken) for sign in (1.0, -1.0)]

    def _ring(self, stub: Stub) -> None:
        """A run with a second way beside it, which leaves it at one tee and comes back at another."""
        d = stub.diameter
        narrower = max(LEAST, float(d * self.rng.choice([1.0, 0.8])))
        first, second = np.radians(self.rng.uniform(50, 90, 2))
        away = self.towards(stub.direction, math.pi / 2)
        taken = 4.2 * (d / 2 + 0.01)
        height = 3.5 * taken
        one = self._finish(stub, taken)
        start, along = np.array(self.nodes[one].position), stub.direction
        length = float(height / math.tan(first) + height / math.tan(second) + 2 * taken + d)
        two = self.node(start + length * along)
        bend = float(narrower * self.rng.choice([0.0, 0.8, 1.0]))
        up = self.node(start + height * (along / math.tan(first) + away), bend_radius=bend)
        down = self.node(start + length * along + height * (away - along / math.tan(second)), bend_radius=bend)
        self.pipe(one, two, d)
        for a, b in ((one, up), (up, down), (down, two)):
            self.pipe(a, b, narrower)
        self.stubs.append(Stub(two, along, d, taken))


def random_network(seed: int, most: int = 6, level: bool | None = None) -> PipeNetwork:
    """A network of up to so many fittings; what does not fit beside the rest is left out.

    Args:
        seed: seed of its chances.
        most: fittings.
        level: whether all lies in a plane z = constant; None leaves it to chance.
    """
    rng = np.random.default_rng(seed)
    growing = GrowingNetwork(rng, level=bool(rng.random() < 0.25) if level is None else level)
    direction = np.array([1.0, 0.0, 0.0]) if growing.level else rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    first = growing.node(rng.uniform(-1, 1, 3))
    diameter, wall = float(rng.uniform(0.05, 0.15)), float(rng.uniform(0.002, 0.006))
    growing.stubs = [Stub(first, direction, diameter, 0.0)]
    made: PipeNetwork | None = None
    for _ in range(3 * most):
        if not growing.stubs or (made is not None and len(growing.nodes) > 3 * most):
            break
        before = dict(growing.nodes), list(growing.pipes), list(growing.stubs)
        growing.grow(growing.stubs.pop(int(rng.integers(len(growing.stubs)))))
        try:
            made = _closed(growing, rng, wall)
        except PipenavError:
            growing.nodes, growing.pipes, growing.stubs = before
    return made if made is not None else _closed(growing, rng, wall)


def _closed(growing: GrowingNetwork, rng: np.random.Generator, wall: float) -> PipeNetwork:
    """The network with an end at every stub."""
    whole = GrowingNetwork(rng, growing.level)
    whole.nodes, whole.pipes = dict(growing.nodes), list(growing.pipes)
    for stub in growing.stubs:
        whole.end(stub)
    return PipeNetwork(nodes=whole.nodes, pipes=tuple(whole.pipes), wall=wall)


def ways_through(network: PipeNetwork) -> list[list[str]]:
    """All ways from an open end of a network to another end that come to no node twice."""
    found: list[list[str]] = []
    waiting = [[name] for name, node in network.nodes.items() if len(network.pipes_at(name)) == 1 and not node.capped]
    while waiting:
        way = waiting.pop()
        at_end = len(way) > 1 and len(network.pipes_at(way[-1])) == 1
        if at_end and len(way) > 2:
            found.append(way)
        beyond = [pipe.other(way[-1]) for pipe in network.pipes_at(way[-1])]
        waiting += [[*way, name] for name in beyond if name not in way]
    return found


def random_routes(seed: int, level: bool | None = None) -> list[PipeRoute]:
    """Routes through a random network, at most four."""
    network = random_network(seed, 2, level)
    found = []
    for way in ways_through(network)[:4]:
        try:
            found.append(network.route(way))
        except PipenavError as error:  # two straights that one short straight joins must stay farther apart in a route
            if not isinstance(error.__cause__, CrossesItself):
                raise
    return found
