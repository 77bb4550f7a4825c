"""Files, pictures and tables of an evaluation."""

from __future__ import annotations

import csv
import errno
import io
import os
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from pipenav.errors import FileProblem
from pipenav.evaluation.figures import map_figure, percent, success_figure
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.report import FILES, evaluation_table, pipes_csv, write_evaluation
from pipenav.evaluation.results import Evaluation, read_evaluation
from pipenav.evaluation.thesis import ANGLES_DEG, thesis_best
from pipenav.learning.figures import write_training_plot

PNG = b"\x89PNG\r\n\x1a\n"
PROGRESS = "steps,seconds,steps_per_s,success,min_range_m,reward,episode_steps,std,eval_success\n"


def record(diameter: float, angle: float, turn: str = "left", successes: int = 8, **facts: Any) -> PipeRecord:
    measured = {
        "failures": {"limit": 10 - successes} if successes < 10 else {},
        "mean_steps": 25.0 if successes else None,
        "min_range_m": 0.004,
        "max_penetration_m": 0.0012,
        "peak_force_n": 12.5,
        "contact_time_share": 0.125,
    }
    stages = {"reach_attempts": 10, "reach_successes": successes}
    return PipeRecord(diameter_mm=diameter, angle_deg=angle, turn=turn, episodes=10, **{**stages, **measured, **facts})


def evaluation(pipes: list[PipeRecord]) -> Evaluation:
    return Evaluation.of(
        pipes,
        policy="some-policy",
        backend="mujoco",
        robot="basic",
        thesis=thesis_best("torque"),
        stage="reach",
        seed=0,
        episodes_per_pipe=10,
        penetration_p99_m=0.00111,
    )


GRID = evaluation(
    [record(d, a, turn, 10 if d > 90 else 7) for turn in ("left", "right") for d in (120, 90) for a in ANGLES_DEG]
)
BARE = evaluation([PipeRecord(diameter_mm=70, angle_deg=55, turn="right", episodes=1)])
WHOLE = evaluation(
    [
        record(90, 60, located=10, rear_attempts=8, rear_successes=7, failures={"limit": 2, "rear timeout": 1}),
        record(90, 75, located=9, reach_attempts=9, failures={"not located": 1}, rear_attempts=8, rear_successes=8),
    ]
)
RUNS = evaluation(
    [
        PipeRecord(
            diameter_mm=d,
            angle_deg=None,
            turn=None,
            run=f"run-d{d:g}-{corners}",
            episodes=4,
            reach_attempts=4,
            reach_successes=passed,
            failures={"limit": 4 - passed},
        )
        for d, corners, passed in ((70, "R65-L70-R100-R55-L110", 1), (120, "-".join(["R120"] * 50), 3), (70, "L90", 2))
    ]
)
MIXED = evaluation([record(90, 60), *RUNS.pipes])
CASES = {
    "grid": GRID,
    "bare": BARE,
    "whole": WHOLE,
    "runs": RUNS,
    "mixed": MIXED,
    "perfect": evaluation([record(90, 60, successes=10)]),
}


def shown(case: Evaluation) -> str:
    text = io.StringIO()
    Console(file=text, width=100).print(evaluation_table(case))
    return text.getvalue()


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
    for fact in ("some-policy: 85.0 % of 600 episodes", "stage front, 60 pipes × 10 episodes", "1.11 mm"):
        assert fact in text
    narrow = next(line for line in text.splitlines() if line.split()[:1] == ["90"])
    assert narrow.split()[:5] == ["90", "300", "70.0", "64.6-74.9", "89"]
    assert "limit 90" in narrow
    assert "The 8 worst of 30 pipes with failures" in text
    assert "Every episode succeeded" in shown(CASES["perfect"])


def test_tables_show_only_the_stages_that_were_run() -> None:
    assert "located" not in shown(GRID)
    assert "rear" not in shown(GRID)
    assert all(word in shown(WHOLE) for word in ("located", "front", "rear", "not located 1"))


@pytest.mark.parametrize(
    ("share", "decimals", "text"),
    [(1.0, 1, "100"), (0.0, 1, "0"), (0.9999, 1, "99.9"), (0.0001, 1, "0.1"), (0.996, 0, "99"), (0.5, 0, "50")],
)
def test_only_perfect_shares_read_perfect(share: float, decimals: int, text: str) -> None:
    assert percent(share, decimals) == text


def test_pictures_pool_turns_or_separate_them() -> None:
    success, cells = success_figure(GRID), map_figure(GRID)
    lines = [line for line in success.axes[0].lines if not line.get_label().startswith("_")]
    assert [line.get_label() for line in lines] == ["120 mm", "90 mm"]
    assert list(lines[1].get_ydata()) == pytest.approx([70.0] * 15)
    panels = [axes for axes in cells.axes if axes.texts and axes.images]
    assert [axes.get_ylabel().split()[0] for axes in panels] == ["left", "right"]
    assert sum(text.get_text() == "70" for text in panels[0].texts) == 15


def test_runs_stand_apart_from_corners_by_their_number() -> None:
    assert [text.get_text() for text in success_figure(RUNS).axes[0].get_xticklabels()] == ["1", "2", "3"]
    assert [text.get_text() for text in success_figure(MIXED).axes[0].get_xticklabels()] == ["60"]
    panels = [axes for axes in map_figure(MIXED).axes if axes.texts and axes.images]
    assert [axes.get_ylabel().split()[0] for axes in panels] == ["left", "routes"]
    assert sorted(text.get_text() for text in panels[1].texts) == ["25", "50", "75"]
    assert "R65-L70-R100-R55-L110" in shown(RUNS)
    assert RUNS.diameters[1].reach_success == pytest.approx(3 / 8)
    assert RUNS.diameters[1].thesis_percent is None


@pytest.mark.parametrize(
    "rows",
    [
        "",
        "800,1.0,800,,0.01,-1,,0.5,\n",
        "800,1.0,800,,0.01,-1,,0.5,\n1600,2.0,800,0.5,0.02,-1,40,0.5,0.75\n2400,3.0,nonsense,inf,,,,,\n32",
    ],
)
def test_training_plots_tolerate_what_a_run_leaves(rows: str, tmp_path: Path) -> None:
    (tmp_path / "progress.csv").write_text(PROGRESS + rows, encoding="utf-8")
    write_training_plot(tmp_path / "training.png", tmp_path / "progress.csv")
    assert (tmp_path / "training.png").read_bytes().startswith(PNG)


def test_training_plot_needs_its_file(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"cannot read .*progress.csv"):
        write_training_plot(tmp_path / "training.png", tmp_path / "progress.csv")
