"""Evaluations with a cable behind the robot and a limit on the contact force."""

from __future__ import annotations

import pytest

from pipenav.errors import PipenavError
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.results import Evaluation

PIPE = "d=100,angle=120"


def evaluated(**given: object) -> Evaluation:
    config = {"policy": "arm", "pipes": (PIPE,), "episodes": 8, "seed": 1, **given}
    return CheckedEvaluation(EvaluationConfig.model_validate(config)).run()


def test_episodes_with_more_than_the_largest_force_have_failed() -> None:
    free = evaluated()
    (record,) = free.pipes
    assert free.success == 1.0 and free.force_p99_n is not None
    peak = record.peak_force_n
    assert evaluated(max_force=1.01 * peak).success == 1.0
    limited = evaluated(max_force=0.99 * peak)
    assert limited.success < 1.0
    assert limited.pipes[0].failures == {"force": round(8 * (1 - limited.success))}


def test_a_limit_holds_in_every_stage_of_a_passage() -> None:
    strict = evaluated(stage="passage", max_force=0.01)
    assert strict.success == 0.0
    assert set(strict.pipes[0].failures) <= {"force", "not_tried"} or "force" in strict.pipes[0].failures


@pytest.mark.slow
def test_a_robot_passes_with_a_cable_that_it_can_pull_and_stands_with_a_longer_one() -> None:
    easy = evaluated(policy="pirate-strong", episodes=4, tether=100.0)
    assert easy.success == 1.0
    hopeless = evaluated(policy="pirate-strong", episodes=4, tether=2000.0)
    assert hopeless.success == 0.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"tether": 100.0}, "a cable is pulled by a whole robot"),
        ({"recover": True}, "a whole robot recovers by itself: give a policy such as pirate, or leave out --recover"),
        ({"sensors": "mems"}, "are a whole robot's: give a policy such as pirate, or leave out --sensors"),
        ({"starts": "stuck-starts"}, "--starts are poses of a whole robot"),
        ({"starts": "stuck"}, "unknown set of starts"),
        ({"cable_friction": 0.5}, "--cable-friction is of the cable of --tether"),
    ],
)
def test_what_makes_no_sense_is_refused(given: dict[str, float], message: str) -> None:
    with pytest.raises(PipenavError, match=message):
        evaluated(**given)
