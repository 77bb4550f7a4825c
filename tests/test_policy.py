"""The policy file: it does what Stable-Baselines3's own policy does, and survives strangers, cuts and full disks."""

from __future__ import annotations

import errno
import json
import os
import pickle
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import safetensors.numpy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipenav.errors import FileProblem, PipenavError, UnknownName
from pipenav.policies.policy import (
    Policy,
    PolicyFileError,
    header_for,
    load_policy,
    policy_names,
    resolve_policy,
    save_policy,
)
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import task_of

ROBOT = load_robot("basic")
TASK = ReachConfig(observation="relative")
SIZE, JOINTS = len(task_of(TASK).observation_scale(ROBOT)), len(ROBOT.joints)
ROOT = Path(__file__).parent.parent

Members = dict[str, bytes]


class _Still(gymnasium.Env):
    """Spaces of the right size, and nothing that moves."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (SIZE,), np.float32)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (JOINTS,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:  # noqa: ARG002
        return np.zeros(SIZE, np.float32), {}

    def step(self, action: Any) -> Any:  # noqa: ARG002
        return np.zeros(SIZE, np.float32), 0.0, False, False, {}


def _ppo(**settings: Any) -> Any:
    import torch
    from stable_baselines3 import PPO

    torch.set_num_threads(1)
    kwargs = {"activation_fn": torch.nn.Tanh, "net_arch": {"pi": [32, 16], "vf": [8]}, **settings}
    model = PPO("MlpPolicy", _Still(), n_steps=8, batch_size=8, seed=1, device="cpu", policy_kwargs=kwargs)
    with torch.no_grad():  # actions well inside and well outside of [-1, 1]
        model.policy.action_net.weight.mul_(100.0)
    return model


@pytest.fixture(scope="module")
def model() -> Any:
    return _ppo()


@pytest.fixture(scope="module")
def good(model: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("policy") / "best.zip"
    save_policy(path, model, _header())
    return path


def _header() -> Any:
    return header_for(ROBOT, TASK, ["thesis-train"], {"steps": 8, "seconds": 0.5, "seed": 1, "preset": "arm"})


def _members(path: Path) -> Members:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _zip(path: Path, members: Members) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def _refusal(path: Path) -> str:
    """The one sentence that the file is refused with."""
    with pytest.raises(PolicyFileError) as caught:
        load_policy(path)
    text = str(caught.value)
    assert str(path) in text
    assert text.endswith(".")
    assert "\n" not in text
    return text


def _observations(count: int) -> np.ndarray:
    return np.random.default_rng(0).normal(size=(count, SIZE)).astype(np.float32)


def test_acts_as_the_model_it_was_saved_from(good: Path, model: Any) -> None:
    observations = _observations(500)
    expected, _ = model.predict(observations, deterministic=True)
    actions = load_policy(good).act(observations)
    assert actions.dtype == np.float32
    assert (np.abs(expected) < 0.9).any()
    assert (np.abs(expected) == 1.0).any()
    np.testing.assert_allclose(actions, expected, rtol=0.0, atol=1e-5)


def test_stable_baselines_opens_the_file(good: Path, model: Any) -> None:
    from stable_baselines3 import PPO

    again = PPO.load(good, device="cpu")
    observations = _observations(20)
    np.testing.assert_array_equal(
        again.predict(observations, deterministic=True)[0], model.predict(observations, deterministic=True)[0]
    )
    PPO.load(good, env=_Still(), device="cpu").learn(8)


@pytest.mark.parametrize("count", [1, 2, 3, 17, 64, 129])
def test_a_row_does_not_depend_on_the_others(good: Path, count: int) -> None:
    policy, observations = load_policy(good), _observations(300)
    everything = policy.act(observations)
    np.testing.assert_array_equal(policy.act(observations[100 : 100 + count]), everything[100 : 100 + count])
    np.testing.assert_array_equal(policy.act(np.asfortranarray(observations)), everything)


def test_header_and_scale_come_back(good: Path) -> None:
    policy = load_policy(good)
    header = policy.header
    assert header.model_dump() == _header().model_dump()
    assert sum(part.size for part in header.observation) == SIZE
    assert [part.joint for part in header.action] == [joint.name for joint in ROBOT.joints]
    assert [part.unit for part in header.action] == ["N", "N m", "N m", "N m"]
    assert [part.scale for part in header.action] == pytest.approx(ROBOT.effort_limits)
    np.testing.assert_allclose(policy.observation_scale, task_of(TASK).observation_scale(ROBOT), rtol=1e-6)


def test_nothing_of_the_training_machine_is_in_the_file(good: Path) -> None:
    content = b"".join(_members(good).values())
    assert os.uname().release.encode() not in content
    assert b"system_info.txt" not in good.read_bytes()


def test_loading_imports_neither_torch_nor_stable_baselines(good: Path) -> None:
    code = (
        "import sys; from pipenav.policies.policy import load_policy; import numpy as np\n"
        f"policy = load_policy({str(good)!r}); policy.act(np.zeros((1, {SIZE})))\n"
        "assert not {'torch', 'stable_baselines3', 'pickle5', 'mujoco'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


# What the policy was made for


def test_its_own_robot_and_task_are_accepted(good: Path) -> None:
    policy = load_policy(good)
    policy.require(robot=ROBOT, task=TASK)
    policy.require(robot=ROBOT.model_copy(update={"description": "the same, said otherwise"}))
    policy.require(task=TASK.model_copy(update={"max_steps": 7, "reach_tolerance": 0.001}))


@pytest.mark.parametrize(
    ("robot", "task", "expected"),
    [
        ({"name": "pirate"}, {}, "robot 'basic', not 'pirate'"),
        ({"friction": 0.9}, {}, "friction is 0.3, here 0.9"),
        ({}, {"observation": "basic"}, "observation 'relative', not 'basic'"),
        ({}, {"control": "position"}, "control 'torque', not 'position'"),
    ],
)
def test_a_mismatch_is_refused_by_name(good: Path, robot: dict[str, Any], task: dict[str, Any], expected: str) -> None:
    with pytest.raises(PolicyFileError, match=expected):
        load_policy(good).require(robot=ROBOT.model_copy(update=robot), task=TASK.model_copy(update=task))


def test_another_position_step_is_refused(model: Any, tmp_path: Path) -> None:
    task = TASK.model_copy(update={"control": "position"})
    save_policy(tmp_path / "best.zip", model, header_for(ROBOT, task, [], {}))
    policy = load_policy(tmp_path / "best.zip")
    assert [part.unit for part in policy.header.action] == ["m", "rad", "rad", "rad"]
    with pytest.raises(PolicyFileError, match="another size of a position step"):
        policy.require(task=task.model_copy(update={"alpha": 0.5}))


def test_a_name_or_a_path_is_resolved(tmp_path: Path) -> None:
    assert resolve_policy("runs/x/best.zip") == Path("runs/x/best.zip")
    assert resolve_policy("best.zip") == Path("best.zip")
    for name in policy_names():
        assert isinstance(load_policy(resolve_policy(name)), Policy)
    with pytest.raises(UnknownName, match=r"unknown policy 'no-such-policy'.*FILE\.zip"):
        resolve_policy("no-such-policy")
    assert resolve_policy(str(tmp_path)) == tmp_path


# Hostile and broken files


class _Bomb:
    """Unpickled, it leaves a mark."""

    def __init__(self, mark: Path) -> None:
        self._mark = mark

    def __reduce__(self) -> Any:
        return Path.touch, (self._mark,)


def test_pickles_in_the_file_never_run(good: Path, tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    bomb = pickle.dumps(_Bomb(mark))
    members = _members(good)
    for name in [name for name in members if name not in ("pipenav.json", "policy.safetensors")]:
        members[name] = bomb
    actions = load_policy(_zip(tmp_path / "best.zip", members)).act(_observations(3))
    np.testing.assert_array_equal(actions, load_policy(good).act(_observations(3)))
    for name in ("pipenav.json", "policy.safetensors"):
        _refusal(_zip(tmp_path / "bad.zip", members | {name: bomb}))
    assert not mark.exists()
    pickle.loads(bomb)
    assert mark.exists()  # the bomb is a real one


def test_a_truncated_file_is_refused(good: Path, tmp_path: Path) -> None:
    content, path = good.read_bytes(), tmp_path / "cut.zip"
    for length in {0, 1, 2, 4, 21, len(content) - 1, *range(0, len(content), 997)}:
        path.write_bytes(content[:length])
        _refusal(path)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_flipped_bytes_never_crash(good: Path, tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray(good.read_bytes())
    # Half of the places in the last kilobytes, where our members and the zip's directory lie.
    anywhere = st.integers(0, len(content) - 1)
    late = st.integers(max(0, len(content) - 14_000), len(content) - 1)
    for place in data.draw(st.lists(anywhere | late, min_size=1, max_size=8)):
        content[place] = data.draw(st.integers(0, 255))
    path = tmp_path / "flipped.zip"
    path.write_bytes(bytes(content))
    try:
        assert np.isfinite(load_policy(path).act(_observations(2))).all()
    except PipenavError as error:
        assert str(path) in str(error)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_flipped_bytes_inside_our_members_never_crash(good: Path, tmp_path: Path, data: st.DataObject) -> None:
    members = _members(good)
    name = data.draw(st.sampled_from(["pipenav.json", "policy.safetensors"]))
    content = bytearray(members[name])
    places = st.integers(0, len(content) - 1) | st.integers(0, min(700, len(content) - 1))
    for place in data.draw(st.lists(places, min_size=1, max_size=4)):
        content[place] = data.draw(st.integers(0, 255))
    path = _zip(tmp_path / "flipped.zip", members | {name: bytes(content)})  # with checksums that fit
    try:
        load_policy(path).act(_observations(2))
    except PipenavError as error:
        assert str(path) in str(error)


def test_two_members_of_one_name_are_refused(good: Path, tmp_path: Path) -> None:
    path = _zip(tmp_path / "best.zip", _members(good))
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.writestr("pipenav.json", "{}")
    assert "two members of one name" in _refusal(path)


@pytest.mark.parametrize("name", ["pipenav.json", "policy.safetensors"])
@pytest.mark.parametrize("packing", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_zip_bomb_is_refused_before_it_unpacks(good: Path, tmp_path: Path, name: str, packing: int) -> None:
    members = _members(good)
    del members[name]
    path = _zip(tmp_path / "bomb.zip", members)
    with zipfile.ZipFile(path, "a", packing) as archive:
        archive.writestr(name, bytes(64 << 20))
    assert path.stat().st_size < 1 << 20
    assert f"holds a {name} that is larger than" in _refusal(path)


def test_a_member_that_lies_about_its_size_is_refused(good: Path, tmp_path: Path) -> None:
    members = _members(good)
    whole = members.pop("pipenav.json")
    path = _zip(tmp_path / "lie.zip", members)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("pipenav.json", bytes(64 << 20))
    size = (64 << 20).to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(size, len(whole).to_bytes(4, "little")))
    _refusal(path)


def test_an_oversized_file_is_refused(good: Path, tmp_path: Path) -> None:
    path = tmp_path / "large.zip"
    path.write_bytes(good.read_bytes() + bytes(17 << 20))
    assert "larger than 16 MiB" in _refusal(path)


def test_path_traversal_writes_nothing(good: Path, tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    path = _zip(folder / "best.zip", _members(good) | {"../../evil": b"x", "/evil": b"x"})
    load_policy(path)
    assert sorted(p for p in tmp_path.rglob("*") if p.is_file()) == [path]


def test_a_zip_of_stable_baselines_alone_is_named(model: Any, tmp_path: Path) -> None:
    model.save(tmp_path / "foreign.zip")
    assert "made by Stable-Baselines3 alone" in _refusal(tmp_path / "foreign.zip")


def test_no_file_no_zip_no_policy(tmp_path: Path) -> None:
    assert "is a folder: name the file in it" in _refusal(tmp_path)
    assert "No such file" in _refusal(tmp_path / "missing.zip")
    text = tmp_path / "text.zip"
    text.write_text("hello")
    assert "is not a zip file" in _refusal(text)
    assert "not of a policy" in _refusal(_zip(tmp_path / "other.zip", {"a": b"b"}))
    with pytest.raises(PolicyFileError, match="null"):
        load_policy("a\0b.zip")


def _edit_json(change: Callable[[dict[str, Any]], object]) -> Callable[[Members], None]:
    def edit(members: Members) -> None:
        header = json.loads(members["pipenav.json"])
        change(header)
        members["pipenav.json"] = json.dumps(header).encode()

    return edit


def _edit_weights(change: Callable[[dict[str, Any]], object]) -> Callable[[Members], None]:
    def edit(members: Members) -> None:
        tensors = {name: array.copy() for name, array in safetensors.numpy.load(members["policy.safetensors"]).items()}
        change(tensors)
        members["policy.safetensors"] = safetensors.numpy.save(tensors)

    return edit


BROKEN: dict[str, tuple[Callable[[Members], Any], str]] = {
    "no header": (lambda m: m.pop("pipenav.json"), "damaged"),
    "no weights": (lambda m: m.pop("policy.safetensors"), "damaged"),
    "no json": (lambda m: m.update({"pipenav.json": b"\xff{"}), "unusable pipenav.json"),
    "deep json": (lambda m: m.update({"pipenav.json": b"[" * 100_000}), "unusable pipenav.json"),
    "unknown key": (_edit_json(lambda h: h.update(surprise=1)), "unknown key 'surprise'"),
    "unknown key inside": (_edit_json(lambda h: h["task"].update(surprise=1)), "unknown key 'task.surprise'"),
    "missing key": (_edit_json(lambda h: h.pop("rate_hz")), "rate_hz: field required"),
    "newer version": (_edit_json(lambda h: h.update(version=2, extra=1)), "format 2.*update pipenav"),
    "other format": (_edit_json(lambda h: h.update(format="x")), "format"),
    "number as text": (_edit_json(lambda h: h.update(rate_hz="10")), "rate_hz"),
    "infinite number": (_edit_json(lambda h: h["robot"]["actuators"]["hinge"].update(armature=1e999)), "finite"),
    "other observation": (_edit_json(lambda h: h["observation"].reverse()), "observation, action or rate differ"),
    "other action": (_edit_json(lambda h: h["action"][0].update(scale=1e9)), "observation, action or rate differ"),
    "other rate": (_edit_json(lambda h: h.update(rate_hz=100.0)), "observation, action or rate differ"),
    "escape codes": (_edit_json(lambda h: h["versions"].update({"\x1b[31m": 1})), r"\?\[31m"),
    "flood": (_edit_json(lambda h: h.update(format="x" * 500_000)), r"x\.\.\."),
    "no safetensors": (lambda m: m.update({"policy.safetensors": b"junk"}), "unreadable policy.safetensors"),
    "no layers": (_edit_weights(lambda t: [t.pop(k) for k in list(t) if "layer" in k]), "instead of layer0"),
    "layer left out": (_edit_weights(lambda t: [t.pop(k) for k in list(t) if "layer1" in k]), "instead of layer0"),
    "shapes": (_edit_weights(lambda t: t.update({"layer1.weight": t["layer1.weight"].T.copy()})), "layer1.weight of"),
    "outputs": (_edit_weights(lambda t: t.update({"layer2.bias": np.zeros(9, np.float32)})), "layer2.bias of shape"),
    "bias matrix": (_edit_weights(lambda t: t.update({"layer0.bias": t["layer0.bias"][None]})), "layer0.bias of shape"),
    "float64": (_edit_weights(lambda t: t.update({"layer0.bias": np.zeros(32)})), "float64 instead of float32"),
    "nan": (_edit_weights(lambda t: t["layer1.weight"].fill(np.nan)), "not finite"),
    "infinite": (_edit_weights(lambda t: t["layer2.bias"].fill(np.inf)), "not finite"),
    "other scale": (_edit_weights(lambda t: t["observation_scale"].__imul__(2.0)), "another observation scale"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_member_is_refused_in_a_sentence(good: Path, tmp_path: Path, case: str) -> None:
    breaks, expected = BROKEN[case]
    members = _members(good)
    breaks(members)
    text = _refusal(_zip(tmp_path / "broken.zip", members))
    assert re.search(expected, text), text
    assert len(text) < 700
    assert text.isprintable()


# Writing


@pytest.mark.parametrize("name", ["os.fsync", "pathlib.Path.replace", "pathlib.Path.write_bytes"])
def test_a_full_disk_leaves_the_old_file(
    good: Path, model: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    path = tmp_path / "best.zip"
    path.write_bytes(good.read_bytes())

    def fail(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(name, fail)
        with pytest.raises(FileProblem, match=r"cannot write .*best\.zip: No space left on device"):
            save_policy(path, model, _header())
    assert path.read_bytes() == good.read_bytes()
    assert list(tmp_path.iterdir()) == [path]


def test_a_missing_folder_is_named(model: Any, tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="cannot write"):
        save_policy(tmp_path / "nowhere" / "best.zip", model, _header())


def test_what_cannot_be_loaded_is_not_written(tmp_path: Path) -> None:
    import torch

    sick = _ppo()
    with torch.no_grad():
        sick.policy.action_net.bias[0] = float("nan")
    with pytest.raises(PolicyFileError, match="not finite"):
        save_policy(tmp_path / "best.zip", sick, _header())
    with pytest.raises(PipenavError, match="tanh"):
        save_policy(tmp_path / "best.zip", _ppo(activation_fn=torch.nn.ReLU), _header())
    assert not list(tmp_path.iterdir())


def test_the_documented_snippet_reads_the_file(
    good: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "docs/formats/policy-file.md").read_text(encoding="utf-8")
    snippet = text.split("```python\n")[1].split("```")[0]
    monkeypatch.chdir(good.parent)
    exec(compile(snippet, "docs/formats/policy-file.md", "exec"), {})
    found = [float(x) for x in re.findall(r"float32\(([-\d.e]+)\)", capsys.readouterr().out)]
    np.testing.assert_allclose(found, load_policy(good).act(np.zeros((1, SIZE)))[0], atol=1e-5)
