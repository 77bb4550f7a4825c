"""Range of pipes that a policy was trained in: outside of it nobody knows what the policy does."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from pipenav.errors import PipenavError
from pipenav.pipes.route_sets import parse_pipes
from pipenav.policies.header import PolicyHeader
from pipenav.survey.classes import FittingClass
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.units import m_to_mm, rad_to_deg


class Trained(NamedTuple):
    """Range of pipes that a policy was trained in.

    Attributes:
        bores_mm: least and largest inner diameter.
        sharpest_deg: sharpest interior angle.
        inclined: whether it was trained under gravity along the pipe.
    """

    bores_mm: tuple[float, float]
    sharpest_deg: float
    inclined: bool

    @classmethod
    def of(cls, header: PolicyHeader) -> Trained:
        """The range of a policy's training pipes.

        Raises:
            PipenavError: the policy takes no whole robot through pipes.
        """
        task = header.task
        if not isinstance(task, TraverseConfig):
            raise PipenavError(
                f"the policy was made for {header.robot.name!r}, which passes no pipe as a whole: choose one that "
                "does, such as --policy pirate."
            )
        bores, sharpest = _range_of(header.train_pipes)
        return cls(bores, sharpest, task.inclination_deg is not None)

    def refusal(self, kind: FittingClass) -> str:
        """Reason why a class lies outside of what the policy was trained in; empty where it does not."""
        low, high = self.bores_mm
        for bore in (kind.bore_mm, kind.to_mm):
            if bore and not low <= bore <= high:
                return f"a bore of {bore:g} mm lies outside of the {low:g}-{high:g} mm that the policy was trained in"
        if kind.kind == "bend" and kind.angle_deg < self.sharpest_deg:
            return f"{kind.angle_deg:g} deg is sharper than the {self.sharpest_deg:g} deg that it was trained in"
        if kind.incline_deg and not self.inclined:
            return f"the policy was trained in level pipes, this one climbs by {kind.incline_deg:g} deg"
        return ""


@cache
def _range_of(pipes: tuple[str, ...]) -> tuple[tuple[float, float], float]:
    """Least and largest bore [mm] and sharpest interior angle [deg] of sets of pipes."""
    made = parse_pipes(pipes)
    bores = [m_to_mm(pipe.diameter) for pipe in made]
    return (min(bores), max(bores)), min(rad_to_deg(float(pipe.interior_angles.min())) for pipe in made)
