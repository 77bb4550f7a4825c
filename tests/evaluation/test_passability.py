"""Passability in evaluations: what was possible is counted apart, and no success stands against a proof."""

from __future__ import annotations

import json
from typing import Any

import pytest
from helpers.evaluations import evaluation, record, shown
from hypothesis import given
from hypothesis import strategies as st

from pipenav.certify.arm import Ends
from pipenav.certify.model import Model
from pipenav.certify.verdict import Verdict, certify
from pipenav.errors import PipenavError
from pipenav.evaluation import passability
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.passability import Answer, Chance, Question, answer
from pipenav.evaluation.passability_record import Passability, PipePassability
from pipenav.evaluation.report import pipes_csv
from pipenav.evaluation.results import Evaluation
from pipenav.jobs import MemoryStore
from pipenav.jobs.here import HerePlace
from pipenav.jobs.processes import ProcessesPlace
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route_sets import parse_pipes
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import default_config

KINDS = ("passable", "undecided", "impossible")
counts = st.fixed_dictionaries(
    {kind: st.integers(0, 9) for kind in ("possible", "with_overlap", "undecided", "impossible")}
)


def asked(robot: str, pipe: Pipe, failed: tuple[int, ...]) -> Answer:
    spec = load_robot(robot)
    question = Question(spec, default_config(spec), pipe, 20, 0, failed)
    return Answer.from_bytes(answer(question, None))  # type: ignore[arg-type]  # it asks nothing of the place


def corner(text: str) -> Pipe:
    return parse_corners([text])[0]


def on(successes: int, failed: dict[Chance, int], rigid: str = "passable", soft: str = "passable") -> PipePassability:
    return PipePassability.on(Answer(rigid, soft, "width: of a test", failed), successes)  # type: ignore[arg-type]


@given(st.integers(0, 9), counts)
def test_every_episode_has_one_chance(successes: int, failed: dict[Chance, int]) -> None:
    found = on(successes, failed)
    assert found.episodes == successes + sum(failed.values())
    assert found.successes == successes
    assert found.gaps == failed["possible"]
    assert found.of_possible == wilson(successes, successes + failed["possible"])


@given(st.lists(st.tuples(st.integers(0, 9), counts), min_size=1, max_size=4))
def test_an_evaluation_has_the_episodes_of_its_pipes(pipes: list[tuple[int, dict[Chance, int]]]) -> None:
    parts = [on(*pipe) for pipe in pipes]
    whole = Passability.of(parts)
    assert whole.episodes == sum(part.episodes for part in parts)
    assert whole.success_of_possible == (whole.successes / whole.possible if whole.possible else None)
    left = whole.episodes - whole.impossible
    assert whole.success_of_not_impossible == (whole.successes / left if left else None)
    if whole.success_of_possible is not None:
        assert whole.success_of_possible >= (whole.success_of_not_impossible or 0)


@given(st.integers(0, 9), st.sampled_from(KINDS))
def test_only_a_success_against_a_proof_with_overlap_is_a_contradiction(successes: int, soft: str) -> None:
    assert on(successes, {}, "impossible", soft).contradictions == (successes if soft == "impossible" else 0)


def test_a_pipe_decides_about_whole_robots() -> None:
    assert asked("pirate", corner("d=58,angle=60"), (3, 7)).failed == {"impossible": 2}
    assert asked("pirate", corner("d=90,angle=90"), (3,)).failed == {"possible": 1}
    between = asked("pirate", corner("d=62,angle=60"), (3,))
    assert between.verdict == "impossible"
    assert between.failed == {"with_overlap" if between.verdict_with_overlap == "passable" else "undecided": 1}


def test_an_arms_failed_episodes_are_certified_by_themselves(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Ends] = []

    def seeing(model: Model, ends: Ends, resolution: float) -> Verdict:
        seen.append(ends)
        return certify(model, ends, resolution)

    monkeypatch.setattr(passability, "certify", seeing)
    found = asked("basic", corner("d=90,angle=90"), (3, 5))
    assert found.failed == {"possible": 2}
    assert len(seen) == 3
    assert seen[1].start_slide != seen[2].start_slide


def test_what_the_method_does_not_know_is_undecided() -> None:
    tee = asked("basic", corner("d=100,tee=90,way=into"), (1,))
    assert (tee.verdict, tee.failed) == ("undecided", {"undecided": 1})
    assert "branches" in tee.reason
    route = asked("pirate", parse_pipes(["runs-level"])[0], (1, 2))
    assert (route.verdict, route.failed) == ("undecided", {"undecided": 2})
    assert "single corners" in route.reason


def certified(**given: Any) -> CheckedEvaluation:
    pipes = ("d=100,angle=90", "d=44,angle=60,turn=right")
    return CheckedEvaluation(EvaluationConfig(policy="arm", pipes=pipes, episodes=2, certify=True, **given))


@pytest.mark.slow
def test_verdicts_are_the_same_wherever_they_are_found_and_change_nothing_else() -> None:
    here, there = certified(), certified()
    store = MemoryStore()
    here.run_parts(store)
    whole = here.merged(store)
    assert there.run(place=ProcessesPlace("2")).to_json() == whole.to_json()
    assert Evaluation.model_validate_json(whole.to_json()) == whole
    first, second = whole.pipes
    assert first.passability is not None and second.passability is not None
    assert (first.passability.verdict, first.trained) == ("passable", True)
    assert (second.passability.impossible, second.trained) == (2, False)
    assert whole.passability is not None
    assert (whole.passability.possible, whole.passability.success_of_possible) == (2, 1.0)
    plain = CheckedEvaluation(whole.config.model_copy(update={"certify": False})).run()
    keys, more = json.loads(plain.to_json()), json.loads(whole.to_json())
    assert more.pop("passability") and more["config"].pop("certify")
    for pipe in more["pipes"]:
        assert pipe.pop("passability") and pipe.pop("trained") is not None
    assert keys == more
    assert pipes_csv(whole.pipes).splitlines()[0].startswith(pipes_csv(plain.pipes).splitlines()[0] + ",possible,")


@pytest.mark.slow
def test_verdicts_that_are_kept_are_not_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    store, checked = MemoryStore(), certified()
    checked.run_parts(store)
    first = checked.merged(store)
    monkeypatch.setattr(passability, "certify", None)
    assert checked.merged(store, HerePlace()) == first


def test_what_goes_on_from_something_found_is_refused() -> None:
    with pytest.raises(PipenavError, match="choose stage reach"):
        CheckedEvaluation(EvaluationConfig(policy="arm", stage="passage", certify=True))


def test_gaps_are_listed_apart_from_impossible_episodes() -> None:
    pipes = [
        record(90, 60, successes=7, passability=on(7, {"possible": 3}), trained=True),
        record(60, 60, successes=0, passability=on(0, {"impossible": 10}, "impossible", "impossible"), trained=False),
        record(62, 60, successes=0, passability=on(0, {"with_overlap": 10}, "impossible"), trained=None),
    ]
    text = shown(evaluation(pipes))
    assert "70.0 % of the 10 possible episodes" in text
    assert "impossible 10, possible only with overlap 10, undecided 0" in text
    gaps, impossible, open_ = (text.index(title) for title in ("Gaps of the policy", "Not gaps", "Not decided"))
    assert "3 of 10" in text[gaps:impossible] and "60°" not in text[gaps:impossible]
    assert "10 of 10" in text[impossible:open_] and "outside" in text[impossible:open_]
    assert "contradict" not in text
    wrong = evaluation([record(60, 60, successes=1, passability=on(1, {"impossible": 9}, "impossible", "impossible"))])
    assert "1 successes contradict a proof" in shown(wrong)
