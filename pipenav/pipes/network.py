"""A network of pipes in space: nodes where pipes meet, and the routes through them.

A node's fitting follows from its pipes: one is an open end or a cap, two are a mitre, a bend or a reducer, three a tee,
four a cross. A route is a way through the network, from node to node; what tasks, simulators and files ask for is asked
of a route.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from pydantic import ConfigDict, model_validator

from pipenav.arrays import Floats, Table
from pipenav.errors import PipenavError, UnknownName, shown
from pipenav.pipes.branch import Branch
from pipenav.pipes.branch_pipes import with_default_branches
from pipenav.pipes.network_checks import check_apart, check_pipes
from pipenav.pipes.pipe import DEFAULT_WALL, Turn
from pipenav.pipes.rotations import about_x, about_z
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner
from pipenav.units import m_to_mm

SNAP = 1e-3
"""Angle within which two pipes of a tee, a cross or a reducer count as in line [rad]: 1 mm in a metre."""


ROUNDING = 1e-9
"""Angle that counts as none [rad]: rounding of directions."""

MISPLACED = 2e-3
"""Distance from its place at which the last node of a route may be laid [m]."""


class NetworkNode(Table):
    """A place where pipes end or meet.

    Attributes:
        position: position, z upwards, (3,) [m].
        bend_radius: radius of the centre line's bend where two pipes meet [m]; 0 is a mitre.
        length: length of the reducer where two pipes of different bores meet [m]; 0 is a step.
        capped: whether a cap closes a pipe that ends there.
    """

    model_config = ConfigDict(allow_inf_nan=True)  # checked with sentences of their own

    position: tuple[float, float, float]
    bend_radius: float = 0.0
    length: float = 0.0
    capped: bool = False


class NetworkPipe(Table):
    """A straight pipe between two nodes, given by their names, with an inner diameter [m]."""

    model_config = ConfigDict(allow_inf_nan=True)  # as above

    start: str
    end: str
    diameter: float

    def other(self, node: str) -> str:
        """The node at its other end."""
        return self.end if node == self.start else self.start


class PipeNetwork(Table):
    """Nodes and the pipes between them, as lengths in metres in one frame, z upwards.

    Attributes:
        nodes: nodes by name.
        pipes: pipes.
        wall: wall thickness of all pipes [m].
    """

    model_config = ConfigDict(allow_inf_nan=True)  # as above

    nodes: Mapping[str, NetworkNode]
    pipes: tuple[NetworkPipe, ...]
    wall: float = DEFAULT_WALL

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_pipes(self)
        for way in self.strands:
            if way[0] == way[-1]:
                raise PipenavError(
                    f"a ring leads from {shown(way[0])} by {', '.join(way[1:-1])} back to {shown(way[0])}: "
                    "let it end in another tee or cross."
                )
            whole = self._prolonged(way)
            if len(whole) > 2:
                self.laid(whole)  # it refuses what is not possible
        check_apart(self)
        return self

    @property
    def length(self) -> float:
        """Length of all pipes, from node to node [m]."""
        return sum(self._length(pipe.start, pipe.end) for pipe in self.pipes)

    def pipes_at(self, node: str) -> list[NetworkPipe]:
        """The pipes that meet in a node."""
        return [pipe for pipe in self.pipes if node in (pipe.start, pipe.end)]

    def pipe_between(self, one: str, other: str) -> NetworkPipe:
        """The pipe from one node to another.

        Raises:
            PipenavError: there is none.
        """
        for pipe in self.pipes_at(one):
            if pipe.other(one) == other:
                return pipe
        near = ", ".join(pipe.other(one) for pipe in self.pipes_at(one))
        raise PipenavError(f"no pipe leads from {shown(one)} to {shown(other)}: from there pipes lead to {near}.")

    @property
    def strands(self) -> list[list[str]]:
        """Ways from one end, tee or cross to the next, through all nodes with two pipes, each way once."""
        terminals = [name for name in self.nodes if len(self.pipes_at(name)) != 2]
        found: list[list[str]] = []
        for terminal in terminals:
            for pipe in self.pipes_at(terminal):
                way = [terminal, pipe.other(terminal)]
                while len(self.pipes_at(way[-1])) == 2:
                    one, other = self.pipes_at(way[-1])
                    onward = other if one.other(way[-1]) == way[-2] else one
                    way.append(onward.other(way[-1]))
                if way[::-1] not in found:
                    found.append(way)
        return found

    def route(self, way: Sequence[str]) -> PipeRoute:
        """The route from node to node, in a frame of its own whose z lies as near to the network's as it can.

        Args:
            way: names of the nodes, three or more; no cap may close the first one.

        Raises:
            PipenavError: an unknown node, no pipe between two of them, a node that comes twice, a cap where the robot
                comes in, or fittings that are not possible.
        """
        self._check_way(way)
        if self.nodes[way[0]].capped:
            raise PipenavError(f"the route begins in {shown(way[0])}, which a cap closes: begin in an open end.")
        return self.laid(way)

    def laid(self, way: Sequence[str]) -> PipeRoute:
        """The pipes of a way as a route, whether or not its first end is open, see `route`."""
        directions = [self._direction(*pair) for pair in pairwise(way)]
        axes, rolled = first_axes(directions[0]), 0.0
        corners: list[Corner] = []
        for i, name in enumerate(way[1:-1]):
            corner, turned = self._corner(way[i], name, way[i + 2], axes, rolled)
            corners.append(corner)
            axes, rolled = turned, rolled + corner.roll
        pipes = [self.pipe_between(*pair) for pair in pairwise(way)]
        capped = self.nodes[way[-1]].capped and len(self.pipes_at(way[-1])) == 1
        straights = tuple(self._length(*pair) for pair in pairwise(way))
        slope = math.asin(max(-1.0, min(float(directions[0][2]), 1.0)))
        try:
            made = PipeRoute(
                diameter=pipes[0].diameter,
                corners=tuple(corners),
                straights=straights,
                wall=self.wall,
                capped=capped,
                slope=_rounded(slope),
            )
            self._check_place(way, made)
            return made
        except PipenavError as error:
            named = ", ".join(f"{number} is {shown(name)}" for number, name in enumerate(way[1:-1], 1))
            raise PipenavError(f"on the way {', '.join(way)}, whose corner {named}: {error}") from error

    def _check_way(self, way: Sequence[str]) -> None:
        for name in way:
            if name not in self.nodes:
                raise UnknownName("node", name, self.nodes)
        if len(way) < 3:
            raise PipenavError("a route needs three nodes or more: the open end, a fitting, and the end.")
        if twice := next((name for i, name in enumerate(way) if name in way[:i]), None):
            raise PipenavError(f"the route comes to {shown(twice)} twice: name each node once.")

    def _check_place(self, way: Sequence[str], made: PipeRoute) -> None:
        """Refuse a way whose pipes are not quite in line, and so long that its end is laid in another place."""
        step = np.subtract(self.nodes[way[-1]].position, self.nodes[way[1]].position)
        off = float(np.linalg.norm(made.centre_line[-1] - step @ first_axes(self._direction(*way[:2]))))
        if off > MISPLACED:
            raise PipenavError(
                f"{shown(way[-1])} would lie {m_to_mm(off):.1f} mm from its place, as pipes of a fitting within "
                f"{math.degrees(SNAP):.2f} deg of one line are laid straight: give nodes that are exactly in line."
            )

    def _direction(self, one: str, other: str) -> Floats:
        step = np.subtract(self.nodes[other].position, self.nodes[one].position)
        return np.asarray(step / np.linalg.norm(step))

    def _length(self, one: str, other: str) -> float:
        return float(np.linalg.norm(np.subtract(self.nodes[other].position, self.nodes[one].position)))

    def _corner(self, before: str, name: str, after: str, axes: Floats, rolled: float) -> tuple[Corner, Floats]:
        """The corner of a route at a node, and the axes of the leg after it.

        Args:
            before, name, after: the node, and those before and after it.
            axes: unit vectors along the leg before, to its left and upwards as columns, without twist, (3, 3).
            rolled: sum of the rolls of the corners before [rad].
        """
        node, before_pipe, after_pipe = self.nodes[name], *(self.pipe_between(name, to) for to in (before, after))
        others = [pipe for pipe in self.pipes_at(name) if pipe not in (before_pipe, after_pipe)]
        snap = bool(others) or before_pipe.diameter != after_pipe.diameter
        turn = _turn_to(axes, self._direction(name, after), rolled, snap)
        to_diameter = None if before_pipe.diameter == after_pipe.diameter else after_pipe.diameter
        branches = tuple(
            Branch(
                diameter=pipe.diameter,
                length=0.0,
                closed=False,
                **_turn_to(axes, self._direction(name, pipe.other(name)), rolled, snap)._asdict(),
            )
            for pipe in others
        )
        corner = Corner(
            bend_radius=node.bend_radius,
            to_diameter=to_diameter,
            length=node.length,
            branches=branches,
            **turn._asdict(),
        )
        if branches:
            corner = self._with_lengths(corner, name, others, (before_pipe.diameter, after_pipe.diameter))
        around = rolled + turn.roll + math.pi * (turn.turn == "right")
        return corner, axes @ about_x(around) @ about_z(math.pi - turn.angle) @ about_x(-around)

    def _with_lengths(
        self, corner: Corner, name: str, others: Sequence[NetworkPipe], diameters: tuple[float, float]
    ) -> Corner:
        """The corner with branches of a default length, or as long as they are, if that is shorter."""
        shown_long = with_default_branches(corner, *diameters, self.wall)
        branches = []
        for branch, pipe in zip(shown_long.branches, others, strict=True):
            end = pipe.other(name)
            length = self._length(name, end)
            whole = length <= branch.length
            closed = whole and self.nodes[end].capped and len(self.pipes_at(end)) == 1
            branches.append(branch.model_copy(update={"length": min(branch.length, length), "closed": closed}))
        return shown_long.model_copy(update={"branches": tuple(branches)})

    def _prolonged(self, way: Sequence[str]) -> list[str]:
        """A strand with a node before and after it where it ends in a tee or a cross, which then is a corner too."""
        before = self._beyond(way[0], way)
        return [*before, *way, *self._beyond(way[-1], [*before, *way])]

    def _beyond(self, node: str, way: Sequence[str]) -> list[str]:
        """A node next to a tee or cross that a way does not come to, if there is one."""
        pipes = self.pipes_at(node)
        others = [pipe.other(node) for pipe in pipes if pipe.other(node) not in way]
        return others[:1] if len(pipes) > 2 else []


class _Turning(NamedTuple):
    """Turn from a leg to a direction, as a `Corner` or a `Branch` has it: angle [rad], turn, roll [rad]."""

    angle: float
    turn: Turn
    roll: float


def first_axes(direction: Floats) -> Floats:
    """Axes of a route's frame in its network: x along the first leg, y level, to its left, (3, 3)."""
    left = np.cross([0.0, 0.0, 1.0], direction)
    size = float(np.linalg.norm(left))
    left = left / size if size > SNAP else np.array([0.0, 1.0, 0.0])
    left -= (left @ direction) * direction
    left /= np.linalg.norm(left)
    return np.stack([direction, left, np.cross(direction, left)], axis=1)


def _turn_to(axes: Floats, direction: Floats, rolled: float, snap: bool) -> _Turning:
    """Turn from a leg to a direction.

    Args:
        axes: unit vectors along the leg, to its left and upwards as columns, without twist, (3, 3).
        direction: unit vector, (3,).
        rolled: sum of the rolls of the corners before [rad].
        snap: whether a direction within `SNAP` of the leg's counts as in line with it.
    """
    along, left, up = (direction @ axes).tolist()
    turned = math.atan2(math.hypot(left, up), along)
    if turned < (SNAP if snap else ROUNDING):
        return _Turning(math.pi, "left", 0.0)
    around = math.remainder(math.atan2(up, left) - rolled, 2 * math.pi)
    if abs(around) <= math.pi / 2 + ROUNDING:
        return _Turning(math.pi - turned, "left", _rounded(around))
    return _Turning(math.pi - turned, "right", _rounded(math.remainder(around - math.pi, 2 * math.pi)))


def _rounded(roll: float) -> float:
    """A roll without the rounding errors of a plane's own directions."""
    return 0.0 if abs(roll) < ROUNDING else roll
