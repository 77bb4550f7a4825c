"""Drafts carry their owner's process: those of the dead go, those of the living stay."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pipenav.storage.atomic_files import atomic_write, prepare_folder
from pipenav.storage.drafts import FOREIGN_AGE_S, clear_drafts, draft_path, replaced_path


@pytest.fixture
def dead() -> int:
    """Number of a process that is no more."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def owned_by(path: Path, pid: int) -> Path:
    """The path of a draft as another process would name it."""
    return path.with_name(path.name.replace(f"-{os.getpid()}-", f"-{pid}-"))


def test_drafts_of_the_dead_go_and_nothing_else(tmp_path: Path, dead: int) -> None:
    mine, theirs, folder = draft_path(tmp_path, ".zip"), owned_by(draft_path(tmp_path, ".zip"), dead), tmp_path / ".git"
    for path in (mine, theirs, tmp_path / ".pipenav-notes", tmp_path / "best.zip"):
        path.touch()
    folder.mkdir()
    whole = owned_by(draft_path(tmp_path), dead)
    whole.mkdir()
    (whole / "eval.json").touch()
    clear_drafts(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {mine.name, ".git", ".pipenav-notes", "best.zip"}


def test_a_folder_that_a_killed_process_moved_aside_comes_back(tmp_path: Path, dead: int) -> None:
    aside = owned_by(replaced_path(tmp_path / "my-[pipe] 1.5"), dead)
    aside.mkdir()
    (aside / "pipe.json").touch()
    clear_drafts(tmp_path)
    assert (tmp_path / "my-[pipe] 1.5" / "pipe.json").is_file()
    again = owned_by(replaced_path(tmp_path / "my-[pipe] 1.5"), dead)
    again.mkdir()
    clear_drafts(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["my-[pipe] 1.5"]


def test_drafts_of_another_machine_go_when_they_are_old(tmp_path: Path) -> None:
    foreign = tmp_path / re.sub(r"-[0-9a-f]{6}-", "-0f0f0f-", draft_path(tmp_path).name, count=1)
    foreign.touch()
    clear_drafts(tmp_path)
    assert foreign.exists()
    old = time.time() - 2 * FOREIGN_AGE_S
    os.utime(foreign, (old, old))
    clear_drafts(tmp_path)
    assert not foreign.exists()


def test_the_next_start_clears(tmp_path: Path, dead: int) -> None:
    left = owned_by(draft_path(tmp_path), dead)
    left.touch()
    prepare_folder(tmp_path)
    assert not left.exists()
    (tmp_path / "a").mkdir()
    left = owned_by(draft_path(tmp_path / "a"), dead)
    left.touch()
    atomic_write(tmp_path / "a" / "file", "x")
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["file"]
