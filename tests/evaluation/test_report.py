"""Files, pictures and tables of an evaluation."""

from __future__ import annotations

import csv
import errno
import io
import os
from pathlib import Path

import pytest
from helpers.evaluations import BARE, CASES, GRID, WHOLE, shown

from pipenav.errors import FileProblem
from pipenav.evaluation.report import FILES, pipes_csv, write_evaluation
from pipenav.evaluation.results import read_evaluation

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_all_files_appear(case: str, tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "eval"
    write_evaluation(folder, CASES[case])
    assert {path.name for path in folder.iterdir()} == set(FILES)
    assert read_evaluation(folder) == CASES[case]
    for name in ("success.png", "map.png"):
        content = (folder / name).read_bytes()
        assert content.startswith(PNG)
        assert len(content) > 5000


@pytest.mark.slow
def test_a_full_disk_leaves_the_earlier_evaluation_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_evaluation(tmp_path, BARE)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    synced = []

    def full_at_the_third(_: int) -> None:
        synced.append(1)
        if len(synced) == 3:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full_at_the_third)
    with pytest.raises(FileProblem, match="No space left on device"):
        write_evaluation(tmp_path, WHOLE)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_csv_has_one_row_per_pipe() -> None:
    rows = list(csv.DictReader(io.StringIO(pipes_csv(WHOLE.pipes))))
    assert len(rows) == 2
    assert rows[0]["failures"] == "limit=2 rear timeout=1"
    assert (rows[0]["diameter_mm"], rows[0]["reach_successes"]) == ("90.0", "8")
    assert 0 < float(rows[0]["reach_success_low"]) < 0.8
    assert next(csv.DictReader(io.StringIO(pipes_csv(BARE.pipes))))["mean_steps"] == ""


@pytest.mark.parametrize("case", CASES)
def test_tables_fit_into_100_columns_without_cut_words(case: str) -> None:
    text = shown(CASES[case])
    assert max(map(len, text.splitlines())) <= 100
    assert "…" not in text


def test_tables_say_what_was_measured() -> None:
    text = shown(GRID)
    for fact in (
        "some-policy: 85.0 % of 600 episodes",
        "stage reach, 60 pipes × 10 episodes",
        "1.11 mm",
        "disturbances none",
    ):
        assert fact in text
    narrow = next(line for line in text.splitlines() if line.split()[:1] == ["90"])
    assert narrow.split()[:5] == ["90", "300", "70.0", "64.6-74.9", "89"]
    assert "limit 90" in narrow
    assert "The 8 worst of 30 pipes with failures" in text
    assert "Every episode succeeded" in shown(CASES["perfect"])


def test_tables_say_seconds_beside_steps_and_what_range_and_overlap_are() -> None:
    text = shown(GRID)
    assert any(line.split()[:3] == ["90", "25.0", "2.5"] for line in text.splitlines())
    words = " ".join(text.split())
    assert "smallest reading of the laser at the tip" in words
    assert "how deep a part sinks into the simulated wall" in words


def test_tables_show_only_the_stages_that_were_run() -> None:
    assert "located" not in shown(GRID)
    assert "rear" not in shown(GRID)
    assert all(word in shown(WHOLE) for word in ("located", "reach", "rear", "not located 1"))
