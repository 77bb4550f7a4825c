"""Ends of a route: a cap at the far one, and the slope of the first leg."""

from __future__ import annotations

from typing import NamedTuple

from pipenav.units import rad_to_deg


class RouteEnds(NamedTuple):
    """Ends of a route: whether a cap closes the far one, and the angle by which the first leg climbs [rad]."""

    capped: bool = False
    slope: float = 0.0

    @property
    def names(self) -> list[str]:
        """Parts of a route's name, usable in a file name."""
        return self._parts("cap", f"slope{rad_to_deg(self.slope):g}")

    @property
    def labels(self) -> list[str]:
        """Parts of a route's description in words."""
        return self._parts(
            "a cap", f"{'climbing' if self.slope > 0 else 'falling'} by {abs(rad_to_deg(self.slope)):g} deg"
        )

    def _parts(self, cap: str, slope: str) -> list[str]:
        return [*([cap] if self.capped else []), *([slope] if self.slope else [])]


PLAIN_ENDS = RouteEnds()
"""Open ends, and a first leg that is level."""
