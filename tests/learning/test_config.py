"""The configuration of a training: presets, files, settings, options, in this order."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from pipenav.cli import main
from pipenav.errors import PipenavError
from pipenav.learning.config import DEFAULT_PRESET, load_config, preset_names, validate_config
from pipenav.robots.robot import load_robot
from pipenav.storage.shipped import presets_dir
from pipenav.tasks.registry import task_of

THESIS = [name for name in preset_names() if name.startswith("thesis")]


def problem(*settings: str) -> str:
    with pytest.raises(PipenavError) as caught:
        load_config(settings=settings)
    return str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("name", preset_names())
def test_every_preset_can_be_trained(name: str) -> None:
    config = load_config(name)
    load_robot(config.robot)
    assert task_of(config.task).parse_training_pipes(config.pipes)
    assert config.description
    assert config.learner.noise_stop < config.learner.noise_start


def test_the_default_is_shipped() -> None:
    assert load_config() == load_config(DEFAULT_PRESET)


@pytest.mark.parametrize("name", THESIS)
def test_a_thesis_preset_says_what_the_thesis_says(name: str) -> None:
    config = load_config(name)
    assert config.steps == 120_000
    assert config.pipes == ("thesis-train",)
    assert config.task.control == name.removeprefix("thesis-")
    assert config.task.observation == "history"
    weights = config.task.reward
    assert (weights.c1, weights.c2, weights.c3) == (1.5, 0.1, 1.5)
    assert (weights.progress, weights.reach, weights.step, weights.force, weights.penetration) == (0, 0, 0, 0, 0)
    assert weights.limit == -1000  # eq 3.15


@pytest.mark.parametrize("name", THESIS)
def test_a_thesis_network_narrows_and_its_value_net_has_one_layer_more(name: str) -> None:
    network = load_config(name).network
    for widths in network:
        assert list(widths[1]) == sorted(set(widths[1]), reverse=True)
    assert len(network.value) == len(network.policy) + 1


def test_both_thesis_presets_are_there() -> None:
    assert THESIS == ["thesis-position", "thesis-torque"]


def test_later_layers_win(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('seed = 1\nsteps = 111\nrobot = "basic"\n[learner]\nepochs = 3\nclip = 0.3\n', encoding="utf-8")
    below = load_config("arm")
    assert below.seed == 0
    config = load_config("arm", file)
    assert (config.seed, config.steps, config.learner.epochs, config.learner.clip) == (1, 111, 3, 0.3)
    assert config.learner.gamma == below.learner.gamma
    assert config.task == below.task
    config = load_config("arm", file, ["steps=222", "learner.clip=0.4", "steps=223"])
    assert (config.seed, config.steps, config.learner.epochs, config.learner.clip) == (1, 223, 3, 0.4)
    config = load_config("arm", file, ["steps=222", "seed=2"], {"steps": 333, "seed": None, "task.control": "torque"})
    assert (config.seed, config.steps, config.learner.epochs, config.task.control) == (2, 333, 3, "torque")


def test_settings_are_toml_or_bare_words() -> None:
    config = load_config(settings=["pipes=['thesis', 'd=90,angle=60']", "robot=basic", " learner.clip = 1 "])
    assert config.pipes == ("thesis", "d=90,angle=60")
    assert config.learner.clip == 1.0
    assert load_config(settings=["options.timestep=0.001"]).options["timestep"] == 0.001


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("learner.epoch=4", "unknown key 'learner.epoch': did you mean 'learner.epochs'"),
        ("task.reward.forse=4", "unknown key 'task.reward.forse': did you mean 'task.reward.force'"),
        ("learner.batch_size=500", "batch_size 500 must divide robots x rollout_steps = 1536."),
        ("learner.epochs=1.5", "learner.epochs: input should be a valid integer, given 1.5."),
        ("learner.epochs=0", "learner.epochs: input should be greater than or equal to 1, given 0."),
        ("learner.learning_rate=inf", "input should be a finite number"),
        ("learner=5", "learner: input should be a table"),
        ("network.policy=[0]", "network.policy.0: input should be greater than or equal to 1"),
        ("network.policy=64", "network.policy: input should be a list"),
        ("network.policy=['64']", "network.policy.0: input should be a valid integer, given '64'."),
        ("pipes=[]", "pipes: "),
        ("seed=-1", "seed: input should be greater than or equal to 0, given -1."),
        ("steps=many", "steps: input should be a valid integer, given 'many'."),
        ("task.control=torqu", "task.control: input should be 'torque' or 'position', given 'torqu'."),
        ("seed", "'seed' is not a setting: write it as key=value, for example seed=1."),
        ("=3", "'=3' is not a setting"),
    ],
)
def test_a_wrong_setting_is_one_sentence(setting: str, message: str) -> None:
    said = problem(setting)
    assert message in said
    assert "\n" not in said


def test_a_wrong_file_is_named(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    with pytest.raises(PipenavError, match=r"cannot read .*mine\.toml: No such file"):
        load_config(file=file)
    file.write_text("seed = ", encoding="utf-8")
    with pytest.raises(PipenavError, match=r"mine\.toml is not valid TOML"):
        load_config(file=file)
    file.write_text("sed = 1", encoding="utf-8")
    with pytest.raises(PipenavError, match=r"mine\.toml: unknown key 'sed': did you mean 'seed'"):
        load_config(file=file)


def preset_folder(path: Path, monkeypatch: pytest.MonkeyPatch, **presets: str) -> None:
    """A folder with the shipped presets and some more, for which `load_config` looks there."""
    shutil.copytree(presets_dir(), path / "presets")
    for name, text in presets.items():
        (path / "presets" / f"{name}.toml").write_text(text, encoding="utf-8")
    monkeypatch.setattr("pipenav.storage.shipped.presets_dir", lambda: path / "presets")


def test_a_preset_says_only_what_differs_from_the_one_it_extends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    preset_folder(tmp_path, monkeypatch, mine='extends = "pirate"\nseed = 7\noptions = {}\n[learner]\nepochs = 2\n')
    mine, below = load_config("mine"), load_config("pirate")
    assert (mine.seed, mine.learner.epochs, mine.options) == (7, 2, {})
    assert below.options
    changed = {"seed": below.seed, "options": below.options, "learner": below.learner}
    assert mine.model_copy(update=changed) == below
    assert mine.learner.model_copy(update={"epochs": below.learner.epochs}) == below.learner


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('extends = "pirat"', "preset mine: extends: unknown preset 'pirat': did you mean 'pirate'"),
        (
            'extends = "pirate-strong-gravity"',
            "preset 'pirate-strong-gravity' extends 'pirate' itself: extend that one.",
        ),
        ("extends = 3", "preset mine: extends: input should be the name of a preset, given 3."),
    ],
)
def test_a_preset_that_extends_wrongly_is_one_sentence(
    text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    preset_folder(tmp_path, monkeypatch, mine=text)
    with pytest.raises(PipenavError) as caught:
        load_config("mine")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_extends_a_preset_is_laid_over_it(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('extends = "pirate-strong-gravity"\nseed = 4\n', encoding="utf-8")
    below = load_config("pirate-strong-gravity")
    assert load_config(file=file) == load_config("pirate-strong-gravity", file) == below.model_copy(update={"seed": 4})
    with pytest.raises(PipenavError, match=r"mine\.toml extends preset 'pirate-strong-gravity', given 'arm'"):
        load_config("arm", file)
    file.write_text('extends = "amr"', encoding="utf-8")
    with pytest.raises(PipenavError, match=r"mine\.toml: extends: unknown preset 'amr': did you mean 'arm'"):
        load_config(file=file)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--preset", "amr"), "unknown preset 'amr': did you mean 'arm'?"),
        (("--robot", "basik"), "unknown robot 'basik': did you mean 'basic'?"),
        (("--backend", "mujocco"), "unknown backend 'mujocco': did you mean 'mujoco'"),
        (("--pipes", "thesis-trian"), "unknown pipe set 'thesis-trian': did you mean 'thesis-train'"),
        (("--set", "options.timstep=1"), "unknown key 'timstep': did you mean 'timestep'"),
        (("--control", "torqe"), "task.control: input should be 'torque' or 'position'"),
        (("--steps", "0"), "steps: input should be greater than or equal to 1, given 0."),
    ],
)
def test_an_unknown_name_stops_before_a_folder_is_made(
    options: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(["train", "--out", str(tmp_path / "run"), *options])
    assert left.value.code == 1
    shown = capsys.readouterr()
    assert message in shown.err
    assert shown.err.count("\n") == 1
    assert not shown.out
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("name", preset_names())
def test_a_configuration_survives_json(name: str) -> None:
    config = load_config(name, settings=["options.timestep=0.001", "seed=7"])
    text = json.dumps(config.model_dump(mode="json"), allow_nan=False)
    assert validate_config(json.loads(text), "config.json") == config
