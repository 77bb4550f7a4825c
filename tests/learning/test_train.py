"""Real, short trainings: they learn, repeat, go on, and say what stops them."""

from __future__ import annotations

import csv
import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from helpers.tiny_training import tiny, weights
from safetensors import safe_open
from safetensors.torch import save

from pipenav.cli import main
from pipenav.errors import PipenavError
from pipenav.learning.config import TrainConfig, load_config
from pipenav.learning.divergence import TrainingDiverged
from pipenav.learning.learner import Learner
from pipenav.learning.progress import PROGRESS_COLUMNS
from pipenav.learning.train import TrainingSummary, train
from pipenav.learning.training_folder import TrainingFolder, default_training_path
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.policy import load_policy

pytestmark = pytest.mark.slow

MADE = {"training.png", "report.html"}
FILES = MADE | {
    "best.zip",
    "last.zip",
    "config.json",
    "command.txt",
    "progress.csv",
    "checks.json",
    "resume.safetensors",
}


def trained(path: Path, config: TrainConfig, **more: Any) -> tuple[TrainingFolder, TrainingSummary]:
    folder = TrainingFolder.create(path, config, "pipenav train")
    return folder, train(config, folder, **more)


def progress(folder: TrainingFolder) -> list[dict[str, str]]:
    with folder.progress.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert all(tuple(row) == PROGRESS_COLUMNS and None not in row.values() for row in rows)
    return rows


@pytest.fixture(autouse=True)
def plain_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setenv("NO_COLOR", "1")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> TrainingFolder:
    """A finished tiny training, not to be changed."""
    folder, _ = trained(tmp_path_factory.mktemp("runs") / "tiny", tiny())
    return folder


@pytest.fixture
def copied(run: TrainingFolder, tmp_path: Path) -> TrainingFolder:
    return TrainingFolder(Path(shutil.copytree(run.path, tmp_path / "run")))


def test_a_training_learns_to_pass_one_corner(tmp_path: Path) -> None:
    config = load_config(
        options={"pipes": ["d=110,angle=110"], "steps": 18_432, "check.every": 18_432, "check.episodes": 32}
    )
    folder, outcome = trained(tmp_path / "run", config)
    assert (outcome.steps, outcome.stopped) == (18_432, False)
    assert outcome.check_success >= 0.9
    rows = progress(folder)
    assert float(rows[0]["success"] or 0) < 0.5 < float(rows[-1]["success"])
    header = load_policy(folder.best).header
    assert header.training["steps"] == 18_432
    assert header.task == config.task


def test_a_training_folder_is_complete(run: TrainingFolder) -> None:
    names = {path.name for path in run.path.iterdir()}
    events = {name for name in names if name.startswith("events.")}
    assert events
    assert names - events == FILES
    rows = progress(run)
    assert [int(row["steps"]) for row in rows] == list(range(256, 2049, 256))
    assert all(float(row["steps_per_s"]) > 0 for row in rows)
    assert run.plot.read_bytes().startswith(b"\x89PNG")
    assert run.command.read_text() == "pipenav train\n"
    assert TrainingFolder.open(run.path)[1] == tiny()


def test_the_same_seed_gives_the_same_weights(run: TrainingFolder, tmp_path: Path) -> None:
    again, _ = trained(tmp_path / "again", tiny())
    assert weights(again.last) == weights(run.last)
    other, _ = trained(tmp_path / "other", tiny(seed=1, steps=256))
    assert weights(other.last) != weights(run.last)


def test_a_resumed_training_goes_on_where_it_was(copied: TrainingFolder) -> None:
    before = progress(copied)
    folder, config = TrainingFolder.open(copied.path)
    outcome = train(config.model_copy(update={"steps": 3072}), folder, resumed=True)
    assert outcome.steps == 3072
    rows = progress(copied)
    assert rows[: len(before)] == before
    assert [int(row["steps"]) for row in rows] == list(range(256, 3073, 256))
    seconds = [float(row["seconds"]) for row in rows]
    assert seconds == sorted(seconds)
    assert load_policy(copied.last).header.training["steps"] == 3072
    assert outcome.check_success >= 0


def test_resume_restores_weights_and_keeps_the_best(copied: TrainingFolder) -> None:
    """A resumed training that is stopped at once has learned nothing and lost nothing."""
    before, best = weights(copied.last), copied.best.read_bytes()
    folder, config = TrainingFolder.open(copied.path)
    longer = config.model_copy(update={"steps": 4096})
    outcome = train(longer, folder, resumed=True, should_stop=lambda: True)
    assert outcome.stopped
    assert 2048 <= outcome.steps <= 2048 + 16
    assert weights(copied.last) == before
    assert copied.best.read_bytes() == best


def test_a_training_that_starts_from_another_has_its_weights_and_its_own_count(
    run: TrainingFolder, tmp_path: Path
) -> None:
    folder, outcome = trained(tmp_path / "new", tiny(seed=1), should_stop=lambda: True, start=run.path)
    assert outcome.steps <= 16
    assert weights(folder.last) == weights(run.last)
    (tmp_path / "half").mkdir()
    shutil.copy(run.config, tmp_path / "half")
    (tmp_path / "half" / run.checkpoint.name).write_bytes(b"half")
    with pytest.raises(PipenavError, match="cannot be started from"):
        trained(tmp_path / "newer", tiny(), start=tmp_path / "half")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("resume.safetensors", b"half", "cannot be resumed from"),
        ("config.json", b"{", "config.json is not valid JSON"),
        ("config.json", b"{}", "description: this key is missing, add it"),
        ("progress.csv", b"\xff\xfe", "progress.csv is not text"),
        ("resume.safetensors", None, "holds no training"),
    ],
)
def test_a_spoilt_training_folder_is_refused(
    copied: TrainingFolder, name: str, content: bytes | None, message: str
) -> None:
    path = copied.path / name
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(PipenavError, match=message):
        folder, config = TrainingFolder.open(copied.path)
        train(config, folder, resumed=True)


SPOILT_PROGRESS: list[dict[str, Any]] = [
    {"steps": -1},
    {"steps": 10**30},
    {"steps": 1.5},
    {"seconds": math.nan},
    {"seconds": -1.0},
    {"seconds": "1"},
    {"best_success": 2.0},
    {"best_success": math.inf},
    {"more": 1},
]


@pytest.mark.parametrize("spoilt", SPOILT_PROGRESS, ids=str)
def test_a_checkpoint_of_impossible_progress_is_refused(copied: TrainingFolder, spoilt: dict[str, Any]) -> None:
    with safe_open(copied.checkpoint, framework="pt") as file:
        progress = json.loads(file.metadata()["pipenav"]) | spoilt
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118  # safe_open is no dict
    copied.checkpoint.write_bytes(save(tensors, {"pipenav": json.dumps(progress)}))
    with pytest.raises(PipenavError, match="cannot be resumed from"):
        train(TrainingFolder.open(copied.path).config, copied, resumed=True)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda t: t.double(),
        lambda t: t * math.nan,
        lambda t: torch.cat([t.flatten(), t.flatten()]),
    ],
)
@pytest.mark.parametrize("name", ["policy.action_net.weight", "optimizer.1.exp_avg", "optimizer.1.step"])
def test_a_checkpoint_of_other_numbers_is_refused(copied: TrainingFolder, spoil: Any, name: str) -> None:
    with safe_open(copied.checkpoint, framework="pt") as file:
        metadata = file.metadata()
        tensors = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118  # safe_open is no dict
    assert name in tensors, sorted(tensors)
    tensors[name] = spoil(tensors[name]).contiguous()
    copied.checkpoint.write_bytes(save(tensors, metadata))
    with pytest.raises(PipenavError, match="cannot be resumed from") as refused:
        train(TrainingFolder.open(copied.path).config, copied, resumed=True)
    assert len(str(refused.value)) < 600


class Poisoned:
    """A backend whose first robot reads NaN from the k-th reading on."""

    def __init__(self, inner: Any, healthy: int) -> None:
        self._inner, self._healthy = inner, healthy

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def read(self) -> Any:
        self._healthy -= 1
        reading = self._inner.read()
        if self._healthy < 0:
            reading.ranges[0, 3] = np.nan
        return reading


def test_a_value_that_is_not_finite_stops_the_training(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    import pipenav.learning.environment as module

    real: Callable[..., Any] = module.open_simulator
    healthy = iter([60, 10**6])  # of the robots' first share, and of the second
    monkeypatch.setattr(module, "open_simulator", lambda *given: Poisoned(real(*given), next(healthy)))
    config = tiny(**{"check.every": 256})
    folder = TrainingFolder.create(tmp_path / "run", config, "pipenav train")
    with pytest.raises(TrainingDiverged, match=r"diverged\.json.*last\.zip"):
        train(config, folder)
    cause = json.loads(folder.diverged.read_text(encoding="utf-8"))
    assert cause["robots"] == [0]
    assert cause["pipes"] == [PipeCorner.of(100, 90).name]
    assert "nan" in cause["observations"][0]
    assert np.isfinite(np.array(cause["actions"], float)).all()
    for path in (folder.best, folder.last):
        assert all(np.isfinite(values).all() for values in weights(path).values())


def test_weights_that_are_not_finite_stop_the_training(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def spoil(model: Any) -> None:
        with torch.no_grad():
            next(model.policy.action_net.parameters())[0, 0] = torch.inf

    monkeypatch.setattr(Learner, "train", spoil)
    folder = TrainingFolder.create(tmp_path / "run", tiny(), "pipenav train")
    with pytest.raises(TrainingDiverged):
        train(tiny(), folder)
    assert folder.diverged.is_file()
    assert all(np.isfinite(values).all() for values in weights(folder.last).values())
    assert TrainingFolder.open(folder.path)


def refused(capsys: pytest.CaptureFixture[str], *args: str) -> str:
    with pytest.raises(SystemExit) as left:
        main(["train", *args])
    assert left.value.code == 1
    shown = capsys.readouterr()
    assert shown.err.startswith("pipenav: error: ")
    assert shown.err.count("\n") == 1
    return shown.err


def test_an_existing_training_is_not_overwritten(run: TrainingFolder, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path: path.stat().st_mtime_ns for path in run.path.iterdir()}
    assert f"--resume {run.path}" in refused(capsys, "--out", str(run.path))
    assert {path: path.stat().st_mtime_ns for path in run.path.iterdir()} == before


def test_what_a_killed_start_left_is_no_training(tmp_path: Path) -> None:
    for _ in range(2):
        TrainingFolder.create(tmp_path / "run", tiny(), "pipenav train")
    with pytest.raises(PipenavError, match="holds no training"):
        TrainingFolder.open(tmp_path / "run")


def test_the_next_free_folder(tmp_path: Path) -> None:
    assert default_training_path("arm", tmp_path) == tmp_path / "arm"
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm-2").mkdir()
    assert default_training_path("arm", tmp_path) == tmp_path / "arm-3"


def test_a_folder_that_cannot_be_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "file"
    file.touch()
    assert "it is a file" in refused(capsys, "--out", str(file))
    assert "Not a directory" in refused(capsys, "--out", str(file / "run"))
    assert "holds no training" in refused(capsys, "--resume", str(tmp_path))
    assert "only --steps" in refused(capsys, "--resume", str(tmp_path), "--seed", "1")


def test_a_start_that_does_not_fit_is_refused_before_anything_is_written(
    run: TrainingFolder, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    new, begin = tmp_path / "new", ["--from", str(run.path)]
    assert "another network" in refused(capsys, *begin, "--set", "network.policy=[8]", "--out", str(new))
    assert "robot 'basic'" in refused(capsys, *begin, "--preset", "pirate", "--out", str(new))
    assert "control" in refused(capsys, *begin, "--control", "torque", "--out", str(new))
    assert "holds no training" in refused(capsys, "--from", str(tmp_path), "--out", str(new))
    assert "only --steps" in refused(capsys, *begin, "--resume", str(run.path))
    assert not new.exists()


@pytest.mark.parametrize(
    "options",
    [("--set", "seed=1", "--set", " seed = 2"), ("--set", "seed=1", "--seed", "2")],
    ids=["two", "and-option"],
)
def test_a_key_is_set_once(options: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert "seed is set twice, again by --set" in refused(capsys, *options)


def test_resume_refuses_fewer_steps_than_are_done(run: TrainingFolder, capsys: pytest.CaptureFixture[str]) -> None:
    before = run.config.read_bytes()
    assert "steps behind it, given --steps 7: give more" in refused(capsys, "--resume", str(run.path), "--steps", "7")
    assert run.config.read_bytes() == before


def test_resume_checks_its_steps(run: TrainingFolder, capsys: pytest.CaptureFixture[str]) -> None:
    assert "steps: input should be greater than" in refused(capsys, "--resume", str(run.path), "--steps", "0")


def test_a_disk_that_is_full_is_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pipenav.storage.atomic_files._write_draft", full)
    assert "cannot write" in (said := refused(capsys, "--out", str(tmp_path / "run")))
    assert "No space left on device." in said
    assert not (tmp_path / "run").exists()
