"""Robot descriptions: what the shipped ones say, and how wrong ones are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from pipenav.errors import ConfigError, FileProblem, UnknownName
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.robots.variants import robot_names
from pipenav.storage.shipped import robots_dir

TEXT = (robots_dir() / "basic" / "robot.toml").read_text(encoding="utf-8")


def message(tmp_path: Path, text: str) -> str:
    """The message about a robot.toml of this text."""
    path = tmp_path / "robot.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_robot(str(path))
    said = str(caught.value)
    assert said.startswith(str(path))
    assert "\n" not in said
    assert said.endswith((".", "?"))
    return said


@pytest.mark.parametrize("name", robot_names())
def test_every_shipped_robot_loads_under_its_folders_name(name: str) -> None:
    robot = load_robot(name)
    assert robot.name == name
    assert np.all(robot.lower < 0)
    assert np.all(robot.upper > 0)
    assert robot.mirror_signs.tolist() == [1.0 if joint.type == "slide" else -1.0 for joint in robot.joints]


def test_the_basic_robot_is_the_thesiss() -> None:
    robot = load_robot("basic")
    assert [link.length for link in robot.links] == [0.04, 0.12, 0.12, 0.11]
    assert robot.length == pytest.approx(0.39)
    assert (robot.laser.beams, robot.laser.range_min, robot.laser.range_max) == (10, 0.005, 0.5)
    assert [joint.name for joint in robot.joints] == ["l", "theta1", "theta2", "theta3"]


def test_an_actuator_is_a_torque_speed_line() -> None:
    # effort = limit * duty - damping * speed: nothing is left at full duty and the no-load speed.
    for actuator in load_robot("basic").joint_actuators:
        assert actuator.effort_limit - actuator.damping * actuator.speed_limit == pytest.approx(0.0)
        assert actuator.controller_gain * actuator.full_drive_error == pytest.approx(actuator.stall_effort)


def test_an_unknown_robot_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"unknown robot 'basci': did you mean 'basic'\?"):
        load_robot("basci")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"cannot read .*none\.toml"):
        load_robot(str(tmp_path / "none.toml"))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("friction = 0.3", "fricton = 0.3", r"friction"),
        ("friction = 0.3", "friction = 0.3\ncolour = 1", r"unknown key 'colour'"),
        ("length = 0.040", "lenght = 0.040", r"unknown key 'links.0.lenght': did you mean 'links.0.length'"),
        ("mass = 0.10 ", "mass = 0.10\nwidht = 1.0 ", r"unknown key 'links.0.widht': did you mean 'links.0.width'"),
        ("stall_effort = 1.5", 'stall_effort = "1.5"', r"actuators.hinge.stall_effort: .*number.*given '1.5'"),
        ("range_min = 0.005", "range_min = 0.005\nrange_mix = 1", r"did you mean 'laser.range_min'"),
        ("lower = -2.4", "lower = 0.1", r"start pose, 0, must lie strictly between lower and upper"),
        ('actuator = "slide"', 'actuator = "slider"', r"names actuator 'slider', which is not described"),
        ('name = "theta2"', 'name = "theta1"', r"joint names must differ"),
        ("lower = -0.050,", "lowr = 1, lower = -0.050,", r"did you mean 'links.0.joint.lower'"),
        ("schema_version = 2", "schema_version = 3", r"schema_version: input should be 1 or 2, given 3"),
        ("schema_version = 2", "schema_version = = 2", r"is not valid TOML"),
    ],
)
def test_errors_are_one_sentence_that_names_the_key(tmp_path: Path, old: str, new: str, said: str) -> None:
    import re

    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    given = message(tmp_path, text)
    assert re.search(said, given), given


def test_a_part_that_sticks_out_of_its_link_is_refused(tmp_path: Path) -> None:
    text = TEXT.replace(
        "mass = 0.10", 'shape = [{ shape = "disc", x = 0.0, diameter = 0.03, height = 0.01 }]\nmass = 0.10', 1
    )
    assert "part 0 of link 'base' sticks out of the link's width or height" in message(tmp_path, text)


def test_an_unknown_shape_of_a_part_is_refused(tmp_path: Path) -> None:
    text = TEXT.replace("mass = 0.10", 'shape = [{ shape = "cone", x = 0.0 }]\nmass = 0.10', 1)
    said = message(tmp_path, text)
    assert "'box'" in said
    assert "'disc'" in said


def test_a_changed_copy_works_out_its_own_arrays() -> None:
    robot = load_robot("basic")
    assert robot.lengths.tolist() == [0.04, 0.12, 0.12, 0.11]
    shorter = robot.model_copy(update={"links": robot.links[1:]})
    assert shorter.lengths.tolist() == [0.12, 0.12, 0.11]
    assert shorter.mirror_signs.tolist() == [-1.0, -1.0, -1.0]
    assert robot == load_robot("basic")


def whole(change: dict[str, object]) -> str:
    """The message about the whole robot's file with a change, as pydantic gives it."""
    table = load_robot("pirate").model_dump()
    with pytest.raises(ValidationError) as caught:
        RobotSpec.model_validate(table | change)
    return str(caught.value)


def test_the_whole_robot_stands_free_on_six_wheels_with_six_bends() -> None:
    robot = load_robot("pirate")
    assert (robot.free, len(robot.links), len(robot.joints), len(robot.wheels)) == (True, 7, 6, 6)
    assert robot.coordinates == 3 + 6
    assert [one.name for one in robot.commanded_parts] == [f"bend{i}" for i in range(1, 7)] + [
        f"wheel{i}" for i in range(1, 7)
    ]
    assert robot.effort_limits.tolist() == [1.0] * 6 + [0.0373] * 6
    assert robot.roll is not None
    assert robot.roll.link == "middle"
    assert not load_robot("basic").free


def test_wheels_stand_out_of_the_links_that_they_carry() -> None:
    robot = load_robot("pirate")
    for link in robot.links:
        assert link.wheel is None or link.wheel.diameter > link.width
    assert robot.width == max(wheel.diameter for wheel in robot.wheels)


def test_only_the_first_link_may_stand_free() -> None:
    links = load_robot("pirate").model_dump()["links"]
    assert "link 'link2' has no joint: only the first link may stand free" in whole(
        {"links": [*links[:2], links[2] | {"joint": None}, *links[3:]]}
    )


def test_wheels_and_roll_name_what_is_described() -> None:
    table = load_robot("pirate").model_dump()
    links, roll = table["links"], table["roll"]
    wheel = links[1]["wheel"] | {"actuator": "steam"}
    assert "wheel 'wheel1' names actuator 'steam'" in whole(
        {"links": [links[0], links[1] | {"wheel": wheel}, *links[2:]]}
    )
    assert "the roll joint divides link 'nose'" in whole({"roll": roll | {"link": "nose"}})


def test_an_unknown_key_of_a_wheel_is_answered_with_the_nearest(tmp_path: Path) -> None:
    text = (robots_dir() / "pirate" / "robot.toml").read_text(encoding="utf-8")
    said = message(tmp_path, text.replace('name = "wheel2",', 'name = "wheel2", diametre = 0.03,'))
    assert "did you mean 'links.2.wheel.diameter'" in said
