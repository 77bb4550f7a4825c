"""Scripts of faults."""

from __future__ import annotations

import pytest
from pipenav_hardware.emulator.faults import BUS_FAULTS, Fault, FaultScript

from pipenav.errors import PipenavError


def test_faults_have_their_time_their_number_and_their_chance() -> None:
    script = FaultScript([Fault(fault="drop", at=1.0, span=1.0), Fault(fault="echo", count=2)], 0)
    struck = []
    for now in (0.5, 1.0, 1.9, 2.0):
        script.now = now
        struck.append(script.active("drop") is not None)
    assert struck == [False, True, True, False]
    assert [script.active("echo") is not None for _ in range(3)] == [True, True, False]
    chance = FaultScript([Fault(fault="drop", probability=0.25)], 1)
    assert 150 < sum(chance.active("drop") is not None for _ in range(1000)) < 350
    again = FaultScript([Fault(fault="drop", probability=0.25)], 1)
    first = [FaultScript([Fault(fault="drop", probability=0.25)], 1).active("drop") for _ in range(1)]
    assert [again.active("drop") is not None] == [first[0] is not None]


def test_an_unknown_fault_is_refused_by_name() -> None:
    with pytest.raises(PipenavError, match="bus has no fault 'explode': choose drop, "):
        FaultScript([Fault(fault="explode")], 0)
    assert "drop" in BUS_FAULTS
