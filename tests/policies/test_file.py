"""Policy files: what is broken or hostile is refused in one sentence, and a file appears whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import pickle
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import safetensors.numpy
from helpers.policy_files import (
    Members,
    members_of,
    random_observations,
    refusal,
    some_header,
    untrained_ppo,
    zipped,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipenav.errors import FileProblem, PipenavError
from pipenav.policies.file import PolicyFileError
from pipenav.policies.policy import load_policy, save_policy


class Bomb:
    """Unpickled, it leaves a mark."""

    def __init__(self, mark: Path) -> None:
        self._mark = mark

    def __reduce__(self) -> Any:
        return Path.touch, (self._mark,)


def test_pickles_in_the_file_never_run(policy_file: Path, tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    bomb = pickle.dumps(Bomb(mark))
    members = members_of(policy_file)
    for name in [name for name in members if name not in ("pipenav.json", "policy.safetensors")]:
        members[name] = bomb
    actions = load_policy(zipped(tmp_path / "best.zip", members)).act(random_observations(3))
    np.testing.assert_array_equal(actions, load_policy(policy_file).act(random_observations(3)))
    for name in ("pipenav.json", "policy.safetensors"):
        refusal(zipped(tmp_path / "bad.zip", members | {name: bomb}))
    assert not mark.exists()
    pickle.loads(bomb)
    assert mark.exists()  # the bomb is a real one


def test_a_truncated_file_is_refused(policy_file: Path, tmp_path: Path) -> None:
    content, path = policy_file.read_bytes(), tmp_path / "cut.zip"
    for length in {0, 1, 2, 4, 21, len(content) - 1, *range(0, len(content), 997)}:
        path.write_bytes(content[:length])
        refusal(path)


@pytest.mark.slow
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_flipped_bytes_never_crash(policy_file: Path, tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray(policy_file.read_bytes())
    # Half of the positions in the last kilobytes, where our members and the zip's directory lie.
    anywhere = st.integers(0, len(content) - 1)
    late = st.integers(max(0, len(content) - 14_000), len(content) - 1)
    for position in data.draw(st.lists(anywhere | late, min_size=1, max_size=8)):
        content[position] = data.draw(st.integers(0, 255))
    path = tmp_path / "flipped.zip"
    path.write_bytes(bytes(content))
    try:
        assert np.isfinite(load_policy(path).act(random_observations(2))).all()
    except PipenavError as error:
        assert str(path) in str(error)


@pytest.mark.slow
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_flipped_bytes_inside_our_members_never_crash(policy_file: Path, tmp_path: Path, data: st.DataObject) -> None:
    members = members_of(policy_file)
    name = data.draw(st.sampled_from(["pipenav.json", "policy.safetensors"]))
    content = bytearray(members[name])
    positions = st.integers(0, len(content) - 1) | st.integers(0, min(700, len(content) - 1))
    for position in data.draw(st.lists(positions, min_size=1, max_size=4)):
        content[position] = data.draw(st.integers(0, 255))
    path = zipped(tmp_path / "flipped.zip", members | {name: bytes(content)})  # with checksums that fit
    try:
        load_policy(path).act(random_observations(2))
    except PipenavError as error:
        assert str(path) in str(error)


def test_two_members_of_one_name_are_refused(policy_file: Path, tmp_path: Path) -> None:
    path = zipped(tmp_path / "best.zip", members_of(policy_file))
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.writestr("pipenav.json", "{}")
    assert "two members of one name" in refusal(path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pipenav.json", "policy.safetensors"])
@pytest.mark.parametrize("packing", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_zip_bomb_is_refused_before_it_unpacks(policy_file: Path, tmp_path: Path, name: str, packing: int) -> None:
    members = members_of(policy_file)
    del members[name]
    path = zipped(tmp_path / "bomb.zip", members)
    with zipfile.ZipFile(path, "a", packing) as archive:
        archive.writestr(name, bytes(64 << 20))
    assert path.stat().st_size < 1 << 20
    assert f"holds a {name} that is larger than" in refusal(path)


def test_a_member_that_lies_about_its_size_is_refused(policy_file: Path, tmp_path: Path) -> None:
    members = members_of(policy_file)
    whole = members.pop("pipenav.json")
    path = zipped(tmp_path / "lie.zip", members)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("pipenav.json", bytes(64 << 20))
    size = (64 << 20).to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(size, len(whole).to_bytes(4, "little")))
    refusal(path)


def test_an_oversized_file_is_refused(policy_file: Path, tmp_path: Path) -> None:
    path = tmp_path / "large.zip"
    path.write_bytes(policy_file.read_bytes() + bytes(17 << 20))
    assert "larger than 16 MiB" in refusal(path)


def test_path_traversal_writes_nothing(policy_file: Path, tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    path = zipped(folder / "best.zip", members_of(policy_file) | {"../../evil": b"x", "/evil": b"x"})
    load_policy(path)
    assert sorted(p for p in tmp_path.rglob("*") if p.is_file()) == [path]


def test_a_zip_of_stable_baselines_alone_is_named(ppo: Any, tmp_path: Path) -> None:
    ppo.save(tmp_path / "foreign.zip")
    assert "made by Stable-Baselines3 alone" in refusal(tmp_path / "foreign.zip")


def test_no_file_no_zip_no_policy(tmp_path: Path) -> None:
    assert "is a folder: name the file in it" in refusal(tmp_path)
    assert "No such file" in refusal(tmp_path / "missing.zip")
    text = tmp_path / "text.zip"
    text.write_text("hello")
    assert "is not a zip file" in refusal(text)
    assert "not of a policy" in refusal(zipped(tmp_path / "other.zip", {"a": b"b"}))
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
    "missing key": (_edit_json(lambda h: h.pop("rate_hz")), "rate_hz: this key is missing, add it"),
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
def test_a_broken_member_is_refused_in_a_sentence(policy_file: Path, tmp_path: Path, case: str) -> None:
    breaks, expected = BROKEN[case]
    members = members_of(policy_file)
    breaks(members)
    text = refusal(zipped(tmp_path / "broken.zip", members))
    assert re.search(expected, text), text
    assert len(text) < 700
    assert text.isprintable()


@pytest.mark.parametrize("name", ["os.fsync", "pathlib.Path.replace", "pathlib.Path.write_bytes"])
def test_a_full_disk_leaves_the_old_file(
    policy_file: Path, ppo: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    path = tmp_path / "best.zip"
    path.write_bytes(policy_file.read_bytes())

    def fail(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(name, fail)
        with pytest.raises(FileProblem, match=r"cannot write .*best\.zip: No space left on device"):
            save_policy(path, ppo, some_header())
    assert path.read_bytes() == policy_file.read_bytes()
    assert list(tmp_path.iterdir()) == [path]


def test_a_missing_folder_is_named(ppo: Any, tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="cannot write"):
        save_policy(tmp_path / "nowhere" / "best.zip", ppo, some_header())


def test_what_cannot_be_loaded_is_not_written(tmp_path: Path) -> None:
    import torch

    sick = untrained_ppo()
    with torch.no_grad():
        sick.policy.action_net.bias[0] = float("nan")
    with pytest.raises(PolicyFileError, match="not finite"):
        save_policy(tmp_path / "best.zip", sick, some_header())
    with pytest.raises(PipenavError, match="tanh"):
        save_policy(tmp_path / "best.zip", untrained_ppo(activation_fn=torch.nn.ReLU), some_header())
    assert not list(tmp_path.iterdir())
