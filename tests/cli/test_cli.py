"""The command line as a person sees it: help, errors of one line, exit codes, tables."""

from __future__ import annotations

import subprocess
import sys

import pytest
from helpers.command import run

import pipenav
from pipenav import cli
from pipenav.backends import plugins
from pipenav.cli import COMMANDS, LazyCommand
from pipenav.errors import PipenavError


@pytest.fixture(autouse=True)
def wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.delenv("FORCE_COLOR", raising=False)


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--help") == 0
    shown = capsys.readouterr().out
    for name, (_, line) in COMMANDS.items():
        assert name in shown
        assert line in shown


def test_without_arguments_there_is_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert run() == 2
    assert "gen-pipe" in "".join(capsys.readouterr())


@pytest.mark.parametrize("name", COMMANDS)
def test_the_commands_own_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--help") == 0
    shown = capsys.readouterr().out
    assert f"pipenav {name}" in shown
    assert COMMANDS[name][1] in shown


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_says_what_the_command_says(name: str) -> None:
    target, line = COMMANDS[name]
    help = LazyCommand(name, target, line).load().help
    assert help.strip().splitlines()[0] == line


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--version") == 0
    assert capsys.readouterr().out == f"pipenav {pipenav.__version__}\n"


def test_wrong_usage_is_exit_code_2_with_a_suggestion(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("robot") == 2
    assert "No such command 'robot'. Did you mean 'robots'?" in capsys.readouterr().err
    assert run("robots", "--no-such-option") == 2


def test_an_error_is_one_line_without_a_traceback() -> None:
    command = [sys.executable, "-m", "pipenav", "gen-pipe", "--d", "500", "--angle", "75"]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 1
    assert result.stdout == ""
    assert result.stderr == "pipenav: error: diameter 500 mm is out of range: choose 40 to 300 mm.\n"


def command_that_raises(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    def fail() -> None:
        raise error

    monkeypatch.setattr("pipenav.cli.robots.robots", fail)


def test_errors_of_several_lines_become_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command_that_raises(monkeypatch, PipenavError("first [bold]\n  second"))
    assert run("robots") == 1
    assert capsys.readouterr().err == "pipenav: error: first [bold] second\n"


def test_an_interrupt_is_quiet(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    command_that_raises(monkeypatch, KeyboardInterrupt())
    assert run("robots") == 130
    assert capsys.readouterr() == ("", "")


def test_a_command_whose_library_is_missing_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(cli.COMMANDS, "later", ("no_such_library:later", "Comes later."))
    assert run("--help") == 0
    assert run("later") == 1
    assert "Python module 'no_such_library' is not installed, which this command needs" in capsys.readouterr().err


def test_robots(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("robots") == 0
    header, *rows = capsys.readouterr().out.splitlines()
    assert "length [mm]" in header
    basic = next(row for row in rows if row.startswith("basic "))
    assert "l, theta1, theta2, theta3" in basic
    assert "10 beams over 180 deg, 5-500 mm" in basic


def test_backends(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    installed = {
        "kinematic": plugins.BackendPlugin("kinematic", "pipenav.testing:KinematicBackend", "pipenav", "0.1"),
        "ghost": plugins.BackendPlugin("ghost", "no_such_ghost:Ghost", "pipenav", "0.1"),
    }
    monkeypatch.setattr(plugins, "find_backends", lambda: installed)
    assert run("backends") == 0
    _, kinematic, ghost = capsys.readouterr().out.splitlines()
    assert kinematic.split() == ["kinematic", "yes", "pipenav", "0.1"]
    assert ghost.startswith("ghost      no")
    assert "'no_such_ghost' is not installed; reinstall pipenav" in ghost
    assert run("backends", "kinematic") == 0
    assert "speed_share  1.0      share of the no-load speed" in capsys.readouterr().out
    assert run("backends", "ghst") == 1
    assert "unknown backend 'ghst': did you mean 'ghost'?" in capsys.readouterr().err


def test_a_bare_checkout_gets_the_advice_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(plugins, "find_backends", dict)
    assert run("backends") == 1
    assert "install pipenav itself" in capsys.readouterr().err
