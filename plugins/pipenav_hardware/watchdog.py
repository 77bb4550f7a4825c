"""The driver's side of the supervisor process."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from pipenav.backends import Stopped
from pipenav_hardware import supervisor
from pipenav_hardware.packets import READ, TORQUE_OFF_ALL, Packet
from pipenav_hardware.table import TORQUE_ENABLE

SILENCE = 0.25
"""Longest silence of the driver while torque is on [s]: it speaks at least twice a control period, and stops by itself
when a tick takes 0.15 s. Longer silence means that it hangs."""

NO_SERVOS: Mapping[int, str] = MappingProxyType({})
"""No servo that the supervisor could ask."""


class Watchdog:
    """Starts the supervisor, and lets it know whether torque is on and that the driver lives."""

    def __init__(self, port: int, patience: float = 1.0, servos: Mapping[int, str] = NO_SERVOS) -> None:
        """
        Args:
            port: descriptor of the servo bus.
            patience: factor on `SILENCE`.
            servos: joint of each servo that the supervisor asks, by the servo's id.
        """
        reading, self._pipe = os.pipe()
        command = [sys.executable, "-I", str(Path(supervisor.__file__)), str(port), str(reading)]
        command += [TORQUE_OFF_ALL.hex(), str(SILENCE * patience)]
        command += [_question(servo, joint) for servo, joint in servos.items()]
        # A session of its own: neither Ctrl-C nor the terminal's end must reach it.
        self._process = subprocess.Popen(command, pass_fds=(port, reading), start_new_session=True)
        os.close(reading)

    def armed(self) -> None:
        """Let the supervisor know that torque is about to be switched on.

        Raises:
            Stopped: the supervisor is gone; torque must not be on without it.
        """
        self._order(b"A")

    def beat(self) -> None:
        """Let the supervisor know that the driver lives.

        Raises:
            Stopped: the supervisor is gone; torque must not be on without it.
        """
        self._order(b".")

    def disarmed(self) -> None:
        """Let the supervisor know that torque is off."""
        with contextlib.suppress(Stopped):
            self._order(b"D")

    def close(self) -> None:
        """Let the supervisor end; closing twice is harmless."""
        if self._pipe >= 0:
            os.close(self._pipe)
            self._pipe = -1
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout=2)

    def _order(self, order: bytes) -> None:
        try:
            os.write(self._pipe, order)
        except OSError as error:
            raise Stopped(
                "supervisor",
                f"the supervisor process, which switches torque off if this one dies, is gone ({error})",
                "find out what ended it, then start again",
            ) from error


class Farewell:
    """Sends a device its last order when this process ends without having done so itself, however it ends."""

    def __init__(self, port: int, order: bytes) -> None:
        """
        Args:
            port: descriptor of the device's port.
            order: what the device is sent.
        """
        reading, self._pipe = os.pipe()
        command = [sys.executable, "-I", str(Path(supervisor.__file__)), supervisor.FAREWELL]
        command += [str(port), str(reading), order.hex()]
        self._process = subprocess.Popen(command, pass_fds=(port, reading), start_new_session=True)
        os.close(reading)

    def close(self) -> None:
        """Let it end without a word: the device has had its order; closing twice is harmless."""
        if self._pipe >= 0:
            with contextlib.suppress(OSError):
                os.write(self._pipe, b"D")
            os.close(self._pipe)
            self._pipe = -1
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout=2)


def _question(servo: int, joint: str) -> str:
    """Question of the supervisor to a servo, whether its torque is off, as an argument of its command line."""
    request = Packet(servo, READ, bytes([TORQUE_ENABLE.address, TORQUE_ENABLE.size])).encode()
    off = Packet(servo, 0, bytes(TORQUE_ENABLE.size)).encode()
    return f"{request.hex()}:{off.hex()}:{joint}"
