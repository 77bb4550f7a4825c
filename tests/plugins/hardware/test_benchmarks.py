"""Each measurement of the arm, cut short; it exits with 1 where a promise is broken."""

from __future__ import annotations

import subprocess
import sys

import pytest
from helpers.checkout import ROOT

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.flaky(reruns=2),  # they measure times, and another program that is busy makes these long
]

BENCHMARKS = ROOT / "benchmarks"


@pytest.mark.parametrize(
    ("script", "args", "words"),
    [
        ("hardware_stops", ("--trials", "2", "--patience", "10", "--life", "1.2"), "segfault: 2 trials"),
        ("hardware_hostile", ("--actions", "400"), "0 of them wrong"),
        ("hardware_loop", ("--ticks", "20", "--policy", "arm", "--patience", "10"), "20 ticks"),
    ],
)
def test_a_short_measurement_keeps_its_promises(script: str, args: tuple[str, ...], words: str) -> None:
    command = [sys.executable, str(BENCHMARKS / f"{script}.py"), *args]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=240)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert words in ended.stdout
