"""Routes of n robots as their drawings say: what the robots know of the pipes before they move."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Ints
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import MAX_CORNERS
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, steepness

MARGIN = 0.03
"""Distance to leave between a corner and the robot before it rolls, besides what it stretches backwards [m]."""

PARALLEL = math.radians(1.0)
"""Largest angle between the planes of two corners that count as one plane."""


class Drawings:
    """Routes of n robots, corner by corner; what a shorter route leaves over is meaningless.

    Corners of one plane with too little room for the robot between them make one passage: there is nowhere to clamp, so
    the policy goes through all of them. Every other corner is a passage of its own. Places are distances along the
    middle of the pipe, in which a bend counts as its arc; 0 is where the first corner begins.

    Args:
        robot: the robot, as `check_robot` accepts it.
        n: number of robots.

    Attributes:
        corners: number of corners, (n,).
        reducer: whether each corner is a reducer, (n, corners).
        straight_on: whether the route goes straight on at each corner, (n, corners).
        inside: direction of each corner's inside, counted around the straights without twist, (n, corners) [rad].
        axes: directions along the straight before each corner, to its left and upwards as columns,
            (n, corners, 3, 3).
        radius: radius of the bore before each corner, (n, corners) [m].
        room: distance to roll on in the straight before each corner, from the corner before it, until the robot can
            turn its plane, (n, corners) [m].
        reach: distance from the middle of a clamped robot to either end in that straight, (n, corners) [m].
        begin, end: places where each corner begins and ends, (n, corners) [m].
        first, last: first and last corner of the passage that each corner belongs to, (n, corners).
        net_turn: change of direction in that passage, positive to the side of its first corner, (n, corners) [rad].
    """

    def __init__(self, robot: RobotSpec, n: int) -> None:
        self._robot = robot
        self.corners = np.ones(n, np.intp)
        self.reducer, self.straight_on = np.zeros((2, n, MAX_CORNERS), bool)
        self.inside, self.radius = np.zeros((2, n, MAX_CORNERS))
        self.axes = np.zeros((n, MAX_CORNERS, 3, 3))
        self.room, self.reach, self.begin, self.end, self.net_turn = np.zeros((5, n, MAX_CORNERS))
        self.first, self.last = np.zeros((2, n, MAX_CORNERS), np.intp)

    def put(self, rows: Ints, routes: Sequence[PipeRoute]) -> None:
        """Overwrite the routes of some robots, k of them."""
        for row, route in zip(rows, routes, strict=True):
            legs, corners = route.legs, len(route.corners)
            used = row, slice(corners)
            self.corners[row], self.reducer[used], self.inside[used] = corners, ~np.isnan(legs.taper), legs.inside
            self.straight_on[used] = [corner.straight_on for corner in route.corners]
            self.axes[used], self.radius[used] = legs.axes[:-1], legs.radius[:-1]
            steep, lengths = steepness(self._robot, self.radius[used]), self._robot.lengths
            self.room[used] = lengths[0] + 2 * lengths[HALF] * (1 - np.cos(steep)) + MARGIN
            self.reach[used] = (lengths[0] + lengths[-1] + lengths[1:-1].sum() * np.cos(steep)) / 2
            self._put_passages(row, route)

    def _put_passages(self, row: int, route: PipeRoute) -> None:
        """Set the places of a route's corners and its passages."""
        legs, edges, corners = route.legs, route.inner_edges, len(route.corners)
        long = np.where(legs.bend > 0, legs.bend * legs.turn_angle, 2 * edges)
        clear = legs.length[1:-1] - edges[:-1] - edges[1:]
        begin = np.concatenate([[0.0], np.cumsum(long[:-1] + clear)])
        self.begin[row, :corners], self.end[row, :corners] = begin, begin + long
        apart = np.abs(np.sin(legs.inside[1:] - legs.inside[:-1])) > math.sin(PARALLEL)
        passage = np.concatenate([[0], np.cumsum(apart | (clear >= self._robot.length))])
        first = np.searchsorted(passage, passage)
        to_first = np.where(np.cos(legs.inside - legs.inside[first]) > 0, 1.0, -1.0)
        self.first[row, :corners] = first
        self.last[row, :corners] = np.searchsorted(passage, passage, side="right") - 1
        self.net_turn[row, :corners] = np.bincount(passage, legs.turn_angle * to_first)[passage]
