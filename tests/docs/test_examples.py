"""The programs in examples/ run, and the example plugin is installed, listed and kept to the contract."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.doc_pages import ROOT
from helpers.documented import pipenav

from pipenav.testing import ALL_LAWS

EXAMPLES = ROOT / "examples"

PROGRAMS = {
    "train.py": (["1536", "trained"], "success of the best check", "trained/best.zip"),
    "evaluate.py": (["1", "evaluated"], "90 mm, 60 deg, right: 1 of 1", "evaluated/eval.json"),
    "run_onnx.py": (["arm.onnx"], "basic, reach, control by position, 10 Hz", None),
    "own_backend.py": ([], f"{len(ALL_LAWS)} of {len(ALL_LAWS)} laws kept", None),
}
"""Arguments for a tiny size, what the program prints, and what it writes."""


def test_every_program_is_tested() -> None:
    assert {path.name for path in EXAMPLES.glob("*.py")} == set(PROGRAMS)


@pytest.mark.slow
@pytest.mark.parametrize("name", PROGRAMS)
def test_program(name: str, lag_plugin: Path, tmp_path: Path) -> None:
    arguments, printed, written = PROGRAMS[name]
    if name == "run_onnx.py":
        pytest.importorskip("onnxruntime")
        export = ("export", "--policy", "arm", "--to", "onnx", "--observations", "20", "--pipes", "d=90,angle=90")
        assert pipenav(*export, "--out", str(tmp_path / "arm.onnx")) == 0
    command = [sys.executable, str(EXAMPLES / name), *arguments]
    result = subprocess.run(
        command, cwd=tmp_path, env=environment(lag_plugin), capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert printed in result.stdout
    assert written is None or (tmp_path / written).is_file()


def test_the_exported_policy_needs_no_pipenav() -> None:
    """NumPy, onnxruntime and the standard library, in 30 lines at most."""
    text = (EXAMPLES / "run_onnx.py").read_text(encoding="utf-8")
    roots = {line.split()[1].partition(".")[0] for line in text.splitlines() if line.startswith(("import ", "from "))}
    assert roots == {"json", "sys", "numpy", "onnxruntime"}
    assert len(text.splitlines()) <= 30


@pytest.mark.slow
def test_plugin_is_listed(lag_plugin: Path, capfd: pytest.CaptureFixture[str]) -> None:
    del lag_plugin
    assert pipenav("backends") == 0
    line = next(line for line in capfd.readouterr().out.splitlines() if line.startswith("lag"))
    assert line.split() == ["lag", "yes", "pipenav-lag", "0.1.0"]


@pytest.mark.slow
def test_plugin_settings_are_listed(lag_plugin: Path, capfd: pytest.CaptureFixture[str]) -> None:
    del lag_plugin
    assert pipenav("backends", "lag") == 0
    assert "time constant" in capfd.readouterr().out


@pytest.mark.slow
def test_plugin_passes_its_own_tests(lag_plugin: Path, tmp_path: Path) -> None:
    """Installed as a stranger installs it, and run outside our checkout."""
    tests = shutil.copytree(EXAMPLES / "backend/tests", tmp_path / "tests")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tests)]
    result = subprocess.run(
        command, cwd=tmp_path, env=environment(lag_plugin), capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stdout
    assert "passed" in result.stdout
    assert "skipped" not in result.stdout


def environment(*more: Path) -> dict[str, str]:
    """The environment of a program that finds this pipenav, as this process does, and these folders."""
    path = [str(ROOT), str(ROOT / "plugins"), *map(str, more)]
    return os.environ | {"PYTHONPATH": os.pathsep.join([*path, os.environ.get("PYTHONPATH", "")])}
