"""Audits by geometry: the same wherever parts run, true to the motion, and blind to nothing that they are for."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.cli.percentages import audited_share
from pipenav.errors import PipenavError
from pipenav.evaluation import part_plan
from pipenav.evaluation.audit import Auditor, AuditRows, audited
from pipenav.evaluation.audit_record import AuditRecord
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.parts import PartResult
from pipenav.evaluation.passage import EpisodePlan, Passages
from pipenav.evaluation.results import Evaluation
from pipenav.jobs.processes import ProcessesPlace
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import parse_corners
from pipenav.policies.named import open_controller
from pipenav.robots.robot import load_robot
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import sample

NAMES = ("d=100,angle=90", "d=75,angle=60,turn=right")


def config(**given: Any) -> EvaluationConfig:
    settings: dict[str, Any] = {"policy": "arm", "pipes": NAMES, "episodes": 4, "seed": 3}
    return EvaluationConfig(**settings | given)


@given(st.integers(0, 10**9), st.floats(0.001, 1), st.floats(0.001, 1))
def test_what_is_audited_at_a_share_is_audited_at_every_larger_one(number: int, one: float, other: float) -> None:
    assert audited(number, min(one, other)) <= audited(number, max(one, other))
    assert audited(number, 1.0)


@given(st.integers(0, 10**6), st.sampled_from([0.01, 0.1, 0.5]))
def test_the_share_holds_wherever_one_begins_to_count(first: int, share: float) -> None:
    found = sum(audited(number, share) for number in range(first, first + 1000))
    assert abs(found - 1000 * share) <= 4


def test_an_audit_is_the_same_in_parts_and_processes_and_changes_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    without = CheckedEvaluation(config()).run()
    whole = CheckedEvaluation(config(audit=0.6)).run()
    monkeypatch.setattr(part_plan, "PART_EPISODES", (2, 3))
    cut = CheckedEvaluation(config(audit=0.6)).run(place=ProcessesPlace("2"))
    assert cut.to_json() == whole.to_json()
    assert whole.audit is not None
    assert 0 < whole.audit.episodes == sum(audited(i, 0.6) for i in range(8))
    plain, other = json.loads(without.to_json()), json.loads(whole.to_json())
    assert other.pop("audit")
    assert other["config"].pop("audit") == 0.6
    assert plain == other
    assert "audit" not in plain
    assert "audit" not in plain["config"]
    assert Evaluation.model_validate_json(whole.to_json()) == whole


def test_pybullet_is_audited_too() -> None:
    found = CheckedEvaluation(config(audit=1.0, backend="pybullet", episodes=1)).run().audit
    assert found is not None
    assert (found.episodes, found.broken) == (2, 0)


@pytest.fixture(scope="module")
def recorded() -> tuple[EpisodePlan, Any, np.ndarray]:
    controller = open_controller("arm")
    plan = EpisodePlan(controller.robot, controller.task, parse_corners(["d=80,angle=75"]), 1, 0)
    passages = Passages(plan)
    return plan, passages._given(0), passages.task(controller).motions[0]


def rows(plan: EpisodePlan, episode: Any, motion: np.ndarray) -> AuditRows:
    auditor = Auditor(plan.robot, plan.task, 1.0, 5)
    auditor.audit(2, episode, motion)
    return auditor.rows


def test_a_motion_as_it_was_passes_and_every_fault_is_noticed(recorded: tuple[EpisodePlan, Any, np.ndarray]) -> None:
    plan, episode, motion = recorded

    def broken(changed: np.ndarray) -> tuple[int, int, int]:
        found = AuditRecord.of([rows(plan, episode, changed)], plan.task.max_penetration)
        assert found.episodes == 1
        assert found.broken == max(found.overlapping, found.too_fast, found.not_arrived)
        return found.overlapping, found.too_fast, found.not_arrived

    assert rows(plan, episode, motion).jobs.tolist() == [7]
    assert broken(motion) == (0, 0, 0)
    assert broken(motion[:-4])[2] == 1
    assert broken(motion[::3])[1] == 1
    assert broken(np.where(np.arange(4) == 1, motion + 0.25, motion))[0] == 1


@given(st.floats(0.5, 4.0), st.integers(0, 5))
def test_wheels_may_push_a_joint_past_its_motor_only_as_fast_as_their_power_allows(times: float, joint: int) -> None:
    robot = load_robot("pirate")
    episode = sample(robot, TraverseConfig(kind="traverse"), [PipeCorner.of(90, 90)], np.random.default_rng(0))
    turned = np.zeros(robot.coordinates)
    turned[-6 + joint] = times * robot.speed_limits[joint] * CONTROL_PERIOD
    auditor = Auditor(robot, TraverseConfig(kind="traverse"), 1.0, 0)
    auditor.audit(0, episode, np.stack([episode.q[0], episode.q[0] + turned]))
    (speed,), (power,) = auditor.rows.speed, auditor.rows.power
    assert speed == pytest.approx(times)
    # Six wheels of 0.0373 N m and 5.5 rad/s and five joints of 1 N m and 1 rad/s push one that takes r (r - 1) W.
    at_hand = (6 * 0.0373 * 5.5 + 5 * 1.0 * 1.0) / 4
    assert power == pytest.approx(max(times * (times - 1.0), 0.0) / at_hand)


@given(st.integers(0, 20), st.integers(0, 20), st.integers(0, 20))
def test_audits_of_parts_are_cut_and_read_back(k: int, first: int, end: int) -> None:
    rng = np.random.default_rng(k)
    audits = AuditRows(np.arange(k), *rng.random((4, k)), rng.random(k) < 0.5)
    result = PartResult.from_bytes(PartResult({}, "some cpu", audits).to_bytes())
    cut = result.between(min(first, end), max(first, end)).audits
    assert cut is not None
    assert cut.jobs.tolist() == [i for i in range(k) if min(first, end) <= i < max(first, end)]
    np.testing.assert_array_equal(cut.overlap, audits.overlap[cut.jobs])
    assert cut.arrived.tolist() == audits.arrived[cut.jobs].tolist()


def test_nothing_audited_is_no_fault() -> None:
    found = AuditRecord.of([], 0.002)
    assert (found.episodes, found.broken, found.max_overlap_m) == (0, 0, None)
    assert "no successful episode" in found.words


def test_what_cannot_be_replayed_is_refused() -> None:
    with pytest.raises(PipenavError, match="stage locate has none"):
        CheckedEvaluation(EvaluationConfig(pipes=NAMES, stage="locate", audit=0.5))
    with pytest.raises(PipenavError, match="leave out the pipes that leave it"):
        CheckedEvaluation(EvaluationConfig(policy="pirate", pipes=("runs-rolled",), audit=0.5))


@pytest.mark.parametrize(("text", "share"), [("10%", 0.1), ("0.1", 0.1), ("1", 1.0), ("100%", 1.0)])
def test_a_share_is_typed_as_a_percentage_or_a_share(text: str, share: float) -> None:
    assert audited_share(text) == share


@pytest.mark.parametrize("text", ["0", "0%", "10", "-1", "101%", "some", "nan"])
def test_what_is_no_share_is_refused(text: str) -> None:
    with pytest.raises(PipenavError, match="write it as 10%"):
        audited_share(text)
