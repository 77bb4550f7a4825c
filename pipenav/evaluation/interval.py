"""The 95 % interval of a share that was counted."""

from __future__ import annotations

import math
from typing import NamedTuple

Z_95 = 1.959963984540054
"""The normal distribution's 97.5 % quantile, for two-sided 95 % intervals."""


class Interval(NamedTuple):
    """A 95 % interval of a share, both ends in [0, 1]."""

    low: float
    high: float


def wilson(successes: int, n: int) -> Interval:
    """Wilson's 95 % score interval of a share of which `successes` of `n` trials were seen; without trials, [0, 1].

    Source: E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal of the
    American Statistical Association 22 (1927) 209-212; without continuity correction (method 3 of R. G. Newcombe,
    Statistics in Medicine 17 (1998) 857-872). It holds up where the textbook's interval collapses: at 0 and n.
    """
    if not 0 <= successes <= n:
        raise ValueError(f"{successes} successes of {n} trials")
    if n == 0:
        return Interval(0.0, 1.0)
    share, z2 = successes / n, Z_95**2
    centre = share + z2 / (2 * n)
    half = Z_95 * math.sqrt(share * (1 - share) / n + z2 / (4 * n * n))
    # Both ends are exact where nothing, or everything, succeeded; rounding would leave 1e-17 there.
    low = 0.0 if successes == 0 else (centre - half) / (1 + z2 / n)
    high = 1.0 if successes == n else (centre + half) / (1 + z2 / n)
    return Interval(low, high)
