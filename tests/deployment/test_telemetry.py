"""The log of a mission: what was written is read, bit for bit, and what is damaged is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.deployment.telemetry import REMEMBERED, Telemetry, TelemetryFileError, read_telemetry
from pipenav.errors import PipenavError

finite = st.floats(allow_nan=False, allow_infinity=False)


def written(path: Path, ticks: list[dict[str, Any]], end: bool = True) -> Path:
    path.unlink(missing_ok=True)
    with Telemetry(path) as telemetry:
        telemetry.begin({"robot": "basic"})
        for number, tick in enumerate(ticks):
            telemetry.tick({"tick": number, "raw": {}, **tick})
        if end:
            telemetry.end("passed", None, "")
    return path


@given(st.lists(st.lists(finite, max_size=4), max_size=5), st.booleans())
def test_what_was_written_is_read(tmp_path_factory: pytest.TempPathFactory, rows: list[list[float]], end: bool) -> None:
    path = written(tmp_path_factory.mktemp("log") / "t.jsonl", [{"q": row} for row in rows], end)
    recording = read_telemetry(path)
    assert recording.header["robot"] == "basic"
    assert [tick["q"] for tick in recording.ticks] == rows
    assert (recording.end is not None) == end


def test_every_tick_is_on_disk_as_it_ends(tmp_path: Path) -> None:
    telemetry = Telemetry(tmp_path / "t.jsonl")
    telemetry.begin({})
    for number in range(REMEMBERED + 5):
        telemetry.tick({"tick": number, "raw": {}})
        assert len(read_telemetry(telemetry.path).ticks) == number + 1
    assert [tick["tick"] for tick in telemetry.last] == list(range(5, REMEMBERED + 5))


def test_a_last_line_that_was_cut_short_is_left_out(tmp_path: Path) -> None:
    path = written(tmp_path / "t.jsonl", [{}, {}], end=False)
    whole = path.read_bytes()
    for cut in range(1, len(whole.splitlines()[-1])):
        path.write_bytes(whole[:-cut])
        assert len(read_telemetry(path).ticks) == 1


@pytest.mark.parametrize(
    ("line", "content", "words"),
    [
        (0, "{}", "does not begin with a header"),
        (0, json.dumps({"pipenav_telemetry": 99}), "does not begin with a header of version 1 or 2"),
        (1, "not json", "is damaged in line 2"),
        (1, "[1, 2]", "is damaged in line 2"),
        (1, json.dumps({"tick": 7, "raw": {}}), "misses tick 0"),
        (2, json.dumps({"tick": 1}), "misses tick 1"),
    ],
)
def test_damage_is_named(tmp_path: Path, line: int, content: str, words: str) -> None:
    path = written(tmp_path / "t.jsonl", [{}, {}])
    lines = path.read_text().splitlines()
    lines[line] = content
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(TelemetryFileError, match=words):
        read_telemetry(path)


def test_no_log_no_reading_and_none_is_written_over(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match="No such file"):
        read_telemetry(tmp_path / "none")
    (tmp_path / "t.jsonl").write_text("something")
    with pytest.raises(PipenavError, match="exists"):
        Telemetry(tmp_path / "t.jsonl").begin({})
    (tmp_path / "empty").write_bytes(b"")
    with pytest.raises(TelemetryFileError, match="does not begin"):
        read_telemetry(tmp_path / "empty")
