"""Whether the process that a file or folder is named after still runs."""

from __future__ import annotations

import os
from pathlib import Path

CLOCKS_APART_S = 2.0
"""Largest error of a process's begin [s], which the kernel counts from a boot in whole seconds."""

_ENDED = ("Z", "X")
"""States of a process that has ended and whose parent did not ask for its exit code yet, proc(5)."""


def owner_runs(process: int, changed: float) -> bool:
    """Whether the process that left something behind still runs.

    A number is given again when its process has ended; a process that began after the change is another one.

    Args:
        process: the owner's number.
        changed: time at which the owner last changed what it left [s since the epoch].
    """
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    state, began = _state(process)
    return state not in _ENDED and began <= changed + CLOCKS_APART_S


def _state(process: int) -> tuple[str, float]:
    """State of a process, a letter, and its begin [s since the epoch]; "R" and 0 where the system tells nothing."""
    try:
        stat = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
        booted = next(line for line in Path("/proc/stat").read_text(encoding="utf-8").splitlines() if "btime" in line)
    except (OSError, StopIteration):
        return "R", 0.0
    fields = stat.rpartition(")")[2].split()  # from the third on; the second, a name, may hold spaces and brackets
    return fields[0], int(booted.split()[1]) + int(fields[19]) / os.sysconf("SC_CLK_TCK")
