"""`pipenav list`: everything that can be named is in it, and only that."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from helpers.command import run

from pipenav.cli.keys import keys_of
from pipenav.cli.names import KINDS
from pipenav.disturbances.disturbance import Disturbance, disturbance_names
from pipenav.experiments.definition import experiment_names
from pipenav.learning.config import TrainConfig, load_config, preset_names
from pipenav.pipes.corner_sets import corner_set_names
from pipenav.pipes.route_sets import route_set_names
from pipenav.policies.named import BASELINES
from pipenav.policies.policy import policy_names
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.robots.variants import robot_names
from pipenav.tuning.space import space_names

NAMES = {
    "policies": [*policy_names(), *(f"baseline:{name}" for name in BASELINES)],
    "pipes": [*corner_set_names(), *route_set_names()],
    "disturbances": disturbance_names(),
    "experiments": [*experiment_names(), "all"],
    "presets": preset_names(),
    "spaces": space_names(),
    "robots": robot_names(),
    "backends": ["hardware", "mujoco", "pybullet"],
    "disturbance-keys": list(Disturbance.model_fields),
}


def first_words(text: str) -> list[str]:
    """The first word of every row of a table, without the heading."""
    return [line.split()[0] for line in text.splitlines()[1:]]


@pytest.mark.parametrize("kind", NAMES)
def test_a_kind_lists_its_names(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("list", kind) == 0
    assert sorted(first_words(capsys.readouterr().out)) == sorted(NAMES[kind])


def test_without_a_kind_there_are_the_kinds(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("list") == 0
    assert first_words(capsys.readouterr().out) == list(KINDS)
    assert run("list", "polices") == 1
    assert "unknown kind 'polices': did you mean 'policies'" in capsys.readouterr().err


def leaves(table: Mapping[str, Any], before: str = "") -> set[str]:
    """Dotted keys of the values in a table, as `pipenav list` names them."""
    found: set[str] = set()
    for key, value in table.items():
        if key == "actuators":
            found |= {leaf for part in value.values() for leaf in leaves(part, f"{before}{key}.NAME.")}
        elif key == "stages":
            found |= {f"{key}[].{inner}" for part in value for inner in part}
        elif isinstance(value, dict) and key != "options":
            found |= leaves(value, f"{before}{key}.")
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            found |= {leaf for part in value for leaf in leaves(part, f"{before}{key}[].")}
        elif value != []:
            found.add(f"{before}{key}")
    return found


@pytest.mark.parametrize("preset", preset_names())
def test_every_key_of_every_preset_is_listed(preset: str) -> None:
    listed = {key.name for key in keys_of(TrainConfig)}
    tables = {name.rpartition(".")[0] for name in listed}  # those that a preset leaves out are no values
    assert leaves(load_config(preset).model_dump(mode="json")) <= listed | tables


@pytest.mark.parametrize("robot", robot_names())
def test_every_key_of_every_robot_is_listed(robot: str) -> None:
    given = load_robot(robot).model_dump(mode="json", exclude_none=True)
    assert leaves(given) <= {key.name for key in keys_of(RobotSpec)}


def test_training_keys_are_as_set_takes_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("list", "training-keys") == 0
    assert "learner.epochs" in capsys.readouterr().out
    for key in keys_of(TrainConfig):
        if key.default not in ("required", "not set") and not key.name.startswith("task."):
            load_config(settings=[f"{key.name}={key.default}"])
