"""Mappings: what is refused, in one sentence, and that every shipped one fits its robots."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipenav.driving.mapping import Device, load_mapping
from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot, robot_names

DEVICES: tuple[Device, ...] = ("keyboard", "gamepad", "midi")


@pytest.mark.parametrize("robot", robot_names())
@pytest.mark.parametrize("device", DEVICES)
def test_the_shipped_mapping_reaches_every_joint_of_a_robot_and_its_end(robot: str, device: Device) -> None:
    spec = load_robot(robot)
    actions = load_mapping(None, spec, device).values()
    assert {"stop", "end", "hand-back"} <= set(actions)
    if device != "gamepad":  # sticks are few
        assert all(any(action.rstrip("+-") == joint.name for action in actions) for joint in spec.joints)


WRONG = {
    "unknown joint": ('[keyboard]\nq = "joint9+"', "6 joints"),
    "unknown joint by name": ('[keyboard]\nq = "theta1+"', "theta1+"),
    "two keys for one action": ('[keyboard]\nq = "step-a"\nw = "step-a"', "'q' and 'w'"),
    "two names of one joint": ('[keyboard]\nq = "joint1+"\nw = "bend1+"', "'q' and 'w'"),
    "unknown action": ('[keyboard]\nq = "fly"', "fly"),
    "unknown key": ('[keyboard]\nF13 = "end"', "no 'F13'"),
    "unknown table": ('[mouse]\nq = "end"', "unknown key 'mouse'"),
    "nothing": ("[midi]\n", "maps nothing"),
    "no table": ("keyboard = 3", "keyboard"),
    "no text": ("[keyboard]\nq = 3", "keyboard.q"),
    "a held action on a fader's table": ('[keyboard]\nq = "wheels"', "'wheels'"),
}


@pytest.mark.parametrize(("text", "words"), WRONG.values(), ids=WRONG)
def test_what_does_not_fit_is_refused_in_one_sentence(text: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(PipenavError, match="mine") as refused:
        load_mapping(file, load_robot("pirate"), "keyboard")
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_joints_by_number_and_by_name_are_the_same(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('[keyboard]\nq = "joint2+"\nw = "theta2-"', encoding="utf-8")
    assert load_mapping(file, load_robot("basic"), "keyboard") == {"q": "theta1+", "w": "theta2-"}


def test_keys_turn_the_roll_joint_and_faders_do_not(tmp_path: Path) -> None:
    """A fader asks for positions, and a roll joint's is the roll's own."""
    file = tmp_path / "mine.toml"
    file.write_text('[keyboard]\nq = "roll+"\nw = "roll"\n[midi]\ncc0 = "roll"', encoding="utf-8")
    assert load_mapping(file, load_robot("pirate"), "keyboard") == {"q": "roll+", "w": "roll"}
    with pytest.raises(PipenavError, match="'cc0' of the midi names an unknown action"):
        load_mapping(file, load_robot("pirate"), "midi")
