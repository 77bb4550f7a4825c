"""Robots that extend a shipped one say only what is different."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot
from pipenav.robots.traction import mass, pull, speed_under, top_speed
from pipenav.robots.variants import robot_names


def variant(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("name", [name for name in robot_names() if name != "pirate-strong"])
def test_a_variant_is_the_shipped_robot_but_for_what_it_says(name: str, tmp_path: Path) -> None:
    text = f'schema_version = 2\nextends = "{name}"\nname = "mine"\n[laser]\nbeams = 7\n'
    mine, shipped = load_robot(variant(tmp_path, text)), load_robot(name)
    changed = {"name": "mine", "laser": shipped.laser.model_copy(update={"beams": 7})}
    assert mine == shipped.model_copy(update=changed)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('extends = "pirat"', r"mine\.toml: extends: unknown robot 'pirat': did you mean 'pirate'"),
        ("extends = 3", "extends: input should be the name of a shipped robot, given 3"),
        ('extends = "pirate-strong"', "robot 'pirate-strong' extends 'pirate' itself: extend that one"),
    ],
)
def test_what_cannot_be_extended_is_refused(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match=message):
        load_robot(variant(tmp_path, f"schema_version = 2\n{text}\n"))


def test_the_strong_robot_differs_in_its_wheels_alone() -> None:
    weak, strong = load_robot("pirate"), load_robot("pirate-strong")
    assert (weak.links, weak.laser, weak.roll, mass(weak)) == (strong.links, strong.laser, strong.roll, mass(strong))
    assert weak.actuators["bend"] == strong.actuators["bend"]
    assert pull(weak) == pytest.approx(14.0, rel=0.002) and pull(strong) == pytest.approx(56.25)


@pytest.mark.parametrize("name", ["pirate", "pirate-strong"])
def test_speed_falls_in_a_straight_line_to_nothing_at_the_pull(name: str) -> None:
    robot = load_robot(name)
    at = speed_under(robot, [0.0, pull(robot) / 2, pull(robot)])  # type: ignore[arg-type]
    assert at == pytest.approx([top_speed(robot), top_speed(robot) / 2, 0.0], abs=1e-12)
