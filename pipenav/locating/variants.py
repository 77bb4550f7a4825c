"""The two ways of approach I by their names."""

from __future__ import annotations

from pipenav.locating.locator import Variant
from pipenav.locating.map_locator import MapLocator
from pipenav.locating.printed_locator import PrintedLocator

LOCATORS: dict[Variant, type[MapLocator] | type[PrintedLocator]] = {"map": MapLocator, "thesis": PrintedLocator}
"""The locator of each variant."""
