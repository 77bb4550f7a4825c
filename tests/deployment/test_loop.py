"""Ways to leave a guarded arm: in order, by an error, by a signal."""

from __future__ import annotations

import contextlib
import gc
import os
import signal

import pytest

from pipenav.backends.real_robot import Stoppable
from pipenav.backends.safety import Stopped
from pipenav.deployment.guard import StoppedBySignal, guarded
from pipenav.errors import PipenavError


class Arm(Stoppable):
    collected_before_off = True

    def cut(self) -> None: ...

    def off(self) -> list[str]:
        self.collected_before_off = gc.isenabled()
        return []

    def close(self) -> None: ...


@pytest.mark.parametrize("ending", ["end", "error", "signal"])
def test_garbage_is_collected_again_once_torque_is_off(ending: str) -> None:
    arm = Arm()
    with contextlib.suppress(RuntimeError, StoppedBySignal), guarded(arm):
        assert not gc.isenabled()
        if ending == "error":
            raise RuntimeError
        if ending == "signal":
            os.kill(os.getpid(), signal.SIGTERM)
    assert not arm.collected_before_off
    assert gc.isenabled()


class SilentArm(Arm):
    """An arm two of whose servos do not confirm."""

    def off(self) -> list[str]:
        return ["theta1", "theta3"]


ENDINGS = [
    None,
    Stopped("comms", "a servo is silent", "check"),
    PipenavError("no."),
    RuntimeError("ours"),
    SystemExit(3),
]


@pytest.mark.parametrize("error", ENDINGS, ids=lambda error: type(error).__name__)
def test_every_ending_names_the_joints_that_did_not_confirm(error: BaseException | None) -> None:
    with pytest.raises(PipenavError) as raised, guarded(SilentArm()):
        if error is not None:
            raise error
    said = str(raised.value)
    assert said.endswith("Torque may still be on at theta1, theta3: switch the supply off before touching the arm.")
    assert error is None or str(error).split(":")[0].rstrip(".") in said, "what ended it is said too"
    assert not isinstance(error, Stopped) or raised.value is error


def test_a_signal_keeps_its_number_and_names_the_joints_that_did_not_confirm() -> None:
    with pytest.raises(StoppedBySignal, match="theta1, theta3: switch the supply off") as raised, guarded(SilentArm()):
        os.kill(os.getpid(), signal.SIGTERM)
    assert raised.value.number == signal.SIGTERM
