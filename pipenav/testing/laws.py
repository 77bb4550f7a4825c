"""Helpers of the laws: the state that a backend reports, and requirements that fail in words."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeGuard

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import Backend, Simulator
from pipenav.testing.bench import Bench

Law = Callable[[Bench], None]
"""A check of one law on a bench; it raises AssertionError, in words, where the law is broken."""


def state_of(subject: Backend) -> dict[str, Floats]:
    """All that a backend reports now, by the names of its fields: readings, and of a simulator the truth."""
    truth = subject.truth()._asdict() if isinstance(subject, Simulator) else {}
    return {**subject.read().measured(), **truth}


def can_vary(subject: Backend) -> TypeGuard[Simulator]:
    """Whether a backend is a simulator that can vary its robots."""
    return isinstance(subject, Simulator) and subject.can_vary


def require(condition: bool, message: str) -> None:
    """Raise AssertionError with the message unless the condition holds."""
    if not condition:
        raise AssertionError(message)


def require_same(one: dict[str, Floats], other: dict[str, Floats], between: str) -> None:
    """Require two states to be equal to the last bit; `between` says whose they are."""
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=f"{name} differs between {between}")
