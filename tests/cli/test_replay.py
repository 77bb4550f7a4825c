"""`replay` never writes over what it reads."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command import run


@pytest.mark.parametrize("picture", ["telemetry.jsonl", "policy.zip"])
def test_a_picture_is_not_drawn_over_a_mission(
    picture: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "telemetry.jsonl"
    for name in ("telemetry.jsonl", "policy.zip"):
        (tmp_path / name).write_text("mission")
    assert run("replay", str(log), "--draw", str(tmp_path / picture)) == 1
    assert "is read and would be written over" in capsys.readouterr().err
    assert (tmp_path / picture).read_text() == "mission"


def test_a_picture_of_another_kind_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "telemetry.jsonl").write_text("mission")
    assert run("replay", str(tmp_path / "telemetry.jsonl"), "--draw", str(tmp_path / "mission.gif")) == 1
    assert "give --draw a name ending in .png." in capsys.readouterr().err
