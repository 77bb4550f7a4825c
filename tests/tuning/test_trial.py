"""A trial's training: ended at its first success, gone on with where it was, the same in a temporary folder."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from helpers.tiny_training import weights
from helpers.tuning import STEPS, tiny_plan

from pipenav.jobs import JobStopped
from pipenav.learning.train import train
from pipenav.learning.training_folder import TrainingFolder
from pipenav.tuning.objective import Objective, Outcome
from pipenav.tuning.trial import CHECKS_FILE, TrialOrder, run_trial, trial_folder

pytestmark = pytest.mark.slow


NAME = "trial-0000"


class Place:
    """The side of a place that a job sees; it asks to stop at a report of so many steps."""

    cores = 1

    def __init__(self, stop_at: int = 1 << 60) -> None:
        self._stop_at, self._now = stop_at, False
        self.heard: list[Outcome] = []

    def report(self, progress: Outcome) -> None:
        self.heard.append(progress)
        self._now = self._now or progress.steps >= self._stop_at

    def should_stop(self) -> bool:
        return self._now


def order(search: Path, objective: Objective, *settings: str, steps: int = STEPS, shared: bool = True) -> TrialOrder:
    """A trial of a search at a place that shares the driver's disk, or does not."""
    plan = tiny_plan(search, objective=objective, steps=steps, settings=settings)
    return TrialOrder(plan.config, objective, NAME, trial_folder(search, NAME) if shared else None)


def done(given: TrialOrder, place: Place | None = None) -> Outcome:
    return Outcome.model_validate_json(run_trial(given, place or Place()))


WHOLE = Objective(name="success")
EASY = Objective(name="steps", success=0.5)


def timeless(found: Outcome) -> list[tuple[int, float]]:
    return [(check.steps, check.success) for check in found.checks]


def test_a_trial_is_the_training_that_train_does(tmp_path: Path) -> None:
    given = order(tmp_path / "search", WHOLE)
    place = Place()
    found = done(given, place)
    folder = TrainingFolder.create(tmp_path / "plain", given.config, "pipenav train")
    summary = train(given.config, folder)
    mine = trial_folder(tmp_path / "search", NAME)
    assert weights(mine / "last.zip") == weights(folder.last)
    assert found.steps == STEPS == found.checks[-1].steps
    assert found.success == summary.check_success
    assert [check.steps for check in found.checks] == [256, 512]  # during the training, and of its best at the end
    assert place.heard[-1].steps == STEPS
    assert [len(one.checks) for one in place.heard] == sorted(len(one.checks) for one in place.heard)


def test_without_a_shared_disk_the_same_comes_back(tmp_path: Path) -> None:
    here, away = order(tmp_path / "here", WHOLE), order(tmp_path / "away", WHOLE, shared=False)
    assert timeless(done(here)) == timeless(done(away))
    assert trial_folder(tmp_path / "here", NAME).exists()
    assert not trial_folder(tmp_path / "away", NAME).exists()


def test_a_trial_that_was_stopped_goes_on(tmp_path: Path) -> None:
    given = order(tmp_path / "search", WHOLE, steps=1024)
    with pytest.raises(JobStopped):
        run_trial(given, Place(stop_at=512))
    path = trial_folder(tmp_path / "search", NAME)
    first = json.loads((path / CHECKS_FILE).read_text())["checks"]
    assert [check[0] for check in first] == [256]
    place = Place()
    found = done(given, place)
    assert place.heard[0].steps > 512
    assert [list(check) for check in found.checks][: len(first)] == first
    assert found.steps >= 1024  # a training that goes on begins a new rollout


def test_a_training_of_other_settings_is_not_gone_on_with(tmp_path: Path) -> None:
    given = order(tmp_path / "search", WHOLE)
    other = order(tmp_path / "other", WHOLE, steps=256)
    done(other)
    path = trial_folder(tmp_path / "search", NAME)
    shutil.copytree(trial_folder(tmp_path / "other", NAME), path)
    assert done(given).steps == STEPS
    assert TrainingFolder.open(path).config.steps == STEPS


def test_a_success_ends_the_training(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pipenav.learning.callback import TrainingCallback

    success = iter([0.25, 0.75, 1.0, 1.0, 1.0])
    monkeypatch.setattr(TrainingCallback, "_measure", lambda _self, _steps, _seconds: next(success))
    given = order(tmp_path / "search", Objective(name="steps", success=0.7), "check.every=512", steps=4096)
    found = done(given)
    assert timeless(found) == [(512, 0.25), (1024, 0.75)]
    assert given.objective.value(found) == 1024
    assert found.steps < 1536
    assert timeless(done(given)) == timeless(found)  # given again, it has nothing left to do


def test_checks_of_other_pipes_are_no_success(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pipenav.learning.callback import TrainingCallback

    monkeypatch.setattr(TrainingCallback, "_measure", lambda _self, _steps, _seconds: 1.0)
    stages = 'stages=[{name="easy", steps=1024, pipes=["d=120,angle=120"]}, {name="own", steps=1024}]'
    plan = tiny_plan(tmp_path / "search", objective=EASY, steps=None, settings=[stages, "check.every=512"])
    found = done(TrialOrder(plan.config, EASY, NAME, trial_folder(tmp_path, NAME)))
    assert timeless(found) == [(1536, 1.0)]
