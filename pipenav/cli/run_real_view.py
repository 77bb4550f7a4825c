"""The view of a mission in the terminal, and the keys that stop the arm."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import termios
import tty
from types import TracebackType
from typing import Any, Self

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from pipenav.backends.safety import Stopped
from pipenav.cli.terminal import say
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm, rad_to_deg

BARS = " ▁▂▃▄▅▆▇█"
EVERY = 3
"""Number of ticks from one picture to the next: three a second can be read, and cost a tenth of a tick."""


class MissionView:
    """Shows the record of every tick; in a terminal, the space bar is the emergency stop."""

    def __init__(self, console: Console, robot: RobotSpec) -> None:
        self._console, self._robot = console, robot
        self._live = Live(console=console, auto_refresh=False, transient=True) if console.is_terminal else None
        self._stage = ""
        self._terminal: list[Any] | None = None
        self._held = False

    def __enter__(self) -> Self:
        if self._live is not None:
            if sys.stdin.isatty():
                self._terminal = termios.tcgetattr(sys.stdin)
                tty.setcbreak(sys.stdin)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()
        if self._terminal is not None:
            with contextlib.suppress(OSError, ValueError, termios.error):  # the terminal may be gone
                termios.tcsetattr(sys.stdin, termios.TCSANOW, self._terminal)

    def __call__(self, record: dict[str, Any]) -> None:
        """Show the record of a tick.

        Raises:
            Stopped: the space bar was pressed.
        """
        if b" " in self._keys():
            raise Stopped("e-stop", "the space bar was pressed", "start again when the arm is free")
        if record["stage"] not in (self._stage, "hold"):
            self._stage = record["stage"]
            say(f"{record['tick'] / 10:6.1f} s  {self._stage}", console=self._console)
        if self._live is not None and "q" in record and record["tick"] % EVERY == 0:
            self._live.update(self._picture(record), refresh=True)

    def released(self) -> bool:
        """Whether any key was pressed: the person at the keyboard holds the arm now. Asks for it the first time."""
        if not self._held:
            self._held = True
            say("Stopped, and torque is still on: hold the arm, then press any key.", "yellow", self._console)
        return bool(self._keys())

    def _keys(self) -> bytes:
        """All keys pressed since the last time.

        They are read past Python's buffer, in which the second of two keys would wait.
        """
        with contextlib.suppress(OSError, ValueError):
            if self._terminal is not None and select.select([sys.stdin], [], [], 0)[0]:
                return os.read(sys.stdin.fileno(), 1024)
        return b""

    def _picture(self, record: dict[str, Any]) -> Group:
        joints = Table("joint", "position", "sent", "", box=None, pad_edge=False)
        sent = record.get("sent") or [None] * len(self._robot.joints)
        for joint, q, set_point in zip(self._robot.joints, record["q"], sent, strict=True):
            slide = joint.type == "slide"
            shown = [self._position(value, slide) for value in (q, set_point)]
            limited = "limited" if joint.name in record.get("clamped", []) else ""
            joints.add_row(Text(joint.name, "bold"), *shown, Text(limited, "yellow"))
        most = self._robot.laser.range_max
        bars = "".join(BARS[round(r / most * (len(BARS) - 1))] for r in reversed(record["ranges"]))
        target = record.get("target")
        where = "not found yet" if target is None else f"{m_to_mm(target[0]):.0f}, {m_to_mm(target[1]):.0f} mm"
        seconds = record["seconds"]
        timing = ", ".join(
            f"{name} {seconds[name] * 1e3:.1f}" for name in ("bus", "decide", "taken") if name in seconds
        )
        least = m_to_mm(min(record["ranges"]))
        lines = [
            Text(f"stage {record['stage']}, tick {record['tick']}, target {where}"),
            Text(f"ranges, left to right  {bars}  least {least:.0f} mm"),
            Text(f"ms: {timing}; late {record['raw']['late']}"),
            *(Text(warning, "yellow") for warning in record.get("warnings", [])),
            Text("space or Ctrl-C stops", "dim"),
        ]
        return Group(joints, *lines)

    @staticmethod
    def _position(value: float | None, slide: bool) -> str:
        if value is None:
            return ""
        return f"{m_to_mm(value):8.1f} mm" if slide else f"{rad_to_deg(value):8.1f} deg"
