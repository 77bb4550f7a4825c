"""Trials and certificates as jobs: the same record wherever they run, and nothing lost with a worker."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.documented import pipenav
from helpers.surveys import answer_evaluations

from pipenav.jobs import Ending, HearProgress, Job, JobsLost, Lost, Place, ShouldStop, Slots
from pipenav.jobs.here import HerePlace
from pipenav.survey.classes import FittingClass
from pipenav.survey.findings import Findings
from pipenav.survey.trial_jobs import TrialConfig

BENDS = [FittingClass("bend", 100, angle) for angle in (60.0, 90.0, 135.0)]


class LosingPlace(Place):
    """This process, in which jobs whose key has a word are lost so many times."""

    def __init__(self, word: str, times: int) -> None:
        self.name, self.word, self.left = "a bad machine", word, times

    def open(self, hear: HearProgress, should_stop: ShouldStop) -> Slots:
        return _Losing(self, HerePlace().open(hear, should_stop))


class _Losing(Slots):
    def __init__(self, place: LosingPlace, inner: Slots) -> None:
        self._place, self._inner = place, inner

    @property
    def free(self) -> int:
        return self._inner.free

    @property
    def busy(self) -> tuple[Job, ...]:
        return self._inner.busy

    def give(self, job: Job) -> None:
        self._inner.give(job)

    def wait(self, patience: float) -> list[Ending]:
        if self._place.left and any(self._place.word in job.key for job in self.busy):
            self._place.left -= 1
            lost = [Lost(job, "its machine is gone") for job in self.busy]
            self._inner.close()
            return list(lost)
        return self._inner.wait(patience)

    def stop(self, job: Job) -> None:
        self._inner.stop(job)

    def close(self) -> None:
        self._inner.close()


@pytest.mark.parametrize("word", ["a90-part", "geometry-bend-d100-a90"])
def test_a_lost_worker_changes_nothing(word: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answer_evaluations(monkeypatch, lambda name: 15 if "a90" in name else 20)
    whole = Findings(TrialConfig("pirate"), tmp_path / "one").of(BENDS)
    losing = LosingPlace(word, 2)
    assert Findings(TrialConfig("pirate"), tmp_path / "other", losing).of(BENDS) == whole
    assert not losing.left


def test_what_is_lost_every_time_is_named_and_the_others_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = answer_evaluations(monkeypatch)
    with pytest.raises(JobsLost, match="trial of bend-d100-a90"):
        Findings(TrialConfig("pirate"), tmp_path, LosingPlace("a90-part", 3)).of(BENDS)
    before = len(asked)
    Findings(TrialConfig("pirate"), tmp_path).of(BENDS)
    assert len(asked) == before + 1


@pytest.mark.slow
def test_records_are_the_same_wherever_trials_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Byte for byte: in this process, in two others, and where half of the trials had been kept."""
    monkeypatch.chdir(tmp_path)
    Path("town.csv").write_text("x1,y1,x2,y2,bore\n0,0,90,0,100\n90,0,90,80,100\n90,80,160,150,100\n")
    words = (
        "survey",
        "town.csv",
        "--diameter",
        "bore:mm",
        "--coordinates",
        "m",
        "--accuracy",
        "0.01",
        "--episodes",
        "4",
    )
    assert pipenav(*words, "--cache", "one", "--out", "here") == 0
    assert pipenav(*words, "--cache", "other", "--out", "processes", "--jobs", "2") == 0
    next(Path("other").glob("bend-d100-a90-*.json")).unlink()
    assert pipenav(*words, "--cache", "other", "--out", "again", "--jobs", "1") == 0
    records = {(Path(out) / "survey.json").read_bytes() for out in ("here", "processes", "again")}
    assert len(records) == 1
