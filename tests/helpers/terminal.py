"""Commands on a terminal of a given width, and with their output redirected."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from typing import NamedTuple


class Shown(NamedTuple):
    """End of a command: exit code, stdout without colours, and stderr where it is no terminal."""

    code: int
    out: str
    err: str


def environment() -> dict[str, str]:
    """The environment without anything that says how wide a terminal is."""
    return {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "FORCE_COLOR")} | {
        "TERM": "xterm"
    }


def on_terminal(columns: int, *args: str) -> Shown:
    """Run `pipenav ARGS` with stdout on a terminal of so many columns."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    command = [sys.executable, "-m", "pipenav", *args]
    with subprocess.Popen(command, stdout=theirs, stderr=subprocess.PIPE, env=environment()) as process:
        os.close(theirs)
        seen = b""
        try:
            while part := os.read(ours, 65536):
                seen += part
        except OSError:  # the other end was closed
            pass
        assert process.stderr is not None
        err = process.stderr.read().decode()
    os.close(ours)
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", seen.decode()).replace("\r\n", "\n")
    return Shown(process.returncode, text, err)


def redirected(*args: str) -> Shown:
    """Run `pipenav ARGS` with stdout and stderr in pipes."""
    command = [sys.executable, "-m", "pipenav", *args]
    done = subprocess.run(command, capture_output=True, text=True, env=environment())
    return Shown(done.returncode, done.stdout, done.stderr)
