"""The front distance sensor: an Arduino that sends `$F,sequence,millimetres*hh` 25 times a second.

The sketch is `front_sensor.ino` beside this file. `hh` is the exclusive or of all characters between `$` and `*`, in
hexadecimal. Opening the port resets a classic Arduino, which is then deaf for a second or two and says hello.
"""

from __future__ import annotations

import re
import time

from pipenav_hardware.arm_config import FrontSensorConfig
from pipenav_hardware.ranging import SensorLost
from pipenav_hardware.serial_line import SerialLine

BAUD = 115_200
HELLO = "HELLO,pipenav-front,1"
HELLO_TIMEOUT = 3.0
RANGE_MM = (10, 1000)
READING = re.compile(r"F,(\d{1,5}),(\d{1,5})")


def framed(body: str) -> str:
    """A line of the protocol, without its end."""
    return f"${body}*{exclusive_or(body):02X}"


def unframed(line: str) -> str | None:
    """Body of a line; None if the line is damaged."""
    body, star, given = line[1:].partition("*")
    return body if line[:1] == "$" and star and given == f"{exclusive_or(body):02X}" else None


def exclusive_or(body: str) -> int:
    """Exclusive or of all characters."""
    total = 0
    for character in body:
        total ^= ord(character) & 0xFF
    return total


class FrontSensor:
    """The sensor on its serial line, with its newest reading.

    Attributes:
        distance: newest reading, from the tip [m]; None where it measures nothing within its range.
        stamp: when the newest reading came, on the monotonic clock [s].
        rejected: number of lines that came damaged.
    """

    def __init__(self, config: FrontSensorConfig, hello_timeout: float = HELLO_TIMEOUT) -> None:
        self._line = SerialLine(config.port, BAUD, "front sensor")
        self._offset = config.offset_mm
        self._sequence = -1
        self.distance: float | None = None
        self.stamp = time.monotonic()
        self.rejected = 0
        deadline = time.monotonic() + hello_timeout
        while self._sequence < 0:
            if time.monotonic() > deadline:
                raise SensorLost("front sensor", f"on {config.port} sends no readings")
            time.sleep(0.01)
            self.pump(time.monotonic())

    def fileno(self) -> int:
        """A descriptor that becomes readable when there is something to `pump`."""
        return self._line.fileno()

    def pump(self, now: float) -> None:
        """Take in what has arrived."""
        for line in self._line.lines():
            body = unframed(line)
            reading = READING.fullmatch(body) if body else None
            if reading is None:
                self.rejected += body != HELLO
                continue
            sequence, millimetres = int(reading[1]), int(reading[2])
            if sequence == self._sequence:
                continue  # a stuck counter is not a new reading: it grows old
            self._sequence, self.stamp = sequence, now
            inside = RANGE_MM[0] <= millimetres <= RANGE_MM[1]
            self.distance = max(millimetres - self._offset, 0.0) / 1e3 if inside else None

    def close(self) -> None:
        self._line.close()
