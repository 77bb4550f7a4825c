"""How far a robot has come along its pipe: for rewards, verdicts and pictures, never for a policy."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.queries import Pipe, inner_edges, turn_signs
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec


class CentreLines(NamedTuple):
    """The ways through n pipes of at most `legs` straight legs; of shorter ones the rows left over are 0.

    A row of `mitre`, `end` and `turn_sign` is of the corner at the leg's end, of which the last leg has none.

    Attributes:
        start: where each leg begins on the centre line, (n, legs, 2) [m].
        direction: unit vectors along the legs, (n, legs, 2).
        mitre: normals of the corners' mitres, forwards, (n, legs, 2).
        place: where along the way each leg begins; 0 is the first corner, (n, legs) [m].
        low, high: which part of the way is the leg's, from its start; (n, legs) [m].
        ahead, behind: where an open end is, from the leg's start; far away where there is none, (n, legs) [m].
        end: where along the way each inner wall's bend ends, (n, legs) [m].
        turn_sign: +1 for each corner that turns left, -1 for a right one, (n, legs).
        radius: of the bore, (n, 1) [m].
    """

    start: Floats
    direction: Floats
    mitre: Floats
    place: Floats
    low: Floats
    high: Floats
    ahead: Floats
    behind: Floats
    end: Floats
    turn_sign: Floats
    radius: Floats

    @classmethod
    def of(cls, pipes: Sequence[Pipe]) -> CentreLines:
        """Those of some pipes, runs among them in the plane.

        Raises:
            PipenavError: a run leaves the plane.
        """
        ways = [_way(pipe) for pipe in pipes]
        legs = max(way.place.shape[1] for way in ways)
        return cls(*map(np.concatenate, zip(*(way._with_room(legs) for way in ways), strict=True)))

    def put(self, rows: Ints, ways: CentreLines) -> CentreLines:
        """These ways with some rows replaced, in place where they have legs enough."""
        legs = max(self.place.shape[1], ways.place.shape[1])
        mine = self._with_room(legs)
        for own, given in zip(mine, ways._with_room(legs), strict=True):
            own[rows] = given
        return mine

    def _with_room(self, legs: int) -> CentreLines:
        more = legs - self.place.shape[1]
        if not more:
            return self
        columns = self._asdict()
        for name, column in columns.items():
            if name != "radius":
                columns[name] = np.pad(column, [(0, 0), (0, more), (0, 0)][: column.ndim])
        return CentreLines(**columns)

    @property
    def corners(self) -> Ints:
        """How many corners each pipe has, (n,)."""
        return np.asarray(np.count_nonzero(self.turn_sign, axis=1))

    def turn_signs(self, corner: Ints) -> Floats:
        """+1 or -1 for a corner (n,) of each pipe, the one before and the one after; 0 where there is none, (n, 3)."""
        around = np.pad(self.turn_sign, [(0, 0), (1, 0)])  # the last leg's 0 stands behind the last corner
        return np.asarray(np.take_along_axis(around, corner[:, None] + np.array([1, 0, 2]), axis=1))

    def along(self, points: Floats) -> Floats:
        """Distance along the mitred centre line, 0 at the first corner, of points (n, m, 2) of the pipes' frames.

        (n, m) [m]; as `PipeCorner.centre_line_distance` and `PipeRoute.along`, for all pipes at once.
        """
        from_start = points[:, :, None] - self.start[:, None]  # (n, m, legs, 2)
        forwards = (from_start * self.direction[:, None]).sum(axis=-1)  # (n, m, legs)
        x, y = np.moveaxis(self.direction[:, None], -1, 0)
        sideways = np.abs(from_start[..., 1] * x - from_start[..., 0] * y)
        from_corner = points[:, :, None] - self.start[:, None, 1:]
        past = (from_corner * self.mitre[:, None, :-1]).sum(axis=-1) > 0  # (n, m, legs - 1)
        always = np.ones_like(past[..., :1])
        between = np.concatenate([always, past], axis=-1) & np.concatenate([~past, always], axis=-1)
        beyond = np.maximum(np.maximum(self.behind[:, None] - forwards, forwards - self.ahead[:, None]), 0.0)
        in_bore = (sideways <= self.radius[:, None]) & (beyond == 0)
        away = np.where(between, np.where(in_bore, 0.0, np.hypot(sideways, beyond)), np.inf)
        leg = away.argmin(axis=-1)  # (n, m)
        reached = self.place[:, None] + np.clip(forwards, self.low[:, None], self.high[:, None])
        return np.asarray(np.take_along_axis(reached, leg[..., None], axis=-1)[..., 0])


@lru_cache(maxsize=4096)  # every pipe of the largest shipped training set
def _way(pipe: Pipe) -> CentreLines:
    """That of one pipe, n = 1."""
    if isinstance(pipe, PipeCorner):
        ahead, second = np.array([1.0, 0.0]), pipe.second_leg
        start, direction = np.array([[-pipe.leg, 0.0], [0.0, 0.0]]), np.stack([ahead, second])
        length = np.array([pipe.leg, pipe.leg])
    else:
        _ = pipe.walls  # which only a run in the plane has
        start, direction, length = pipe.legs.start[:, :2], pipe.legs.axes[:, :2, 0], pipe.legs.length
    legs = len(length)
    mitre = direction[:-1] + direction[1:]
    first, last = np.arange(legs) == 0, np.arange(legs) == legs - 1
    return CentreLines(
        start=start[None],
        direction=direction[None],
        mitre=np.concatenate([mitre, np.zeros((1, 2))])[None],
        place=(np.cumsum(length) - length - length[0])[None],
        low=np.where(first, -np.inf, 0.0)[None],
        high=np.where(last, np.inf, length)[None],
        ahead=np.where(last, length, np.inf)[None],
        behind=np.where(first, 0.0, -np.inf)[None],
        end=np.append(np.cumsum(length)[:-1] - length[0] + inner_edges(pipe), 0.0)[None],
        turn_sign=np.append(turn_signs(pipe), 0.0)[None],
        radius=np.array([[pipe.radius]]),
    )


def waypoints(robot: RobotSpec, configuration: Floats) -> Floats:
    """Rear end, joints and tip of n robots in their own frame, (n, links + 1, 2) [m], of (n, coordinates)."""
    pose = kinematics.forward(robot, configuration)
    return np.concatenate([pose.joints, pose.tip[:, None]], axis=1)
