"""A simulator before another one has all of the other's abilities, those that come later too."""

from __future__ import annotations

import inspect

import pytest

from pipenav.backends.backend import Backend, Simulator
from pipenav.backends.wrapper import WrappedSimulator
from pipenav.disturbances.disturbed_backend import DisturbedSimulator
from pipenav.driving.driven import DrivenSimulator

ITS_OWN = {"can_vary", "vary", "in_space", "reset", "step"}
"""Members that a wrapper changes, or does not offer."""


@pytest.mark.parametrize("kind", [DisturbedSimulator, DrivenSimulator])
def test_every_ability_is_passed_on(kind: type[WrappedSimulator]) -> None:
    members = {
        name
        for base in (Backend, Simulator)
        for name, member in vars(base).items()
        if not name.startswith("_") and (inspect.isfunction(member) or isinstance(member, property))
    }
    asked = {name for name in members - ITS_OWN if getattr(kind, name) is getattr(Simulator, name)}
    assert not asked, f"{kind.__name__} answers by itself: {asked}"
