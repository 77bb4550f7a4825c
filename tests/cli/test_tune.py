"""The command `tune`: a small search from end to end, what it refuses, and how it is stopped."""

from __future__ import annotations

import importlib.util
import signal
from pathlib import Path

import pytest
from helpers.command import run
from helpers.processes import started
from helpers.tuning import SPACE_TOML, TINY_SETTINGS
from helpers.waiting import wait_until

from pipenav.learning.config import load_config

pytest.importorskip("optuna")

TINY = ("--objective", "success", *(f"--set={setting}" for setting in TINY_SETTINGS))


def search(folder: Path, *more: str) -> tuple[str, ...]:
    """A command that searches in a folder `searched`."""
    (folder / "tiny.toml").write_text(SPACE_TOML)
    return ("tune", "--space", str(folder / "tiny.toml"), *TINY, "--out", str(folder / "searched"), *more)


@pytest.mark.slow
def test_a_search_from_end_to_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = search(tmp_path, "--steps", "256", "--trials", "2", "--again", "1", "--jobs", "2")
    assert run(*command) == 0
    said = capsys.readouterr()
    assert "the preset with the same seed" in said.out
    assert "trial 0001: " in said.err or "trial 0002: " in said.err
    report = (tmp_path / "searched" / "report.md").read_text(encoding="utf-8")
    assert "| preset |" in report
    assert "learner.learning_rate" in report
    best = tmp_path / "searched" / "best.toml"
    assert f"pipenav train --config {best}" in said.out
    assert load_config(file=best).steps == 256

    assert run(*command) == 0  # nothing is left to do
    assert (tmp_path / "searched" / "report.md").read_text(encoding="utf-8") == report


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (("--space", "arms"), "unknown space 'arms': did you mean 'arm'"),
        (("--success", "0.9"), "--success 0.9 is not a percentage: write it as 99% or 99.5%"),
        (("--jobs", "2", "--cluster", "auto"), "--jobs chooses processes of this machine and --cluster another place"),
        (("--set", "learner.epochs=0"), "learner.epochs: input should be greater than or equal to 1, given 0"),
        (("--set", "pipes=nowhere"), "nowhere"),
    ],
)
def test_wrong_usage_makes_no_folder(
    more: tuple[str, ...], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("tune", *more, "--out", str(tmp_path / "searched")) == 1
    assert says in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "searched").exists()


def test_without_optuna_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "optuna" else found(name, *rest)
    )
    assert run(*search(tmp_path)) == 1
    assert "pipenav tune needs Optuna, which is not installed: pip install 'pipenav[tune]'." in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [(), ("--jobs", "2")], ids=["here", "processes"])
def test_ctrl_c_saves_and_the_same_command_goes_on(jobs: tuple[str, ...], tmp_path: Path) -> None:
    command = search(tmp_path, "--steps", "1024", "--trials", "2", "--again", "0", *jobs)
    trainings = tmp_path / "searched" / "trainings"
    with started(*command, folder=tmp_path) as family:
        wait_until(lambda: any(trainings.glob("*/resume.safetensors")), "a training has something to save")
        family.command.send_signal(signal.SIGINT)
        said, _ = family.command.communicate(timeout=120)
    assert family.command.returncode == 130
    assert "stopping, saving ..." in said
    assert f"stopped and saved in {tmp_path / 'searched'}; the same command goes on from there" in said
    with started(*command, folder=tmp_path) as family:
        said, _ = family.command.communicate(timeout=300)
    assert family.command.returncode == 0, said
    assert (tmp_path / "searched" / "best.toml").exists()
