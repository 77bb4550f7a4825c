"""Bend radii as people write them: in millimetres, or as a multiple of the diameter, `1.5D`."""

from __future__ import annotations

from pipenav.errors import PipenavError, shown


def bend_radius_mm(text: str, diameter_mm: float) -> float:
    """The radius of a text [mm]; its range is checked where a pipe is made of it.

    Args:
        text: a number of millimetres, or a multiple of the diameter with D behind it.
        diameter_mm: inner diameter, to which D refers.

    Raises:
        PipenavError: the text is neither.
    """
    number, times = text.strip(), 1.0
    if number[-1:] in ("d", "D"):
        number, times = number[:-1], diameter_mm
    try:
        return float(number) * times
    except ValueError:
        raise PipenavError(
            f"bend radius {shown(text)} is no number: write mm, for example 150, or diameters, for example 1.5D."
        ) from None
