"""The servo bus's serial port: dynamixel-sdk's own, with the sharp edges that were measured on it taken off.

The SDK spins while it waits, measures time by the wall clock, waits 34 ms for a silent servo and may block for ever in
a write. Here the port waits in short blocking reads on a monotonic clock, every write has a time-out, and what the mode
forbids is never sent.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import termios
import time
from collections.abc import Callable, Sequence
from enum import Enum

import serial
from dynamixel_sdk import PortHandler

from pipenav.errors import PipenavError
from pipenav_hardware import packets, table
from pipenav_hardware.port_problems import holder_of, port_problem

FIRST_ALLOWANCE = 0.034
"""Longest silence of a servo before the adapter's latency is known [s]: as long as the SDK waits."""

READ_SLICE = 0.002
"""Longest single wait for bytes [s]: the SDK asks again until its time-out."""

WRITE_TIMEOUT = 0.02
"""Longest wait for the adapter to take a packet [s]; a healthy one takes it at once."""

LOST = (OSError, termios.error, serial.SerialException)
"""Errors that a vanished adapter raises; termios.error is no OSError."""


class Mode(Enum):
    """Packets that may be sent on the bus."""

    LISTEN = "only PING and READ: for checks and dry runs"
    DRIVE = "everything that the driver knows"
    STOPPED = "torque may be switched off, and questions asked"


class Port(PortHandler):  # type: ignore[misc]  # the SDK has no types
    """The SDK's port on a monotonic clock, exclusive, never blocking for long, and refusing what its mode forbids.

    Attributes:
        mode: what may be sent.
        allowance: how long a servo may stay silent before it counts as silent [s]; the bytes' own time is added.
        sent: called with every packet that was sent.
    """

    def __init__(self, name: str, baud: int, patience: float) -> None:
        """
        Args:
            name: device of the port.
            baud: speed of the port.
            patience: factor on every time limit.
        """
        super().__init__(name)
        self._patience = patience
        self.baudrate, self.is_open = baud, False
        self.mode = Mode.LISTEN
        self.allowance = FIRST_ALLOWANCE
        self.sent: Callable[[bytes], None] | None = None
        self._heard = b""

    def setBaudRate(self, baudrate: int) -> bool:
        """Open the port at any speed: the SDK refuses some that the servo and the system can do."""
        self.baudrate = baudrate
        return self.setupPort(baudrate)

    def setupPort(self, cflag_baud: int) -> bool:  # noqa: ARG002  # the SDK's name and argument
        if self.is_open:
            self.closePort()
        try:
            self.ser = serial.Serial(self.port_name, self.baudrate)
        except ValueError:
            raise PipenavError(
                f"{self.port_name} cannot do {self.baudrate} baud: use another adapter, or another speed."
            ) from None
        except LOST as error:
            raise port_problem(self.port_name, error) from error
        try:
            fcntl.flock(self.ser.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.ser.close()
            raise PipenavError(
                f"{self.port_name} is in use by {holder_of(self.port_name)}: one master at a time; end that process."
            ) from None
        self.is_open = True
        self.flush()
        self.tx_time_per_byte = 10_000.0 / self.baudrate  # [ms]
        return True

    def setPacketTimeout(self, packet_length: int) -> None:
        self.packet_start_time = self.getCurrentTime()
        self.packet_timeout = self.tx_time_per_byte * packet_length + 1e3 * self.silence

    @property
    def silence(self) -> float:
        """Longest time until an answer begins [s]."""
        return self.allowance * self._patience

    def getCurrentTime(self) -> float:
        return time.monotonic() * 1e3

    def writePort(self, packet: Sequence[int]) -> int:
        data = bytes(packet)
        refused = _refusal(data, self.mode)
        if refused:
            raise PipenavError(refused)
        descriptor, left = self.ser.fileno(), data
        while left:
            with contextlib.suppress(BlockingIOError):
                left = left[os.write(descriptor, left) :]
            # pyserial's own write time-out also strikes when nothing but this program was slow
            if left and not select.select([], [descriptor], [], WRITE_TIMEOUT * self._patience)[1]:
                raise serial.SerialTimeoutException("it takes no bytes")
        if self.sent is not None:
            self.sent(data)
        return len(data)

    def readPort(self, length: int) -> bytes:
        """Bytes that have arrived, `length` at most; waits only where none has."""
        if not self._heard and select.select([self.ser.fileno()], [], [], READ_SLICE)[0]:
            self._heard = os.read(self.ser.fileno(), 4096)  # the SDK asks for a packet in two parts
            if not self._heard:
                raise serial.SerialException("it is unplugged")
        data, self._heard = self._heard[:length], self._heard[length:]
        return data

    def clearPort(self) -> None:
        """Drop what has arrived; not what the kernel is about to deliver, as `flush` does.

        `flush` waits for the kernel's worker thread, as `select` does where nothing has arrived. The worker runs at
        normal priority, behind every other program that wants the processor, and often has not ended yet when the
        answer before this one wakes us: up to 3 ms were seen. Between an answer and the next question nothing must wait
        for it.
        """
        self._heard = b""
        if waiting := self.ser.in_waiting:
            os.read(self.ser.fileno(), waiting)

    def flush(self) -> None:
        """Drop everything that was sent to us until now."""
        self._heard = b""
        self.ser.reset_input_buffer()

    def closePort(self) -> None:
        if self.ser is not None:
            self.ser.close()
        self.is_open = False


def _refusal(packet: bytes, mode: Mode) -> str:
    """Why a packet may not be sent now; empty if it may."""
    instruction = packet[4]
    if instruction in (packets.PING, packets.READ):
        return ""
    if instruction not in (packets.WRITE, packets.SYNC_WRITE):
        return f"the driver does not send instruction {instruction:#04x}."
    off = instruction == packets.WRITE and packet[5:-1] == bytes([table.TORQUE_ENABLE.address, 0])
    if mode is Mode.DRIVE or (mode is Mode.STOPPED and off):
        return ""
    return "the bus only listens now: nothing that moves or sets a servo is sent."
