"""Stages of a training: how configurations with stages are put together, and how their schedules run."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import ConfigError, PipenavError
from pipenav.learning.config import TrainConfig, load_config, validate_config
from pipenav.learning.schedule import LearningRate, Schedule, noise_at
from pipenav.learning.stage_tables import laid_over
from pipenav.learning.stages import require_one_interface, stage_at, training_stages, with_steps

COARSE = {"name": "coarse", "steps": 3000, "options": {"timestep": 0.005, "contact_time_constant": 0.01}}
FINE = {"name": "fine", "steps": 1000, "pipes": ["thesis"], "learner": {"epochs": 2}}
counts = st.lists(st.integers(1, 10**6), min_size=1, max_size=6)


def staged(*stages: dict[str, Any], **more: Any) -> TrainConfig:
    return load_config("thesis-position", options={"stages": list(stages or (COARSE, FINE)), **more})


def of_lengths(lengths: list[int], **more: Any) -> TrainConfig:
    return staged(*({"name": f"s{i}", "steps": steps} for i, steps in enumerate(lengths)), **more)


def recipe(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


TWO = """
[[stages]]
name = "coarse"
steps = 3000
[stages.options]
timestep = 0.005
[[stages]]
name = "fine"
steps = 1000
pipes = ["thesis"]
[stages.learner]
epochs = 2
learning_rate = 2e-4
"""


def two(path: Path, before: str = "", settings: tuple[str, ...] = (), **options: Any) -> TrainConfig:
    below = None if "extends" in before else "thesis-position"
    return load_config(below, recipe(path / "two.toml", before + TWO), settings, options)


def test_a_stage_is_the_training_with_what_it_says_laid_over_it(tmp_path: Path) -> None:
    config = two(tmp_path, 'pipes = ["tees"]\n[options]\nthreads = 2\n')
    coarse, fine = (stage.config for stage in training_stages(config))
    assert (coarse.pipes, fine.pipes) == (("tees",), ("thesis",))
    assert (coarse.options, fine.options) == ({"threads": 2, "timestep": 0.005}, {"threads": 2})
    assert (fine.learner.epochs, coarse.learner) == (2, config.learner)
    assert fine.learner.model_copy(update={"epochs": 8, "learning_rate": 1e-3}) == config.learner
    same = {"pipes": config.pipes, "options": config.options, "learner": config.learner}
    assert coarse.model_copy(update=same) == fine.model_copy(update=same) == config.model_copy(update={"stages": ()})


@given(counts)
def test_stages_follow_each_other_and_their_steps_are_those_of_the_training(lengths: list[int]) -> None:
    config = of_lengths(lengths)
    stages = training_stages(config)
    assert config.steps == sum(lengths) == stages[-1].end
    assert [stage.end - stage.begin for stage in stages] == lengths
    assert [stage.begin for stage in stages] == [0, *(stage.end for stage in stages[:-1])]
    assert [stage.last for stage in stages] == [False] * (len(stages) - 1) + [True]
    for stage in stages:
        assert stage_at(stages, stage.begin) is stage
        assert stage_at(stages, stage.end - 1) is stage
    assert stage_at(stages, config.steps) is stages[-1]


@given(counts, st.integers(6, 10**7))
def test_steps_are_shared_by_the_stages_in_their_proportion(lengths: list[int], steps: int) -> None:
    whole = sum(lengths)
    if min(lengths) * steps < 2 * whole:
        return
    below = {"stages": [{"name": f"s{i}", "steps": length} for i, length in enumerate(lengths)], "steps": whole}
    table = laid_over(below, {"steps": steps}, "here")
    shares = [stage["steps"] for stage in table["stages"]]
    assert sum(shares) == steps == table["steps"]
    assert all(abs(share - length * steps / whole) <= 1 for share, length in zip(shares, lengths, strict=True))
    again = laid_over(table, {"steps": steps}, "here")
    assert again == table


@given(counts, st.integers(1, 10**6))
def test_a_training_with_more_steps_has_a_longer_last_stage(lengths: list[int], more: int) -> None:
    config = of_lengths(lengths)
    longer = with_steps(config, config.steps + more)
    assert [stage.steps for stage in longer.stages] == [*lengths[:-1], lengths[-1] + more]
    assert with_steps(longer, config.steps) == config
    if len(lengths) > 1:
        with pytest.raises(PipenavError, match=f"stage s{len(lengths) - 1} begins after"):
            with_steps(config, sum(lengths[:-1]))


def test_a_layer_above_holds_in_every_stage(tmp_path: Path) -> None:
    def parts(*settings: str, **options: Any) -> list[TrainConfig]:
        return [stage.config for stage in training_stages(two(tmp_path, "", settings, **options))]

    assert [part.pipes for part in parts(pipes=["tees"])] == [("tees",)] * 2
    assert [part.learner.epochs for part in parts("learner.epochs=5")] == [5] * 2
    assert [part.learner.learning_rate for part in parts("learner.epochs=5")] == [1e-3, 2e-4]
    assert [part.options for part in parts("options.timestep=0.001")] == [{"timestep": 0.001}] * 2
    assert [part.options for part in parts("options.threads=1")] == [{"timestep": 0.005, "threads": 1}, {"threads": 1}]
    assert [part.options for part in parts("options={}")] == [{}] * 2
    assert [part.options for part in parts(backend="pybullet")] == [{}] * 2
    both = parts("options.threads=1", backend="mujoco")
    assert [part.options.get("timestep") for part in both] == [0.005, None]


def test_one_stage_is_changed_by_its_name(tmp_path: Path) -> None:
    changed = two(tmp_path, "", ("stages.fine.steps=500", "stages.coarse.learner.clip=0.3", "learner.epochs=5"))
    assert [stage.steps for stage in changed.stages] == [3000, 500]
    assert changed.steps == 3500
    assert [part.config.learner.clip for part in training_stages(changed)] == [0.3, 0.2]
    assert [part.config.learner.epochs for part in training_stages(changed)] == [5, 5]
    cleared = two(tmp_path, "", ("stages.coarse.options={}",))
    assert [part.config.options for part in training_stages(cleared)] == [{}, {}]


def test_stages_of_a_layer_replace_those_below_and_bring_their_steps(tmp_path: Path) -> None:
    config = two(tmp_path, 'extends = "pirate"\n')
    assert (config.steps, len(config.stages)) == (4000, 2)
    assert two(tmp_path, "", ("stages=[]",)).steps == 4000
    assert two(tmp_path, "", ("stages=[]",), steps=7).steps == 7
    assert [stage.steps for stage in two(tmp_path, "", (), steps=40).stages] == [30, 10]
    assert [stage.steps for stage in two(tmp_path, "", ("steps=40",)).stages] == [30, 10]
    assert two(tmp_path, "steps = 4000\n").steps == 4000


@pytest.mark.parametrize(
    ("before", "settings", "message"),
    [
        ("steps = 4001\n", (), "steps are 4001 and those of the stages 4000 together: say either of them."),
        ("", ("stages.fine.steps=2", "steps=7"), "steps are 7 and those of the stages 3002 together"),
        ("", ("stages.fin.steps=2",), "stages: unknown stage 'fin': did you mean 'fine'?"),
        ("", ("steps=1",), "steps: 1 are too few for 2 stages: give more."),
        ("", ("stages.fine.name=coarse",), "stages: two stages have one name"),
        (
            "",
            ("stages.fine.learner.epoch=2",),
            "stage fine: unknown key 'learner.epoch': did you mean 'learner.epochs'",
        ),
        ("", ("stages.fine.learner.batch_size=7",), "stage fine: learner: batch_size 7 must divide"),
        ("", ("stages.fine.seed=2",), "unknown key 'stages.1.seed'"),
        ("", ("stages=5",), "stages: input should be a list"),
        ("", ("stages=[5]",), "stages.0: input should be a"),
        ("", ("stages.fine.steps=many",), "stages.1.steps: input should be a valid integer, given 'many'."),
        ("", ("steps=many",), "steps: input should be a valid integer, given 'many'."),
    ],
)
def test_what_does_not_fit_is_one_sentence(
    before: str, settings: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError) as caught:
        two(tmp_path, before, settings)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_stage_that_is_named_where_there_are_none_is_refused() -> None:
    with pytest.raises(ConfigError, match="there are no stages, given stage 'fine'"):
        load_config("thesis-torque", settings=["stages.fine.steps=2"])


def test_a_configuration_with_stages_survives_json(tmp_path: Path) -> None:
    config = two(tmp_path)
    assert validate_config(json.loads(json.dumps(config.model_dump(mode="json"))), "config.json") == config
    without = config.model_copy(update={"stages": ()}).model_dump(mode="json")
    del without["stages"]  # as older versions wrote it
    assert validate_config(without, "config.json").stages == ()


@given(counts, st.floats(0, 1))
def test_stages_of_one_schedule_learn_at_the_rate_of_a_training_without_stages(
    lengths: list[int], share: float
) -> None:
    steps = int(share * sum(lengths))
    (whole,) = training_stages(load_config("thesis-torque", options={"steps": sum(lengths)}))
    stage = stage_at(training_stages(load_config("thesis-torque", options={"stages": named(lengths)})), steps)
    rate = stage.learning_rate(1 - steps / stage.end)
    assert rate == pytest.approx(whole.learning_rate(1 - steps / whole.end), rel=1e-6)
    noise = noise_at(stage.config.learner, stage.schedule, steps)
    assert noise == noise_at(whole.config.learner, whole.schedule, steps)


def named(lengths: list[int]) -> list[dict[str, Any]]:
    return [{"name": f"s{i}", "steps": steps} for i, steps in enumerate(lengths)]


@given(counts, st.data())
def test_a_stage_that_says_a_rate_or_a_noise_begins_a_schedule(lengths: list[int], data: st.DataObject) -> None:
    stages = named(lengths)
    own = data.draw(st.sets(st.sampled_from(range(len(lengths)))))
    for i in own:
        key = data.draw(st.sampled_from(["learning_rate", "noise_start", "noise_stop"]))
        stages[i]["learner"] = {key: 0.05}
    made = training_stages(load_config("thesis-torque", options={"stages": stages}))
    begins = {stage.begin for i, stage in enumerate(made) if i in own or i == 0}
    assert {stage.schedule.begin for stage in made} == begins
    for before, after in pairwise(made):
        assert after.schedule == before.schedule or before.schedule.end == after.schedule.begin == after.begin
    assert made[-1].schedule.end == made[-1].end


@given(st.floats(0, 1))
def test_a_schedule_over_the_whole_training_changes_no_bit(remaining: float) -> None:
    assert LearningRate(1e-3, Schedule(0, 5000), 5000)(remaining) == 1e-3 * max(remaining, 0.05)


def test_checks_are_made_with_the_physics_of_the_last_stage_and_compared_where_they_measure_the_same() -> None:
    coarse, fine = training_stages(staged(COARSE, FINE | {"pipes": None}))
    assert coarse.checked.options == fine.config.options == {}
    assert coarse.config.options == COARSE["options"]
    assert (coarse.checked_since, fine.checked_since) == (1, 1)
    assert [stage.checked_since for stage in training_stages(staged(COARSE, FINE))] == [1, 2]
    third = {"name": "third", "steps": 1, "pipes": ["thesis"]}
    assert [stage.checked_since for stage in training_stages(staged(COARSE, FINE, third))] == [1, 2, 2]


def test_stages_of_two_policies_are_refused() -> None:
    with pytest.raises(PipenavError, match=r"stage fine \(2 of 2\) has another task, observation or control"):
        require_one_interface(staged(COARSE, FINE | {"task": {"control": "torque"}}))
    require_one_interface(staged())
