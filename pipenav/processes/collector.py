"""The collector of circles in memory, which takes much of the time where there is much data without any."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator

SELDOM = (100_000, 50, 100)
"""Thresholds of `gc.set_threshold`: the newest objects are looked through after 100,000 more of them, not 700."""


@contextlib.contextmanager
def seldom_collected() -> Iterator[None]:
    """Look for circles in memory seldom for a while; all else is freed at once, as always."""
    before = gc.get_threshold()
    gc.set_threshold(*SELDOM)
    try:
        yield
    finally:
        gc.set_threshold(*before)
