"""The wheel carries the data: it is found from an installed copy too, not only from a checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from pipenav.learning.config import preset_names
from pipenav.pipes.corner_sets import corner_set_names
from pipenav.policies.policy import policy_names
from pipenav.robots.variants import robot_names
from pipenav.storage import shipped

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parent.parent

LIST_ALL = """
from pipenav.storage import shipped
from pipenav.pipes.corner_sets import parse_corners, corner_set_names
from pipenav.policies.policy import load_policy, policy_names, resolve_policy
from pipenav.robots.robot import load_robot
from pipenav.robots.variants import robot_names
from pipenav.learning.config import load_config, preset_names
for name in corner_set_names(): parse_corners([name])
for name in robot_names(): load_robot(name)
for name in preset_names(): load_config(name)
for name in policy_names(): load_policy(resolve_policy(name))
print(shipped.data_root())
print(corner_set_names(), robot_names(), preset_names(), policy_names())
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)], cwd=ROOT, check=True)
    (built,) = folder.glob("*.whl")
    return built


def test_everything_shipped_is_found_and_loads_from_an_unpacked_wheel(wheel: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    code = f"import sys; sys.path.insert(0, {str(tmp_path / 'site')!r})\n{LIST_ALL}"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    root, names = done.stdout.strip().splitlines()
    assert Path(root) == tmp_path / "site" / "pipenav" / "_data"
    assert names == f"{corner_set_names()} {robot_names()} {preset_names()} {policy_names()}"


CORNER = ("--pipes", "d=100,angle=75")
SMALL = ("--set=learner.robots=16", "--set=learner.rollout_steps=16", "--set=learner.batch_size=64")
COMMANDS = [
    ("--help",),
    ("backends",),
    ("gen-pipe", "--d", "100", "--angle", "75", "--out", "demo"),
    ("train", "--steps", "512", *CORNER, *SMALL, "--set=check.episodes=2", "--out", "demo/run"),
    ("eval", "--policy", "demo/run/last.zip", *CORNER, "--episodes", "1", "--out", "demo/eval"),
    ("eval", "--policy", "arm", *CORNER, "--episodes", "1", "--out", "demo/arm"),
]


def test_an_unpacked_wheel_runs_the_demo_and_the_help_without_the_checkout(wheel: Path, tmp_path: Path) -> None:
    site, work = tmp_path / "site", tmp_path / "work"
    work.mkdir()
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    assert (site / "pipenav" / "py.typed").is_file()
    environment = os.environ | {"PYTHONPATH": str(site)}
    python = [sys.executable, "-P"]
    where = [*python, "-c", "import pipenav, pipenav_mujoco; print(pipenav.__file__, pipenav_mujoco.__file__)"]
    found = subprocess.run(where, cwd=work, env=environment, capture_output=True, text=True, check=True).stdout
    assert found.split() == [str(site / name / "__init__.py") for name in ("pipenav", "pipenav_mujoco")]
    for args in COMMANDS:
        command = [*python, "-m", "pipenav", *args]
        done = subprocess.run(command, cwd=work, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, (args, done.stderr)
        assert str(ROOT) not in done.stdout + done.stderr


def test_constraints_allow_only_a_build_of_torch_without_cuda() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert 'torch==2.13.0+cpu ; sys_platform == "linux"' in pins
    assert not [line for line in pins if line.startswith(("nvidia", "cuda", "triton", "-"))]
    assert len([line for line in pins if line.startswith("torch=")]) == 2


def test_the_wheel_declares_command_and_backends(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (entry_points,) = [name for name in archive.namelist() if name.endswith("entry_points.txt")]
        text = archive.read(entry_points).decode()
        assert "pipenav_mujoco/__init__.py" in archive.namelist()
    assert "pipenav = pipenav.cli:main" in text
    assert "[pipenav.backends]" in text
    assert "mujoco = pipenav_mujoco:MujocoBackend" in text


def test_a_checkout_reads_its_own_folders() -> None:
    assert shipped.data_root() == ROOT
