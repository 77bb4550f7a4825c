"""Records of driven episodes, and drivers beside each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.driving.comparison import compare, mean_interval
from pipenav.driving.records import DriveRecords, EpisodeRecord, read_records, write_records
from pipenav.errors import PipenavError


def episode(number: int, passed: bool, seconds: float = 10.0) -> EpisodeRecord:
    return EpisodeRecord(
        pipe="d=90,angle=90",
        number=number,
        outcome="reached" if passed else "jam",
        passed=passed,
        seconds=seconds,
        takeovers=1,
        person_share=0.5,
        peak_force_n=30.0,
        penetration_m=0.0,
        largest_jump=1.0,
    )


def session(passed: list[bool], **changed: object) -> DriveRecords:
    given = {"robot": "pirate", "policy": "pirate", "operator": "none", "input": None, "backend": "mujoco"}
    episodes = tuple(episode(number, one) for number, one in enumerate(passed))
    more = {"seed": 0, "disturb": None, "episodes": episodes, "schema": 1, **changed}
    return DriveRecords.model_validate({**given, **more})


@given(st.lists(st.booleans(), min_size=1, max_size=30), st.lists(st.booleans(), min_size=1, max_size=30))
def test_only_common_episodes_count_and_gains_and_losses_make_up_the_difference(
    one: list[bool], other: list[bool]
) -> None:
    rows = compare([session(one), session(other)])
    n = min(len(one), len(other))
    assert [row.episodes for row in rows] == [n, n]
    assert rows[1].passed - rows[0].passed == rows[1].gained - rows[1].lost
    assert (rows[0].gained, rows[0].lost) == (0, 0)
    assert all(row.success.low <= row.passed / n <= row.success.high for row in rows)


@given(st.lists(st.floats(0, 1e4), min_size=1, max_size=50))
def test_a_mean_lies_in_its_interval(values: list[float]) -> None:
    found = mean_interval(values)
    assert min(values) - 1e-6 <= found.low <= found.high <= max(values) + 1e-6
    assert found.mean == pytest.approx(np.mean(values))


def test_records_that_are_read_back_are_those_that_were_written(tmp_path: Path) -> None:
    records = session([True, False, True])
    write_records(tmp_path, records)
    assert read_records(tmp_path) == records
    assert read_records(tmp_path / "drive.json") == records


@pytest.mark.parametrize("changed", [{"seed": 1}, {"robot": "basic"}])
def test_drivers_of_other_episodes_are_not_compared(changed: dict[str, object]) -> None:
    with pytest.raises(PipenavError, match="differ in their"):
        compare([session([True]), session([True], **changed)])


def test_sessions_without_a_common_episode_are_not_compared() -> None:
    other = session([True], episodes=(episode(7, True),))
    with pytest.raises(PipenavError, match="no episode in common"):
        compare([session([True]), other])


def test_a_folder_without_an_episode_is_refused(tmp_path: Path) -> None:
    write_records(tmp_path, session([]))
    with pytest.raises(PipenavError, match="holds no episode"):
        read_records(tmp_path)
