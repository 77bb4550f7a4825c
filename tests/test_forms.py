"""The forms that keep the code readable: sizes of files and functions, parameters, docstrings, kinds of pipes."""

from __future__ import annotations

import ast
import inspect
import re
import statistics
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted([*(ROOT / "pipenav").rglob("*.py"), *(ROOT / "plugins").rglob("*.py")])
Function = ast.FunctionDef | ast.AsyncFunctionDef

FILE_LINES, MEDIAN_FILE_LINES, FUNCTION_LINES = 320, 120, 50
PARAMETERS, COMMAND_PARAMETERS = 6, 12

IN_MID_SENTENCE = re.compile(r"(Of|That|Those|As|One|What|From|Between|Where|How)\b")
"""Words with which no docstring begins: its subject comes first, so that it can be read alone."""

DOCUMENTED = ("pipenav", "plugins", "tests", "benchmarks", "examples", "docs")
"""Folders whose docstrings are checked."""


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@cache
def functions(path: Path) -> tuple[Function, ...]:
    return tuple(node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, Function))


def parameters(function: Function) -> int:
    """Number of a function's parameters, self or cls aside."""
    given = function.args
    count = len(given.posonlyargs) + len(given.args) + len(given.kwonlyargs)
    return count - bool(given.args and given.args[0].arg in ("self", "cls"))


def test_the_median_file_is_short() -> None:
    assert statistics.median(len(path.read_text().splitlines()) for path in FILES) <= MEDIAN_FILE_LINES


@pytest.mark.parametrize("path", FILES, ids=named)
def test_files_and_functions_are_short(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= FILE_LINES
    long = [f.name for f in functions(path) if (f.end_lineno or 0) - f.lineno + 1 > FUNCTION_LINES]
    assert not long, f"functions of more than {FUNCTION_LINES} lines: {long}"


@pytest.mark.parametrize("path", FILES, ids=named)
def test_functions_take_few_parameters(path: Path) -> None:
    most = COMMAND_PARAMETERS if path.parent.name == "cli" else PARAMETERS
    assert not [f.name for f in functions(path) if parameters(f) > most]


def docstrings(tree: ast.Module) -> Iterator[str]:
    """Docstrings of the module, its classes, functions, attributes and constants: all strings that stand alone."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield inspect.cleandoc(node.value.value)


@pytest.mark.parametrize("path", sorted(p for d in DOCUMENTED for p in (ROOT / d).rglob("*.py")), ids=named)
def test_docstrings_begin_with_their_subject(path: Path) -> None:
    odd = [text for text in docstrings(ast.parse(path.read_text(encoding="utf-8"))) if IN_MID_SENTENCE.match(text)]
    assert not odd, f"docstrings that begin in mid-sentence: {odd}"


@pytest.mark.parametrize("path", [path for path in FILES if "pipes" not in path.parts], ids=named)
def test_only_the_pipes_package_tells_kinds_of_pipes_apart(path: Path) -> None:
    asked = re.findall(r"isinstance\([^)]*\b(?:Pipe|PipeCorner|PipeRoute)\b", path.read_text(encoding="utf-8"))
    assert not asked, "ask the pipe by a property of pipenav.pipes.Pipe instead"
