"""Keys under which pipes stand in JSON files, and a pipe's fields from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, PlainSerializer, Tag

from pipenav.pipes.branch import Branch
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

OPTIONAL_ROUTE_KEYS = {"capped": "capped", "slope": "slope_rad"}
"""Keys of run.json that a route with an open far end and a level first leg leaves out, by field."""

ROUTE_CORNER_KEYS = {
    "turn": "turn",
    "angle": "angle_rad",
    "roll": "roll_rad",
    "bend_radius": "bend_radius_m",
    "to_diameter": "to_diameter_m",
    "length": "length_m",
    "branches": "branches",
}
"""Keys of an entry under `corners` in run.json from which a route's corner is read, by field."""

BRANCH_KEYS = {
    "turn": "turn",
    "angle": "angle_rad",
    "roll": "roll_rad",
    "diameter": "diameter_m",
    "length": "length_m",
    "closed": "capped",
}
"""Keys of an entry under `branches` of a corner from which a branch is read, by field."""

OPTIONAL_CORNER_FIELDS = ("bend_radius", "to_diameter", "length", "branches")
"""Fields that a mitre's entry leaves out."""

Entry = Callable[[Any], Any]
"""Function that reads an entry of a list."""


def route_fields(record: Mapping[str, Any]) -> Any:
    """The fields of a route from the keys of run.json; what is missing stays missing."""
    entries: dict[str, Entry] = {"straights": lambda entry: entry, "corners": _corner_fields}
    return _fields(record, ROUTE_KEYS | OPTIONAL_ROUTE_KEYS, entries)


def keys_of_pipe(pipe: Pipe) -> dict[str, Any]:
    """A pipe under the keys of pipe.json or, for a route, of run.json, in SI units alone."""
    if isinstance(pipe, PipeCorner):
        keys = {key: getattr(pipe, field) for field, key in CORNER_KEYS.items()}
        return keys | ({"branches": keys_of_branches(pipe.branches)} if pipe.branches else {})
    route = as_route(pipe)
    keys = {
        "diameter_m": route.diameter,
        "wall_m": route.wall,
        "corners": [_keys_of_corner(corner) for corner in route.corners],
        "straights_m": list(route.straights),
    }
    return keys | optional_route_keys(route)


def optional_route_keys(route: PipeRoute) -> dict[str, Any]:
    """The optional keys of run.json that a route needs."""
    return {key: getattr(route, field) for field, key in OPTIONAL_ROUTE_KEYS.items() if getattr(route, field)}


def keys_of_branches(branches: Sequence[Branch]) -> list[dict[str, Any]]:
    """The branches of a corner under the keys of run.json, in SI units alone."""
    return [{key: getattr(branch, field) for field, key in BRANCH_KEYS.items()} for branch in branches]


def _keys_of_corner(corner: Corner) -> dict[str, Any]:
    fields = {field: getattr(corner, field) for field in ROUTE_CORNER_KEYS}
    fields["branches"] = keys_of_branches(corner.branches)
    given = {field: value for field, value in fields.items() if value or field not in OPTIONAL_CORNER_FIELDS}
    return {ROUTE_CORNER_KEYS[field]: value for field, value in given.items()}


def _pipe_fields(given: Any) -> Any:
    """The fields of a pipe from its keys; what is no table is left for the model to complain about."""
    if not isinstance(given, Mapping):
        return given
    if "corners" in given:
        return route_fields(given)
    fields = {key: field for field, key in CORNER_KEYS.items()}
    found = {fields.get(key, key): value for key, value in given.items()}
    if "branches" in found:
        found["branches"] = _tuple(found["branches"], _branch_fields)
    return found


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
    return _fields(given, ROUTE_CORNER_KEYS, {"branches": _branch_fields})


def _branch_fields(given: Any) -> Any:
    return _fields(given, BRANCH_KEYS, {})


def _fields(given: Any, keys: Mapping[str, str], entries: Mapping[str, Entry]) -> Any:
    """Fields from a JSON object, lists as tuples; what is no object is left for the model to complain about.

    Args:
        given: the object.
        keys: its keys, by field.
        entries: functions that read the entries of lists, by field.
    """
    if not isinstance(given, Mapping):
        return given
    found = {field: given[key] for field, key in keys.items() if key in given}
    return {field: _tuple(value, entries[field]) if field in entries else value for field, value in found.items()}
