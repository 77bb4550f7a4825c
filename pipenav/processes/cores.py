"""The cores that this process may use, which can be fewer than the machine has."""

from __future__ import annotations

import contextlib
import math
import os
from pathlib import Path, PurePosixPath

CGROUPS = Path("/sys/fs/cgroup")
OWN_CGROUPS = Path("/proc/self/cgroup")


def usable_cores() -> int:
    """Number of cores that the affinity of this process and the quota of its control groups leave it, at least 1.

    A batch system binds its jobs to some cores of a machine, and a container has a share of their time: programs that
    start as many threads as the machine has cores then wait for each other.
    """
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(allowed, quota()))


def quota(cgroups: Path = CGROUPS, own: Path = OWN_CGROUPS) -> int:
    """Cores that the quotas of this process's control groups pay for, rounded up; a large number without any quota.

    Source: Linux's Documentation/admin-guide/cgroup-v2.rst (cpu.max) and scheduler/sched-bwc.rst (version 1).
    """
    shares = [math.inf]
    for line in _lines(own):
        _, controllers, path = line.split(":", 2)
        if controllers and "cpu" not in controllers.split(","):
            continue
        root = cgroups / "cpu" if controllers else cgroups
        inside = PurePosixPath(path.lstrip("/"))
        for group in (inside, *inside.parents):
            shares.append(_share(root / group))
    least = min(shares)
    return 1 << 20 if math.isinf(least) else math.ceil(least)


def _share(group: Path) -> float:
    """Cores that one control group pays for."""
    given = " ".join(_lines(group / "cpu.max"))
    if not given:
        given = " ".join([*_lines(group / "cpu.cfs_quota_us"), *_lines(group / "cpu.cfs_period_us")])
    with contextlib.suppress(ValueError):
        time, period = map(float, given.split())  # `max`, and -1 in version 1, stand for no quota
        return time / period if time > 0 and period > 0 else math.inf
    return math.inf


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
