"""Rectangles that pictures of motions show."""

from __future__ import annotations

from typing import NamedTuple

MARGIN = 0.06
"""Room around all that moves, as a share of its width."""


class ViewBox(NamedTuple):
    """A rectangle in millimetres of the pipe's frame."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def aspect(self) -> float:
        """Height over width."""
        return (self.top - self.bottom) / (self.right - self.left)
