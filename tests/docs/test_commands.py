"""Every command in README and docs is run, with sizes that take a second; `helpers/documented.py` says how.

Commands whose tiny forms are equal are run once. Of trainings of one task on one backend one is run; the others are
prepared and checked, up to where the learner would begin. What is no command of pipenav (make, pip, python) is checked
to name things that exist.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from helpers.doc_pages import PAGES, ROOT, Command, fenced_commands, inline_commands
from helpers.documented import Options, Words, expected, pipenav, tiny

from pipenav.cli import COMMANDS
from pipenav.pipes import parse_pipes

FENCED = [command for page in PAGES for command in fenced_commands(page)]
INLINE = [command for page in PAGES for command in inline_commands(page)]

FRAGMENTS = {
    ("eval", "--certify"),
    ("eval", "--disturb"),
    ("eval", "--require", "99%"),
    ("eval", "--stage"),
    ("eval", "--stage", "passage"),
    ("eval", "--stage", "passage", "--disturb", "real-world"),
    ("eval", "--stage", "reach"),
    ("gen-pipe", "--route"),
    ("list", "[KIND]"),
    ("run-real", "--emulate"),
    ("train", "--config"),
    ("train", "--from-recordings"),
    ("view", "--live"),
}
"""Parts of commands that the text speaks of: their options must exist. A command alone, `pipenav eval`, is another."""


def is_fragment(command: Command) -> bool:
    words = command.argv[1:]
    return words in FRAGMENTS or len(words) == 1 or words == ("COMMAND", "--help")


OURS = [command for command in FENCED if command.argv[0] == "pipenav"]
OURS += [command for command in INLINE if not is_fragment(command)]
OTHERS = {command.argv: command for command in FENCED if command.argv[0] not in ("pipenav", "python")}


def cases() -> list[object]:
    """Test cases, one for each different tiny command."""
    first: dict[Words, Command] = {}
    for command in OURS:
        first.setdefault(tiny(command.argv), command)
    found, trained = [], set[tuple[str | None, bool, bool, bool]]()
    for words, command in first.items():
        on_an_arm = "--emulate" in words or "runs/real-1" in " ".join(words)
        marks = [pytest.mark.realtime] if on_an_arm else []
        marks += [pytest.mark.skipif(needs_pybullet(words), reason="pybullet is not installed")]
        options = Options.of(("pipenav", *words))
        kind = (options.value("--backend"), "pirate" in str(words), options.has("--from"), options.has("--resume"))
        alike = words[0] == "train" and kind in trained
        trained |= {kind} if words[0] == "train" else set()
        found.append(pytest.param(words, alike, id=f"{command.where} {shlex.join(words)}"[:110], marks=marks))
    return found


def needs_pybullet(words: Words) -> bool:
    other = words[0] == "compare-backends" and "lag" not in words
    return (other or "pybullet" in words) and importlib.util.find_spec("pybullet") is None


@pytest.mark.slow
@pytest.mark.parametrize(("words", "alike"), cases())
def test_command(
    words: Words,
    alike: bool,
    here: Path,
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    if "lag" in words:
        request.getfixturevalue("lag_plugin")
    if any(word.startswith("runs/real-1") for word in words):
        shutil.copytree(request.getfixturevalue("mission"), here, dirs_exist_ok=True)
    if alike:
        skip_training(monkeypatch)
    wanted = expected(words)
    code = pipenav(*words)
    said = capfd.readouterr()
    assert code == wanted.code, said.err
    assert wanted.words in said.out + said.err


def skip_training(monkeypatch: pytest.MonkeyPatch) -> None:
    """Prepare trainings without running them."""
    from pipenav.learning import train

    monkeypatch.setattr(train, "train", lambda config, *_: train.TrainingSummary(config.steps, 0.0, False, 0.0))


@pytest.mark.parametrize("command", OURS, ids=lambda command: command.where)
def test_pipes_that_a_command_names_exist(command: Command, among_shown_files: Path) -> None:
    """Tiny commands take one corner in place of a set."""
    del among_shown_files
    pipes = [str(value) for option, value in Options.of(command.argv).given if option == "--pipes"]
    assert len(parse_pipes(pipes)) >= len(pipes)


@pytest.mark.parametrize("command", [c for c in INLINE if is_fragment(c)], ids=lambda command: command.where)
def test_fragment_names_a_command_and_its_options(command: Command, capfd: pytest.CaptureFixture[str]) -> None:
    name = command.argv[1]
    if name in ("COMMAND", "--help"):
        return
    assert name in COMMANDS, f"{command.where}: there is no pipenav {name}"
    pipenav(name, "--help")
    known = set(re.findall(r"--[\w-]+", capfd.readouterr().out))
    assert {word for word in command.argv if word.startswith("--")} <= known, command.where


@pytest.mark.parametrize("command", OTHERS.values(), ids=lambda command: command.where)
def test_other_command(command: Command) -> None:
    """Targets, extras and paths exist; the tests of the examples run in `test_examples.py`."""
    program, *words = command.argv
    if program == "make":
        subprocess.run(["make", "--dry-run", *words], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        return
    if program.endswith(".sh"):
        shown = subprocess.run(
            [ROOT / program, "--help"], env=os.environ | {"PYTHON": sys.executable}, check=True, capture_output=True
        )
        assert {word for word in words if word.startswith("--")} <= set(re.findall(r"--[\w-]+", shown.stdout.decode()))
        return
    assert program in ("pip", "pytest"), f"{command.where}: this test does not know how to check {program}"
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    for word in words[1:] if program == "pip" else words:
        path, _, extra = word.removesuffix("]").partition("[")
        assert word.startswith(("-", "https:")) or (ROOT / path).exists(), f"{command.where}: there is no {path}"
        assert not extra or extra in extras


SCRIPTS = sorted({match for page in PAGES for match in re.findall(r"python ([\w/]+\.py)", page.read_text("utf-8"))})


@pytest.mark.parametrize("script", SCRIPTS)
def test_scripts_exist(script: str) -> None:
    assert (ROOT / script).is_file()


def test_options_of_a_script() -> None:
    """`python benchmarks/same_results.py HEAD --only arm` and the like: the options are in the script's own help."""
    lines = [match for page in PAGES for match in re.findall(r"python ([\w/]+\.py[^`\n#]*)", page.read_text("utf-8"))]
    for line in lines:
        script, *words = shlex.split(line)
        text = (ROOT / script).read_text("utf-8")
        assert all(word in text for word in words if word.startswith("--")), line
