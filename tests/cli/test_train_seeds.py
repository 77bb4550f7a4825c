"""The command `train --seeds`: the trainings that single commands make, side by side, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command import run
from helpers.tiny_training import TINY, weights

RECIPE = ["--preset", "arm", "--steps", "2048", "--pipes", "d=100,angle=90"]
RECIPE += [word for key, value in TINY.items() if key != "pipes" for word in ("--set", f"{key}={value}")]


@pytest.mark.slow
def test_every_seed_is_trained_as_a_single_command_trains_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    several = ("train", *RECIPE, "--seeds", "2", "--seed", "3", "--jobs", "2", "--out", str(tmp_path / "several"))
    assert run(*several) == 0
    assert run("train", *RECIPE, "--seed", "4", "--out", str(tmp_path / "single")) == 0
    one, other = tmp_path / "several" / "seed-4", tmp_path / "single"
    assert weights(one / "best.zip") == weights(other / "best.zip")
    assert json.loads((tmp_path / "several" / "seed-3" / "config.json").read_text())["seed"] == 3
    capsys.readouterr()
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "several").rglob("best.zip")}
    assert run(*several) == 0
    assert "2 of them done before" in capsys.readouterr().out
    assert before == {path: path.stat().st_mtime_ns for path in (tmp_path / "several").rglob("best.zip")}
    assert run(*several, "--set", "learner.gamma=0.9") == 1
    assert "holds trainings that differ in learner: give the same settings" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--jobs", "2"], "give the number of them by --seeds"),
        (["--cluster", "auto"], "give the number of them by --seeds"),
        (["--seeds", "2", "--resume", "runs/arm"], "--seeds begins new trainings"),
        (["--seeds", "2", "--from", "runs/arm"], "--seeds begins new trainings"),
        (["--seeds", "2", "--jobs", "2", "--cluster", "auto"], "give one of them"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    options: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("train", *RECIPE, *options) == 1
    assert message in capsys.readouterr().err
    assert not list(tmp_path.rglob("config.json"))
