"""How a guarded arm is left: in order, by an error, by a signal."""

from __future__ import annotations

import contextlib
import gc
import os
import signal

import pytest

from pipenav.deployment.guard import Interrupted, guarded


class Arm:
    collected_before_off = True

    def cut(self) -> None: ...

    def off(self) -> list[str]:
        self.collected_before_off = gc.isenabled()
        return []


@pytest.mark.parametrize("ending", ["end", "error", "signal"])
def test_garbage_is_collected_again_once_torque_is_off(ending: str) -> None:
    arm = Arm()
    with contextlib.suppress(RuntimeError, Interrupted), guarded(arm):
        assert not gc.isenabled()
        if ending == "error":
            raise RuntimeError
        if ending == "signal":
            os.kill(os.getpid(), signal.SIGTERM)
    assert not arm.collected_before_off
    assert gc.isenabled()
