"""The numbers of an evaluation, their format, and the thesis's figures."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from pipenav.errors import ConfigError, FileProblem
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.pipe_results import DiameterRecord, PipeRecord
from pipenav.evaluation.results import Evaluation, Extremes, read_evaluation
from pipenav.evaluation.thesis import ANGLES_DEG, thesis_best

PIPE_KEYS = {
    "diameter_mm",
    "angle_deg",
    "turn",
    "bend_radius_mm",
    "fitting",
    "route",
    "episodes",
    "located",
    "reach_attempts",
    "reach_successes",
    "rear_attempts",
    "rear_successes",
    "traverse_attempts",
    "traverse_successes",
    "failures",
    "mean_steps",
    "min_range_m",
    "max_penetration_m",
    "peak_force_n",
    "contact_time_share",
}
"""Keys of a pipe in eval.json that other programs rely on."""


def pipe(diameter: float = 90, angle: float | None = 60, successes: int = 9, **facts: Any) -> PipeRecord:
    defaults = {"turn": "left", "episodes": 10, "reach_attempts": 10, "reach_successes": successes}
    return PipeRecord(diameter_mm=diameter, angle_deg=angle, **{**defaults, **facts})


def evaluation(pipes: list[PipeRecord], **facts: Any) -> Evaluation:
    config = EvaluationConfig(policy="p", pipes=("d=90,angle=60",), episodes=10, seed=1, stage="reach")
    return Evaluation.of(pipes, **{"config": config, "robot": "basic", **facts})


@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [
        # Newcombe (1998), table I, method 3
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
        # common textbook values
        (10, 10, 0.7225, 1.0),
        (0, 10, 0.0, 0.2775),
        (5, 10, 0.2366, 0.7634),
        (0, 0, 0.0, 1.0),
    ],
)
def test_wilson_agrees_with_published_values(successes: int, n: int, low: float, high: float) -> None:
    assert wilson(successes, n) == pytest.approx((low, high), abs=5e-5)


@given(st.integers(1, 10**6).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilson_holds_the_share_inside_the_unit_interval(counts: tuple[int, int]) -> None:
    successes, n = counts
    low, high = wilson(successes, n)
    assert 0 <= low <= successes / n <= high <= 1
    assert low < high
    mirrored = wilson(n - successes, n)
    assert (low, high) == pytest.approx((1 - mirrored.high, 1 - mirrored.low), abs=1e-12)


@pytest.mark.parametrize("counts", [(-1, 5), (6, 5)])
def test_wilson_refuses_impossible_counts(counts: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="trials"):
        wilson(*counts)


def test_json_has_exactly_the_documented_keys() -> None:
    table = json.loads(evaluation([pipe()]).to_json())
    assert set(table) == {
        *("schema", "policy", "backend", "robot", "stage", "seed", "pipes", "diameters", "episodes_per_pipe"),
        *("success", "success_low", "success_high", "penetration_p99_m", "force_p99_n", "options", "disturb", "config"),
    }
    assert table["schema"] == 2
    assert EvaluationConfig.model_validate(table["config"]) == evaluation([pipe()]).config
    assert set(table["pipes"][0]) == PIPE_KEYS | {"reach_success_low", "reach_success_high"}
    assert table["pipes"][0]["rear_attempts"] is None


def test_evaluations_survive_the_file(tmp_path: Path) -> None:
    full = pipe(located=10, rear_attempts=9, rear_successes=8, failures={"limit": 1}, min_range_m=0.01)
    options = EvaluationConfig(stage="locate", options={"timestep_s": 0.002, "list": [1, None]})
    given_one = evaluation([full, pipe(100)], config=options, extremes=Extremes(1e-3, 50.0))
    (tmp_path / "eval.json").write_text(given_one.to_json(), encoding="utf-8")
    assert read_evaluation(tmp_path) == read_evaluation(tmp_path / "eval.json") == given_one


def test_unreadable_evaluations_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"eval.json: No such file"):
        read_evaluation(tmp_path)
    file = tmp_path / "eval.json"
    file.write_text("{", encoding="utf-8")
    with pytest.raises(ConfigError, match="not valid JSON"):
        read_evaluation(file)
    file.write_text(evaluation([pipe()]).to_json().replace('"schema": 2', '"schema": 3'), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"schema: input should be 1 or 2, given 3"):
        read_evaluation(file)


def test_a_file_of_schema_1_is_read_as_one_of_today(tmp_path: Path) -> None:
    """Keys were `run`, `front_...` and `min_clearance_m`, the stage `front`, and there was no `config`."""
    table = json.loads(evaluation([pipe(min_range_m=0.01)]).to_json()) | {"schema": 1, "stage": "front"}
    config = table.pop("config")
    text = json.dumps(table).replace("reach_", "front_").replace('"route"', '"run"')
    (tmp_path / "eval.json").write_text(text.replace("min_range_m", "min_clearance_m"), encoding="utf-8")
    found = read_evaluation(tmp_path)
    assert (found.pipes, found.diameters) == ((pipe(min_range_m=0.01),), evaluation([pipe()]).diameters)
    names = ["d=90.0,angle=60.0,turn=left"]
    assert found.config.model_dump(mode="json") == {**config, "pipes": names}


def test_added_keys_do_not_stop_a_reader(tmp_path: Path) -> None:
    table = json.loads(evaluation([pipe()]).to_json()) | {"added_later": 1}
    (tmp_path / "eval.json").write_text(json.dumps(table), encoding="utf-8")
    assert read_evaluation(tmp_path) == evaluation([pipe()])


@pytest.mark.parametrize(
    "facts",
    [
        {"angle": None},
        {"turn": None},
        {"route": "run-d90-L60"},
        {"reach_attempts": 11},
        {"reach_successes": 11},
        {"located": 9},
        {"rear_attempts": 10, "rear_successes": 1},
        {"reach_attempts": None},
        {"min_range_m": float("nan")},
        {"contact_time_share": 1.5},
    ],
)
def test_records_refuse_what_cannot_be(facts: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        pipe(**facts)


def test_success_counts_every_stage_that_was_run() -> None:
    assert pipe().success == 0.9
    assert pipe(located=10, rear_attempts=9, rear_successes=6).success == 0.6
    located = pipe(located=7, reach_attempts=None, reach_successes=None)
    assert located.success == 0.7
    assert located.reach_success_low is None
    nothing_found = pipe(located=0, reach_attempts=0, reach_successes=0)
    assert (nothing_found.reach_success_low, nothing_found.reach_success_high) == (0.0, 1.0)


def test_typed_numbers_lose_rounding_errors() -> None:
    assert pipe(diameter=110.00000000000001, angle=55.00000000000001).angle_deg == 55


def test_diameters_take_the_mean_over_pipes() -> None:
    pipes = [pipe(90, 60, 5), pipe(90, 70, 2, episodes=4, reach_attempts=2), pipe(120, 60, 10)]
    result = evaluation(pipes)
    assert [row.diameter_mm for row in result.diameters] == [120, 90]
    narrow = result.diameters[1]
    assert (narrow.pipes, narrow.episodes) == (2, 14)
    assert narrow.reach_success == pytest.approx((0.5 + 1.0) / 2)
    assert (narrow.reach_success_low, narrow.reach_success_high) == wilson(7, 12)
    assert (result.success, result.success_low) == (17 / 24, wilson(17, 24).low)


def test_the_thesis_is_quoted_for_its_own_angles_only() -> None:
    best = thesis_best("torque")
    whole = evaluation([pipe(90, angle) for angle in ANGLES_DEG], thesis=best)
    assert whole.diameters[0].thesis_percent == best[90]
    assert evaluation([pipe(90, 60)], thesis=best).diameters[0].thesis_percent is None
    assert evaluation([pipe(70, angle) for angle in ANGLES_DEG], thesis=best).diameters[0].thesis_percent is None


def test_a_diameter_without_attempts_has_no_rate() -> None:
    row = DiameterRecord.of([pipe(located=0, reach_attempts=0, reach_successes=0)])
    assert (row.reach_success, row.located_share) == (None, 0.0)


@pytest.mark.parametrize("text", ["tee 90", "tee ninety into", "elbow 90 into", "tee 90 sideways"])
def test_a_fitting_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ValidationError):
        pipe(fitting=text)


def test_tees_are_not_compared_with_the_thesis() -> None:
    tees = [pipe(90, angle, fitting=f"tee {angle} into") for angle in ANGLES_DEG]
    plain = [pipe(90, angle) for angle in ANGLES_DEG]
    assert DiameterRecord.of(plain, 80.0).thesis_percent == 80.0
    assert DiameterRecord.of(tees, 80.0).thesis_percent is None
