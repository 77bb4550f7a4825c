"""SCIP2, the language of Hokuyo scanners (specification C-42-03320B): its encoding, and a driver on a serial port.

Every line ends in LF; a reply is the command's echo, a status with its sum, data lines with their sums, an empty line.
Numbers are written big end first, six bits a character.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pipenav.errors import PipenavError
from pipenav_hardware import scip2_status
from pipenav_hardware.arm_config import ScannerConfig
from pipenav_hardware.ranging import RangeScan, RangeSensor, SensorLost, mounted
from pipenav_hardware.serial_line import SerialLine
from pipenav_hardware.watchdog import Farewell

OFFSET = 0x30
LINE_DATA = 64
"""Number of characters of data in a line, before its sum."""

COMMAND_TIMEOUT = 1.0
QUIT = b"QT\n"
"""Order that ends measuring and switches the laser off."""

MEASURING = re.compile(r"MD(\d{4})(\d{4})(\d{2})(\d)(\d{2})")


@lru_cache(maxsize=8192)
def encode(value: int, characters: int) -> str:
    """A number in 2, 3 or 4 characters."""
    return "".join(chr((value >> 6 * i & 0x3F) + OFFSET) for i in reversed(range(characters)))


@lru_cache(maxsize=8192)
def decode(text: str) -> int:
    """The number in such characters."""
    value = 0
    for character in text:
        value = value << 6 | (ord(character) - OFFSET & 0x3F)
    return value


def checksum(text: str) -> str:
    """The character that is a text's sum."""
    return chr((sum(text.encode("latin-1")) & 0x3F) + OFFSET)


def with_sum(text: str) -> str:
    """A text with its sum."""
    return text + checksum(text)


def data_lines(text: str) -> Iterator[str]:
    """A data block as lines of at most 64 characters with their sums; a number may straddle two lines."""
    for start in range(0, len(text), LINE_DATA):
        yield with_sum(text[start : start + LINE_DATA])


def checked(line: str) -> str | None:
    """A line without its sum; None if the sum is wrong."""
    return line[:-1] if line and checksum(line[:-1]) == line[-1] else None


def parameters(lines: list[str]) -> dict[str, str]:
    """Values in `KEY:value;sum` lines. Scanners leave the `;` out of the sum, others count it: both are right."""
    found = {}
    for line in lines:
        body, _, given = line.rpartition(";")
        if given in (checksum(body), checksum(body + ";")):
            key, _, value = body.partition(":")
            found[key] = value
    return found


class Scan(NamedTuple):
    """A measurement of a scanner.

    Attributes:
        stamp: the scanner's own time [ms, 24 bits].
        distances: distance [mm] or error code of every step.
    """

    stamp: int
    distances: list[int]


def parse_scan(lines: list[str]) -> Scan | None:
    """The measurement in a reply to MD, from its echo on; None if it is none, is cut short, or any sum is wrong."""
    echo = MEASURING.fullmatch(lines[0]) if lines else None
    if echo is None or len(lines) < 4 or lines[1] != with_sum("99"):
        return None
    stamp, *blocks = (checked(line) for line in lines[2:])
    if stamp is None or None in blocks:
        return None
    text = "".join(block for block in blocks if block is not None)
    first, last, cluster = int(echo[1]), int(echo[2]), max(int(echo[3]), 1)
    count = (last - first) // cluster + 1
    if len(text) != 3 * count:
        return None
    return Scan(decode(stamp), [decode(text[i : i + 3]) for i in range(0, len(text), 3)])


class Scip2Scanner(RangeSensor):
    """A Hokuyo-like scanner, measuring without pause over the fan that is asked for."""

    def __init__(self, config: ScannerConfig, fan: float) -> None:
        self._line = SerialLine(config.port, config.baud, "scanner")
        self._reply: list[str] = []
        self._sequence, self._stamp, self.rejected = 0, -1, 0
        self._latest: RangeScan | None = None
        self._farewell = Farewell(self._line.fileno(), QUIT)
        try:
            self._begin(config, fan)
        except BaseException:
            self.close()
            raise

    def _begin(self, config: ScannerConfig, fan: float) -> None:
        """Have the scanner measure over a fan [rad], in whatever state an earlier program left it."""
        self._command("QT")
        self._command("SCIP2.0", required=False)
        self._command("TM2", required=False)  # in time-stamp mode it would not measure
        self.words = parameters(self._command("II", required=False)).get("STAT", "")
        values = parameters(self._command("PP"))
        try:
            resolution, front = int(values["ARES"]), int(values["AFRT"])
            first, last = int(values["AMIN"]), int(values["AMAX"])
            self.range_min, self.range_max = int(values["DMIN"]) / 1e3, int(values["DMAX"]) / 1e3
        except (KeyError, ValueError):
            raise SensorLost("scanner", f"on {config.port} does not send its parameters") from None
        half = math.floor((fan / 2 + abs(math.radians(config.mounting_deg))) / (2 * math.pi) * resolution) + 2
        first, last = max(first, front - half), min(last, front + half)
        steps = np.arange(first, last + 1)
        self.angles = mounted((steps - front) * 2 * math.pi / resolution, config)
        self._command("BM")
        self._line.write(f"MD{first:04d}{last:04d}01000\n".encode("ascii"))
        self._wait_for_first()

    def fileno(self) -> int:
        return self._line.fileno()

    def pump(self, now: float) -> None:
        for line in self._line.lines():
            if line:
                self._reply.append(line)
            else:
                self._take(now)

    def latest(self) -> RangeScan | None:
        return self._latest

    def close(self) -> None:
        self._line.close(QUIT)
        self._farewell.close()

    def _take(self, now: float) -> None:
        """Take in a reply that has ended."""
        reply, self._reply = self._reply, []
        if len(reply) > 1 and MEASURING.fullmatch(reply[0]):
            status = checked(reply[1])
            if status not in (None, scip2_status.OK, scip2_status.SCAN, scip2_status.RESUMED):
                raise self._refusal(reply[0], status)
        scan = parse_scan(reply)
        if scan is None or len(scan.distances) != len(self.angles):
            self.rejected += bool(reply) and len(reply) > 2
            return
        if scan.stamp == self._stamp:
            return  # the same measurement once more is not a new one: it grows old
        self._sequence, self._stamp = self._sequence + 1, scan.stamp
        self._latest = RangeScan(tuple(scan.distances), now, self._sequence)

    def _command(self, text: str, required: bool = True) -> list[str]:
        """Send a command.

        Returns:
            The lines of the reply after its status.
        """
        self._line.write(f"{text}\n".encode("ascii"))
        deadline, reply = time.monotonic() + COMMAND_TIMEOUT, list[str]()
        while time.monotonic() < deadline:
            for line in self._line.lines(wait=0.02):
                if line:
                    reply.append(line)
                    continue
                if len(reply) > 1 and reply[0] == text:
                    status = reply[1][:2]
                    if required and not scip2_status.accepted(text, status):
                        raise self._refusal(text, status)
                    return reply[2:]
                reply = []  # the end of an earlier reply
        if required:
            raise SensorLost("scanner", f"does not answer {text}")
        return []

    @staticmethod
    def _refusal(command: str, status: str) -> SensorLost:
        """The error for a command that the scanner did not carry out, in its own words."""
        said = scip2_status.words(command, status)
        return SensorLost("scanner", f"{said} (to {command[:2]})", "switch it off and on, then run pipenav hw-check")

    def _wait_for_first(self) -> None:
        deadline = time.monotonic() + COMMAND_TIMEOUT
        while self._latest is None:
            if time.monotonic() > deadline:
                raise SensorLost("scanner", "sends no scans")
            time.sleep(0.005)
            self.pump(time.monotonic())


def open_scanner(config: ScannerConfig, fan: float) -> RangeSensor:
    """The scanner that a description names.

    Args:
        config: the scanner's description.
        fan: how wide it must see [rad].
    """
    if config.driver == "realsense":
        from pipenav_hardware.realsense import RealSenseScanner

        return RealSenseScanner(config)
    if not config.port:
        raise PipenavError("the scanner has no port: name it in arm.toml, for example port = '/dev/ttyACM0'.")
    return Scip2Scanner(config, fan)
