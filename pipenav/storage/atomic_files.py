"""Files that appear complete or not at all: a killed process or a full disk leaves the earlier file as it was."""

from __future__ import annotations

import contextlib
import errno
import os
import uuid
from collections.abc import Callable, Mapping
from pathlib import Path

from pipenav.errors import FileProblem

Content = Callable[[Path], None] | bytes | str
"""Content of a file: bytes, text (UTF-8), or a function that writes the file at the path that it is given."""


def atomic_write(path: Path, write: Content) -> None:
    """Write one file, complete or not at all.

    Args:
        path: path of the file; its folder must exist.
        write: content of the file. A function gets a temporary path with the same suffix, in the same folder. It must
            raise OSError when the disk fails; where a library reports that otherwise, hand over bytes.

    Raises:
        FileProblem: the file cannot be written; an earlier file of that name is untouched.
    """
    atomic_write_all({path: write})


def atomic_write_all(files: Mapping[Path, Content]) -> None:
    """Write several files; no earlier file is replaced before the last new one has reached the disk.

    Raises:
        FileProblem: a file cannot be written; earlier files of those names are untouched.
    """
    drafts: dict[Path, Path] = {}
    path = Path()
    try:
        for path, content in files.items():
            _refuse_special(path)
            drafts[path] = path.with_name(f".{path.stem}-{uuid.uuid4().hex[:8]}{path.suffix}")
            _write_draft(drafts[path], content)
        for path, draft in drafts.items():
            draft.replace(path)
        for folder in {path.parent for path in drafts}:
            _sync_folder(folder)
    except OSError as error:
        raise FileProblem(path, "write", error) from error
    finally:
        for draft in drafts.values():
            with contextlib.suppress(OSError):
                draft.unlink(missing_ok=True)


def prepare_folder(path: Path) -> Path:
    """Create a folder where there is none, and make sure that files can be written into it.

    Raises:
        FileProblem: it cannot be created, is no folder, or is read-only.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise FileProblem(path, "use the folder", OSError(errno.ENOTDIR, "it is a file")) from None
    except OSError as error:
        raise FileProblem(path, "create the folder", error) from error
    probe = path / f".probe-{uuid.uuid4().hex[:8]}"  # permissions alone say too little: a mount may be read-only
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileProblem(path, "write into", error) from error
    return path


def _refuse_special(path: Path) -> None:
    """Refuse a folder, and a device such as /dev/null, which would be replaced by a plain file."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "it is a folder")
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "it is not a plain file")


def _write_draft(draft: Path, content: Content) -> None:
    if isinstance(content, str):
        content = content.encode("utf-8")
    if isinstance(content, bytes):
        draft.write_bytes(content)
    else:
        content(draft)
    with draft.open("rb") as file:
        os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    """Make the new names last through a power cut, where the file system can."""
    with contextlib.suppress(OSError):  # the files are in place already, and some systems cannot sync a folder
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
