"""Legs of routes that robots can touch within a control period."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.robots import space_kinematics

PART = 0.1
"""Distance within which every part of a robot lies from its rear end, a joint or its tip [m]: links are up to 0.1 m
long, so that half a link and a wheel's radius, or half a diagonal across, is less."""

HURRY = 0.15
"""Distance that no point of a robot moves in a control period [m], or the period is repeated among all walls."""


class LegBoxes(NamedTuple):
    """Bounding boxes of the walls of each leg, of n robots.

    Attributes:
        origin: origin of the leg's body, (n, legs, 3) [m].
        axes: axes of the leg's body as columns, (n, legs, 3, 3).
        middle, half: box in the body's frame, (n, legs, 3) [m].
    """

    origin: Floats
    axes: Floats
    middle: Floats
    half: Floats

    @classmethod
    def of(cls, models: list[Any], first: int, legs: int) -> LegBoxes:
        """Boxes of models whose legs are bodies in a row, by the roots of their trees.

        Args:
            models: model of each robot.
            first: body of the first leg.
            legs: number of legs.
        """
        made: dict[int, tuple[Any, ...]] = {}
        for model in models:
            if id(model) not in made:
                bodies = slice(first, first + legs)
                root = model.bvh_aabb[model.body_bvhadr[bodies]]
                turned = space_kinematics.rotation(model.body_quat[bodies])
                made[id(model)] = model.body_pos[bodies].copy(), turned, root[:, :3], root[:, 3:]
        return cls(*map(np.array, zip(*(made[id(model)] for model in models), strict=True)))

    def within_reach(self, points: Floats) -> Flags:
        """Whether a robot at points (n, p, 3) can touch each leg before it has moved by `HURRY`, (n, legs)."""
        local = (points[:, None] - self.origin[:, :, None]) @ self.axes  # (n, legs, p, 3)
        outside = np.maximum(np.abs(local - self.middle[:, :, None]) - self.half[:, :, None], 0.0)
        return np.asarray(~((outside**2).sum(axis=-1).min(axis=2) > (PART + HURRY) ** 2))
