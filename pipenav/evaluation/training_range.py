"""Range of the pipes that a policy was trained in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.tee import fitting_of
from pipenav.policies.controller import AnyController
from pipenav.policies.named import PolicyController
from pipenav.tasks.registry import task_of
from pipenav.units import rad_to_deg

SPARE = 1e-6
"""Slack of comparisons of diameters [m], angles [deg] and bend radii in diameters."""


class TrainingRange:
    """Range of trained corners, by kind of fitting.

    A corner lies inside where trained ones of its kind lie around it: in each direction of diameter, angle and bend
    radius, both larger and smaller ones, or equal ones. Turns do not count, as policies see every turn as a left one.

    Args:
        trained: pipes that a policy was trained in; routes are left out.
    """

    def __init__(self, trained: Sequence[Pipe]) -> None:
        kinds: dict[str, set[tuple[float, float, float]]] = {}
        for pipe in trained:
            if pipe.corner is not None:
                kind, numbers = _shape(pipe.corner)
                kinds.setdefault(kind, set()).add(numbers)
        self._kinds = {kind: np.array(sorted(numbers)) for kind, numbers in kinds.items()}

    @classmethod
    def of(cls, controller: AnyController | None) -> Self | None:
        """The range of a policy; None for a baseline, and where the files of its pipes are not there."""
        if not isinstance(controller, PolicyController):
            return None
        try:
            return cls(task_of(controller.task).parse_pipes(controller.policy.header.train_pipes))
        except PipenavError:
            return None

    def has(self, pipe: Pipe) -> bool | None:
        """Whether a corner lies inside; None for a route."""
        if pipe.corner is None:
            return None
        kind, numbers = _shape(pipe.corner)
        trained = self._kinds.get(kind)
        return trained is not None and _surrounds(trained, np.array(numbers))


def _shape(corner: PipeCorner) -> tuple[str, tuple[float, float, float]]:
    """Kind of a corner's fitting with the way through it, and diameter [m], angle [deg] and bend radius in diameters.

    The angle is that of the branch where there is one.
    """
    name, angle, way = (fitting_of(corner) or f"corner {rad_to_deg(corner.angle)} through").split()
    return f"{name} {way}", (corner.diameter, float(angle), corner.bend_radius / corner.diameter)


def _surrounds(trained: Floats, at: Floats) -> bool:
    """Whether trained corners, (n, 3), lie in every direction of one, (3,)."""
    below, above = trained <= at + SPARE, trained >= at - SPARE  # (n, 3) each
    every = np.stack([below, above])  # (2, n, 3)
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
    return all(bool((every[x, :, 0] & every[y, :, 1] & every[z, :, 2]).any()) for x, y, z in corners)
