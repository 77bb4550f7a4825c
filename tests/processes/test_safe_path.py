"""No process of pipenav runs or reads what lies in the current folder."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pipenav.cli import COMMANDS

NAMES = (
    "__future__, concurrent, ctypes, dynamixel_sdk, gymnasium, imageio_ffmpeg, json, logging, matplotlib, "
    "mujoco, multiprocessing, numpy, onnx, onnxruntime, optuna, PIL, pipenav_hardware, pipenav_mujoco, "
    "pipenav_pybullet, pybullet, pydantic, queue, ray, rich, runpy, safetensors, scipy, serial, shapely, signal, "
    "sitecustomize, stable_baselines3, subprocess, tempfile, tensorboard, threading, torch, trimesh, typer, "
    "usercustomize, uuid"
)
LIBRARIES = NAMES.split(", ")

LOADED_BY_PYTHON = ("contextlib", "functools", "warnings")
"""Modules that `python -m` itself imports with the current folder on the path; the installed command does not."""

CORNER = ("--pipes", "d=100,angle=90")
TINY = ("--set=learner.robots=16", "--set=learner.rollout_steps=16", "--set=learner.batch_size=64")

SEARCH = ("--space", "arm", "--jobs", "2", "--steps", "512", '--set=pipes=["d=100,angle=90"]', *TINY)
EXAMPLE = str(Path(__file__).resolve().parents[2] / "examples/schutterwald/network.json")

RUNS: dict[str, tuple[str, ...]] = {
    "gen-pipe": ("gen-pipe", "--d", "100", "--angle", "90", "--out", "pipe"),
    "train": ("train", "--steps", "512", *CORNER, *TINY, "--set=check.episodes=2", "--out", "trained"),
    "eval": ("eval", "--policy", "arm", *CORNER, "--episodes", "1", "--out", "evaluated"),
    "eval on pybullet": ("eval", "--policy", "arm", *CORNER, "--episodes", "1", "--backend", "pybullet", "--out", "e2"),
    "eval in processes": ("eval", "--policy", "arm", *CORNER, "--episodes", "65", "--jobs", "2", "--out", "e3"),
    "eval on a cluster": ("eval", "--policy", "arm", *CORNER, "--episodes", "65", "--cluster", "auto", "--out", "e4"),
    "view": ("view", "--policy", "arm", *CORNER, "--out", "film.mp4", "--out", "front.csv"),
    "locate-target": ("locate-target", "--d", "100", "--angle", "90", "--out", "located"),
    "certify": ("certify", "--robot", "basic", *CORNER, "--out", "certified"),
    "mirror-rear": ("mirror-rear", "--help"),
    "experiment": ("experiment", "f", "--seeds", "1", "--steps", "512", "--episodes", "1", "--out", "tried"),
    "export": ("export", "--policy", "arm", "--to", "onnx", "--observations", "50", *CORNER, "--out", "arm.onnx"),
    "run-real": ("run-real", "--emulate", "--allow-slow-bus", "--patience", "8", "--ticks", "5", "--out", "real"),
    "drive": ("drive", "--operator", "scripted", "--robot", "basic", *CORNER, "--out", "driven"),
    "compare": ("compare", "--help"),
    "hw-check": ("hw-check", "--help"),
    "calibrate": ("calibrate", "--help"),
    "replay": ("replay", "--help"),
    "backends": ("backends",),
    "compare-backends": ("compare-backends", "--robot", "basic", "--other", "mujoco", "--out", "compared"),
    "robots": ("robots",),
    "presets": ("presets",),
    "list": ("list", "presets"),
    "survey": ("survey", EXAMPLE, "--check"),
    "tune": ("tune", *SEARCH, "--trials", "2", "--again", "0", "--objective", "success", "--out", "searched"),
}


def plant(folder: Path, names: tuple[str, ...] | list[str]) -> Path:
    """Lay modules of these names into a folder, which make a file there when they are run; the file."""
    marker = folder / "decoys"
    for name in names:
        text = f"open({str(marker)!r}, 'a').write({name!r} + '\\n')\n"
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    (folder / "matplotlibrc").write_bytes(b"\xff no text, and no setting")
    return marker


def harmed(marker: Path) -> str:
    return marker.read_text(encoding="utf-8") if marker.exists() else ""


def test_every_command_is_tried() -> None:
    assert {arguments[0] for arguments in RUNS.values()} == COMMANDS.keys()


@pytest.mark.slow
@pytest.mark.parametrize("arguments", RUNS.values(), ids=RUNS)
def test_no_command_runs_what_lies_in_the_current_folder(arguments: tuple[str, ...], tmp_path: Path) -> None:
    if "pybullet" in arguments:
        pytest.importorskip("pybullet")
    if "--cluster" in arguments:
        pytest.importorskip("ray")
    marker = plant(tmp_path, LIBRARIES)
    command = [sys.executable, "-m", "pipenav", *arguments]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert not harmed(marker)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "matplotlibrc" not in result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("path", ["", os.pathsep], ids=["as it is", "with an empty entry in PYTHONPATH"])
def test_the_installed_command_runs_nothing_of_the_current_folder(path: str, tmp_path: Path) -> None:
    here, elsewhere = tmp_path / "here", tmp_path / "script.py"
    here.mkdir()
    elsewhere.write_text("from pipenav.cli import main\nmain()\n", encoding="utf-8")
    names = [name for name in (*LIBRARIES, *LOADED_BY_PYTHON) if not (path and name.endswith("customize"))]
    marker = plant(here, [name for name in names if not path or name in ("mujoco", "numpy", "torch")])
    environment = os.environ | {"PYTHONPATH": os.environ.get("PYTHONPATH", "") + path}
    command = [sys.executable, str(elsewhere), "eval", "--policy", "arm", *CORNER, "--episodes", "1"]
    result = subprocess.run(command, cwd=here, env=environment, capture_output=True, text=True)
    assert not harmed(marker)
    assert result.returncode == 0, result.stderr


def test_children_run_nothing_of_the_current_folder(tmp_path: Path) -> None:
    """The parent has the current folder on its own path, as a notebook has."""
    marker = plant(tmp_path, LIBRARIES)
    program = (
        "import sys\n"
        "kept = sys.path[:]\n"
        "sys.path[:] = [entry for entry in sys.path if entry]\n"
        "import numpy\n"
        "from pipenav.processes.children import start_worker\n"
        "sys.path[:] = kept\n"
        "worker = start_worker('helpers.answering')\n"
        "worker.send('hello')\n"
        "print(worker.receive())\n"
        "worker.close()\n"
    )
    helpers = str(Path(__file__).resolve().parents[1])
    path = os.pathsep.join([helpers, "", *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-I", "-c", f"import sys; sys.path[:0] = {path.split(os.pathsep)!r}\n{program}"]
    result = subprocess.run(
        command, cwd=tmp_path, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True
    )
    assert not harmed(marker)
    assert result.stdout == "hello\n", result.stderr
