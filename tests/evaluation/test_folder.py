"""Folders of evaluations: different ones have different names, and none replaces another."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from helpers.evaluations import BARE
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.folder import check_folder, default_folder
from pipenav.evaluation.report import write_evaluation
from pipenav.evaluation.results import Evaluation
from pipenav.storage.shipped import policies_dir

CHANGES: list[Mapping[str, Any]] = [
    {"seed": 3},
    {"episodes": 100},
    {"backend": "pybullet"},
    {"options": {"timestep": 0.001}},
    {"options": {"timestep": 0.002}},
    {"disturb": "real-world"},
    {"stage": "reach-rear"},
    {"stage": "passage"},
    {"stage": "passage", "variant": "thesis"},
    {"pipes": ("thesis",)},
    {"pipes": ("d=90,angle=60", "d=90,angle=70")},
    {"policy": "runs/arm/best.zip"},
    {"policy": "runs/arm/last.zip"},
    {"policy": "high-fidelity"},
    {"policy": "baseline:random"},
    {"policy": "baseline:random", "robot": "high-fidelity"},
    {"policy": "baseline:random", "robot": "mine/robot.toml"},
    {"policy": None, "stage": "locate"},
    {"policy": None, "stage": "locate", "variant": "thesis"},
    {"policy": None, "stage": "locate", "robot": "high-fidelity"},
]
PLAIN = EvaluationConfig(policy="arm")


def changed(change: Mapping[str, Any]) -> EvaluationConfig:
    return EvaluationConfig(**{"policy": "arm", **change})


def evaluated(config: EvaluationConfig) -> Evaluation:
    return BARE.model_copy(update={"config": config})


def test_different_evaluations_have_different_folders() -> None:
    folders = [default_folder(config) for config in (PLAIN, *map(changed, CHANGES))]
    assert len(set(folders)) == len(folders)
    assert not any(folder.is_absolute() for folder in folders)


def test_a_shipped_policy_never_meets_a_training_of_its_name() -> None:
    assert default_folder(PLAIN) == Path("runs/shipped-arm/eval-working-range")
    assert default_folder(changed({"policy": "runs/arm/best.zip"})) == Path("runs/arm/eval-working-range")
    by_path = changed({"policy": str(policies_dir() / "arm" / "best.zip")})
    assert default_folder(by_path) == default_folder(PLAIN)


@given(st.lists(st.text(min_size=1, max_size=60), min_size=1, max_size=40))
def test_names_of_folders_suit_every_file_system(pipes: list[str]) -> None:
    name = default_folder(changed({"pipes": tuple(pipes)})).name
    assert len(name) <= 120
    assert "/" not in name
    assert name.startswith("eval")


@pytest.fixture(scope="module")
def plain_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the evaluation with default settings."""
    folder = tmp_path_factory.mktemp("plain")
    write_evaluation(folder, evaluated(PLAIN))
    return folder


@pytest.mark.parametrize("change", CHANGES)
def test_another_evaluation_is_refused_by_its_difference(change: Mapping[str, Any], plain_folder: Path) -> None:
    check_folder(plain_folder, PLAIN)
    with pytest.raises(PipenavError, match="holds another evaluation") as refused:
        check_folder(plain_folder, changed(change))
    assert any(f"{key} " in str(refused.value) for key in change)


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
def test_the_same_evaluation_may_be_repeated(change: Mapping[str, Any], tmp_path: Path) -> None:
    write_evaluation(tmp_path, evaluated(changed(change)))
    check_folder(tmp_path, changed(change))


@pytest.mark.parametrize("named", ["runs/arm/best.zip", "./runs/arm/best.zip", "best.zip", "../arm/best.zip"])
def test_a_file_may_be_named_from_another_folder(named: str, tmp_path: Path) -> None:
    write_evaluation(tmp_path, evaluated(changed({"policy": "runs/arm/best.zip"})))
    check_folder(tmp_path, changed({"policy": named}))
    with pytest.raises(PipenavError, match="policy "):
        check_folder(tmp_path, changed({"policy": "runs/other/best.zip"}))


def test_the_robot_that_a_policy_brings_may_be_named(tmp_path: Path) -> None:
    write_evaluation(tmp_path, evaluated(PLAIN))
    check_folder(tmp_path, changed({"robot": BARE.robot}))


def test_what_cannot_be_read_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "eval.json").write_text("{}")
    with pytest.raises(PipenavError, match=r"move .* away, or choose another --out"):
        check_folder(tmp_path, PLAIN)
    check_folder(tmp_path / "new", PLAIN)
