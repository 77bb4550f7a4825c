"""The top view of a robot in its pipe as text: dots of braille letters, eight to a letter."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints

BLANK = 0x2800
"""The braille letter without dots (Unicode 15, block Braille Patterns)."""

DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""Bit of each dot of a letter, by its row and column."""

FINE = 4
"""Points for each dot along a line: enough that a line has no holes."""


class View(NamedTuple):
    """Piece of the plane that is shown.

    Attributes:
        centre: its middle, (2,) [m].
        width: its width [m]; its height follows from the letters.
        columns, rows: number of letters.
    """

    centre: Floats
    width: float
    columns: int
    rows: int


class Cell(NamedTuple):
    """A letter of the picture, and the layer that it shows: the last one with a dot in it; -1 for none."""

    letter: str
    layer: int


def draw(view: View, layers: Iterable[Iterable[Floats]]) -> list[list[Cell]]:
    """A picture of lines, row by row from the top.

    Args:
        view: the piece of the plane.
        layers: lines of each layer, (k, 2) [m] each; later layers lie on top.
    """
    dots = np.zeros((4 * view.rows, 2 * view.columns), bool)
    top = np.full((view.rows, view.columns), -1)
    for number, lines in enumerate(layers):
        own = np.zeros_like(dots)
        for line in lines:
            _mark(own, _dots(view, line))
        cells = own.reshape(view.rows, 4, view.columns, 2).any(axis=(1, 3))
        top[cells] = number
        if number:
            hidden = cells.repeat(4, axis=0).repeat(2, axis=1)
            dots[hidden] = False  # a letter has one colour
        dots |= own
    bits = (dots.reshape(view.rows, 4, view.columns, 2) * DOTS[None, :, None, :]).sum(axis=(1, 3))
    return [
        [Cell(chr(BLANK + int(bit)), int(layer)) for bit, layer in zip(row, layer_row, strict=True)]
        for row, layer_row in zip(bits, top, strict=True)
    ]


def _dots(view: View, line: Floats) -> Ints:
    """Rows and columns of the dots on a line, (m, 2), some of them outside."""
    size = view.width / (2 * view.columns)  # a dot is as wide as it is high, in most fonts
    at = (np.asarray(line, float) - view.centre) / size
    at = np.stack([2 * view.rows - at[:, 1], view.columns + at[:, 0]], axis=1)
    parts = [at[:1]]
    for a, b in itertools.pairwise(at):
        count = min(int(FINE * np.abs(b - a).max()) + 1, 4000)
        parts.append(a + np.linspace(0.0, 1.0, count + 1)[1:, None] * (b - a))
    return np.floor(np.concatenate(parts)).astype(int)


def _mark(dots: Flags, at: Ints) -> None:
    """Set dots, as far as they lie inside."""
    rows, columns = at.T
    inside = (rows >= 0) & (rows < dots.shape[0]) & (columns >= 0) & (columns < dots.shape[1])
    dots[rows[inside], columns[inside]] = True
