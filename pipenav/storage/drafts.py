"""Names of drafts: hidden, each with its owner's process, so that what a killed process left is cleared away later."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import re
import shutil
import time
import uuid
from functools import cache
from pathlib import Path

from pipenav.storage.owners import owner_runs

FOREIGN_AGE_S = 86_400.0
"""Age at which a draft of another machine, or of an earlier start of this one, is taken for abandoned [s]."""

_DRAFT = re.compile(r"\.pipenav-(?P<pid>\d+)-(?P<host>[0-9a-f]{6})-[0-9a-f]{8}(?:-old-(?P<replaced>.+)|\..*|-probe)?")


def draft_path(folder: Path, suffix: str = "") -> Path:
    """A free path for a draft in a folder."""
    return folder / f".pipenav-{os.getpid()}-{_host()}-{uuid.uuid4().hex[:8]}{suffix}"


def replaced_path(path: Path) -> Path:
    """A free path beside a folder, to which it can be moved while another one takes its place."""
    return draft_path(path.parent, f"-old-{path.name}")


def clear_drafts(folder: Path) -> None:
    """Remove the drafts of killed processes from a folder; a folder that one moved aside is put back if it is missing.

    What cannot be removed stays: it is hidden, and the next process tries again.
    """
    with contextlib.suppress(OSError):
        for entry in os.scandir(folder):
            match = _DRAFT.fullmatch(entry.name)
            if match and _abandoned(int(match["pid"]), match["host"], entry):
                _clear(Path(entry.path), match["replaced"])


@cache
def clear_drafts_once(folder: Path) -> None:
    """`clear_drafts`, the first time that this process writes into the folder."""
    clear_drafts(folder)


def _clear(draft: Path, replaced: str | None) -> None:
    if replaced is not None and not (draft.parent / replaced).exists():
        draft.rename(draft.parent / replaced)
    elif draft.is_dir() and not draft.is_symlink():
        shutil.rmtree(draft, ignore_errors=True)
    else:
        draft.unlink(missing_ok=True)


def _abandoned(pid: int, host: str, entry: os.DirEntry[str]) -> bool:
    stat = entry.stat(follow_symlinks=False)
    if host != _host():
        return time.time() - stat.st_mtime > FOREIGN_AGE_S
    return not owner_runs(pid, stat.st_ctime)  # the time of contents stays old when a folder is moved aside


@cache
def _host() -> str:
    """Mark of the numbering of processes that this one belongs to: of the machine, its start and its container."""
    marks = [platform.node()]
    with contextlib.suppress(OSError):
        marks.append(Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii"))
    with contextlib.suppress(OSError):
        marks.append(str(Path("/proc/self/ns/pid").readlink()))
    return hashlib.sha256(" ".join(marks).encode()).hexdigest()[:6]
