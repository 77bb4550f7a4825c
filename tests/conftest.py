"""Fixtures of several tests, and the package `helpers` made importable."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from pipenav_hardware.emulator.client import Emulator

    from pipenav.experiments.plan import ExperimentPlan
    from pipenav.motions.trajectory import Trajectory

# nohup starts programs with SIGHUP ignored, and their children inherit that: tests that send one would see nothing.
signal.signal(signal.SIGHUP, signal.SIG_DFL)

sys.path.append(str(Path(__file__).parent))
pytest.register_assert_rewrite("helpers")
# A loaded machine is no fault of the code, and the same tests run on every machine; `make explore` draws others.
settings.register_profile("default", deadline=None, derandomize=True)
settings.register_profile("quick", settings.get_profile("default"), max_examples=20)
settings.register_profile("explore", deadline=None)
settings.load_profile("default")
pytest_plugins = ["helpers.workshop"]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A headless browser; skips the test where there is none."""
    from helpers.browser import started_browser

    with started_browser() as started:
        yield started


@pytest.fixture
def helpers_for_children(monkeypatch: pytest.MonkeyPatch) -> None:
    """Children find the module of a worker that only tests have."""
    path = [str(Path(__file__).resolve().parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path))


@pytest.fixture(scope="session")
def ppo() -> Any:
    """A small policy that has not been trained, as Stable-Baselines3's PPO."""
    from helpers.policy_files import untrained_ppo

    return untrained_ppo()


@pytest.fixture(scope="session")
def policy_file(ppo: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of that policy."""
    from helpers.policy_files import some_header

    from pipenav.policies import save_policy

    path = tmp_path_factory.mktemp("policy") / "best.zip"
    save_policy(path, ppo, some_header())
    return path


@pytest.fixture(scope="session")
def front() -> Trajectory:
    """The recording of a front half that passes a right turn."""
    from pipenav.pipes import PipeCorner
    from pipenav.policies import open_controller
    from pipenav.recording.record import RecordingSettings, record_task

    simulator = RecordingSettings("mujoco", {"timestep": 0.005, "threads": 1})
    return record_task(open_controller("arm"), "arm", PipeCorner.of(100, 75, "right"), 0, 0, simulator)


@pytest.fixture(scope="session")
def thesis_plan(tmp_path_factory: pytest.TempPathFactory) -> ExperimentPlan:
    """A folder of results that holds the thesis's own figures."""
    from helpers.thesis_results import write_thesis_results

    return write_thesis_results(tmp_path_factory.mktemp("thesis"))


@pytest.fixture
def emulator() -> Iterator[Emulator]:
    """An emulated arm on a bench, in a process of its own."""
    from helpers.emulated import ROBOT
    from pipenav_hardware.emulator.client import Emulator
    from pipenav_hardware.emulator.config import EmulatorSettings

    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0)) as started:
        yield started
