"""Files appear whole or not at all, whatever the disk does."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from pipenav.errors import FileProblem, PipenavError
from pipenav.storage.atomic_files import atomic_write, atomic_write_all, check_outputs, prepare_folder


def _no_space(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _half_then_full(path: Path) -> None:
    path.write_bytes(b"half")
    _no_space()


@pytest.mark.parametrize("content", ["grün\n", "grün\n".encode(), lambda path: path.write_bytes("grün\n".encode())])
def test_text_bytes_and_functions_are_written(tmp_path: Path, content: str | bytes | Callable[[Path], None]) -> None:
    atomic_write(tmp_path / "a.txt", content)
    assert (tmp_path / "a.txt").read_bytes() == "grün\n".encode()
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_function_gets_a_sibling_with_the_same_suffix(tmp_path: Path) -> None:
    seen = []
    atomic_write(tmp_path / "best.zip", lambda path: (seen.append(path), path.touch())[1])
    assert seen[0].parent == tmp_path
    assert seen[0].suffix == ".zip"  # libraries add a suffix that is missing, and would write elsewhere


def test_the_mode_follows_the_umask(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("x")
    atomic_write(tmp_path / "atomic", "x")
    assert (tmp_path / "atomic").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_full_disk_leaves_the_earlier_file_whole(tmp_path: Path) -> None:
    path = tmp_path / "best.zip"
    path.write_text("earlier")
    with pytest.raises(FileProblem, match=r"cannot write .*best.zip: No space left on device"):
        atomic_write(path, _half_then_full)
    assert path.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_fails_at_sync_leaves_the_earlier_file_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.json"
    path.write_text("earlier")
    monkeypatch.setattr(os, "fsync", _no_space)
    with pytest.raises(FileProblem, match="No space left"):
        atomic_write(path, "later")
    assert path.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_other_ends_leave_no_draft_either(tmp_path: Path, error: type[BaseException]) -> None:
    def interrupted(path: Path) -> None:
        path.write_text("half")
        raise error

    (tmp_path / "a").write_text("earlier")
    with pytest.raises(error):
        atomic_write(tmp_path / "a", interrupted)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a", "earlier")]


def test_of_several_files_none_is_replaced_when_the_last_fails(tmp_path: Path) -> None:
    first, last = tmp_path / "a", tmp_path / "b"
    first.write_text("earlier")
    with pytest.raises(FileProblem, match=r"cannot write .*b: No space"):
        atomic_write_all({first: "later", last: _half_then_full})
    assert first.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [first]


def test_a_missing_folder_is_a_file_problem(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="No such file or directory"):
        atomic_write(tmp_path / "nowhere" / "a", "x")


def test_folders_and_devices_are_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="it is a folder"):
        atomic_write(tmp_path, "x")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileProblem, match="it is not a plain file"):
        atomic_write(tmp_path / "pipe", "x")
    assert (tmp_path / "pipe").is_fifo()


def test_prepare_folder_creates_and_accepts(tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "one"
    assert prepare_folder(folder) == folder
    (folder / "kept").touch()
    prepare_folder(folder)
    assert [path.name for path in folder.iterdir()] == ["kept"]


def test_prepare_folder_refuses_files_and_what_lies_below_them(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FileProblem, match=r"cannot use the folder .*file: it is a file"):
        prepare_folder(tmp_path / "file")
    with pytest.raises(FileProblem, match="cannot create the folder"):
        prepare_folder(tmp_path / "file" / "below")


def test_prepare_folder_notices_a_read_only_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_only(*_: object, **__: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(Path, "touch", read_only)  # permissions would not stop a test that runs as root
    with pytest.raises(FileProblem, match=r"cannot write into .*: Read-only file system"):
        prepare_folder(tmp_path)


def test_outputs_are_refused_before_the_work(tmp_path: Path) -> None:
    read, link, new = tmp_path / "front.csv", tmp_path / "link.csv", tmp_path / "rear.csv"
    read.write_text("front")
    link.symlink_to(read)
    for output in (read, link, tmp_path / "." / ".." / tmp_path.name / "front.csv"):
        with pytest.raises(PipenavError, match=r"is read and would be written over: give the result another name"):
            check_outputs([output], inputs=[read])
    with pytest.raises(PipenavError, match=r"rear.csv is named for two results"):
        check_outputs([new, tmp_path / "." / "rear.csv"])
    with pytest.raises(PipenavError, match=r"there is no folder .*nowhere for a.csv: make it first"):
        check_outputs([tmp_path / "nowhere" / "a.csv"])
    with pytest.raises(FileProblem, match="it is a folder"):
        check_outputs([tmp_path])
    check_outputs([new], inputs=[read])
    assert {path.name for path in tmp_path.iterdir()} == {"front.csv", "link.csv"}
