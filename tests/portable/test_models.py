"""Models for other programs act as the policy that they came from, on observations in physical units."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.documented import pipenav
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.policies.file import Array32, Layer
from pipenav.policies.header import header_for
from pipenav.policies.policy import Policy, load_policy, policy_names, resolve_policy
from pipenav.portable import onnx_file, parity, torchscript_file
from pipenav.portable.interface import METADATA_KEY, acted_values, observed_values
from pipenav.robots.robot import load_robot, robot_names
from pipenav.tasks.registry import default_config, task_of

onnx = pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")


class Format(NamedTuple):
    """A format of models: how a policy is written, how what was written is run, and the text of its metadata."""

    write: Callable[[Policy], bytes]
    run: Callable[[bytes], Callable[[Array32], Array32]]
    told: Callable[[bytes], str]


def told_by_onnx(content: bytes) -> str:
    return {prop.key: prop.value for prop in onnx.load_from_string(content).metadata_props}[METADATA_KEY]


def told_by_torchscript(content: bytes) -> str:
    import torch

    told = {torchscript_file.EXTRA_FILE: ""}
    torch.jit.load(io.BytesIO(content), _extra_files=told)
    text: Any = told[torchscript_file.EXTRA_FILE]
    return text.decode() if isinstance(text, bytes) else str(text)


FORMATS = {
    "onnx": Format(onnx_file.onnx_bytes, onnx_file.onnx_runner, told_by_onnx),
    "torchscript": Format(torchscript_file.torchscript_bytes, torchscript_file.torchscript_runner, told_by_torchscript),
}


@pytest.fixture(params=FORMATS)
def form(request: pytest.FixtureRequest) -> Format:
    return FORMATS[request.param]


def random_policy(robot_name: str, hidden: list[int], gain: float, seed: int) -> Policy:
    """A policy with random weights: the larger the gain, the more actions are clipped."""
    robot, rng = load_robot(robot_name), np.random.default_rng(seed)
    task = default_config(robot)
    scale = task_of(task).observation_scale(robot).astype(np.float32)
    sizes = [len(scale), *hidden, len(robot.driven_actuators)]
    layers = [
        Layer((gain * rng.normal(size=pair) / pair[0] ** 0.5).astype(np.float32), rng.normal(size=pair[1]).astype("f4"))
        for pair in pairwise(sizes)
    ]
    return Policy(Path("best.zip"), header_for(robot, task, ["thesis"], {}), scale, layers)


@pytest.mark.parametrize("name", FORMATS)
@given(
    robot=st.sampled_from(robot_names()),
    hidden=st.lists(st.integers(1, 64), max_size=3),
    gain=st.floats(0.1, 3.0),
    seed=st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=15)
def test_any_policy_acts_alike_in_a_model(name: str, robot: str, hidden: list[int], gain: float, seed: int) -> None:
    form, policy = FORMATS[name], random_policy(robot, hidden, gain, seed)
    scaled = np.random.default_rng(seed).normal(size=(50, len(policy.observation_scale)))
    assert parity.compare(policy, form.run(form.write(policy)), scaled).passed


@pytest.mark.parametrize("name", policy_names())
def test_shipped_policies_act_alike_on_recorded_observations(name: str, form: Format) -> None:
    policy = load_policy(resolve_policy(name))
    scaled = parity.ObservationSource(policy, ["d=120,angle=90"]).record(500)
    assert scaled.shape == (500, len(policy.observation_scale))
    assert parity.compare(policy, form.run(form.write(policy)), scaled).passed


def test_metadata_name_every_value(form: Format) -> None:
    for robot in robot_names():
        policy = random_policy(robot, [8], 1.0, 0)
        told = json.loads(form.told(form.write(policy)))
        assert told["observation"] == [value._asdict() for value in observed_values(policy)]
        assert [value["scale"] for value in told["observation"]] == policy.observation_scale.tolist()
        assert len({value["name"] for value in told["observation"]}) == len(policy.observation_scale)
        assert told["action"] == [value._asdict() for value in acted_values(policy.header)]
        assert told["policy"] == json.loads(policy.header.model_dump_json())


def test_slides_have_metres_and_hinges_radians() -> None:
    values = {value.name: value.unit for value in observed_values(random_policy("basic", [], 1.0, 0))}
    robot = load_robot("basic")
    for joint in robot.joints:
        unit = "rad" if joint.type == "hinge" else "m"
        assert values[f"q.{joint.name}"] == unit and values[f"qd.{joint.name}"] == f"{unit}/s"


def test_physical_actions_are_actions_in_their_units() -> None:
    import onnxruntime

    policy = random_policy("pirate", [16], 2.0, 3)
    session = onnxruntime.InferenceSession(onnx_file.onnx_bytes(policy), providers=["CPUExecutionProvider"])
    observation = np.random.default_rng(0).normal(size=(9, len(policy.observation_scale))).astype(np.float32)
    action, physical = session.run(["action", "physical_action"], {"observation": observation})
    np.testing.assert_allclose(physical, action * [value.scale for value in acted_values(policy.header)], rtol=1e-6)


def test_the_same_policy_gives_the_same_bytes() -> None:
    assert onnx_file.onnx_bytes(random_policy("basic", [8], 1.0, 0)) == onnx_file.onnx_bytes(
        random_policy("basic", [8], 1.0, 0)
    )


@pytest.mark.parametrize("wrong", [1e-3, float("nan")])
def test_a_model_that_differs_is_not_written(
    wrong: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def runner(content: bytes) -> Callable[[Array32], Array32]:
        right = torchscript_file.torchscript_runner(content)

        def act(observation: Array32) -> Array32:
            actions = right(observation).copy()
            actions[len(actions) // 2, 0] += wrong
            return actions

        return act

    monkeypatch.setattr("pipenav.cli.export._formats", lambda: {"onnx": form_with(runner)})
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.onnx").write_bytes(b"an earlier one")
    words = ("export", "--policy", "arm", "--to", "onnx", "--observations", "20", "--pipes", "d=90,angle=90")
    assert pipenav(*words, "--out", "arm.onnx") == 1
    assert "nothing is written" in capsys.readouterr().err
    assert (tmp_path / "arm.onnx").read_bytes() == b"an earlier one"


def form_with(runner: Any) -> Any:
    """The command's format of TorchScript, whose models run otherwise."""
    from pipenav.cli.export import _Format

    return _Format(".pt", torchscript_file.torchscript_bytes, runner)


def test_the_command_prints_the_parity_and_writes_the_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("export", "--policy", "arm", "--to", "onnx", "--observations", "20", "--pipes", "d=90,angle=90")
    assert pipenav(*words) == 0
    said = capsys.readouterr().out
    assert "largest difference of an action" in said and "20 observations" in said
    content = (tmp_path / "runs/shipped-arm/best.onnx").read_bytes()
    assert content == onnx_file.onnx_bytes(load_policy(resolve_policy("arm")))
