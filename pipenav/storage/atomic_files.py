"""Files that appear complete or not at all: a killed process or a full disk leaves the earlier file as it was."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from pipenav.errors import FileProblem, PipenavError
from pipenav.storage.drafts import clear_drafts, clear_drafts_once, draft_path

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
            clear_drafts_once(path.parent.absolute())
            drafts[path] = draft_path(path.parent, path.suffix)
            _write_draft(drafts[path], content)
        for path, draft in drafts.items():
            draft.replace(path)
        for folder in {path.parent for path in drafts}:
            sync_folder(folder)
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
    clear_drafts(path)
    probe = draft_path(path, "-probe")  # permissions alone say too little: a mount may be read-only
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileProblem(path, "write into", error) from error
    return path


@contextlib.contextmanager
def used_folder(path: Path) -> Iterator[Path]:
    """A folder as `prepare_folder` gives it; one that was made for it, and is empty in the end, goes again.

    Raises:
        FileProblem: it cannot be created, is no folder, or is read-only.
    """
    made = [folder for folder in (path, *path.parents) if not folder.exists()]
    try:
        yield prepare_folder(path)
    finally:
        with contextlib.suppress(OSError):  # the first that holds anything ends it
            for folder in made:
                folder.rmdir()


def check_outputs(outputs: Sequence[Path], inputs: Iterable[Path] = ()) -> None:
    """Refuse files that could not be written later, before the work is done whose results they hold.

    Args:
        outputs: files that will be written.
        inputs: files that are read, none of which may be written over.

    Raises:
        PipenavError: a file would be written over one that is read, or over another result.
        FileProblem: a file cannot be written.
    """
    read = list(inputs)
    for i, path in enumerate(outputs):
        if any(_same(path, other) for other in read):
            raise PipenavError(f"{path} is read and would be written over: give the result another name.")
        if any(_same(path, other) for other in outputs[:i]):
            raise PipenavError(f"{path} is named for two results: give each a name of its own.")
        if not path.parent.is_dir():
            raise PipenavError(f"there is no folder {path.parent} for {path.name}: make it first.")
        probe = draft_path(path.parent, "-probe")
        try:
            _refuse_special(path)
            probe.touch()
            probe.unlink()
        except OSError as error:
            raise FileProblem(path, "write", error) from error


def _same(one: Path, other: Path) -> bool:
    """Whether two paths name one file, by links too."""
    with contextlib.suppress(OSError):
        return one.samefile(other)
    return one.absolute() == other.absolute()


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
    _sync_file(draft)


def sync_files(folder: Path) -> None:
    """Make all files of a folder reach the disk.

    Raises:
        OSError: the disk failed.
    """
    for path in folder.iterdir():
        if path.is_file():
            _sync_file(path)
    sync_folder(folder)


def _sync_file(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


def sync_folder(folder: Path) -> None:
    """Make the new names last through a power cut, where the file system can."""
    with contextlib.suppress(OSError):  # the files are in place already, and some systems cannot sync a folder
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
