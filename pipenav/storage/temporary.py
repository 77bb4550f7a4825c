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

from pipenav.storage.owners import owner_runs

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


@functools.cache
def _remove_abandoned() -> None:
    """Remove folders of ours whose process is gone, once in a process."""
    for path in Path(tempfile.gettempdir()).glob("pipenav-*-*"):
        named = _NAME.match(path.name)
        with contextlib.suppress(OSError):
            stat = path.lstat()
            if named and stat.st_uid == os.getuid() and not owner_runs(int(named["process"]), stat.st_mtime):
                shutil.rmtree(path)
