"""Options in groups: as typed they are single options, in the help they share a panel, in the command they are one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import pytest
import typer
from typer.testing import CliRunner

from pipenav.cli.option_groups import OptionGroup, takes_option_groups

given: list[tuple[str, Cooking]] = []


@dataclass(frozen=True)
class Cooking(OptionGroup):
    panel: ClassVar[str] = "Cooking"
    minutes: Annotated[int, typer.Option(min=1, help="How long.")]
    hot: Annotated[bool, typer.Option("--hot", help="How warm.")] = False


@takes_option_groups
def cook(cooking: Cooking, dish: Annotated[str, typer.Option(help="Food.")] = "rice") -> None:
    """Cook a dish."""
    given.append((dish, cooking))


@pytest.fixture
def app(monkeypatch: pytest.MonkeyPatch) -> typer.Typer:
    monkeypatch.setenv("TERM", "dumb")
    given.clear()
    app = typer.Typer()
    app.command()(cook)
    return app


def test_every_field_is_an_option_of_its_own(app: typer.Typer) -> None:
    assert CliRunner().invoke(app, ["--hot", "--dish", "soup", "--minutes", "5"]).exit_code == 0
    assert CliRunner().invoke(app, ["--minutes", "3"]).exit_code == 0
    assert given == [("soup", Cooking(5, True)), ("rice", Cooking(3))]


@pytest.mark.parametrize("args", [[], ["--minutes", "0"], ["--minutes", "x"]])
def test_fields_are_checked_as_options_are(app: typer.Typer, args: list[str]) -> None:
    assert CliRunner().invoke(app, args).exit_code == 2


def test_the_help_shows_a_panel_for_each_group(app: typer.Typer) -> None:
    shown = CliRunner().invoke(app, ["--help"]).output
    assert shown.index("Options") < shown.index("--dish") < shown.index("Cooking") < shown.index("--minutes")
    assert "Cook a dish." in shown
