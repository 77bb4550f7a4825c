"""The terminal: paths whole, brackets literal, headings whole, progress on stderr, no "nan"."""

from __future__ import annotations

import ast
import io
import math
from pathlib import Path

import pytest
from helpers.terminal import on_terminal, redirected
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from rich.progress import Task, TaskID

import pipenav.cli
from pipenav.cli.progress_bars import FINALISING, TimeLeftColumn, percentage_bar
from pipenav.cli.terminal import say
from pipenav.cli.train_progress import progress_text
from pipenav.learning.progress import TrainingProgress

COMMANDS = Path(pipenav.cli.__file__).parent
ODD = "exp[bold] real[/]1 " + "long-" * 40
"""A name of a folder with brackets that are markup elsewhere, wider than any terminal."""

TABLES = [
    ("robots",),
    ("robots", "pirate"),
    ("presets",),
    ("backends",),
    ("list",),
    ("list", "policies"),
    ("list", "robot-keys"),
    ("locate-target", "--pipes", "d=100,angle=90", "--pipes", "d=100,angle=80", "--option", "timestep=0.005"),
    ("eval", "--policy", "baseline:random", "--pipes", "thesis-real", "--episodes", "1"),
]


@given(st.text(st.characters(exclude_categories=["C", "Zl", "Zp"])))
def test_what_is_said_is_printed_as_it_is(text: str) -> None:
    written = io.StringIO()
    say(text, console=Console(file=written, width=20))
    assert written.getvalue() == f"{text}\n"


@pytest.mark.parametrize("file", sorted(COMMANDS.glob("*.py")), ids=lambda file: file.name)
def test_commands_print_by_way_of_one_helper(file: Path) -> None:
    """Whatever prints a text itself forgets one of wrapping, markup and highlighting."""
    if file.name == "terminal.py":
        return
    calls = [node for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(node, ast.Call)]
    printed = [c for c in calls if isinstance(c.func, ast.Attribute) and c.func.attr == "print"]
    assert not [call.lineno for call in printed if not ast.unparse(call.args[0]).startswith("Text.assemble")]


@pytest.mark.slow
@pytest.mark.parametrize("args", TABLES, ids=" ".join)
def test_no_heading_is_cut_at_80_columns(
    args: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    narrow, piped = on_terminal(80, *args), redirected(*args)
    assert narrow.code == piped.code
    assert "…" not in narrow.out + piped.out
    assert set(narrow.out.split()) - {"─" * 80} >= {word for word in piped.out.split() if "─" not in word}


@pytest.mark.slow
def test_paths_and_brackets_are_whole_wherever_the_output_goes(tmp_path: Path) -> None:
    folder = tmp_path / ODD
    folder.mkdir(parents=True)
    for result in (
        on_terminal(80, "gen-pipe", "--d", "100", "--angle", "75", "--out", str(folder)),
        redirected("gen-pipe", "--d", "100", "--angle", "75", "--out", str(folder)),
    ):
        assert result.code == 0
        assert f"Made {folder}/corner-d100-a75-left\n" in result.out
        assert not result.err


def test_without_a_finished_episode_there_is_no_nan() -> None:
    text = progress_text(TrainingProgress("", 100, 50.0, math.nan, 0.05, math.nan))
    assert text == "50 steps/s, no episode has ended yet, least laser reading 50 mm"
    assert "success 12.5%" in progress_text(TrainingProgress("", 100, 50.0, 0.125, 0.05, math.nan))


def test_after_the_last_step_it_is_finalising() -> None:
    column = TimeLeftColumn()
    task = Task(TaskID(0), "", 100, 50, _get_time=lambda: 0.0)
    assert column.render(task).plain.startswith("left ")
    task.completed, task.finished_time = 100, 1.0
    assert column.render(task).plain == FINALISING


def test_a_bar_that_has_ended_is_not_finalising() -> None:
    written = io.StringIO()
    with percentage_bar(Console(file=written, width=100)) as bar:
        bar.update(bar.add_task("[training]", total=10), completed=10)
    assert "[training]" in written.getvalue()
    assert FINALISING not in written.getvalue()
    assert "left" not in written.getvalue()
