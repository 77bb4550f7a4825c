"""Drag of a cable that a robot pulls through pipes: by weight and friction along them, by the capstan around turns.

The capstan equation is Euler's (Remarques sur l'effet du frottement dans l'equilibre, 1769) and Eytelwein's (1808): a
cable that slides around a turn of angle a with friction mu needs exp(mu a) times the tension behind it.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats

CABLE_WEIGHT = 0.185
"""Weight of PIRATE's cable [N/m], chosen: 14 N pull 250 m of it in straight PVC, as published, and 260 m stop it."""

PVC_FRICTION = 0.3
"""Friction of a cable in a PVC pipe, chosen; 0.6 in corroded steel, where 14 N pull 125 m."""


def drag_per_metre(weight: float, friction: float, rise: Floats | float = 0.0) -> Floats:
    """Growth of a cable's tension along straight pipes [N/m]; a cable that slides down by itself pulls nobody back.

    Args:
        weight: weight of the cable [N/m].
        friction: coefficient of friction of the cable in the pipe.
        rise: sine of each pipe's slope, positive where the robot goes up; the result has its shape.
    """
    slope = np.asarray(rise)
    level = np.sqrt(np.maximum(1 - slope * slope, 0.0))
    return np.asarray(np.maximum(weight * (friction * level + slope), 0.0))


def capstan(friction: float, turned: Floats | float) -> Floats:
    """Factor on the tension of a cable that slides around turns, in the shape of `turned`.

    Args:
        friction: coefficient of friction of the cable in the pipe.
        turned: sum of the turns' angles, all counted as positive [rad].
    """
    return np.exp(friction * np.asarray(turned))
