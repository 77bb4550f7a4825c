"""Variables that a notebook, a server or a shell sets change no result and break no command."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

SETTINGS: dict[str, dict[str, str]] = {
    "notebook": {
        "MPLBACKEND": "module://matplotlib_inline.backend_inline",
        "MUJOCO_GL": "egl",
        "OMP_NUM_THREADS": "1",
        "COLUMNS": "20",
    },
    "server": {
        "MPLBACKEND": "nonsense",
        "MUJOCO_GL": "nonsense",
        "PYOPENGL_PLATFORM": "nonsense",
        "OMP_NUM_THREADS": "3",
        "LANG": "C",
    },
    "ASCII alone": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
}

CORNER = ("--pipes", "d=100,angle=75")
SMALL = ("--set=learner.robots=16", "--set=learner.rollout_steps=16", "--set=learner.batch_size=64")
COMMANDS: dict[str, tuple[str, ...]] = {
    "help": ("eval", "--help"),
    "list": ("list", "policies"),
    "backends": ("backends",),
    "gen-pipe": ("gen-pipe", "--d", "100", "--angle", "75", "--out", "made"),
    "train": ("train", "--steps", "512", *CORNER, *SMALL, "--set=check.episodes=2", "--out", "made"),
    "eval": ("eval", "--policy", "arm", *CORNER, "--episodes", "2", "--out", "made"),
    "view": ("view", "--policy", "arm", *CORNER, "--out", "made.png", "--out", "front.csv"),
}

TIMED = ("command.txt", "progress.csv", "checks.json", "resume.safetensors", "training.png", "events.")
"""Beginnings of names of files that hold times of day or durations; a training's report.html holds them too."""


def is_timed(file: Path) -> bool:
    """Whether a file holds times of day or durations."""
    return file.name.startswith(TIMED) or (file.name == "report.html" and (file.parent / "progress.csv").exists())


def contents(file: Path) -> bytes:
    """Content of a file; of a policy file its weights."""
    if file.suffix != ".zip":
        return file.read_bytes()
    with zipfile.ZipFile(file) as archive:
        return archive.read("policy.safetensors")


class Ended:
    """Traces of a command: exit code, stdout, and the files without times in them, by name."""

    def __init__(self, args: tuple[str, ...], variables: dict[str, str]) -> None:
        unset = {"MPLBACKEND", "MUJOCO_GL", "OMP_NUM_THREADS", "COLUMNS", "LC_ALL"}
        environment = {key: value for key, value in os.environ.items() if key not in unset} | variables
        with TemporaryDirectory() as folder:
            command = [sys.executable, "-m", "pipenav", *args]
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True)
            found = [file for file in Path(folder).rglob("*") if file.is_file() and not is_timed(file)]
            self.files = {str(file.relative_to(folder)): contents(file) for file in found}
        self.code = done.returncode
        self.out = done.stdout
        self.err = done.stderr.decode("ascii", errors="replace")


@cache
def plainly(command: str) -> Ended:
    return Ended(COMMANDS[command], {})


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("setting", SETTINGS)
def test_a_variable_changes_no_result_and_breaks_nothing(setting: str, command: str) -> None:
    ended, expected = Ended(COMMANDS[command], SETTINGS[setting]), plainly(command)
    assert ended.code == expected.code == 0, ended.err
    assert ended.files.keys() == expected.files.keys()
    assert not [name for name, data in ended.files.items() if data != expected.files[name]]


def test_letters_that_an_encoding_lacks_become_plain_ones(tmp_path: Path) -> None:
    code = (
        "import sys; from pipenav.cli.plain_letters import print_plain_letters as plain; plain(); plain(); "
        "print('1\\u20132 \\u22121 a\\u2026 \\u00b0'); print('\\udc80', file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        cwd=tmp_path,
        capture_output=True,
        check=True,
    )
    assert done.stdout.decode() == "1-2 -1 a~ ?\n"
    assert done.stderr.decode() == "?\n"


def test_a_command_in_ascii_alone_says_everything() -> None:
    ended = Ended(("list", "policies"), {"PYTHONIOENCODING": "ascii"})
    assert ended.code == 0, ended.err
    assert ended.out.isascii()


def test_a_library_that_is_not_installed_is_named(tmp_path: Path) -> None:
    code = "import sys; sys.modules['torch'] = None; from pipenav.cli import main; main()"
    command = [sys.executable, "-c", code, *COMMANDS["train"]]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert "Python module 'torch' is not installed" in done.stderr
