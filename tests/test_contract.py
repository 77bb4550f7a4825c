"""The laws of `pipenav.testing.contract`, over every installed simulator that can run here."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pipenav.backend import Backend
from pipenav.registry import availability, find_backends
from pipenav.testing import CONTRACT, Bench, KinematicBackend

NEEDS_A_MACHINE = {"hardware"}
"""Backends that cannot be opened without their machine: their own tests run them over a fake wire."""


def _subjects() -> list[object]:
    subjects: list[object] = [pytest.param(KinematicBackend, id="kinematic")]
    for name, plugin in find_backends().items():
        if name not in NEEDS_A_MACHINE:
            can_load, missing, remedy = availability(plugin)
            marks = () if can_load else pytest.mark.skip(reason=f"{name}: {missing}; {remedy}")
            subjects.append(pytest.param(name, id=name, marks=marks))
    return subjects


def test_our_backends_are_installed() -> None:
    """Else the contract below would have run over next to nothing."""
    assert "mujoco" in find_backends(), (
        "pipenav's own backends are not installed, so the contract was not run over them: this is a bare checkout. "
        "Backends are found through the installed distribution: pip install -c constraints.txt -e '.[dev]'"
    )


@pytest.mark.parametrize("check", CONTRACT, ids=lambda check: check.__name__.removeprefix("check_"))
@pytest.mark.parametrize("backend", _subjects())
def test_contract(backend: str | type[Backend], check: Callable[[Bench], None]) -> None:
    check(Bench(backend))


@pytest.mark.parametrize("check", CONTRACT, ids=lambda check: check.__name__.removeprefix("check_"))
def test_contract_holds_for_one_robot(check: Callable[[Bench], None]) -> None:
    check(Bench(KinematicBackend, n=1))
