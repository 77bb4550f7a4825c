"""An episode that is run again from its seed ends as it did, at the same step, whichever others run with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.documented import pipenav

from pipenav.evaluation import CheckedEvaluation, EvaluationConfig
from pipenav.evaluation.atlas import _chosen, atlas_files
from pipenav.evaluation.failures import FILE, Failure, Failures, failed_episodes, read_failures, same_end, with_poses
from pipenav.evaluation.replay import Replayer
from pipenav.jobs import MemoryStore
from pipenav.tasks.outcome import Outcome

NARROW = ("d=55,angle=45", "d=60,angle=60,turn=right", "d=90,angle=90")

KINDS: dict[str, dict[str, Any]] = {
    "reach": {"policy": "arm", "pipes": NARROW, "episodes": 6},
    "passage": {"policy": "arm", "pipes": ("d=70,angle=55", *NARROW), "episodes": 4, "stage": "passage"},
    "locate": {"pipes": NARROW, "episodes": 4, "stage": "locate", "variant": "thesis"},
    "disturbed": {"policy": "arm", "pipes": NARROW, "episodes": 6, "disturb": "real-world"},
    "random": {"policy": "baseline:random", "pipes": NARROW[2:], "episodes": 12},
    "traverse": {"policy": "pirate", "pipes": ("d=60,angle=45",), "episodes": 4},
}


def evaluated(kind: str) -> tuple[CheckedEvaluation, MemoryStore, Any]:
    """An evaluation that was run, its parts and its results."""
    checked, store = CheckedEvaluation(EvaluationConfig(**KINDS[kind])), MemoryStore()
    return checked, store, checked.run(store=store)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_episodes_end_alike_when_they_are_run_again(kind: str) -> None:
    checked, store, evaluation = evaluated(kind)
    failures = {failure.number: failure for failure in failed_episodes(checked, store)}
    assert len(failures) == evaluation.episodes - sum(record.successes for record in evaluation.pipes)
    assert len(failures) > 0
    replayer = Replayer(checked)
    again = list(replayer.run(range(checked.parts.total)))
    assert [one.number for one in again] == list(range(checked.parts.total))
    for one in again:
        assert one.passed == (one.number not in failures)
        assert one.passed or same_end(failures[one.number], one)
    alone = next(iter(failures))
    (one,) = replayer.run([alone])
    assert same_end(failures[alone], one)


@pytest.mark.slow
def test_every_failure_gets_its_place_and_pose(tmp_path: Path) -> None:
    checked, store, evaluation = evaluated("reach")
    files = atlas_files(checked, evaluation, store, tmp_path)
    (tmp_path / FILE).write_bytes(files[FILE])
    found = read_failures(tmp_path)
    assert found and all(failure.pose is not None for failure in found.values())
    for failure in found.values():
        assert failure.pose is not None
        assert failure.pose.rear_mm < failure.pose.tip_mm, "the tip goes first"
        assert failure.pose.side in failure.kind and failure.outcome in failure.kind
        assert len(failure.pose.q) == checked.parts.episodes.robot.coordinates


def test_an_episode_that_ends_otherwise_gets_no_pose() -> None:
    checked, store, _ = evaluated("reach")
    failures = failed_episodes(checked, store)
    (one,) = Replayer(checked).run([failures[0].number])
    other = one._replace(steps=one.steps - 1)
    robot = checked.parts.episodes.robot
    assert with_poses(failures[:1], [one], robot)[0].pose is not None
    assert with_poses(failures[:1], [other], robot)[0].pose is None
    assert with_poses(failures[:1], [one._replace(outcome=Outcome.LIMIT)], robot)[0].pose is None


def test_failures_come_back_from_their_file(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    every = tuple(
        Failure(number=i, pipe=i // 3, stage="reach", outcome="timeout", steps=int(rng.integers(1, 200)))
        for i in range(20)
    )
    (tmp_path / FILE).write_text(Failures(schema=1, failures=every).to_json(), encoding="utf-8")
    assert read_failures(tmp_path) == {failure.number: failure for failure in every}
    assert read_failures(tmp_path / "nowhere") is None


def test_pictures_are_taken_from_all_pipes_in_turn() -> None:
    checked, store, evaluation = evaluated("reach")
    del checked, store
    many = [Failure(number=n, pipe=n // 6, stage="reach", outcome="timeout", steps=1) for n in range(12)]
    assert sorted(_chosen(many, evaluation)) == [*range(12), 12], "all failures, and one episode of the pipe without"


@pytest.mark.slow
def test_view_says_that_an_episode_ended_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    pipes = [word for pipe in NARROW for word in ("--pipes", pipe)]
    assert pipenav("eval", "--policy", "arm", *pipes, "--episodes", "2", "--out", "narrow") == 0
    capsys.readouterr()
    for number in range(6):
        assert pipenav("view", "--eval", "narrow", "--episode", str(number), "--out", "picture.png") == 0
        assert "as in the evaluation" in capsys.readouterr().out.replace("\n", " ")
    text = (tmp_path / "narrow" / FILE).read_text().replace('"steps":100', '"steps":99')
    (tmp_path / "narrow" / FILE).write_text(text)
    assert pipenav("view", "--eval", "narrow", "--episode", "0", "--out", "picture.png") == 0
    assert "in the evaluation, reach: timeout after 9.9 s" in capsys.readouterr().out.replace("\n", " ")
    assert pipenav("view", "--eval", "narrow", "--episode", "6") == 1
    assert "choose 0 to 5" in capsys.readouterr().err
    (tmp_path / "narrow" / FILE).write_text("{}")
    assert pipenav("view", "--eval", "narrow", "--episode", "0") == 1
    assert FILE in capsys.readouterr().err
