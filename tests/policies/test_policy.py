"""The policy file: it does what Stable-Baselines3's own policy does, and survives strangers, cuts and full disks."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.checkout import ROOT
from helpers.policy_files import (
    ROBOT,
    SIZE,
    TASK,
    Still,
    members_of,
    random_observations,
    some_header,
)

from pipenav.errors import UnknownName
from pipenav.policies.file import PolicyFileError
from pipenav.policies.header import header_for
from pipenav.policies.policy import Policy, load_policy, policy_names, resolve_policy, save_policy
from pipenav.tasks.registry import task_of


def test_acts_as_the_model_it_was_saved_from(policy_file: Path, ppo: Any) -> None:
    observations = random_observations(500)
    expected, _ = ppo.predict(observations, deterministic=True)
    actions = load_policy(policy_file).act(observations)
    assert actions.dtype == np.float32
    assert (np.abs(expected) < 0.9).any()
    assert (np.abs(expected) == 1.0).any()
    np.testing.assert_allclose(actions, expected, rtol=0.0, atol=1e-5)


def test_stable_baselines_opens_the_file(policy_file: Path, ppo: Any) -> None:
    from stable_baselines3 import PPO

    again = PPO.load(policy_file, device="cpu")
    observations = random_observations(20)
    np.testing.assert_array_equal(
        again.predict(observations, deterministic=True)[0], ppo.predict(observations, deterministic=True)[0]
    )
    PPO.load(policy_file, env=Still(), device="cpu").learn(8)


@pytest.mark.parametrize("count", [1, 2, 3, 17, 64, 129])
def test_a_row_does_not_depend_on_the_others(policy_file: Path, count: int) -> None:
    policy, observations = load_policy(policy_file), random_observations(300)
    everything = policy.act(observations)
    np.testing.assert_array_equal(policy.act(observations[100 : 100 + count]), everything[100 : 100 + count])
    np.testing.assert_array_equal(policy.act(np.asfortranarray(observations)), everything)


def test_header_and_scale_come_back(policy_file: Path) -> None:
    policy = load_policy(policy_file)
    header = policy.header
    assert header.model_dump() == some_header().model_dump()
    assert sum(part.size for part in header.observation) == SIZE
    assert [part.joint for part in header.action] == [joint.name for joint in ROBOT.joints]
    assert [part.unit for part in header.action] == ["N", "N m", "N m", "N m"]
    assert [part.scale for part in header.action] == pytest.approx(ROBOT.effort_limits)
    np.testing.assert_allclose(policy.observation_scale, task_of(TASK).observation_scale(ROBOT), rtol=1e-6)


def test_nothing_of_the_training_machine_is_in_the_file(policy_file: Path) -> None:
    content = b"".join(members_of(policy_file).values())
    assert os.uname().release.encode() not in content
    assert b"system_info.txt" not in policy_file.read_bytes()


def test_loading_imports_neither_torch_nor_stable_baselines(policy_file: Path) -> None:
    code = (
        "import sys; from pipenav.policies.policy import load_policy; import numpy as np\n"
        f"policy = load_policy({str(policy_file)!r}); policy.act(np.zeros((1, {SIZE})))\n"
        "assert not {'torch', 'stable_baselines3', 'pickle5', 'mujoco'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


# What the policy was made for


def test_its_own_robot_and_task_are_accepted(policy_file: Path) -> None:
    policy = load_policy(policy_file)
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
def test_a_mismatch_is_refused_by_name(
    policy_file: Path, robot: dict[str, Any], task: dict[str, Any], expected: str
) -> None:
    with pytest.raises(PolicyFileError, match=expected):
        load_policy(policy_file).require(robot=ROBOT.model_copy(update=robot), task=TASK.model_copy(update=task))


def test_another_position_step_is_refused(ppo: Any, tmp_path: Path) -> None:
    task = TASK.model_copy(update={"control": "position"})
    save_policy(tmp_path / "best.zip", ppo, header_for(ROBOT, task, [], {}))
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


def test_the_documented_snippet_reads_the_file(
    policy_file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "docs/formats/policy-file.md").read_text(encoding="utf-8")
    snippet = text.split("```python\n")[1].split("```")[0]
    monkeypatch.chdir(policy_file.parent)
    exec(compile(snippet, "docs/formats/policy-file.md", "exec"), {})
    found = [float(x) for x in re.findall(r"float32\(([-\d.e]+)\)", capsys.readouterr().out)]
    np.testing.assert_allclose(found, load_policy(policy_file).act(np.zeros((1, SIZE)))[0], atol=1e-5)
