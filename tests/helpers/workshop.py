"""Fixtures of the tests of documentation: the folder in which documented commands find all that they read."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from helpers.doc_pages import PAGES, ROOT, blocks
from helpers.documented import Options, pipenav, tiny

FIRST_TRAININGS = {"runs/arm": "arm", "runs/pirate-strong-gravity": "pirate-strong-gravity"}
"""Training folders that a command goes on with, and the preset of each."""

POLICIES = {
    "best.zip": "real-setup",
    "runs/real-setup": "real-setup",
    **dict.fromkeys(("runs/first", "runs/my-robot", "runs/torque-0"), "arm"),
}
"""Policies that a command before would have trained, and the shipped one that stands in."""

ROLLED_ROUTE = """
schema = 1
diameter_mm = 100
first_straight_mm = 1000

[[corners]]
angle_deg = 120
turn = "left"
roll_deg = 90
straight_mm = 1000
"""
"""The shortest route that leaves the plane."""


def named_files() -> dict[str, str]:
    """Contents of the files that pages show: blocks of TOML right below a text that ends with the file's name."""
    found = {}
    for page in PAGES:
        lines = page.read_text(encoding="utf-8").splitlines()
        for block in blocks(page):
            above = " ".join(lines[max(0, block.line - 5) : block.line - 2])
            names = re.findall(r"`([\w-]+\.toml)`", above)
            if block.language == "toml" and names:
                found.setdefault(names[-1], block.code)
    return found


@pytest.fixture(scope="session")
def lag_plugin(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The example plugin, installed into a folder of its own that stands in the path."""
    target = tmp_path_factory.mktemp("plugin")
    command = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-build-isolation"]
    source = shutil.copytree(ROOT / "examples/backend", tmp_path_factory.mktemp("source") / "backend")
    subprocess.run([sys.executable, *command, "--target", target, source], check=True)
    sys.path.append(str(target))
    yield target
    sys.path.remove(str(target))


@pytest.fixture(scope="session")
def shown_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files that pages show, a robot and some policies."""
    folder = tmp_path_factory.mktemp("shown")
    for name, text in named_files().items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "my-rolled-route.toml").write_text(ROLLED_ROUTE, encoding="utf-8")
    shutil.copy(ROOT / "models/robots/basic/robot.toml", folder / "my-robot.toml")
    for place, policy in POLICIES.items():
        file = folder / place if place.endswith(".zip") else folder / place / "best.zip"
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / "models/policies" / policy / "best.zip", file)
    return folder


@pytest.fixture(scope="session")
def workshop(shown_files: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all that documented commands read, except what only a mission leaves behind."""
    folder = shutil.copytree(shown_files, tmp_path_factory.mktemp("workshop") / "workshop")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for place, preset in FIRST_TRAININGS.items():
            words = Options.of(("pipenav", *tiny(("pipenav", "train", "--preset", preset))))
            assert pipenav(*words.without({"--out"}).plus(("--out", place)).argv) == 0
        assert pipenav("view", "--policy", "arm", "--out", "front.csv") == 0
        tiny_eval = ("eval", "--policy", "arm", "--pipes", "d=100,angle=90", "--episodes", "1")
        assert pipenav(*tiny_eval, "--out", "evaluation") == 0
        assert pipenav("mirror-rear", "--trajectory", "front.csv", "--out", "rear.csv") == 0
        for place in ("alone", "shared", "composed", "by-hand", "alone-1", "shared-1", "by-hand-1"):
            script = ("--robot", "basic", "--operator", "scripted", "--pipes", "d=100,angle=90", "--no-record")
            assert pipenav("drive", *script, "--out", place) == 0
    return folder


@pytest.fixture(scope="session")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of one whole mission of an emulated arm."""
    folder = tmp_path_factory.mktemp("mission")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        words = ("run-real", "--emulate", "--d", "130", "--angle", "90", "--yes", "--patience", "10")
        assert pipenav(*words, "--out", "runs/real-1") == 0
    return folder


@pytest.fixture
def here(workshop: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the workshop, in which the test is."""
    folder = tmp_path / "here"
    shutil.copytree(workshop, folder)
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def among_shown_files(shown_files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the files that pages show, in which the test is."""
    folder = tmp_path / "shown"
    shutil.copytree(shown_files, folder)
    monkeypatch.chdir(folder)
    return folder
