"""Help and messages point only to what is installed, and a command that they give works as typed."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from helpers.doc_pages import ROOT
from pipenav_hardware.arm_config import load_arm
from pipenav_hardware.servo_flaws import storing

from pipenav.cli import COMMANDS, LazyCommand, command_line
from pipenav.errors import ConfigError, PipenavError
from pipenav.learning.training_folder import TrainingFolder

GIVEN = re.compile(r"\bpipenav ([a-z][a-z-]*)((?: --[a-z-]+(?: (?!--)[^\s,:;.)]+)?)*)")
"""A command in a text, with the options that follow it."""

ODD = "my arm's/a b"
"""A path that a shell would take apart."""


def command(name: str) -> Any:
    """A command of pipenav with its options."""
    lazy = command_line().commands[name]
    assert isinstance(lazy, LazyCommand)
    return lazy.load()


def sources() -> list[Path]:
    return sorted([*(ROOT / "pipenav").rglob("*.py"), *(ROOT / "plugins").rglob("*.py")])


def texts(path: Path) -> Iterator[str]:
    """Strings of a module that are no docstrings; what an f-string fills in is left out."""
    tree = ast.parse(path.read_text("utf-8"))
    prose = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose:
            yield node.value


@pytest.mark.parametrize("name", COMMANDS)
def test_help_points_to_what_is_installed(name: str) -> None:
    loaded = command(name)
    helps = [loaded.help or "", COMMANDS[name][1]]
    helps += [getattr(param, "help", None) or "" for param in loaded.params]
    assert [text for text in helps if "docs/" in text] == []


def test_messages_point_to_what_is_installed() -> None:
    assert [(path.name, text) for path in sources() for text in texts(path) if "docs/" in text] == []


@cache
def commands_given() -> list[tuple[str, str, str]]:
    """Commands in the texts of all modules: name, options, and where it stands."""
    found = [(path.name, text, given) for path in sources() for text in texts(path) for given in GIVEN.finditer(text)]
    return [(given[1], given[2], f"{name}: {text}") for name, text, given in found]


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_in_texts_have_their_options(name: str) -> None:
    options = {option for param in command(name).params for option in param.opts} | {"--help"}
    for given, its_options, where in commands_given():
        if given == name:
            assert set(re.findall(r"--[a-z-]+", its_options)) <= options, where


def test_a_path_in_a_command_is_quoted(tmp_path: Path) -> None:
    path = tmp_path / ODD
    with pytest.raises(ConfigError) as missing:
        load_arm(path)
    written = str(missing.value).partition("write one with ")[2].partition(", or")[0]
    assert shlex.split(written) == ["pipenav", "calibrate", "--port", "/dev/ttyUSB0", "--arm", str(path)]
    stored = storing(path).partition(": ")[2]
    assert shlex.split(stored) == ["pipenav", "calibrate", "--store-only", "--arm", str(path)]


def test_the_folder_to_resume_is_quoted(tmp_path: Path) -> None:
    folder = TrainingFolder(tmp_path / ODD)
    folder.path.mkdir(parents=True)
    folder.checkpoint.write_bytes(b"")
    with pytest.raises(PipenavError) as refused:
        folder.refuse_other_training()
    resume = str(refused.value).partition(" with ")[2].partition(", or choose")[0]
    assert shlex.split(resume) == ["--resume", str(folder.path)]
