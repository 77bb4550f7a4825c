"""The keys under which pipes stand in JSON files, and a pipe's fields from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pipenav.pipes.route import PipeRoute

FIELD_KEYS = {
    "turn": "turn",
    "diameter": "diameter_m",
    "angle": "angle_rad",
    "bend_radius": "bend_radius_m",
    "leg": "leg_m",
    "wall": "wall_m",
}
"""The keys of pipe.json that a pipe is read from; the others follow from these."""


def run_fields(record: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a run from `KEYS` of run.json; what is missing stays missing."""
    fields = {"diameter": "diameter_m", "wall": "wall_m", "straights": "straights_m", "corners": "corners"}
    found = {field: record[key] for field, key in fields.items() if key in record}
    of = {"straights": lambda entry: entry, "corners": _corner}
    return {field: _tuple(value, of[field]) if field in of else value for field, value in found.items()}


def run_keys(run: PipeRoute) -> dict[str, Any]:
    """A run under `KEYS` of run.json, in SI alone."""
    fields = {"turn": "turn", "angle": "angle_rad", "roll": "roll_rad"}
    corners = [{key: getattr(corner, field) for field, key in fields.items()} for corner in run.corners]
    return {"diameter_m": run.diameter, "wall_m": run.wall, "corners": corners, "straights_m": list(run.straights)}


def _tuple(given: Any, of: Callable[[Any], Any]) -> Any:
    """JSON has lists alone, and a run wants tuples; what is no list is left for it to complain about."""
    return tuple(map(of, given)) if isinstance(given, list) else given


def _corner(given: Any) -> Any:
    if not isinstance(given, dict):
        return given
    fields = {"angle": "angle_rad", "turn": "turn", "roll": "roll_rad"}
    return {field: given[key] for field, key in fields.items() if key in given}
