"""Types of joints, wheels and links in a robot.toml, and its documented format."""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from pathlib import Path

import pytest

from pipenav.errors import ConfigError
from pipenav.robots import RobotSpec, load_robot
from pipenav.robots.joint_types import resolve_types
from pipenav.robots.variants import completed
from pipenav.storage import shipped

DOCS = Path(__file__).resolve().parents[2] / "docs/formats/robot-file.md"

SPECS = {
    "basic": "f377ddcd5b1b3e3d",
    "high-fidelity": "80aaf4c4d1cc3c5a",
    "pirate": "bfa0e42e182957ca",
    "pirate-strong": "72da3c2d788b88e9",
    "real-setup": "80e7a02774f4dc51",
}
"""Start of the hash of every shipped robot's description without types, which policy files hold."""


def example() -> str:
    """The minimal robot of the documentation."""
    found = re.search(r"```toml\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    return found[1]


def load(tmp_path: Path, text: str) -> RobotSpec:
    path = tmp_path / "robot.toml"
    path.write_text(text, encoding="utf-8")
    return load_robot(str(path))


@pytest.mark.parametrize("name", SPECS)
def test_shipped_robots_resolve_to_what_they_were(name: str) -> None:
    given = json.dumps(load_robot(name).model_dump(), sort_keys=True)
    assert hashlib.sha256(given.encode()).hexdigest().startswith(SPECS[name])


def test_the_documented_robot_loads(tmp_path: Path) -> None:
    robot = load(tmp_path, example())
    assert [joint.name for joint in robot.joints] == ["slide", "shoulder", "elbow"]
    assert robot.lengths.tolist() == [0.04, 0.1, 0.1]
    assert robot.upper.tolist() == [0.3, 2.4, 1.5]
    assert robot.schema_version == 1


@pytest.mark.parametrize("model", ["Actuator", "Joint", "Wheel", "Link", "Roll", "Laser", "BoxPart", "DiscPart"])
def test_every_key_is_documented(model: str) -> None:
    from pipenav import robots

    text = DOCS.read_text(encoding="utf-8")
    assert [key for key in getattr(robots, model).model_fields if f"`{key}`" not in text] == []


@pytest.mark.parametrize("name", SPECS)
def test_a_file_of_schema_1_says_the_same(name: str) -> None:
    text = (shipped.robots_dir() / name / "robot.toml").read_text(encoding="utf-8")
    table = resolve_types(completed(tomllib.loads(text), name), name)
    assert table["schema_version"] == 1
    assert resolve_types(table, name) == table
    assert RobotSpec.model_validate(table) == load_robot(name)


def test_wheels_and_the_roll_joint_have_types_too(tmp_path: Path) -> None:
    text = (shipped.robots_dir() / "pirate" / "robot.toml").read_text(encoding="utf-8")
    assert {wheel.diameter for wheel in load_robot("pirate").wheels} == {0.032}
    changed = text.replace('name = "wheel3",', 'name = "wheel3", diameter = 0.03,')
    changed = changed.replace('"roll", type = "hinge", lower = -3.2', '"roll", like = "bend", lower = -3.2')
    robot = load(tmp_path, changed)
    assert [wheel.diameter for wheel in robot.wheels] == [0.032, 0.032, 0.03, 0.032, 0.032, 0.032]
    assert robot.roll == load_robot("pirate").roll


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"elbow", like = "hinge"', '"elbow", like = "hing"', "links.2.joint.like: unknown joint type 'hing': did you"),
        ('"elbow", like = "hinge"', '"elbow", like = "x"', "unknown joint type 'x': choose 'hinge'."),
        ('"elbow", like = "hinge"', '"elbow", like = 3', "links.2.joint.like: unknown joint type '3': choose 'hinge'."),
        ('name = "upper"\nlike = "segment"', 'name = "upper"\nlike = "y"', "unknown link type 'y': choose 'segment'."),
        ('name = "upper"\n', 'name = "upper"\nwheel = { like = "z" }\n', "unknown wheel type 'z': there are none."),
        ("lower = -2.4", "lowr = -2.4", "unknown key 'joint_types.hinge.lowr': did you mean 'joint_types.hinge.lower'"),
        ('type = "hinge"', 'name = "a"', "unknown key 'joint_types.hinge.name'"),
        ("upper = 2.4\n", "", "links.1.joint.upper: this key is missing, add it"),
        ("[link_types.segment]", "[link_types]", "link_types must hold one table per type, as in [link_types.NAME]."),
        ("schema_version = 2", "schema_version = 1", "[joint_types] needs schema_version = 2."),
        ("schema_version = 2", "schema_version = 3", "schema_version: input should be 1 or 2, given 3."),
        ("schema_version = 2", "", "schema_version"),
    ],
)
def test_wrong_types_are_one_sentence(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = example().replace(old, new, 1)
    assert text != example()
    with pytest.raises(ConfigError) as caught:
        load(tmp_path, text)
    message = str(caught.value)
    assert said in message
    assert "\n" not in message
    assert message.startswith(str(tmp_path))
