"""Search spaces: ranges as their files say them, and what is refused in one sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.tuning import RANGES, SPACE_TOML, space, tiny_plan
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.learning.stages import training_stages
from pipenav.tuning.objective import Objective
from pipenav.tuning.plan import BaseTraining, checked_plan
from pipenav.tuning.space import SearchSpace, ValueRange, load_space, space_names

numbers = st.floats(-1e6, 1e6) | st.integers(-1000, 1000)


@given(st.lists(numbers, min_size=3, max_size=3, unique=True).map(sorted))
def test_a_range_has_what_lies_in_it(ends: list[float]) -> None:
    low, between, high = ends
    values = ValueRange(low=low, high=high)
    whole = isinstance(low, int) and isinstance(high, int)
    assert all(values.has(end) for end in values.ends)
    assert values.has(between) == (isinstance(between, int) or not whole)
    assert not ValueRange(low=low, high=between).has(high)
    assert values.whole == whole


@given(st.lists(st.integers() | st.text() | st.booleans() | st.lists(st.integers()), min_size=2, max_size=5))
def test_choices_are_what_they_are(choices: list[Any]) -> None:
    unlike = [one for i, one in enumerate(choices) if repr(one) not in map(repr, choices[:i])]
    if len(unlike) == len(choices):
        values = ValueRange(choices=choices)
        assert all(values.has(choice) for choice in choices)
        assert not values.has("none of them, surely")


def test_keys_may_be_dotted_or_in_tables(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(SPACE_TOML)
    dotted = load_space(str(tmp_path / "mine.toml"))
    assert list(dotted.space) == ["learner.learning_rate", "learner.epochs"]
    nested = SearchSpace.model_validate({"description": "x", "space": {"learner": {"epochs": {"low": 1, "high": 3}}}})
    assert nested.space["learner.epochs"] == dotted.space["learner.epochs"]


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"low": 1}, "give low and high, or choices"),
        ({"low": 2, "high": 1}, "low 2 must be below high 1"),
        ({"low": 0, "high": 1, "log": True}, "log = true needs a low above 0, given 0"),
        ({"low": 0, "high": 1, "choices": [1, 2]}, "give either choices, or low and high"),
        ({"choices": [1]}, "at least 2 items"),
        ({"choices": [1, 1]}, "choices: two of them are equal"),
        ({"low": 1, "high": 2, "step": 1}, "unknown key"),
    ],
)
def test_a_range_that_is_none_is_refused(values: dict[str, Any], says: str, tmp_path: Path) -> None:
    lines = "\n".join(f"{key} = {str(value).lower()}" for key, value in values.items())
    (tmp_path / "odd.toml").write_text(f'description = "odd"\n[space."learner.epochs"]\n{lines}\n')
    with pytest.raises(PipenavError, match=says) as refused:
        load_space(str(tmp_path / "odd.toml"))
    assert "odd.toml" in str(refused.value)


def test_an_unknown_space_is_answered_with_the_known() -> None:
    with pytest.raises(PipenavError, match="unknown space 'arms': did you mean 'arm'"):
        load_space("arms")


@pytest.mark.parametrize("name", space_names())
def test_shipped_spaces_fit_their_presets(name: str, tmp_path: Path) -> None:
    shipped = load_space(name)
    plan = checked_plan(BaseTraining(shipped, None, [], None, 0), Objective(), 1, 0, tmp_path)
    assert plan.preset_settings() is not None  # so that the search begins with something that is known to work
    assert plan.config.check.every < plan.config.steps


@pytest.mark.parametrize(
    ("key", "values", "says"),
    [
        ("learner.epoch", {"low": 1, "high": 2}, "no value of learner.epoch fits the training"),
        (
            "learner.gamma",
            {"low": 2.0, "high": 3.0},
            "no value of learner.gamma fits the training: .* less than or equal",
        ),
        ("stages.coarse.learner.epochs", {"low": 1, "high": 2}, "there are no stages, given stage 'coarse'"),
        ("seed", {"low": 1, "high": 2}, "space: seed would change seed, and with it what the checks"),
        ("check.episodes", {"low": 1, "high": 9}, "space: check.episodes would change check"),
        ("options.timestep", {"low": 0.001, "high": 0.002}, "space: options.timestep would change options"),
        ("pipes", {"choices": [["d=90,angle=90"], ["d=80,angle=90"]]}, "space: pipes would change pipes"),
        ("task.max_steps", {"low": 10, "high": 19}, "space: task.max_steps would change task"),
        ("steps", {"low": 100, "high": 512}, "--objective success compares trials of one length"),
    ],
)
def test_settings_that_cannot_be_searched_are_refused(key: str, values: Any, says: str, tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match=says):
        tiny_plan(tmp_path, space=space(**{key: values}))


def test_a_key_of_a_file_must_be_one() -> None:
    with pytest.raises(ValueError, match="is no key of a training"):
        space(**{"learner epochs": {"low": 1, "high": 2}})


STAGES = 'stages=[{name="coarse", steps=256}, {name="fine", steps=256, learner={epochs=1}}]'


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("stages.coarse.learner.epochs", {"low": 1, "high": 3}),
        ("stages.coarse.options.timestep", {"low": 0.002, "high": 0.0025}),
        ("stages.coarse.pipes", {"choices": [["d=90,angle=90"], ["d=80,angle=90"]]}),
        ("stages.fine.steps", {"low": 256, "high": 512}),
    ],
)
def test_settings_of_stages_can_be_searched(key: str, values: Any, tmp_path: Path) -> None:
    plan = tiny_plan(
        tmp_path, space=space(**{key: values}), settings=[STAGES], steps=None, objective=Objective(name="steps")
    )
    for value in plan.space.space[key].ends:
        config = plan.base.config({key: value})
        stage = next(stage for stage in config.stages if stage.name == key.split(".")[1])
        found: Any = stage.model_dump(mode="json")
        for part in key.split(".")[2:]:
            found = found[part]
        assert found == value


@pytest.mark.parametrize("key", ["stages.fine.options.timestep", "stages.fine.check.episodes"])
def test_what_the_last_stage_measures_is_not_searched(key: str, tmp_path: Path) -> None:
    ends = {"low": 0.002, "high": 0.0024} if "timestep" in key else {"low": 5, "high": 6}
    with pytest.raises(PipenavError, match=f"space: {key} would change"):
        tiny_plan(tmp_path, space=space(**{key: ends}), settings=[STAGES], steps=None, objective=Objective())


def test_steps_of_a_stage_and_of_all_are_not_searched_together() -> None:
    steps = {"low": 100, "high": 200}
    with pytest.raises(ValueError, match=r"steps has stages\.coarse\.steps in it: search one of them"):
        space(**{"stages.coarse.steps": steps, "steps": steps})


def test_a_setting_of_the_training_holds_in_all_its_stages(tmp_path: Path) -> None:
    plan = tiny_plan(tmp_path, space=space(**{"learner.epochs": {"low": 2, "high": 3}}), settings=[STAGES], steps=None)
    stages = training_stages(plan.base.config({"learner.epochs": 3}))
    assert [stage.config.learner.epochs for stage in stages] == [3, 3]


def test_the_presets_settings_are_known_where_they_lie_in_the_space(tmp_path: Path) -> None:
    known = tiny_plan(tmp_path, space=space(**{"learner.epochs": {"low": 1, "high": 3}}))
    assert known.preset_settings() == {"learner.epochs": 2}
    outside = tiny_plan(tmp_path, space=space(**{"learner.epochs": {"low": 3, "high": 4}}))
    assert outside.preset_settings() is None
    assert list(RANGES) == list(tiny_plan(tmp_path).preset_settings() or {})
