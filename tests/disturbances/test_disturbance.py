"""Ranges of what goes wrong: read from files and configurations, refused in words, listed in the documents."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from helpers.checkout import ROOT

from pipenav.cli import main
from pipenav.disturbances.disturbance import UNDISTURBED, Disturbance, disturbance_names, load_disturbance
from pipenav.errors import PipenavError
from pipenav.learning.config import load_config, preset_names, validate_config
from pipenav.tasks.reach.config import ReachConfig

DOCUMENT = ROOT / "docs/guides/disturbances.md"


@pytest.mark.parametrize("name", disturbance_names())
def test_every_shipped_disturbance_disturbs_something(name: str) -> None:
    disturbance = load_disturbance(name)
    assert disturbance != UNDISTURBED
    assert disturbance.acts or disturbance.starts(ReachConfig()) != ReachConfig()


def test_the_documents_list_every_shipped_disturbance_and_every_key() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `([\w-]+)` \|", text, re.MULTILINE)) == {
        *disturbance_names(),
        *Disturbance.model_fields,
    }


def test_the_real_world_failure_is_that_of_the_thesis() -> None:
    wanted = Disturbance(dropouts=(0.3, 0.3), noise=(0.01, 0.01), latency=(1, 1), strength=(0.8, 1.2))
    assert load_disturbance("real-world") == wanted


@pytest.mark.parametrize("name", preset_names())
def test_only_the_robust_preset_randomises(name: str) -> None:
    assert (load_config(name).randomise != UNDISTURBED) == (name == "robust")


def test_the_robust_preset_draws_beyond_the_real_world_failure() -> None:
    drawn, seen = load_config("robust").randomise, load_disturbance("real-world")
    for key in Disturbance.model_fields:
        span, point = getattr(drawn, key), getattr(seen, key)
        if point is not None:
            assert span[0] <= point[0]
            assert span[1] >= point[1]
    assert drawn.latency == (0, 2)


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("latency = [0, 1]\nnoise = [0.0, 0.02]\n")
    assert load_disturbance(str(path)) == Disturbance(latency=(0, 1), noise=(0.0, 0.02))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("noise = [0.02, 0.01]", r"noise: a range is written as \[smallest, largest\]"),
        ("noise = [-0.1, 0.1]", "noise.0: input should be greater than or equal to 0"),
        ("strength = [0.0, 1.0]", "strength.0: input should be greater than 0"),
        ("latency = [0, 9]", "latency.1: input should be less than or equal to 5"),
        ("latency = [0, 1.5]", "latency.1: input should be a valid integer"),
        ("nose = [0, 1]", "unknown key 'nose': did you mean 'noise'"),
        ("noise = [", "is not valid TOML"),
    ],
)
def test_a_file_that_describes_none_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(PipenavError, match=message):
        load_disturbance(str(path))


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(PipenavError, match="unknown disturbance 'real-wold': did you mean 'real-world'"):
        load_disturbance("real-wold")
    with pytest.raises(PipenavError, match=r"cannot read nowhere\.toml"):
        load_disturbance("nowhere.toml")


def test_a_training_takes_ranges_and_refuses_wrong_ones() -> None:
    config = load_config("arm", settings=["randomise.latency=[0, 2]"])
    assert config.randomise == Disturbance(latency=(0, 2))
    assert validate_config(config.model_dump(mode="json"), "") == config
    with pytest.raises(PipenavError, match=r"did you mean 'randomise\.latency'"):
        load_config("arm", settings=["randomise.latncy=[0, 2]"])


def test_start_poses_are_those_that_are_wanted() -> None:
    task = ReachConfig(start_bend=0.01, start_gap=(0.05, 0.06))
    assert UNDISTURBED.starts(task) == task
    assert Disturbance(start_bend=0.1).starts(task) == task.model_copy(update={"start_bend": 0.1})
    assert Disturbance(start_gap=(0.1, 0.2)).starts(task).start_gap == (0.1, 0.2)
    assert not Disturbance(start_bend=0.1, start_gap=(0.1, 0.2)).acts


def evaluation(folder: Path, *more: str) -> dict[str, object]:
    """eval.json of a short evaluation of the whole passage."""
    with pytest.raises(SystemExit) as left:
        main(["eval", "--policy", "arm", "--pipes", "d=110,angle=90", "--episodes", "6", "--stage", "passage", "--out",
              str(folder), *more])  # fmt: skip
    assert not left.value.code
    return dict(json.loads((folder / "eval.json").read_text()))


@pytest.mark.slow
def test_an_evaluation_is_disturbed_in_every_stage_and_says_by_what(tmp_path: Path) -> None:
    quiet, weak = evaluation(tmp_path / "a"), evaluation(tmp_path / "b", "--disturb", "weak")
    assert (quiet["disturb"], weak["disturb"]) == (None, "weak")
    (before,), (after,) = quiet["pipes"], weak["pipes"]  # type: ignore[misc]
    assert before["located"] == after["located"] == 6
    assert before["rear_successes"] == 6
    assert after["mean_steps"] > before["mean_steps"]
    again = evaluation(tmp_path / "c", "--disturb", "weak")
    assert again == weak


def test_an_evaluation_under_an_unknown_disturbance_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(["eval", "--policy", "arm", "--disturb", "storm", "--out", str(tmp_path / "x")])
    assert left.value.code == 1
    assert "unknown disturbance 'storm'" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("text", ["", "# nothing yet\n", "friction = [1.0, 1.0]\nlatency = [0, 0]\n"])
def test_a_file_that_disturbs_nothing_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(PipenavError, match=r"mine.toml disturbs nothing: set one of friction, mass, strength"):
        load_disturbance(str(tmp_path / "mine.toml"))
