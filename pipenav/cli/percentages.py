"""Shares that are typed as percentages."""

from __future__ import annotations

import math

from pipenav.errors import PipenavError


def share_of(text: str, option: str) -> float:
    """A share in [0, 1] from a percentage as it was typed, `99%` or `99.5`.

    Args:
        text: the percentage.
        option: name of the option, for messages.

    Raises:
        PipenavError: it is none.
    """
    try:
        percent = float(text.removesuffix("%"))
    except ValueError:
        percent = math.nan
    if not 0 <= percent <= 100 or (0 < percent <= 1 and not text.endswith("%")):
        raise PipenavError(f"{option} {text} is not a percentage: write it as 99% or 99.5%.")
    return percent / 100


def audited_share(text: str) -> float:
    """The share of --audit in ]0, 1], from a percentage or a share as it was typed, `10%` or `0.1`.

    Raises:
        PipenavError: it is none.
    """
    try:
        share = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        share = math.nan
    if not 0 < share <= 1:
        raise PipenavError(f"--audit {text} is no share over 0: write it as 10% or 0.1, and all as 100% or 1.")
    return share
