"""The collector of circles: looked for seldom, and as before afterwards, whatever happened."""

from __future__ import annotations

import gc
import weakref

import pytest

from pipenav.processes.collector import SELDOM, seldom_collected


class Circle:
    """An object that refers to itself."""

    def __init__(self) -> None:
        self.itself = self


def test_thresholds_are_as_before_whatever_happened() -> None:
    before = gc.get_threshold()
    with pytest.raises(KeyError), seldom_collected():
        assert gc.get_threshold() == SELDOM
        raise KeyError
    assert gc.get_threshold() == before


def test_circles_are_still_found() -> None:
    with seldom_collected():
        circle = weakref.ref(Circle())
        kept: list[list[int]] = []
        while circle() is not None and len(kept) < 10 * SELDOM[0]:
            kept.append([])
    assert circle() is None
