"""A pseudo-terminal behind a stable name, that can be pulled out and plugged in again; and the log of its bytes."""

from __future__ import annotations

import contextlib
import json
import os
import select
import termios
import time
import tty
from pathlib import Path
from typing import Any

BAUDS = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name.startswith("B") and name[1:].isdigit()}


class ByteLog:
    """One JSON object a line: `t` on the system's monotonic clock [s], and bytes in and out or what happened."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", buffering=1, encoding="ascii")

    def bytes(self, port: str, direction: str, data: bytes) -> None:
        self._file.write(json.dumps({"t": time.monotonic(), "port": port, "dir": direction, "hex": data.hex()}) + "\n")

    def event(self, what: str, **more: Any) -> None:
        self._file.write(json.dumps({"t": time.monotonic(), "event": what, **more}) + "\n")

    def close(self) -> None:
        self._file.close()


class Line:
    """The device's end of a serial line. The host opens `path`, a link to the terminal of the moment."""

    def __init__(self, path: Path, hold_open: bool = True) -> None:
        self.path, self._hold_open = path, hold_open
        self.master = self._slave = -1
        self.plug()

    def plug(self) -> None:
        """Appear under the stable name."""
        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self.master, False)
        name = os.ttyname(self._slave)
        if not self._hold_open:  # so that the host's closing and opening can be seen
            os.close(self._slave)
            self._slave = -1
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(name)

    def unplug(self) -> None:
        """Vanish: the host's reads and writes fail, the name is gone."""
        self.path.unlink(missing_ok=True)
        for descriptor in (self.master, self._slave):
            with contextlib.suppress(OSError):
                os.close(descriptor)
        self.master = self._slave = -1

    @property
    def plugged(self) -> bool:
        return self.master >= 0

    @property
    def opened(self) -> bool:
        """Whether a host has it open; only of a line that is not held open."""
        poll = select.poll()
        poll.register(self.master, select.POLLIN)
        return not any(event & select.POLLHUP for _, event in poll.poll(0))

    @property
    def baud(self) -> int:
        """What the host has set."""
        return BAUDS.get(termios.tcgetattr(self.master)[5], 0)

    def read(self) -> bytes:
        with contextlib.suppress(OSError):
            return os.read(self.master, 4096)
        return b""

    def write(self, data: bytes) -> None:
        with contextlib.suppress(OSError):  # nobody reads: a device does not wait either
            os.write(self.master, data)
