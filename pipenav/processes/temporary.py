"""Temporary folders that do not stay: those of processes that were killed go at the next start."""

from __future__ import annotations

import contextlib
import functools
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

CLOCKS_APART_S = 2.0
"""Largest error of a process's begin [s], which the kernel counts from a boot in whole seconds."""

_NAME = re.compile(r"pipenav-[a-z]+-(?P<process>[1-9][0-9]*)-")


@contextlib.contextmanager
def temporary_folder(purpose: str) -> Iterator[Path]:
    """A new folder, which is removed at the end; its name holds the number of this process.

    Args:
        purpose: word of lower-case letters, for the folder's name.
    """
    _remove_abandoned()
    with tempfile.TemporaryDirectory(prefix=f"pipenav-{purpose}-{os.getpid()}-", ignore_cleanup_errors=True) as path:
        yield Path(path)


def is_alive(process: int) -> bool:
    """Whether there is a process of this number."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def _is_of_another(process: int, path: Path) -> bool:
    """Whether the process of a number began after a folder was last changed, so that the number was given again."""
    try:
        stat = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
        booted = next(line for line in Path("/proc/stat").read_text(encoding="utf-8").splitlines() if "btime" in line)
    except OSError:
        return False
    ticks = int(stat.rpartition(")")[2].split()[19])  # field 22, proc(5); a name may hold spaces and brackets
    began = int(booted.split()[1]) + ticks / os.sysconf("SC_CLK_TCK")
    return began > path.lstat().st_mtime + CLOCKS_APART_S


@functools.cache
def _remove_abandoned() -> None:
    """Remove folders of ours whose process is gone, once in a process."""
    for path in Path(tempfile.gettempdir()).glob("pipenav-*-*"):
        named = _NAME.match(path.name)
        with contextlib.suppress(OSError):
            if named and path.lstat().st_uid == os.getuid():
                process = int(named["process"])
                if not is_alive(process) or _is_of_another(process, path):
                    shutil.rmtree(path)
