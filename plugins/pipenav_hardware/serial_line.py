"""A sensor's serial line: bytes in and out without blocking, and whatever a vanished device raises as one error."""

from __future__ import annotations

import contextlib
import os
import select
import termios
from collections.abc import Iterator

import serial

from pipenav_hardware.port_problems import port_problem
from pipenav_hardware.ranging import SensorLost


class SerialLine:
    """A serial device that sends lines."""

    def __init__(self, port: str, baud: int, name: str) -> None:
        self._name, self._buffer = name, b""
        try:
            self._serial = serial.Serial(port, baud, timeout=0, write_timeout=0.2, exclusive=True)
            self._serial.reset_input_buffer()
        except (OSError, termios.error) as error:
            raise port_problem(port, error) from error

    def fileno(self) -> int:
        """Descriptor of the port, which becomes readable when bytes have arrived."""
        return int(self._serial.fileno())

    def write(self, data: bytes) -> None:
        """Send bytes to the device."""
        with self._edge():
            self._serial.write(data)

    def lines(self, wait: float = 0.0) -> Iterator[str]:
        """Lines that are complete now, without their end.

        Args:
            wait: longest wait for the first bytes [s].
        """
        with self._edge():
            if wait:
                select.select([self.fileno()], [], [], wait)
            if self._readable():
                arrived = os.read(self.fileno(), 65536)
                if not arrived:
                    raise OSError("unplugged")
                self._buffer += arrived
        *whole, self._buffer = self._buffer.split(b"\n")
        yield from (line.rstrip(b"\r").decode("latin-1") for line in whole)

    def close(self, farewell: bytes = b"") -> None:
        """Send a last order and close the port, as far as the device is still there."""
        with contextlib.suppress(OSError, termios.error):
            self._serial.write(farewell)
        with contextlib.suppress(OSError, termios.error):
            self._serial.close()

    def _readable(self) -> bool:
        return bool(select.select([self.fileno()], [], [], 0)[0])

    @contextlib.contextmanager
    def _edge(self) -> Iterator[None]:
        """Turn everything that a vanished device raises into one error."""
        try:
            yield
        except (OSError, termios.error, ValueError, TypeError) as error:
            raise SensorLost(self._name, f"is lost ({error})") from error
