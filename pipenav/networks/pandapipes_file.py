"""Networks of pandapipes: JSON whose tables are JSON texts of their own, with `columns`, `index` and `data`.

Source of the format: pandapipes' `to_json` (BSD-3), tables `junction`, `junction_geodata`, `pipe` and `pipe_geodata`;
diameters stand in `diameter_m`, since version 0.12 in `inner_diameter_mm`.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

from pipenav.errors import ConfigError, shown
from pipenav.networks.draft import LineFacts, MapDraft, Point
from pipenav.networks.model import NetworkMap
from pipenav.networks.text import network_json
from pipenav.networks.units import number
from pipenav.storage.text_files import parse_json, shown_path

SERVICE_WORDS = ("house", "service", "connection")
"""Words in the type of a pipe that make it a service."""


class _Table(NamedTuple):
    """A table: its name, the label of each row, and its rows by column."""

    name: str
    labels: list[Any]
    rows: list[dict[str, Any]]


def is_pandapipes(content: object) -> bool:
    """Whether JSON content is a network of pandapipes."""
    return isinstance(content, dict) and content.get("_class") == "pandapipesNet"


def read_pandapipes(path: Path, content: object = None) -> NetworkMap:
    """The map of a network of pandapipes.

    Args:
        path: path of the file.
        content: its content where it has been read already.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no such network, with the row that does not fit.
    """
    where = shown_path(path)
    whole = network_json(path) if content is None else content
    if not isinstance(whole, dict) or not is_pandapipes(whole):
        raise ConfigError(f"{where} is not a network of pandapipes: give a file that its to_json wrote.")
    tables = whole.get("_object")
    if isinstance(tables, str):
        tables = parse_json(tables, where)
    if not isinstance(tables, dict):
        raise ConfigError(f"{where} has no tables in it: write it with pandapipes' to_json again.")
    draft = MapDraft(where, "pandapipes JSON")
    junctions, pipes = _table(tables, "junction", where), _table(tables, "pipe", where)
    _add_junctions(draft, junctions, _places(junctions, tables, where))
    courses = _courses(tables, where)
    for index, row in zip(pipes.labels, pipes.rows, strict=True):
        _add_pipe(draft, index, row, courses.get(str(index), []))
    return draft.finish()


def _table(tables: dict[str, Any], name: str, where: str, needed: bool = True) -> _Table:
    held = tables.get(name)
    if isinstance(held, dict) and "_object" in held:
        held = held["_object"]
    if isinstance(held, str):
        held = parse_json(held, f"{where}, table {name}")
    if held is None and not needed:
        return _Table(name, [], [])
    parts = [held.get(key) for key in ("columns", "index", "data")] if isinstance(held, dict) else [None] * 3
    columns, index, data = parts
    if not (isinstance(columns, list) and isinstance(index, list) and isinstance(data, list)):
        raise ConfigError(f"{where} has no table {name!r} with columns, index and data: write it with to_json again.")
    if len(index) != len(data) or not all(isinstance(row, list) and len(row) == len(columns) for row in data):
        raise ConfigError(f"{where}, table {name}: a row is longer or shorter than its columns: write it anew.")
    labels: dict[str, int] = {}
    for row, label in enumerate(map(str, index), 1):
        if (first := labels.setdefault(label, row)) != row:
            raise ConfigError(
                f"{where}, table {name}, row {row}: index {shown(label)} stands in row {first} already: give each row "
                "its own."
            )
    return _Table(name, index, [dict(zip(columns, row, strict=True)) for row in data])


def _places(junctions: _Table, tables: dict[str, Any], where: str) -> dict[str, tuple[float, float]]:
    """Coordinates of the junctions by their index: of a table of their own, or of a GeoJSON text in each row."""
    geodata = _table(tables, "junction_geodata", where, needed=False)
    found = {}
    for index, row in zip(geodata.labels, geodata.rows, strict=True):
        place = f"{where}, junction_geodata {index}"
        found[str(index)] = (number(row.get("x"), "x", place), number(row.get("y"), "y", place))
    for index, row in zip(junctions.labels, junctions.rows, strict=True):
        if str(index) not in found and isinstance(row.get("geo"), str):
            place = f"{where}, junction {index}"
            point = parse_json(row["geo"], place)
            pair = point.get("coordinates") if isinstance(point, dict) else None
            if not isinstance(pair, list) or len(pair) < 2:
                raise ConfigError(f"{place}: geo {shown(row['geo'])} is no point of GeoJSON: correct it there.")
            found[str(index)] = (number(pair[0], "x", place), number(pair[1], "y", place))
    return found


def _add_junctions(draft: MapDraft, junctions: _Table, places: dict[str, tuple[float, float]]) -> None:
    """Add the junctions under their index, by which pipes name them."""
    for index, row in zip(junctions.labels, junctions.rows, strict=True):
        place = f"junction {index}"
        if str(index) not in places:
            raise draft.refuse(place, "it has no coordinates in junction_geodata: a map needs them, add them.")
        height = row.get("height_m")
        known = None if _missing(height) else number(height, "height_m", f"{draft.file}, {place}")
        draft.node(str(index), (*places[str(index)], known), place)


def _courses(tables: dict[str, Any], where: str) -> dict[str, list[Point]]:
    """Points of the pipes by their index, ends included."""
    courses: dict[str, list[Point]] = {}
    table = _table(tables, "pipe_geodata", where, needed=False)
    for index, row in zip(table.labels, table.rows, strict=True):
        coords, place = row.get("coords"), f"{where}, pipe_geodata {index}"
        if isinstance(coords, list) and all(isinstance(pair, list) and len(pair) >= 2 for pair in coords):
            courses[str(index)] = [(number(x, "x", place), number(y, "y", place), None) for x, y, *_ in coords]
        elif not _missing(coords):
            raise ConfigError(f"{place}: coords {shown(json.dumps(coords))} is no list of points: correct it there.")
    return courses


def _add_pipe(draft: MapDraft, index: Any, row: dict[str, Any], course: list[Point]) -> None:
    place, kind = f"pipe {index}", str(row.get("type") or "").lower()
    at = f"{draft.file}, {place}"
    diameter = None
    if not _missing(row.get("inner_diameter_mm")):
        diameter = number(row["inner_diameter_mm"], "inner_diameter_mm", at) / 1e3
    elif not _missing(row.get("diameter_m")):
        diameter = number(row["diameter_m"], "diameter_m", at)
    length = row.get("length_km")
    facts = LineFacts(
        diameter=diameter,
        length=None if _missing(length) else number(length, "length_km", at) * 1e3,
        service=any(word in kind for word in SERVICE_WORDS),
    )
    ends = tuple(draft.number_of(str(row.get(key)), place) for key in ("from_junction", "to_junction"))
    if row.get("in_service") is False:
        draft.note("out-of-service", "info", "pipes out of service are surveyed like the others", str(index))
    draft.line(str(index), (ends[0], ends[1]), facts, course[1:-1], place)


def _missing(value: object) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))
