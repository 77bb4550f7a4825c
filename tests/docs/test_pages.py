"""Pages that list what is in the code list all of it, and the architecture's picture is drawn from today's imports."""

from __future__ import annotations

import importlib
import re
import sys
from pkgutil import resolve_name

import pytest
from helpers.doc_pages import ROOT
from PIL import Image

from pipenav.backends.moved import MOVED

sys.path.append(str(ROOT / "docs"))

import draw_architecture

API = (ROOT / "docs/python-api.md").read_text(encoding="utf-8")
PUBLIC = re.findall(r"^## `(pipenav\.\w+)`$", API, re.MULTILINE)


def listed(module: str) -> list[str]:
    """Names in the first column of a module's table."""
    table = API.partition(f"## `{module}`\n")[2].partition("\n## ")[0]
    return [name for row in re.findall(r"^\| (`.+?) \|", table, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)]


def test_public_packages_are_listed() -> None:
    names = ["robots", "pipes", "backends", "jobs", "policies", "evaluation"]
    names += ["envs", "testing", "errors", "arrays", "units"]
    assert [f"pipenav.{name}" for name in names] == PUBLIC


@pytest.mark.parametrize("module", PUBLIC)
def test_public_names_are_listed(module: str) -> None:
    public = importlib.import_module(module).__all__
    names = listed(module)
    assert sorted(names) == sorted(public), f"docs/python-api.md lists other names of {module} than its __all__"


@pytest.mark.parametrize("module", PUBLIC)
def test_public_names_exist(module: str) -> None:
    loaded = importlib.import_module(module)
    assert [name for name in loaded.__all__ if not hasattr(loaded, name)] == []


def test_names_in_modules_exist_and_are_all_that_examples_import() -> None:
    table = API.partition("## Names in modules\n")[2]
    names = set(re.findall(r"`(pipenav\.\w+\.\w+\.\w+)`", table))
    for name in names:
        resolve_name(name)
    for path in (ROOT / "examples").glob("*.py"):
        imports = re.findall(r"^from (pipenav\.[\w.]+) import (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
        used = {f"{module}.{name}" for module, listed in imports if module not in PUBLIC for name in listed.split(", ")}
        assert used <= names, f"{path.name} imports what docs/python-api.md does not list"


def test_moved_names_are_those_that_plugins_are_told() -> None:
    guide = (ROOT / "docs/guides/write-a-backend.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`pipenav\..+?) \| (`pipenav\..+?) \|$", guide, re.MULTILINE)
    assert len(rows) > 5
    for row in rows:
        old, new = (re.findall(r"`([\w.]+)`", cell) for cell in row)
        for i, name in enumerate(old):
            assert MOVED.get(name, name) == new[min(i, len(new) - 1)]


def test_every_package_has_a_row() -> None:
    rows = {name for floor in draw_architecture.floors() for name in floor}
    packages = {path.parent.name for path in (ROOT / "pipenav").glob("*/__init__.py")}
    assert rows == packages | {"errors", "units", "arrays"}


def test_imports_run_down_the_table() -> None:
    floor = {name: number for number, names in enumerate(draw_architecture.floors(), 1) for name in names}
    upwards = sorted(edge for edge in draw_architecture.imports() if floor[edge[0]] <= floor[edge[1]])
    assert not upwards, f"docs/architecture.md says otherwise: {upwards}"


def test_picture_shows_todays_imports() -> None:
    drawn = Image.open(draw_architecture.PICTURE).text["Imports"]  # type: ignore[attr-defined]
    assert drawn == draw_architecture.as_text(draw_architecture.imports()), "run python docs/draw_architecture.py"
    assert draw_architecture.PICTURE.stat().st_size < 150_000


def test_readme_is_short_and_its_film_small() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) < 90
    assert (ROOT / "docs/passing.gif").stat().st_size < 400_000
