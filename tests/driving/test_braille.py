"""Pictures of braille letters."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pipenav.driving.braille import BLANK, View, draw

VIEW = View(np.zeros(2), 2.0, 20, 10)  # a dot is 0.05 wide, the picture 2 x 2
points = st.tuples(st.floats(-0.95, 0.95), st.floats(-0.95, 0.95))


def dots(picture: list[list[object]]) -> list[tuple[float, float]]:
    """Middles of the dots in the plane."""
    bits = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (3, 0), (3, 1)]
    found = []
    for row, cells in enumerate(picture):
        for column, cell in enumerate(cells):
            pattern = ord(cell.letter) - BLANK  # type: ignore[attr-defined]
            for bit, (down, right) in enumerate(bits):
                if pattern >> bit & 1:
                    x, y = 2 * column + right + 0.5, 4 * row + down + 0.5
                    found.append(((x - 20) * 0.05, (20 - y) * 0.05))
    return found


@given(a=points, b=points)
def test_every_dot_lies_on_the_line_and_the_line_has_no_holes(a: tuple[float, float], b: tuple[float, float]) -> None:
    line = np.array([a, b])
    found = np.array(dots(draw(VIEW, [[line]])))
    along = a + np.linspace(0, 1, 50)[:, None] * (line[1] - line[0])
    away = np.abs(found[:, None] - along).max(axis=2)
    step = np.abs(line[1] - line[0]).max() / 49
    assert (away.min(axis=1) <= 0.026 + step).all()
    assert (away.min(axis=0) <= 0.05).all()


@given(a=points, b=points)
def test_a_later_layer_hides_an_earlier_one(a: tuple[float, float], b: tuple[float, float]) -> None:
    line = np.array([a, b])
    picture = draw(VIEW, [[line], [line]])
    assert all(cell.layer in (-1, 1) for row in picture for cell in row)
    assert [[cell.letter for cell in row] for row in picture] == [
        [cell.letter for cell in row] for row in draw(VIEW, [[line]])
    ]


def test_lines_outside_leave_it_blank() -> None:
    far = np.array([[5.0, 5.0], [9.0, 5.0]])
    assert all(cell.layer == -1 for row in draw(VIEW, [[far]]) for cell in row)
