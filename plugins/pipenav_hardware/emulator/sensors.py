"""The emulated scanner and front sensor, as their lines show them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from pipenav.robots import Laser
from pipenav_hardware import scip2
from pipenav_hardware.emulator.faults import Fault, FaultScript
from pipenav_hardware.emulator.line import Send
from pipenav_hardware.emulator.plant import Plant
from pipenav_hardware.front_sensor import HELLO, RANGE_MM, framed

TURN_STEPS = 1024
"""Number of steps in a whole turn of the scanner."""

SCAN_PERIOD = 0.1
"""Time from scan to scan of a URG-04LX [s]."""

FRONT_STEP = TURN_STEPS // 2
NOISE = 0.002
"""Noise of a healthy scanner, one sigma [m]."""

NO_ECHO = 0
"""Error code of a point that saw no wall."""

PATCH = 18
"""Number of steps in a patch that reads the minimum: 6 deg."""

FRONT_PERIOD = 0.04
BOOT_TIME = 1.5
"""Time for which a classic Arduino is deaf after its port was opened [s]."""


def _nowhere(what: str, **more: Any) -> None:
    """Log of a scanner that nobody watches."""


class Scip2Device:
    """A Hokuyo-like scanner with the ranges of the robot's own laser.

    Attributes:
        shines: whether its laser is on.
    """

    def __init__(
        self, laser: Laser, plant: Plant, faults: FaultScript, send: Send, note: Callable[..., None] = _nowhere
    ) -> None:
        """
        Args:
            laser: the robot's laser, whose ranges it has.
            plant: what it sees.
            faults: what goes wrong.
            send: sends bytes to the host.
            note: logs an event, here `laser` and whether it is on.
        """
        self._plant, self._faults, self._send, self._note = plant, faults, send, note
        self.shines = self._time_mode = False
        self._rng = np.random.default_rng(faults.number(2**31))
        self._least = max(round(laser.range_min * 1e3), 1)
        self._most = round(laser.range_max * 1e3)
        self._input, self._echo, self._next = b"", "", math.inf
        self._first = self._last = FRONT_STEP
        self._distances, self._lines = list[int](), list[str]()
        half = min(math.ceil(math.radians(laser.fan_deg) / 2 / (2 * math.pi) * TURN_STEPS) + 8, 340)
        self._limits = FRONT_STEP - half, FRONT_STEP + half

    def receive(self, data: bytes) -> None:
        """Take in bytes from the host."""
        *commands, self._input = (self._input + data).split(b"\n")
        for command in commands:
            self._command(command.decode("latin-1"))

    def run(self, now: float) -> float:
        """Send what is due.

        Returns:
            When the next scan is due [s].
        """
        if now >= self._next:
            self._scan(now)
            self._next = max(self._next + SCAN_PERIOD, now)
        return self._next

    def _command(self, text: str) -> None:
        """Obey a command of the host, and answer it."""
        if self._time_mode and (text == "BM" or scip2.MEASURING.fullmatch(text)):
            self._say(text, "0A")
        elif text == "BM" and self._faults.active("laser", "scanner"):
            self._say(text, "01")
        elif text == "BM":
            self._say(text, "02" if self.shines else "00")
            self._shine(True)
        elif text[:2] == "TM" and text[2:] in ("0", "2"):
            wanted = text == "TM0"
            self._say(text, "00" if wanted != self._time_mode else "02" if wanted else "03")
            self._time_mode = wanted
        elif text == "II":
            trouble = self._faults.active("trouble", "scanner")
            stat = f"STAT:{f'Error {int(trouble.value)}' if trouble else 'Sensor works well.'}"
            self._say(text, "00", *(f"{line};{scip2.checksum(line)}" for line in ("MODL:URG-04LX(emulated)", stat)))
        elif scip2.MEASURING.fullmatch(text):
            self._shine(True)
            self._first, self._last = int(text[2:6]), int(text[6:10])
            self._echo, self._next = text, 0.0
            self._say(text, "00")
        elif text in ("QT", "RS"):
            self._next = math.inf
            self._shine(False)
            self._say(text, "00")
        elif text == "PP":
            first, last = self._limits
            values = [
                "MODL:URG-04LX(emulated)", f"DMIN:{self._least}", f"DMAX:{self._most}", f"ARES:{TURN_STEPS}",
                f"AMIN:{first}", f"AMAX:{last}", f"AFRT:{FRONT_STEP}", "SCAN:600",
            ]  # fmt: skip
            self._say(text, "00", *(f"{line};{scip2.checksum(line)}" for line in values))
        elif text == "SCIP2.0":
            self._say(text, "00")
        elif text:
            self._say(text, "0E")

    def begin(self, fault: Fault) -> None:
        """Begin a fault that changes the scanner once."""
        if fault.fault == "time_mode":
            self._time_mode, self._next = True, math.inf

    def _shine(self, on: bool) -> None:
        """Switch the laser on or off."""
        if on != self.shines:
            self.shines = on
            self._note("laser", on=on)

    def _say(self, echo: str, status: str, *lines: str) -> None:
        reply = [echo, scip2.with_sum(status), *lines, "", ""]
        self._send(0.0, "\n".join(reply).encode("latin-1"))

    def _scan(self, now: float) -> None:
        """Send a scan, with what goes wrong with it."""
        faults = self._faults
        if faults.active("drop", "scanner"):
            return
        if trouble := faults.active("trouble", "scanner"):
            self._say(self._echo, f"{int(trouble.value):02d}")
            self._next = math.inf
            return
        if not (faults.active("freeze", "scanner") and self._distances):
            self._distances = self.measure(now)
        if not (faults.active("stuck", "scanner") and self._lines):
            text = "".join(scip2.encode(value, 3) for value in self._distances)
            stamp = scip2.with_sum(scip2.encode(round(now * 1e3) & 0xFFFFFF, 4))
            self._lines = [self._echo, scip2.with_sum("99"), stamp, *scip2.data_lines(text), "", ""]
        lines = self._lines
        data = "\n".join(lines).encode("latin-1")
        if faults.active("corrupt", "scanner"):
            at = 25 + faults.number(len(data) - 30)
            data = data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]
        if faults.active("truncate", "scanner"):
            data = data[: len(data) // 2] + b"\n\n"
        late = faults.active("late", "scanner")
        self._send(late.value if late else 0.0, data)

    def measure(self, now: float) -> list[int]:
        """Measure a scan: distances [mm] and error codes."""
        faults = self._faults
        steps = np.arange(self._first, self._last + 1)
        if faults.active("blind", "scanner"):
            return [NO_ECHO] * len(steps)
        noise = faults.active("noise", "scanner")
        true = self._plant.distances(now, (steps - FRONT_STEP) * 2 * math.pi / TURN_STEPS)
        seen = true + self._rng.normal(0.0, noise.value if noise else NOISE, len(steps))
        millimetres = np.round(np.nan_to_num(seen, posinf=1e3) * 1e3)
        millimetres = np.clip(millimetres, self._least, None)
        millimetres[millimetres > self._most] = NO_ECHO
        dropout = faults.active("minimum", "scanner")
        if dropout:
            patches = self._rng.random(len(steps) // PATCH + 2) < dropout.probability
            lost = patches[(np.arange(len(steps)) + int(self._rng.integers(PATCH))) // PATCH]
            millimetres[lost] = self._least
        return [int(value) for value in millimetres]


class FrontDevice:
    """The Arduino: silent while it boots, then hello, then readings."""

    def __init__(self, plant: Plant, faults: FaultScript, send: Send, boot_time: float) -> None:
        self._plant, self._faults, self._send, self._boot_time = plant, faults, send, boot_time
        self._opened, self._next, self._greeted, self._sequence = False, math.inf, False, 0
        self._reading = 0

    def run(self, now: float, opened: bool) -> float:
        """Send what is due.

        Returns:
            When the next reading is due [s].
        """
        if opened and not self._opened:
            self._next, self._greeted = now + self._boot_time, False  # opening the port resets the board
        self._opened = opened
        if not opened:
            return now + FRONT_PERIOD
        if now >= self._next:
            self._next += FRONT_PERIOD
            self._speak(now)
        return min(self._next, now + FRONT_PERIOD)

    def _speak(self, now: float) -> None:
        """Send a reading, with what goes wrong with it; a greeting before the first."""
        faults = self._faults
        if not self._greeted:
            self._send(0.0, f"{framed(HELLO)}\r\n".encode())
            self._greeted = True
        if faults.active("drop", "front"):
            return
        stuck = faults.active("stuck", "front")
        if not stuck:
            self._sequence = (self._sequence + 1) % 65536
        if not (stuck or faults.active("freeze", "front")):
            millimetres = self._plant.distances(now, np.zeros(1))[0] * 1e3
            inside = RANGE_MM[0] <= millimetres <= RANGE_MM[1] and not faults.active("blind", "front")
            self._reading = round(millimetres) if inside else 0
        line = framed(f"F,{self._sequence},{self._reading}")
        if faults.active("corrupt", "front"):
            line = line.replace(",", ";", 1)
        self._send(0.0, f"{line}\n".encode())
