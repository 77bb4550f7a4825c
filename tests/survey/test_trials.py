"""Each class is simulated once, and kept; what a policy was not trained in is never guessed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.surveys import answer_evaluations

from pipenav.errors import PipenavError
from pipenav.evaluation.interval import wilson
from pipenav.survey.classes import FittingClass
from pipenav.survey.trial_jobs import TrialConfig
from pipenav.survey.trials import Trial, Trials

BENDS = [FittingClass("bend", 100, angle) for angle in (60.0, 90.0, 135.0)]


def test_a_class_is_simulated_once_and_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Also by another process, which finds it on disk: here another object."""
    asked = answer_evaluations(monkeypatch, lambda name: 15 if "a60" in name else 20)
    first = Trials(TrialConfig("pirate"), tmp_path).results(BENDS * 3)
    assert len(asked) == len(BENDS)
    again = Trials(TrialConfig("pirate"), tmp_path).results(BENDS)
    assert len(asked) == len(BENDS)
    assert again == first
    assert (first[BENDS[0]].successes, first[BENDS[0]].episodes) == (15, 20)
    assert first[BENDS[0]].failures == {"slip": 5}


@pytest.mark.parametrize(
    "change", [{"episodes": 40}, {"seed": 1}, {"options": {"timestep": 0.001}}, {"policy": "pirate-strong-gravity"}]
)
def test_what_decides_a_trial_is_in_its_key(
    change: dict[str, Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked = answer_evaluations(monkeypatch)
    Trials(TrialConfig("pirate"), tmp_path).results(BENDS)
    Trials(TrialConfig("pirate")._replace(**change), tmp_path).results(BENDS)
    assert len(asked) == 2 * len(BENDS)


def test_a_stopped_survey_goes_on_where_it_was(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    done = []

    def stop_at_second(name: str) -> int:
        done.append(name)
        if len(done) == 2:
            raise KeyboardInterrupt
        return 20

    asked = answer_evaluations(monkeypatch, stop_at_second)
    with pytest.raises(KeyboardInterrupt):
        Trials(TrialConfig("pirate"), tmp_path).results(BENDS)
    Trials(TrialConfig("pirate"), tmp_path).results(BENDS)
    assert len(asked) == 1 + len(BENDS), "only the one that was stopped is tried again"


@pytest.mark.parametrize("damage", ["", "{", '{"key": 1, "trial": 2}', '{"key": {}}'])
def test_a_damaged_file_is_tried_again(damage: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked = answer_evaluations(monkeypatch)
    trials = Trials(TrialConfig("pirate"), tmp_path).results(BENDS[:1])
    (file,) = tmp_path.glob("*.json")
    file.write_text(damage)
    assert Trials(TrialConfig("pirate"), tmp_path).results(BENDS[:1]) == trials
    assert len(asked) == 2


@pytest.mark.parametrize(
    ("kind", "reason"),
    [
        (FittingClass("bend", 145, 90), "145 mm lies outside of the 70-120 mm"),
        (FittingClass("tee", 100, 90, to_mm=50, way="into"), "50 mm lies outside"),
        (FittingClass("bend", 100, 40), "40 deg is sharper than the 55 deg"),
        (FittingClass("bend", 100, 90, incline_deg=30), "trained in level pipes"),
    ],
)
def test_outside_of_what_was_trained_is_unknown(
    kind: FittingClass, reason: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked = answer_evaluations(monkeypatch)
    trial = Trials(TrialConfig("pirate-strong"), tmp_path).results([kind])[kind]
    assert not asked
    assert trial.rate is None and trial.verdict(0.5) == "unknown" and reason in trial.reason


def test_a_straight_pipe_needs_no_trial(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked = answer_evaluations(monkeypatch)
    straight = FittingClass("bend", 100, 180)
    assert Trials(TrialConfig("pirate"), tmp_path).results([straight])[straight].verdict(0.99) == "navigable"
    assert not asked


def test_an_arm_surveys_nothing(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match="passes no pipe as a whole"):
        Trials(TrialConfig("arm"), tmp_path)


@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.95])
def test_a_verdict_follows_the_share_and_its_interval(confidence: float) -> None:
    for successes in range(21):
        verdict = Trial(episodes=20, successes=successes).verdict(confidence)
        assert (verdict == "navigable") == (successes / 20 >= confidence)
        assert (verdict == "not navigable") == (wilson(successes, 20).high < confidence)


@pytest.mark.slow
def test_a_class_is_really_simulated(tmp_path: Path) -> None:
    """The shipped policy passes a right angle in 100 mm."""
    right = FittingClass("bend", 100, 90)
    trial = Trials(TrialConfig("pirate", episodes=4), tmp_path).results([right])[right]
    assert (trial.successes, trial.episodes) == (4, 4)
    assert trial.mean_steps is not None and 20 < trial.mean_steps < 300
