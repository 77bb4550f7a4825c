"""The best settings as a file: `train --config` trains with it what the trial trained."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.tuning import space, tiny_plan
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.learning.config import TrainConfig, load_config
from pipenav.tuning.objective import Objective
from pipenav.tuning.recipe import recipe_text
from pipenav.tuning.study import TrialRecord

STAGES = 'stages=[{name="coarse", steps=256, options={timestep=0.002}}, {name="fine", steps=256, learner={clip=0.1}}]'


def without_description(config: TrainConfig) -> TrainConfig:
    return config.model_copy(update={"description": ""})


def require_same(plan: Any, found: dict[str, Any], file: Path) -> None:
    """The file gives the trial's configuration."""
    file.write_text(recipe_text(plan, TrialRecord(7, "done", found, None, "", False), "two\nlines"))
    given_back = load_config(file=file)
    assert without_description(given_back) == without_description(plan.base.config(found))
    assert "trial 7" in given_back.description


@settings(max_examples=20, deadline=None)
@given(
    rate=st.floats(1e-4, 1e-2),
    epochs=st.integers(1, 3),
    policy=st.sampled_from([[16], [16, 16], [64, 64]]),
    staged=st.booleans(),
)
def test_a_recipe_is_the_trial(
    tmp_path_factory: pytest.TempPathFactory, rate: float, epochs: int, policy: list[int], staged: bool
) -> None:
    folder = tmp_path_factory.mktemp("recipe")
    more: dict[str, Any] = {"settings": [STAGES], "steps": None} if staged else {}
    plan = tiny_plan(folder, **more)
    found = {"learner.learning_rate": rate, "learner.epochs": epochs, "network.policy": policy}
    require_same(plan, found, folder / "best.toml")


@pytest.mark.parametrize("steps", [256, 400])
def test_settings_of_a_presets_stages_are_written_by_their_names(tmp_path: Path, steps: int) -> None:
    """The preset `pirate-strong-gravity` has the stages."""
    key = "stages.corners.steps"
    ranges = {key: {"low": 100, "high": 500}, "stages.routes.learner.clip": {"low": 0.1, "high": 0.3}}
    plan = tiny_plan(tmp_path, objective=Objective())
    gravity = space(**ranges).model_copy(update={"preset": "pirate-strong-gravity"})
    staged = plan.base._replace(space=gravity, settings=["stages.routes.steps=1000"], steps=None)
    found = {key: steps, "stages.routes.learner.clip": 0.25}
    require_same(plan._replace(base=staged), found, tmp_path / "best.toml")
    text = (tmp_path / "best.toml").read_text()
    assert f"stages.corners.steps = {steps}\n" in text
    assert "stages.routes.learner.clip = 0.25\n" in text
