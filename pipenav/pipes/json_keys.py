"""Keys under which pipes stand in JSON files, and a pipe's fields from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, PlainSerializer, Tag

from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import PipeRoute, as_route
from pipenav.pipes.route_corner import Corner

CORNER_KEYS = {
    "turn": "turn",
    "diameter": "diameter_m",
    "angle": "angle_rad",
    "bend_radius": "bend_radius_m",
    "leg": "leg_m",
    "wall": "wall_m",
}
"""Keys of pipe.json from which a `PipeCorner` is read, by field; the other keys follow from these."""

ROUTE_KEYS = {"diameter": "diameter_m", "wall": "wall_m", "corners": "corners", "straights": "straights_m"}
"""Keys of run.json from which a `PipeRoute` is read, by field."""

ROUTE_CORNER_KEYS = {
    "turn": "turn",
    "angle": "angle_rad",
    "roll": "roll_rad",
    "bend_radius": "bend_radius_m",
    "to_diameter": "to_diameter_m",
    "length": "length_m",
}
"""Keys of an entry under `corners` in run.json from which a route's corner is read, by field."""

OPTIONAL_CORNER_FIELDS = ("bend_radius", "to_diameter", "length")
"""Fields that a mitre's entry leaves out."""


def route_fields(record: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a route from the keys of run.json; what is missing stays missing."""
    found = {field: record[key] for field, key in ROUTE_KEYS.items() if key in record}
    entries: dict[str, Callable[[Any], Any]] = {"straights": lambda entry: entry, "corners": _corner_fields}
    return {field: _tuple(value, entries[field]) if field in entries else value for field, value in found.items()}


def keys_of_pipe(pipe: Pipe) -> dict[str, Any]:
    """A pipe under the keys of pipe.json or, for a route, of run.json, in SI units alone."""
    if isinstance(pipe, PipeCorner):
        return {key: getattr(pipe, field) for field, key in CORNER_KEYS.items()}
    route = as_route(pipe)
    return {
        "diameter_m": route.diameter,
        "wall_m": route.wall,
        "corners": [_keys_of_corner(corner) for corner in route.corners],
        "straights_m": list(route.straights),
    }


def _keys_of_corner(corner: Corner) -> dict[str, Any]:
    fields = {field: getattr(corner, field) for field in ROUTE_CORNER_KEYS}
    given = {field: value for field, value in fields.items() if value or field not in OPTIONAL_CORNER_FIELDS}
    return {ROUTE_CORNER_KEYS[field]: value for field, value in given.items()}


def _pipe_fields(given: Any) -> Any:
    """The fields of a pipe from its keys; what is no table is left for the model to complain about."""
    if not isinstance(given, Mapping):
        return given
    if "corners" in given:
        return route_fields(given)
    fields = {key: field for field, key in CORNER_KEYS.items()}
    return {fields.get(key, key): value for key, value in given.items()}


def _tag(given: Any) -> str:
    is_route = isinstance(given, PipeRoute) or (isinstance(given, Mapping) and "corners" in given)
    return "<route>" if is_route else "<corner>"


PipeInFile = Annotated[
    Annotated[Annotated[PipeCorner, Tag("<corner>")] | Annotated[PipeRoute, Tag("<route>")], Discriminator(_tag)],
    BeforeValidator(_pipe_fields),
    PlainSerializer(keys_of_pipe),
]
"""A pipe as a field of a model that is written to JSON, under the keys of pipe.json or run.json."""


def _tuple(given: Any, convert: Callable[[Any], Any]) -> Any:
    """A JSON list as a tuple of its converted entries; what is no list is left for the model to complain about."""
    return tuple(map(convert, given)) if isinstance(given, list) else given


def _corner_fields(given: Any) -> Any:
    if not isinstance(given, dict):
        return given
    return {field: given[key] for field, key in ROUTE_CORNER_KEYS.items() if key in given}
