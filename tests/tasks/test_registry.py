"""Tasks are found by their settings, and settings by the key `kind`."""

from __future__ import annotations

import pytest
from pydantic import TypeAdapter, ValidationError

from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot
from pipenav.robots.variants import robot_names
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.task import ReachTask
from pipenav.tasks.registry import TaskConfig, default_config, require_reach, task_of
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.task import TraverseTask

SETTINGS = TypeAdapter[ReachConfig | TraverseConfig](TaskConfig)


@pytest.mark.parametrize(("given", "kind"), [({}, ReachConfig), ({"kind": "traverse"}, TraverseConfig)])
def test_settings_without_a_kind_are_the_reach_tasks(given: dict[str, str], kind: type) -> None:
    assert type(SETTINGS.validate_python(given)) is kind


def test_settings_read_back_are_those_that_were_written() -> None:
    for config in (ReachConfig(max_steps=7), TraverseConfig(kind="traverse", max_steps=7)):
        assert SETTINGS.validate_json(config.model_dump_json()) == config


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ValidationError, match="'<reach>', '<traverse>'"):
        SETTINGS.validate_python({"kind": "fly"})


@pytest.mark.parametrize("name", robot_names())
def test_a_robots_own_task_is_one_that_it_can_do(name: str) -> None:
    robot = load_robot(name)
    task = task_of(default_config(robot))
    assert isinstance(task, TraverseTask if robot.free else ReachTask)


def test_another_task_than_reach_is_refused_by_who_needs_it() -> None:
    config = ReachConfig()
    assert require_reach(config, "this arm") is config
    with pytest.raises(PipenavError, match=r"this arm is for a policy that reaches .*, not for the task 'traverse'"):
        require_reach(TraverseConfig(kind="traverse"), "this arm")
