"""A fault of pipenav itself ends in a sentence that says so and in a report, never in a traceback."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.command import run

FAULTS = [RuntimeError("no\nsuch \x1b[31mthing" + "x" * 10_000), RecursionError(), MemoryError(), KeyError("a")]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: type(fault).__name__)
def test_a_fault_is_reported_and_owned(
    fault: Exception, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def broken() -> list[str]:
        raise fault

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("pipenav.robots.robot.robot_names", broken)
    assert run("locate-target", "--robot", "basic", "--d", "100", "--angle", "90") == 70
    message = capfd.readouterr().err.strip()
    assert "\n" not in message
    assert "\x1b[31mthing" not in message
    assert len(message) < 600
    assert type(fault).__name__ in message
    assert "pipenav failed by a fault of its own" in message
    report = Path(re.search(r"a report is in (\S+);", message)[1])
    assert "Traceback" in report.read_text()


def test_a_report_that_cannot_be_written_is_said(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def broken() -> list[str]:
        raise RuntimeError("no such thing")

    def full(**_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.mkstemp", full)
    monkeypatch.setattr("pipenav.robots.robot.robot_names", broken)
    assert run("locate-target", "--robot", "basic", "--d", "100", "--angle", "90") == 70
    assert "no report could be written" in capfd.readouterr().err
