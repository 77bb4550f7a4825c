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
        (
            ("mirror-rear", "--trajectory", "a.csv", "b.csv"),
            "mirror-rear --trajectory a.csv --trajectory b.csv",
        ),
        (("mirror-rear", "a.csv"), "try pipenav mirror-rear --trajectory a.csv"),
        (("gen-pipe", "100", "75"), "try pipenav gen-pipe --d 100 --angle 75"),
        (("gen-pipe", "--d", "100", "75"), "try pipenav gen-pipe --d 100 --angle 75"),
        (("gen-pipe", "--d", "100", "--s-bend", "yes"), "--s-bend takes no value, given 'yes': leave that out."),
        (
            ("eval", "--policy", "arm", "--pipes", "d=100", "angle=90"),
            "a value with a blank in it is written in",
        ),
        (("gen-pipe", "--angel", "75"), "unknown option --angel: did you mean --angle?"),
        (("gen-pipe", "--colour", "red"), "unknown option --colour: see pipenav gen-pipe --help"),
        (("gen-pipe", "--d"), "Option '--d' requires an argument: write its value behind it."),
        (("gen-pipe", "--d", "100", "--d=90", "--angle", "75"), "--d is given 2 times, 100 and 90: give it once."),
        (("gen-pipe", "--route", "a.toml", "--run", "b.toml"), "--route is given 2 times, a.toml and b.toml"),
        (("robots", "basic", "--out", ""), "--out is given an empty text: give it a value, or leave it out."),
        (("gen-pipe", "--d", "", "--angle", "75"), "--d is given an empty text: give it a value, or leave it out."),
        (("eval", "--stage", ""), "--stage is given an empty text: give it a value, or leave it out."),
        (("gen-pipe", "--bend", "1.5D"), "unknown option --bend: did you mean --bend-radius?"),
        (("gen-pipe", "-d", "100"), "unknown option -d: did you mean --d?"),
        (("gen-pipes",), "No such command 'gen-pipes'. Did you mean 'gen-pipe'?"),
        (("help",), "No such command 'help'; see pipenav --help."),
        (("--colour",), "unknown option --colour: see pipenav --help for those that there are."),
        (("gen-pipe", "--d", "99,5", "--angle=75"), "given '99,5': write it with a point, 99.5."),
        (("experiment",), "Missing argument 'a|b|c|d|e|f|all'; see pipenav experiment --help for an example."),
        (("gen-pipe", "route.toml"), "try pipenav gen-pipe --route route.toml"),
        (("robots", "basic", "pirate"), "pipenav robots takes no more arguments, given 'pirate': leave out"),
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
