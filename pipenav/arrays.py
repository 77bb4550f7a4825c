"""Types that every module shares: arrays of numbers, the strict table for settings and descriptions, ranges."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

__all__ = ["Flags", "Floats", "Ints", "Table", "ordered"]

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Flags = NDArray[np.bool_]

Number = TypeVar("Number", int, float)


def ordered(given: Any, check: Callable[[Any], tuple[Number, Number]]) -> tuple[Number, Number]:
    """A range, checked; wraps the check of its numbers in pydantic.

    Raises:
        ValueError: it has not two ends, or has them the wrong way round.
    """
    if not isinstance(given, list | tuple) or len(given) != 2:
        instead = f", given {list(given)}" if isinstance(given, list | tuple) else ""
        raise ValueError(f"a range is written as [smallest, largest]{instead}")
    span = check(given)
    if span[0] > span[1]:
        raise ValueError(f"a range is written as [smallest, largest], given [{span[0]:g}, {span[1]:g}]")
    return span


class Table(BaseModel):
    """A frozen, strict model that refuses unknown keys and numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy that computes its own cached properties."""
        copied = super().model_copy(update=update, deep=deep)
        for name in copied.__dict__.keys() - type(self).model_fields.keys():
            del copied.__dict__[name]
        return copied
