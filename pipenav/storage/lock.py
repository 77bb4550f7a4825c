"""A folder has one writer at a time: a lock that vanishes with the process that holds it."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

from pipenav.errors import FileProblem, PipenavError
from pipenav.storage.atomic_files import used_folder

LOCK_FILE = ".pipenav.lock"
"""File in a folder in use; it holds the owner's process number and command."""

_NO_LOCKS = {errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS}
"""Errors by which a file system says that it has no locks: there, nobody is refused."""

MOST_TEXT = 300
"""Most characters of a command that are shown."""


class FolderInUse(PipenavError):
    """A folder that another process writes into."""

    def __init__(self, folder: Path, owner: str) -> None:
        super().__init__(
            f"{folder} is in use by {owner}: wait until that process ends or stop it, or choose another folder."
        )


def current_command() -> str:
    """The command line of this process, as it can be typed again."""
    return shlex.join(["pipenav", *sys.argv[1:]])


@contextlib.contextmanager
def one_writer(folder: Path, command: str | None = None, shared: bool = False) -> Iterator[Path]:
    """Make a folder where there is none, and keep other processes from writing into it until the block is left.

    A folder that was made for it and is still empty then goes again.

    Args:
        folder: path of the folder.
        command: words for what this process does there; by default its command line.
        shared: let others in that share it too, each with files of its own there.

    Raises:
        FolderInUse: another process writes into it.
        FileProblem: the folder cannot be made or written into.
    """
    with used_folder(folder):
        descriptor = _lock(folder, command or current_command(), fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
        try:
            yield folder
        finally:
            with contextlib.suppress(OSError):  # the folder may have been removed, or exchanged for one without it
                if shared:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)  # fails while others share it
                if _is_file_of(descriptor, folder / LOCK_FILE):
                    (folder / LOCK_FILE).unlink()
            os.close(descriptor)


def _lock(folder: Path, command: str, mode: int) -> int:
    """A descriptor of the locked file."""
    file = folder / LOCK_FILE
    while True:
        try:
            descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        except OSError as error:
            raise FileProblem(file, "write", error) from error
        try:
            _take(descriptor, folder, mode)
            if _is_file_of(descriptor, file):  # else its owner removed the file between our two calls
                _write_owner(descriptor, command)
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _take(descriptor: int, folder: Path, mode: int) -> None:
    try:
        fcntl.flock(descriptor, mode | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FolderInUse(folder, _owner(descriptor)) from None
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise FileProblem(folder / LOCK_FILE, "lock", error) from error


def _is_file_of(descriptor: int, file: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), file.stat(follow_symlinks=False))
    except FileNotFoundError:
        return False


def _write_owner(descriptor: int, command: str) -> None:
    with contextlib.suppress(OSError):  # a full disk: the lock holds without words
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"{os.getpid()}\n{command}\n".encode(errors="replace"), 0)


def _owner(descriptor: int) -> str:
    """Words for the process that holds the lock."""
    try:
        pid, _, command = os.pread(descriptor, 4096, 0).decode("utf-8", "replace").partition("\n")
    except OSError:
        pid, command = "", ""
    if not pid.isdigit():
        return "another process"
    shown = " ".join(command.split())
    shown = shown if len(shown) <= MOST_TEXT else f"{shown[:MOST_TEXT]}..."
    return f"process {pid} ({shown})" if shown else f"process {pid}"
