"""The cores of a process are those that affinity and control groups leave it."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.processes.cores import quota, usable_cores

PROGRAM = "from pipenav.processes.cores import usable_cores; print(usable_cores())"


def test_affinity_counts() -> None:
    one = min(os.sched_getaffinity(0))

    def bind() -> None:
        os.sched_setaffinity(0, {one})

    run = subprocess.run([sys.executable, "-c", PROGRAM], preexec_fn=bind, capture_output=True, text=True, check=True)
    assert int(run.stdout) == 1
    assert 1 <= usable_cores() <= len(os.sched_getaffinity(0))


@pytest.mark.parametrize("version", [1, 2])
@given(st.integers(1_000, 10_000_000), st.integers(1_000, 1_000_000))
def test_the_smallest_quota_of_all_groups_counts(version: int, time: int, period: int) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as path:
        root = Path(path)
        group = root / ("cpu" if version == 1 else "") / "batch" / "job"
        group.mkdir(parents=True)
        _write_quota(group, version, "-1" if version == 1 else "max", period)
        _write_quota(group.parent, version, str(time), period)
        own = root / "own"
        own.write_text("3:cpu,cpuacct:/batch/job\n" if version == 1 else "0::/batch/job\n")
        assert quota(root, own) == math.ceil(time / period)


def _write_quota(group: Path, version: int, time: str, period: int) -> None:
    if version == 2:
        (group / "cpu.max").write_text(f"{time} {period}\n")
    else:
        (group / "cpu.cfs_quota_us").write_text(f"{time}\n")
        (group / "cpu.cfs_period_us").write_text(f"{period}\n")


def test_without_control_groups_there_is_no_quota(tmp_path: Path) -> None:
    assert quota(tmp_path, tmp_path / "none") > 10_000
