"""A folder has one writer at a time, and a lock that dies with its owner."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.waiting import wait_until

from pipenav.storage.lock import LOCK_FILE, FolderInUse, one_writer

HOLD = (
    "import sys, time\n"
    "from pathlib import Path\n"
    "from pipenav.storage.lock import one_writer\n"
    "with one_writer(Path(sys.argv[1]), 'pipenav train --out [bold]'):\n"
    "    print('held', flush=True)\n"
    "    time.sleep(600)\n"
)


@pytest.fixture
def owner(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that holds the folder."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()


def test_a_second_writer_is_told_who_the_first_is(tmp_path: Path, owner: subprocess.Popen[str]) -> None:
    with pytest.raises(FolderInUse) as refused, one_writer(tmp_path):
        pass
    assert f"{tmp_path} is in use by process {owner.pid} (pipenav train --out [bold]): wait" in str(refused.value)
    assert (tmp_path / LOCK_FILE).exists()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_the_lock_dies_with_its_owner(tmp_path: Path, owner: subprocess.Popen[str], number: int) -> None:
    owner.send_signal(number)
    owner.wait()
    with one_writer(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_this_process_is_refused_too_and_leaves_no_file(tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "folder"
    with one_writer(folder, "first"):
        with pytest.raises(FolderInUse, match="first"), one_writer(folder, "second"):
            pass
        with one_writer(tmp_path):  # a folder above it is another folder
            pass
    with one_writer(folder):
        assert [path.name for path in folder.iterdir()] == [LOCK_FILE]
    assert list(tmp_path.iterdir()) == [], "folders that were made for it and are empty go with it"


def test_folders_that_were_there_or_hold_anything_stay(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    with one_writer(mine):
        pass
    with one_writer(mine / "deep" / "folder"):
        (mine / "deep" / "result").touch()
    assert [path.name for path in mine.rglob("*")] == ["deep", "result"]


@pytest.mark.slow
def test_of_many_that_start_together_one_writes(tmp_path: Path) -> None:
    code = HOLD.replace("time.sleep(600)", "time.sleep(3)")
    command = [sys.executable, "-c", code, str(tmp_path)]
    started = [subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) for _ in range(6)]
    wait_until(lambda: all(process.poll() is not None for process in started), "all ended")
    assert sum(process.returncode == 0 for process in started) == 1
