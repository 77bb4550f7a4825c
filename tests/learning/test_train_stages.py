"""Real, short trainings in stages: where they begin, how they are resumed, and what is recorded of them."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.tiny_training import tiny, weights
from safetensors import safe_open

from pipenav.cli import main
from pipenav.errors import PipenavError
from pipenav.learning import train as module
from pipenav.learning.checkpoint import NO_CHECK
from pipenav.learning.config import TrainConfig, load_config, validate_config
from pipenav.learning.progress import TrainingProgress
from pipenav.learning.stages import require_one_interface, with_steps
from pipenav.learning.train import TrainingSummary, train
from pipenav.learning.training_folder import TrainingFolder
from pipenav.policies.policy import load_policy

pytestmark = pytest.mark.slow

COARSE = {"name": "coarse", "steps": 1024, "options": {"timestep": 0.005, "contact_time_constant": 0.01}}
FINE = {"name": "fine", "steps": 512, "learner": {"robots": 8, "epochs": 1}}
OTHER = {"name": "other", "steps": 512, "pipes": ["d=110,angle=100"], "task": {"max_steps": 60}}


def staged(*stages: dict[str, Any], **more: Any) -> TrainConfig:
    return tiny(steps=None, stages=list(stages or (COARSE, FINE, OTHER)), **more)


def trained(path: Path, config: TrainConfig, **more: Any) -> tuple[TrainingFolder, TrainingSummary]:
    folder = TrainingFolder.create(path, config, "pipenav train")
    return folder, train(config, folder, **more)


def resumed(folder: TrainingFolder, path: Path, **more: Any) -> TrainingFolder:
    """A copy of a training that has gone on to its end."""
    opened, config = TrainingFolder.open(Path(shutil.copytree(folder.path, path)))
    train(config, opened, resumed=True, **more)
    return opened


def everything(folder: TrainingFolder) -> dict[str, list[float]]:
    """All tensors of the checkpoint, to the bit."""
    with safe_open(folder.checkpoint, framework="pt") as file:
        return {name: file.get_tensor(name).flatten().tolist() for name in file.keys()}  # noqa: SIM118


def learned(folder: TrainingFolder) -> dict[str, list[float]]:
    """All tensors but the noise, which the schedule sets."""
    return {name: values for name, values in everything(folder).items() if name != "policy.log_std"}


def rows(folder: TrainingFolder) -> list[dict[str, str]]:
    with folder.progress.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


class Stop:
    """Asks a training to stop at the first control step after a report of so many steps."""

    def __init__(self, steps: int) -> None:
        self._steps, self._now = steps, False

    def report(self, progress: TrainingProgress) -> None:
        self._now = progress.steps >= self._steps

    def __call__(self) -> bool:
        return self._now


def stopped(path: Path, config: TrainConfig, steps: int) -> TrainingFolder:
    stop = Stop(steps)
    folder, summary = trained(path, config, report=stop.report, should_stop=stop)
    assert summary.stopped
    return folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> TrainingFolder:
    """A finished training in three stages, not to be changed."""
    folder, summary = trained(tmp_path_factory.mktemp("runs") / "staged", staged())
    assert (summary.steps, summary.stopped) == (2048, False)
    return folder


def test_the_curve_goes_on_from_stage_to_stage(whole: TrainingFolder) -> None:
    steps = [int(row["steps"]) for row in rows(whole)]
    assert steps == [*range(256, 1025, 256), *range(1152, 1537, 128), *range(1792, 2049, 256)]
    assert [int(row["stage"]) for row in rows(whole)] == [1] * 4 + [2] * 4 + [3] * 2
    seconds = [float(row["seconds"]) for row in rows(whole)]
    assert seconds == sorted(seconds)
    noise = [float(row["std"]) for row in rows(whole)]
    assert noise == sorted(noise, reverse=True)
    assert whole.plot.read_bytes().startswith(b"\x89PNG")


def test_a_policy_says_in_which_stages_it_was_trained(whole: TrainingFolder) -> None:
    header = load_policy(whole.last).header
    assert header.train_pipes == ("d=100,angle=90", "d=110,angle=100")
    assert header.task.max_steps == 60
    assert header.training["stages"] == (
        "coarse: 1024 steps with options.timestep=0.005, options.contact_time_constant=0.01; "
        "fine: 512 steps with learner.robots=8, learner.epochs=1; "
        "other: 512 steps with pipes=d=110,angle=100, task.max_steps=60"
    )


def test_one_stage_that_says_nothing_is_a_training_without_stages(tmp_path: Path) -> None:
    one, _ = trained(tmp_path / "one", staged({"name": "all", "steps": 768}))
    plain, _ = trained(tmp_path / "plain", tiny(steps=768))
    assert everything(one) == everything(plain)
    assert weights(one.best) == weights(plain.best)


@pytest.mark.parametrize("end", [1024, 1536])
def test_a_training_that_stopped_between_two_stages_goes_on_as_if_it_had_not(
    end: int, whole: TrainingFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real: Callable[..., Any] = module._train_stage
    asked = Stop(end)

    def at_the_boundary(beginning: Any, _report: Any, _should_stop: Any) -> Any:
        summary = real(beginning, asked.report, lambda: False)
        return summary._replace(stopped=asked())

    monkeypatch.setattr(module, "_train_stage", at_the_boundary)
    folder, summary = trained(tmp_path / "stopped", staged())
    monkeypatch.undo()
    assert (summary.steps, summary.stopped) == (end, True)
    again = resumed(folder, tmp_path / "resumed")
    assert everything(again) == everything(whole)
    assert weights(again.best) == weights(whole.best)
    assert [row["steps"] for row in rows(again)] == [row["steps"] for row in rows(whole)]


@pytest.mark.parametrize("steps", [512, 1152, 1792])
def test_a_training_is_resumed_in_the_stage_in_which_it_stopped(
    steps: int, whole: TrainingFolder, tmp_path: Path
) -> None:
    folder = stopped(tmp_path / "stopped", staged(), steps)
    kept = learned(folder)
    at_once = resumed(folder, tmp_path / "at-once", should_stop=lambda: True)
    assert learned(at_once) == kept
    one, other = (resumed(folder, tmp_path / name) for name in ("one", "other"))
    assert everything(one) == everything(other)
    number = {int(row["steps"]): row["stage"] for row in rows(whole)}
    assert all(number.get(int(row["steps"]), row["stage"]) == row["stage"] for row in rows(one))
    assert int(rows(one)[-1]["steps"]) >= 2048
    assert load_policy(one.last).header.training["stages"] == load_policy(whole.last).header.training["stages"]


def test_a_training_that_is_prolonged_goes_on_in_its_last_stage(whole: TrainingFolder, tmp_path: Path) -> None:
    path = Path(shutil.copytree(whole.path, tmp_path / "longer"))
    with pytest.raises(SystemExit) as left:
        main(["train", "--resume", str(path), "--steps", "2560"])
    assert left.value.code in (0, None)
    folder, config = TrainingFolder.open(path)
    assert config == with_steps(staged(), 2560)
    assert [row["stage"] for row in rows(folder)[len(rows(whole)) :]] == ["3", "3"]


def test_the_best_policy_is_that_of_comparable_checks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A later stage in other pipes begins to compare anew; one with other physics alone does not."""
    found: list[tuple[int, float]] = []
    real = module.TrainingCallback.__init__

    def noted(self: Any, stage: Any, *given: Any) -> None:
        real(self, stage, *given)
        found.append((stage.number, self.best_success))

    monkeypatch.setattr(module.TrainingCallback, "__init__", noted)
    trained(tmp_path / "run", staged(**{"check.every": 256}))
    assert [number for number, _ in found] == [1, 2, 3]
    (_, first), (_, second), (_, third) = found
    assert first == third == NO_CHECK
    assert second >= 0


def test_the_progress_names_the_stage(tmp_path: Path) -> None:
    seen: list[TrainingProgress] = []
    trained(tmp_path / "run", staged(), report=seen.append)
    assert list(dict.fromkeys(one.stage for one in seen)) == ["coarse (1 of 3)", "fine (2 of 3)", "other (3 of 3)"]
    assert [one.steps for one in seen] == sorted(one.steps for one in seen)


def test_the_command_trains_all_stages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recipe = tmp_path / "mine.toml"
    recipe.write_text(
        '[[stages]]\nname = "first"\nsteps = 256\noptions.timestep = 0.005\n[[stages]]\nname = "second"\nsteps = 256\n'
        "[learner]\nrobots = 16\nrollout_steps = 16\nbatch_size = 64\n[check]\nepisodes = 4\n",
        encoding="utf-8",
    )
    with pytest.raises(SystemExit) as left:
        main(["train", "--config", str(recipe), "--pipes", "d=100,angle=90", "--out", str(tmp_path / "run")])
    assert left.value.code in (0, None)
    said = capsys.readouterr()
    assert "512 steps in 2 stages (first, second)" in " ".join((said.out + said.err).split())
    assert load_policy(tmp_path / "run" / "best.zip").header.train_pipes == ("d=100,angle=90",)


LEVEL = {"name": "level", "steps": 128, "options": {"timestep": 0.005, "contact_time_constant": 0.01}}
INCLINED = {"name": "inclined", "steps": 128, "task": {"inclination_deg": [0.0, 360.0]}}


def test_a_stage_that_observes_more_begins_with_the_policy_as_it_was(tmp_path: Path) -> None:
    """The policy learns where down is when gravity comes after a level plane; until then it does not heed it."""
    small = {"network.policy": [8], "network.value": [8], "task.max_steps": 12, "pipes": ["d=90,angle=90"]}
    learner = {"learner.robots": 4, "learner.rollout_steps": 16, "learner.batch_size": 64, "check.episodes": 1}
    config = load_config("pirate", options={**small, **learner, "stages": [LEVEL, INCLINED]})
    narrow, _ = trained(tmp_path / "narrow", with_stages(config, LEVEL))
    both, config_of_both = tmp_path / "both", with_stages(config, LEVEL, INCLINED)
    shutil.copytree(narrow.path, both)
    folder, _ = TrainingFolder.open(both)
    train(config_of_both, folder, resumed=True, should_stop=lambda: True)
    before, after = weights(narrow.last), weights(folder.last)
    size = len(before["observation_scale"])
    assert len(after["observation_scale"]) == size + 2
    first, wider = (np.reshape(w["layer0.weight"], (8, -1)) for w in (before, after))
    np.testing.assert_array_equal(wider[:, :size], first)
    assert not wider[:, size:].any()
    opened, _ = TrainingFolder.open(both)
    train(config_of_both, opened, resumed=True)
    assert np.reshape(weights(opened.last)["layer0.weight"], (8, -1))[:, size:].any()
    require_one_interface(config)
    with pytest.raises(PipenavError, match=r"stage level \(2 of 2\) has another task, observation or control"):
        require_one_interface(with_stages(config, INCLINED, LEVEL))


def with_stages(config: TrainConfig, *stages: dict[str, Any]) -> TrainConfig:
    table = config.model_dump() | {"stages": list(stages), "steps": sum(stage["steps"] for stage in stages)}
    return validate_config(table, "here")
