"""Whole searches with tiny trainings: what a killed worker, a killed driver and a stop cost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from helpers.tuning import space, tiny_plan, workers_of
from helpers.waiting import wait_until

from pipenav.errors import PipenavError
from pipenav.jobs.here import HerePlace
from pipenav.jobs.processes import ProcessesPlace
from pipenav.learning.config import load_config
from pipenav.tuning.objective import Objective
from pipenav.tuning.report import BEST_FILE, REPORT_FILE, verdict, write_report
from pipenav.tuning.search import MOST_REFUSED, PRESET, RESULTS, Search, SearchNews

pytest.importorskip("optuna")
pytestmark = pytest.mark.slow


class Told:
    """News of a search, and the wish to stop after some trials."""

    def __init__(self, stop_after: int = 1 << 30) -> None:
        self.ended: list[str] = []
        self.shares: list[float] = []
        self._stop_after = stop_after

    def __call__(self, news: SearchNews) -> None:
        self.shares.append(news.share)
        if news.ended:
            self.ended.append(news.ended)

    def should_stop(self) -> bool:
        return len(self.ended) >= self._stop_after


def run(search: Search, place: Any = None, told: Told | None = None) -> bool:
    told = told or Told()
    return search.run(place or HerePlace(), told, told.should_stop)


def suggested(search: Search) -> list[dict[str, Any]]:
    return [record.settings for record in search.study.records() if record.state != "refused"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Search:
    """A finished search, not to be changed."""
    search = Search(tiny_plan(tmp_path_factory.mktemp("tune") / "whole", trials=3, again=1))
    told = Told()
    assert run(search, told=told)
    assert len(told.ended) >= 4  # the preset and the trials
    assert max(told.shares) == 1.0
    return search


def test_a_search_begins_with_the_preset_and_tries_what_was_asked(whole: Search) -> None:
    records = whole.study.records()
    assert [record.preset for record in records] == [True, False, False, False]
    assert {record.state for record in records} == {"done"}
    assert all(record.outcome is not None and record.outcome.steps == 512 for record in records)


def test_the_best_settings_are_a_recipe(whole: Search) -> None:
    files = write_report(whole)
    assert all(file.stat().st_size > 0 for file in files)
    best = whole.best()
    assert best is not None
    assert load_config(file=whole.plan.out / BEST_FILE).learner == whole.plan.base.config(best.settings).learner
    assert verdict(whole) in (whole.plan.out / REPORT_FILE).read_text(encoding="utf-8")


def test_the_same_seed_finds_the_same_with_one_job(whole: Search, tmp_path: Path) -> None:
    stopped = Search(tiny_plan(tmp_path, trials=3))
    assert not run(stopped, told=Told(stop_after=2))  # stopped on its way, which changes nothing
    again = Search(tiny_plan(tmp_path, trials=3))
    assert run(again)
    assert suggested(again) == suggested(whole)
    values = [
        [whole.plan.objective.value(r.outcome) for r in one.study.records() if r.outcome] for one in (whole, again)
    ]
    assert values[0] == values[1]


def test_more_trials_go_on_with_a_finished_search(whole: Search) -> None:
    before = suggested(whole)
    longer = Search(whole.plan._replace(trials=4, again=0))
    told = Told()
    assert run(longer, told=told)
    assert suggested(longer)[: len(before)] == before
    assert len(suggested(longer)) == len(before) + 1
    assert len(told.ended) == 2  # the preset's result is kept, and one trial is new


def test_another_search_is_refused_in_the_folder(whole: Search) -> None:
    other = whole.plan._replace(objective=Objective(name="steps"))
    with pytest.raises(PipenavError, match="holds finished parts of something else"):
        Search(other)


def test_a_killed_worker_costs_only_its_trial(tmp_path: Path) -> None:
    search, killed = Search(tiny_plan(tmp_path, trials=3, steps=1024)), []

    def told(_news: SearchNews) -> None:
        """Kill a worker as soon as there are two."""
        workers = workers_of(os.getpid())
        if len(workers) == 2 and not killed:
            killed.append(workers[0])
            os.kill(workers[0], signal.SIGKILL)

    assert search.run(ProcessesPlace("2"), told, lambda: False)
    assert killed
    assert [record.state for record in search.study.records() if not record.preset] == ["done"] * 3


DRIVER = """
import sys
from pathlib import Path
from helpers.tuning import tiny_plan
from pipenav.jobs.processes import ProcessesPlace
from pipenav.tuning.search import Search
search = Search(tiny_plan(Path(sys.argv[1]), trials=3, steps=1024))
search.run(ProcessesPlace("2"), lambda news: print(news.ended, flush=True) if news.ended else None, lambda: False)
"""


@pytest.mark.usefixtures("helpers_for_children")
def test_a_killed_driver_loses_no_trial(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", DRIVER, str(tmp_path)], stdout=subprocess.PIPE, text=True) as driver:
        assert driver.stdout is not None
        first = driver.stdout.readline()
        wait_until(lambda: len(list((tmp_path / "trainings").iterdir())) >= 3, "a trial runs beside another training")
        workers = workers_of(driver)
        driver.kill()
    assert first
    wait_until(lambda: not any(Path(f"/proc/{number}").exists() for number in workers), "the workers have ended")
    kept = {file.name: file.read_bytes() for file in (tmp_path / RESULTS).glob("[!.]*")}
    search = Search(tiny_plan(tmp_path, trials=3, steps=1024))
    running = [record.settings for record in search.study.records() if record.state == "running"]
    assert running
    assert run(search)
    records = search.study.records()
    assert [record.state for record in records if not record.preset] == ["done"] * 3
    assert all(settings in [record.settings for record in records] for settings in running)
    assert {name: (tmp_path / RESULTS / name).read_bytes() for name in kept} == kept


def test_a_trial_without_a_future_is_ended_early(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pipenav.learning.callback import TrainingCallback

    def measured(callback: TrainingCallback, _steps: int, _seconds: float) -> float:
        """Made-up success: the more epochs, the better."""
        return 0.9 if callback.model.n_epochs == 3 else 0.1 * callback.model.n_epochs

    monkeypatch.setattr(TrainingCallback, "_measure", measured)
    epochs = {"learner.epochs": {"choices": [1, 2, 3]}}
    search = Search(tiny_plan(tmp_path, trials=9, steps=768, space=space(**epochs)))
    assert run(search)
    records = search.study.records()
    assert {record.settings["learner.epochs"] for record in records if record.state == "pruned"} <= {1, 2}
    assert any(record.state == "pruned" for record in records)
    assert all(record.outcome and record.outcome.steps < 768 for record in records if record.state == "pruned")
    best = search.best()
    assert best is not None and best.settings == {"learner.epochs": 3}
    assert "beats the preset" not in verdict(search) or "with other seeds" in verdict(search)


def test_settings_that_fit_no_training_are_passed_over(tmp_path: Path) -> None:
    """Batches of 100 never divide a rollout of 16 robots; those of 64 do for some lengths."""
    ranges = {"learner.batch_size": {"choices": [100, 64]}, "learner.rollout_steps": {"choices": [8, 12]}}
    search = Search(tiny_plan(tmp_path, trials=2, space=space(**ranges), settings=["learner.rollout_steps=8"]))
    assert run(search)
    records = search.study.records()
    assert {record.state for record in records} <= {"done", "refused"}
    assert sum(record.state == "done" and not record.preset for record in records) == 2
    assert all("must divide" in record.problem for record in records if record.state == "refused")


def test_a_space_in_which_nothing_fits_ends_the_search(tmp_path: Path) -> None:
    fits = space(**{"learner.batch_size": {"choices": [64, 128]}})
    nothing = space(**{"learner.batch_size": {"choices": [96, 160]}})
    plan = tiny_plan(tmp_path, space=fits, trials=1)
    nothing_fits = plan._replace(base=plan.base._replace(space=nothing))
    with pytest.raises(PipenavError, match=f"the last {MOST_REFUSED} settings fit no training, .*must divide"):
        run(Search(nothing_fits))
    assert Search(nothing_fits).preset() is not None
    write_report(Search(nothing_fits))
    assert "100 suggestions fitted no training" in (tmp_path / REPORT_FILE).read_text(encoding="utf-8")
    assert (tmp_path / RESULTS / PRESET).exists()
