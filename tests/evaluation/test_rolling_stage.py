"""The rolling stage: which gravity comes with the task."""

from __future__ import annotations

from pipenav.evaluation.rolling_stage import gravity_of
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import GRAVITY


def test_gravity_comes_with_the_task() -> None:
    assert gravity_of(TraverseConfig(kind="traverse")) == 0.0
    assert gravity_of(TraverseConfig(kind="traverse", inclination_deg=(0.0, 360.0))) == GRAVITY
