"""Points go from frame to frame and back, many at once as one by one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.robots import frames

metres = st.floats(-10, 10)
placed = st.lists(st.tuples(metres, metres, metres, st.sampled_from([-1.0, 1.0])), min_size=1, max_size=6).map(np.array)
"""Points with the base and the side of their robots, (n, 4)."""


@given(placed)
def test_there_and_back_is_where_it_was(rows: Floats) -> None:
    points, base, turn_sign = rows[:, :2], rows[:, 2], rows[:, 3]
    assert frames.pipe_to_robot(frames.robot_to_pipe(points, base), base) == pytest.approx(points, abs=1e-12)
    assert np.array_equal(frames.canonical_to_robot(frames.robot_to_canonical(points, turn_sign), turn_sign), points)


@given(placed)
def test_many_points_are_converted_as_each_alone(rows: Floats) -> None:
    in_pipe = frames.robot_to_pipe(rows[:, :2], rows[:, 2])
    canonical = frames.robot_to_canonical(rows[:, :2], rows[:, 3])
    for row, pipe, left in zip(rows, in_pipe, canonical, strict=True):
        assert np.array_equal(frames.robot_to_pipe(row[:2], row[2]), pipe)
        assert np.array_equal(frames.robot_to_canonical(row[:2], row[3]), left)


@given(placed)
def test_the_base_moves_points_along_the_pipe_and_a_right_turn_reflects_them_across_it(rows: Floats) -> None:
    (x, y), base, turn_sign = rows[0, :2], rows[0, 2], rows[0, 3]
    assert frames.robot_to_pipe([x, y], base).tolist() == [x + base, y]
    assert frames.robot_to_canonical([x, y], turn_sign).tolist() == [x, y if turn_sign > 0 else -y]
