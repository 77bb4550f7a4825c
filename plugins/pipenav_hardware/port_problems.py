"""Sentences about what stands in the way of a serial port."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path

from pipenav.errors import PipenavError


def port_problem(name: str, error: Exception) -> PipenavError:
    """Why a port could not be opened, and what to do."""
    path = Path(name)
    number = getattr(error, "errno", None)
    if not path.exists():
        return PipenavError(f"there is no port {name}: plug the adapter in; {_ports_here()}.")
    if number == errno.EACCES or not os.access(path, os.R_OK | os.W_OK):
        group = _group_of(path)
        return PipenavError(
            f"no permission for {name}: it belongs to group {group}; "
            f"run sudo usermod -a -G {group} $USER and log in again."
        )
    if number == errno.EBUSY:
        return PipenavError(f"{name} is in use by {holder_of(name)}: end that process.")
    return PipenavError(f"{name} cannot be opened as a serial port ({error}): check its name.")


def holder_of(name: str) -> str:
    """The process that holds a port: the one that locked it, else one that has it open."""
    with contextlib.suppress(OSError):
        pid = _locked_by(Path(name).stat()) or _opened_by(Path(name).resolve())
        if pid:
            return f"process {pid} ({_command(pid)})"
    return "another process"


def _locked_by(status: os.stat_result) -> int | None:
    """Process that locked the file, from the kernel's table of locks."""
    wanted = f"{os.major(status.st_dev):02x}:{os.minor(status.st_dev):02x}:{status.st_ino}"
    for line in Path("/proc/locks").read_text().splitlines():
        fields = line.split()
        if "->" not in fields and fields[-3] == wanted:
            return int(fields[-4]) if int(fields[-4]) > 0 else None
    return None


def _opened_by(path: Path) -> int | None:
    for process in Path("/proc").iterdir():
        if process.name.isdigit() and int(process.name) != os.getpid():
            with contextlib.suppress(OSError):
                if any(file.readlink() == path for file in (process / "fd").iterdir()):
                    return int(process.name)
    return None


def _command(pid: int) -> str:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace").strip()[:80]
    return "?"


def _group_of(path: Path) -> str:
    try:
        return path.group()
    except KeyError:
        return str(path.stat().st_gid)


def _ports_here() -> str:
    from serial.tools.list_ports import comports

    names = [port.device for port in comports()]
    return f"here are {', '.join(names)}" if names else "no other is plugged in"
