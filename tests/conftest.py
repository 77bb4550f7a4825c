"""Makes the package `helpers` importable for all tests."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

sys.path.append(str(Path(__file__).parent))
pytest.register_assert_rewrite("helpers")


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
