"""The study: the same suggestions for the same seed, also after a kill, and trials that are ended early."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.tuning import copied, outcome, space
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.tuning.objective import Objective
from pipenav.tuning.study import BEFORE_PRUNING, JOURNAL_FILE, TuningStudy, best_record

pytest.importorskip("optuna")
EVERY = 100


def study(folder: Path, seed: int = 0, name: str = "steps") -> TuningStudy:
    folder.mkdir(exist_ok=True)
    return TuningStudy(folder, space(), Objective(name=name, success=0.9), seed, EVERY)


def quality(found: dict[str, Any]) -> list[float]:
    """Made-up checks of a training: a greater learning rate is better."""
    return [min(1.0, found["learner.learning_rate"] * 100 * (i + 1) / 4) for i in range(4)]


def run(one: TuningStudy, trials: int) -> list[dict[str, Any]]:
    """Suggestions of some trials, one after the other."""
    suggested = []
    for _ in range(trials):
        record = one.ask()
        suggested.append(record.settings)
        one.tell(record.number, outcome(*quality(record.settings), every=EVERY))
    return suggested


@settings(max_examples=3, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_seed_decides_what_is_suggested(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    path = tmp_path_factory.mktemp("studies")
    one = run(study(path / "one", seed), 13)
    assert one == run(study(path / "same", seed), 13)
    assert one != run(study(path / "other", seed ^ 1), 13)
    assert all(space().space[key].has(value) for found in one for key, value in found.items())


@pytest.mark.parametrize("kept", [1, 11])
def test_a_killed_study_goes_on_as_if_it_had_not_been(tmp_path: Path, kept: int) -> None:
    whole = run(study(tmp_path / "whole"), 14)
    run(study(tmp_path / "killed"), kept)
    assert run(study(tmp_path / "killed"), 14 - kept) == whole[kept:]


def test_a_trial_that_ran_is_taken_up_again(tmp_path: Path) -> None:
    first = study(tmp_path)
    running = first.ask()
    first.hear(running.number, outcome(0.1, 0.2))
    again = study(tmp_path)
    assert [(one.state, one.settings) for one in again.records()] == [("running", running.settings)]
    again.hear(running.number, outcome(0.1, 0.3))  # it begins anew, and its first checks are known already
    again.tell(running.number, outcome(0.1, 0.3, 0.9))
    assert study(tmp_path).record(running.number).outcome == outcome(0.1, 0.3, 0.9)


@pytest.mark.parametrize("cut", [1, 7, 40])
def test_half_a_line_at_the_end_is_left_out(tmp_path: Path, cut: int) -> None:
    one = study(tmp_path / "one")
    run(one, 2)
    whole = (tmp_path / "one" / JOURNAL_FILE).read_bytes()
    lines = whole.splitlines(keepends=True)
    folder = copied(tmp_path / "one", tmp_path / "cut")
    (folder / JOURNAL_FILE).write_bytes(b"".join(lines[:-1]) + lines[-1][:cut])
    (folder / f"{JOURNAL_FILE}.lock").symlink_to(folder / JOURNAL_FILE)  # as a driver leaves it that is killed
    broken = study(folder)
    assert [record.state for record in broken.records()] == ["done", "running"]
    run(broken, 2)
    assert len(study(folder).records()) == 4


def test_a_damaged_journal_is_named(tmp_path: Path) -> None:
    (tmp_path / JOURNAL_FILE).write_text("no journal\nat all\n")
    with pytest.raises(PipenavError, match=r"study\.journal is damaged: choose another --out"):
        study(tmp_path)


def good_trials(one: TuningStudy, count: int) -> None:
    for _ in range(count):
        one.tell(one.ask().number, outcome(0.5, 0.95))


def test_what_is_worse_than_the_median_is_ended_early_but_never_at_first(tmp_path: Path) -> None:
    one = study(tmp_path)
    for known in range(BEFORE_PRUNING + 2):
        record = one.ask()
        assert one.hear(record.number, outcome(0.1)) == (known >= BEFORE_PRUNING)
        better = one.ask()
        assert not one.hear(better.number, outcome(0.6))
        one.tell_pruned(record.number, outcome(0.1))
        one.tell(better.number, outcome(0.5, 0.95))
    assert best_record(one.records(), Objective(success=0.9)).outcome == outcome(0.5, 0.95)  # type: ignore[union-attr]


def test_an_early_success_counts_at_later_checks(tmp_path: Path) -> None:
    one = study(tmp_path)
    slow = one.ask()
    one.hear(slow.number, outcome(0.5, 0.6, 0.6, 0.6))
    good_trials(one, BEFORE_PRUNING)
    assert one.hear(slow.number, outcome(0.5, 0.6, 0.6, 0.6, 0.6)) is False  # nobody has been there
    late = one.ask()
    one.hear(late.number, outcome(0.5, 0.6, 0.6, 0.6, 0.6))
    good_trials(one, BEFORE_PRUNING)
    assert one.hear(late.number, outcome(0.5, 0.6, 0.6, 0.6, 0.6, 0.6)) in (True, False)
    another = one.ask()
    assert one.hear(another.number, outcome(0.5, 0.6, 0.6, 0.6))


def test_refused_settings_are_no_results(tmp_path: Path) -> None:
    one = study(tmp_path)
    record = one.ask()
    one.refuse(record.number, "they do not fit.")
    [refused] = study(tmp_path).records()
    assert (refused.state, refused.problem, refused.outcome) == ("refused", "they do not fit.", None)
    assert best_record([refused], Objective()) is None


def test_the_preset_is_known_once_and_is_not_the_best(tmp_path: Path) -> None:
    one = study(tmp_path)
    own = {"learner.learning_rate": 1e-3, "learner.epochs": 2, "network.policy": [64, 64]}
    for _ in range(2):
        study(tmp_path).add_preset(own, outcome(1.0))
    good_trials(one, 1)
    preset, trial = study(tmp_path).records()
    assert (preset.preset, preset.settings, trial.preset) == (True, own, False)
    assert best_record([preset, trial], Objective(success=0.9)) == trial


def test_what_matters_is_found(tmp_path: Path) -> None:
    one = study(tmp_path, name="success")
    assert one.importance() == {}
    run(one, 30)
    importance = one.importance()
    assert set(importance) == set(space().space)
    assert next(iter(importance)) == "learner.learning_rate"
    assert sum(importance.values()) == pytest.approx(1.0)
