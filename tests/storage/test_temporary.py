"""Temporary folders of processes that were killed go, also where another process has got their number."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from pipenav.storage import temporary
from pipenav.storage.temporary import temporary_folder


@pytest.mark.parametrize(("age", "left"), [(0.0, True), (3600.0 * 24 * 365, False)])
def test_a_folder_older_than_the_process_of_its_number_goes(
    age: float, left: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    folder = tmp_path / f"pipenav-emulator-{os.getpid()}-abc"
    folder.mkdir()
    changed = time.time() - age
    os.utime(folder, (changed, changed))
    temporary._remove_abandoned.cache_clear()
    with temporary_folder("later") as later:
        assert later.is_dir()
    assert folder.exists() == left and not later.exists()
