"""The whole passage: every stage takes up what the one before left, and the counts say so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipenav.cli import main
from pipenav.errors import PipenavError
from pipenav.evaluation.config import EvaluationConfig, StageName
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.passage import EpisodePlan, Passages, StageResult
from pipenav.evaluation.results import Evaluation
from pipenav.motions.mirror import join, rear_motion
from pipenav.motions.trajectory import Motion
from pipenav.pipes.corner_sets import parse_corners
from pipenav.policies.controller import Controller
from pipenav.policies.named import open_controller
from pipenav.robots import kinematics
from pipenav.storage import shipped
from pipenav.tasks.outcome import Outcome

NAMES = ("d=110,angle=90", "d=100,angle=75,turn=right")
EPISODES = 3
JOBS = len(NAMES) * EPISODES


@pytest.fixture(scope="module")
def controller() -> Controller:
    return open_controller("arm")


@pytest.fixture(scope="module")
def passages(controller: Controller) -> Passages:
    return Passages(EpisodePlan(controller.robot, controller.task, parse_corners(NAMES), EPISODES, seed=5))


@pytest.fixture(scope="module")
def located(passages: Passages) -> StageResult:
    return passages.locate()


@pytest.fixture(scope="module")
def front(passages: Passages, controller: Controller, located: StageResult) -> StageResult:
    return passages.task(controller, located)


def test_a_motion_is_what_the_stage_went_through(located: StageResult, front: StageResult) -> None:
    for part in (located, front):
        for k in range(len(part.jobs)):
            assert len(part.motions[k]) == part.results.steps[k] + 1
            np.testing.assert_array_equal(part.motions[k][-1], part.results.q[k])


def test_the_front_begins_where_locating_ended(located: StageResult, front: StageResult) -> None:
    assert list(front.jobs) == [job for job, passed in zip(located.jobs, located.passed, strict=True) if passed]
    assert len(front.jobs) == JOBS
    for job, motion in zip(front.jobs, front.motions, strict=True):
        np.testing.assert_array_equal(motion[0], located.results.q[job])


def test_the_front_goes_for_the_target_that_was_found(
    front: StageResult, controller: Controller, located: StageResult
) -> None:
    assert front.passed.all()
    turn_signs = np.array([pipe.turn_sign for pipe in parse_corners(NAMES) for _ in range(EPISODES)])
    tips = kinematics.forward(controller.robot, front.results.q).tip * np.stack([np.ones(JOBS), turn_signs], axis=1)
    off = np.linalg.norm(tips - located.targets, axis=1)
    assert (off <= controller.task.reach_tolerance).all()


def test_the_rear_plays_both_motions_backwards(passages: Passages, located: StageResult, front: StageResult) -> None:
    rear = passages.rear(front, located)
    assert list(rear.jobs) == list(front.jobs)
    assert rear.passed.all()
    whole = [join([Motion(parse_corners(NAMES)[0], 0.0, part.motions[0]) for part in (located, front)])]
    robot = open_controller("arm").robot
    assert (
        abs(rear.results.steps[0] - (len(rear_motion(robot, whole[0]).q) - 1)) <= 20
    )  # it waits at the end until it is there


def evaluate(policy: str | None, stage: StageName) -> Evaluation:
    return CheckedEvaluation(EvaluationConfig(policy=policy, pipes=NAMES, episodes=EPISODES, seed=5, stage=stage)).run()


def counts(evaluation: Evaluation) -> list[tuple[int | None, ...]]:
    return [
        (r.located, r.reach_attempts, r.reach_successes, r.rear_attempts, r.rear_successes) for r in evaluation.pipes
    ]


@pytest.mark.parametrize("stage", ["reach", "reach-rear", "locate", "passage"])
def test_counts_are_those_of_the_stages_that_ran(stage: StageName) -> None:
    found = evaluate("arm" if stage != "locate" else None, stage)
    n = EPISODES
    expected = {
        "reach": (None, n, n, None, None),
        "reach-rear": (None, n, n, n, n),
        "locate": (n, None, None, None, None),
        "passage": (n, n, n, n, n),
    }
    assert counts(found) == [expected[stage]] * len(NAMES)
    assert found.stage == stage
    assert found.success == 1.0


def test_failures_add_up_and_a_stage_that_nothing_came_to_is_empty() -> None:
    found = evaluate("baseline:random", "passage")
    for record in found.pipes:
        assert record.located == record.reach_attempts == EPISODES
        assert (record.reach_successes, record.rear_attempts, record.rear_successes) == (0, 0, 0)
        assert sum(record.failures.values()) == EPISODES
    assert found.success == 0.0


def test_the_same_seed_gives_the_same_passages(passages: Passages, located: StageResult) -> None:
    again = passages.locate()
    np.testing.assert_array_equal(again.targets, located.targets)
    for one, other in zip(again.motions, located.motions, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("policy", "stage", "message"),
    [(None, "reach", "stage reach measures a policy"), ("arm", "locate", "stage locate runs without a policy")],
)
def test_a_stage_wants_its_policy(policy: str | None, stage: StageName, message: str) -> None:
    with pytest.raises(PipenavError, match=message):
        evaluate(policy, stage)


def test_a_pipe_too_narrow_for_the_robot_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wide = tmp_path / "robot.toml"
    text = (shipped.robots_dir() / "real-setup" / "robot.toml").read_text(encoding="utf-8")
    wide.write_text(text.replace("width = 0.036", "width = 0.042"), encoding="utf-8")
    args = ["eval", "--stage", "locate", "--robot", str(wide), "--pipes", "d=45,angle=90"]
    with pytest.raises(SystemExit) as left:
        main([*args, "--out", str(tmp_path / "out")])
    assert left.value.code == 1
    assert "which is 42 mm wide and needs 46 mm at rest" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_failed_stage_names_itself() -> None:
    config = EvaluationConfig(stage="locate", pipes=("d=110,angle=175",), episodes=2, variant="thesis")
    found = CheckedEvaluation(config).run()
    assert set(found.pipes[0].failures) <= {f"locate {outcome.label}" for outcome in Outcome}
    assert found.policy == "locate:thesis"
