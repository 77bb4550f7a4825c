"""A folder that is replaced is the older one or the new one at every moment, whole."""

from __future__ import annotations

import errno
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pipenav.errors import FileProblem, PipenavError
from pipenav.storage import atomic_folder
from pipenav.storage.atomic_folder import write_folder
from pipenav.storage.drafts import clear_drafts
from pipenav.storage.exchange import exchange

FILES = ("record.json", "a.txt", "b.txt")


def write(folder: Path, text: str) -> None:
    """Write a folder whose files all hold the same text."""

    def fill(draft: Path) -> None:
        for name in FILES:
            (draft / name).write_text(text)

    write_folder(folder, "test folder", "record.json", FILES, fill)


def texts(folder: Path) -> set[str]:
    """The texts in the files of a folder, one if it is whole."""
    return {(folder / name).read_text() for name in FILES}


@pytest.mark.parametrize("atomic", [True, False])
def test_files_of_others_are_kept(tmp_path: Path, atomic: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not atomic:
        monkeypatch.setattr(atomic_folder, "exchange", lambda *_: False)
    folder = tmp_path / "folder"
    write(folder, "1")
    (folder / "notes").mkdir()
    (folder / "notes" / "mine.txt").write_text("mine")
    (folder / "link").symlink_to("nowhere")
    write(folder, "2")
    assert texts(folder) == {"2"}
    assert (folder / "notes" / "mine.txt").read_text() == "mine"
    assert (folder / "link").is_symlink()
    assert list(tmp_path.iterdir()) == [folder]


def test_an_empty_folder_may_be_filled_and_another_may_not(tmp_path: Path) -> None:
    write(tmp_path / "empty", "1")
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "thesis.txt").touch()
    with pytest.raises(PipenavError, match="taken exists and is not a test folder: move it away"):
        write(tmp_path / "taken", "1")
    (tmp_path / "made").mkdir()
    write(tmp_path / "made", "1")
    assert texts(tmp_path / "made") == {"1"}


def test_a_full_disk_leaves_the_older_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "folder"
    write(folder, "1")

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(FileProblem, match=r"cannot write .*folder: No space left on device"):
        write(folder, "2")
    assert texts(folder) == {"1"}
    assert list(tmp_path.iterdir()) == [folder]


def test_an_exchange_is_one_step_or_none(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    one.mkdir()
    other.mkdir()
    (one / "x").touch()
    if exchange(one, other):
        assert list(other.iterdir()) == [other / "x"]
    with pytest.raises(FileNotFoundError):
        exchange(one, tmp_path / "missing")


@pytest.mark.slow
@pytest.mark.parametrize("atomic", [True, False])
def test_killed_at_any_moment_it_leaves_a_whole_folder(tmp_path: Path, atomic: bool) -> None:
    folder = tmp_path / "folder"
    write(folder, "0")
    (folder / "kept.txt").write_text("kept")
    program = (
        "import sys, itertools\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from pathlib import Path\n"
        "from test_atomic_folder import atomic_folder, write\n"
        f"if not {atomic}:\n    atomic_folder.exchange = lambda *_: False\n"
        "print('started', flush=True)\n"
        "for i in itertools.count(1): write(Path(sys.argv[1]), str(i))\n"
    )
    rng = random.Random(0)
    for _ in range(12):
        process = subprocess.Popen([sys.executable, "-c", program, str(folder)], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(rng.uniform(0.0, 0.1))
        process.send_signal(signal.SIGKILL)
        process.wait()
        if not atomic:
            clear_drafts(tmp_path)  # puts back a folder that was moved aside
        assert len(texts(folder)) == 1
        assert (folder / "kept.txt").read_text() == "kept"
        write(folder, "after")
        assert texts(folder) == {"after"}
        assert list(tmp_path.iterdir()) == [folder]
