"""GeoJSON (RFC 7946): features whose geometry is a LineString or a MultiLineString."""

from __future__ import annotations

from pathlib import Path

from pipenav.errors import ConfigError, shown
from pipenav.networks.draft import MapDraft, Point
from pipenav.networks.fields import ReadOptions, facts_of
from pipenav.networks.model import NetworkMap
from pipenav.networks.polylines import PolyLine, joined_map
from pipenav.networks.text import network_json
from pipenav.networks.units import number
from pipenav.storage.text_files import shown_path


def read_geojson(path: Path, options: ReadOptions, content: object = None) -> NetworkMap:
    """The map of the lines of a GeoJSON file; other geometries are counted and left out.

    Args:
        path: path of the file.
        options: settings of readers.
        content: its content where it has been read already.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no such file, with the feature that does not fit.
    """
    where = shown_path(path)
    whole = network_json(path) if content is None else content
    features = whole.get("features") if isinstance(whole, dict) else None
    if not isinstance(features, list):
        raise ConfigError(f"{where} is no FeatureCollection of GeoJSON: give a file with a list of features.")
    draft = MapDraft(where, "GeoJSON")
    lines: list[PolyLine] = []
    for i, feature in enumerate(features, 1):
        lines += _lines(draft, feature, i, options)
    return joined_map(draft, lines, options, degrees=not isinstance(whole, dict) or "crs" not in whole)


def _lines(draft: MapDraft, feature: object, i: int, options: ReadOptions) -> list[PolyLine]:
    place = f"feature {i}"
    geometry = feature.get("geometry") if isinstance(feature, dict) else None
    if not isinstance(feature, dict) or not (geometry is None or isinstance(geometry, dict)):
        raise draft.refuse(place, "it is no feature with a geometry: correct it there.")
    kind = None if geometry is None else geometry.get("type")
    if geometry is None or kind not in ("LineString", "MultiLineString"):
        draft.note("other-geometry", "info", "features that are no lines were left out", f"{place} ({kind})")
        return []
    coordinates = geometry.get("coordinates")
    parts = [coordinates] if kind == "LineString" else coordinates
    if not isinstance(parts, list):
        raise draft.refuse(place, f"its coordinates {shown(coordinates)} are no list: correct them there.")
    properties = feature.get("properties") or {}
    if not isinstance(properties, dict):
        raise draft.refuse(place, f"its properties {shown(properties)} are no table: correct them there.")
    facts = facts_of(draft, properties, options, place)
    name = str(feature.get("id", i))
    return [
        PolyLine(name if len(parts) == 1 else f"{name}.{k}", _points(draft, part, place), facts, place)
        for k, part in enumerate(parts, 1)
    ]


def _points(draft: MapDraft, part: object, place: str) -> list[Point]:
    if not isinstance(part, list) or not all(isinstance(point, list) and len(point) >= 2 for point in part):
        raise draft.refuse(place, "its coordinates are no points of two or three numbers: correct them there.")
    where = f"{draft.file}, {place}"
    return [
        (
            number(point[0], "x", where),
            number(point[1], "y", where),
            number(point[2], "z", where) if len(point) > 2 else None,
        )
        for point in part
    ]
