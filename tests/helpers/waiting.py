"""Waiting for what happens in another process or thread."""

from __future__ import annotations

import time
from collections.abc import Callable

GENEROUS = 120.0
"""Longest wait [s]: it is only reached where what is waited for never comes."""


def wait_until(holds: Callable[[], bool], what: str) -> None:
    """Wait until a condition holds; `what` names it in the failure of a test that waits in vain."""
    deadline = time.monotonic() + GENEROUS
    while not holds():
        assert time.monotonic() < deadline, f"in {GENEROUS:g} s it never came that {what}"
        time.sleep(0.02)
