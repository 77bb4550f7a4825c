"""Wrong usage says what was given and what to type instead."""

from __future__ import annotations

import re

import pytest
from helpers.command import run

from pipenav.cli.usage import OPTION_OF


@pytest.fixture(autouse=True)
def wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("TERM", "dumb")


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("eval", "arm"), "pipenav eval takes its inputs by options, given 'arm': try pipenav eval --policy arm"),
        (("train", "arm"), "try pipenav train --preset arm"),
        (("mirror-rear", "--trajectory", "a.csv", "b.csv"), "try pipenav mirror-rear --trajectory b.csv"),
        (("gen-pipe", "100", "75"), "try pipenav gen-pipe --d 100"),
        (("gen-pipe", "route.toml"), "try pipenav gen-pipe --route route.toml"),
        (("robots", "basic", "pirate"), "pipenav robots takes no more arguments, given 'pirate'."),
        (("gen-pipe", "--d", "100mm", "--angle", "75"), "given '100mm': write a number in mm, without the unit."),
        (("gen-pipe", "--d", "100", "--angle=75deg"), "given '75deg': write a number in deg, without the unit."),
        (("run-real", "--emulate", "--d", "100mm"), "given '100mm': write a number in mm"),
        (("locate-target", "--d", "100mm", "--angle", "75"), "given '100mm': write a number in mm"),
        (("eval", "--policy", "arm", "--episodes", "many"), "given 'many'"),
        (("eval", "--policy", "arm", "--episodes", "-3"), "given '-3'"),
    ],
)
def test_wrong_usage(args: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*args) == 2
    assert message in re.sub(r"[│╭╮╰╯─\s]+", " ", capsys.readouterr().err)


@pytest.mark.parametrize("command", OPTION_OF)
def test_the_options_that_are_named_exist(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(command, "--help") == 0
    assert f"{OPTION_OF[command]} " in capsys.readouterr().out
