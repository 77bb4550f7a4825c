"""A pseudo-terminal behind a stable name, which can be pulled out and plugged in again; and the log of its bytes."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import select
import struct
import termios
import time
import tty
from collections.abc import Callable
from io import FileIO
from pathlib import Path
from typing import Any

Send = Callable[[float, bytes], None]
"""Sends bytes to the host, so many seconds from now."""

TCGETS2, TERMIOS2_SIZE = 0x802C542A, 44
"""Linux's question for all settings of a terminal, the output speed last."""

BAUDS = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name.startswith("B") and name[1:].isdigit()}
"""Speeds by the terminal's own numbers for them."""


class ByteLog:
    """A log of JSON objects, one a line: `t` on the system's monotonic clock [s], and bytes in or out, or an event."""

    def __init__(self, path: Path) -> None:
        self._file, self._full = FileIO(path, "w"), False

    def bytes(self, port: str, direction: str, data: bytes) -> None:
        """Log bytes that came `in` from the host, or went `out` to it."""
        self._write({"t": time.monotonic(), "port": port, "dir": direction, "hex": data.hex()})

    def event(self, what: str, **more: Any) -> None:
        """Log something that happened."""
        self._write({"t": time.monotonic(), "event": what, **more})

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._file.close()

    def _write(self, record: dict[str, Any]) -> None:
        """Write a record; on a full disk nothing more is written, and the devices go on."""
        try:
            if not self._full:
                self._file.write((json.dumps(record) + "\n").encode("ascii"))
        except OSError:
            self._full = True


class Line:
    """The device's end of a serial line. The host opens `path`, a link to the terminal of the moment.

    Attributes:
        path: the stable name.
        master: descriptor of our end; negative while the line is unplugged.
    """

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
        """Whether the line is there."""
        return self.master >= 0

    @property
    def opened(self) -> bool:
        """Whether a host has the line open; it is known only where we do not hold it open ourselves."""
        poll = select.poll()
        poll.register(self.master, select.POLLIN)
        return not any(event & select.POLLHUP for _, event in poll.poll(0))

    @property
    def baud(self) -> int:
        """Speed that the host has set; 0 where it is not known."""
        speed = termios.tcgetattr(self.master)[5]
        if speed in BAUDS:
            return BAUDS[speed]
        with contextlib.suppress(OSError):  # a speed without a name, as a number of its own
            return int(struct.unpack("I", fcntl.ioctl(self.master, TCGETS2, bytes(TERMIOS2_SIZE))[-4:])[0])
        return 0

    def read(self) -> bytes:
        """Bytes that have arrived from the host."""
        with contextlib.suppress(OSError):
            return os.read(self.master, 4096)
        return b""

    def write(self, data: bytes) -> None:
        """Send bytes to the host, without waiting."""
        with contextlib.suppress(OSError):  # nobody reads: a device does not wait either
            os.write(self.master, data)
