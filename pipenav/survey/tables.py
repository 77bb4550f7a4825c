"""Tables of a survey for other programs: features as inspection reports lay them out, and the map as GeoJSON."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import Any

from pipenav.storage.json_parts import json_parts

CODES = {
    "bend": "BND",
    "joint": "JNT",
    "reducer": "RED",
    "tee": "TEE",
    "cross": "CRS",
    "junction": "JUN",
    "end": "END",
}
"""Codes of fittings in the table."""

COLUMNS = (
    "entry",
    "distance_m",
    "code",
    "remark",
    "node",
    "x_m",
    "y_m",
    "z_m",
    "bore_mm",
    "angle_deg",
    "angle_error_deg",
    "verdict",
    "cause",
    "reason",
)


def features_csv(record: dict[str, Any]) -> str:
    """The features as CSV: those that the robot comes to by entry and distance, then all others."""
    names = {feature["id"]: feature["name"] for feature in record["features"]}
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    far = float("inf")

    def place(feature: dict[str, Any]) -> tuple[float, float, int]:
        reached = feature["entry"] is not None
        return (feature["entry"] if reached else far, feature["distance_m"] if reached else far, feature["id"])

    for feature in sorted(record["features"], key=place):
        bores = [bore for bore in feature["bores_mm"] if bore is not None]
        writer.writerow(
            [
                names.get(feature["entry"], ""),
                "" if feature["distance_m"] is None else f"{feature['distance_m']:.1f}",
                CODES[feature["kind"]],
                remark(feature),
                feature["name"],
                *feature["position_m"],
                f"{min(bores):g}" if bores else "",
                feature["angle_deg"],
                feature["angle_error_deg"],
                feature["verdict"],
                feature["cause"],
                feature["reason"],
            ]
        )
    return file.getvalue()


def remark(feature: dict[str, Any]) -> str:
    """A feature in words."""
    words = [feature["kind"]]
    if feature["kind"] in ("bend", "tee", "cross"):
        words.append(f"{feature['angle_deg']:.0f} deg within {feature['angle_error_deg']:.0f} deg")
    if feature["kind"] == "bend":
        radius = feature["radius_mm"]
        words.append(f"radius {radius:.0f} mm {feature['radius']}" if radius else f"mitre {feature['radius']}")
    if feature["kind"] == "reducer":
        words.append(" to ".join("?" if bore is None else f"{bore:g}" for bore in feature["bores_mm"]) + " mm")
    if feature["taps"]:
        words.append(f"{feature['taps']} service tap{'s' * (feature['taps'] > 1)}")
    return ", ".join(words)


def map_geojson(record: dict[str, Any]) -> Iterator[str]:
    """The pipes and the features other than straight joints as GeoJSON, coordinates as in the map, in metres.

    It comes in parts.
    """
    yield from json_parts(
        {"type": "FeatureCollection", "coordinates": "metres, as in the map", "features": _drawn(record)}
    )
    yield "\n"


def _drawn(record: dict[str, Any]) -> Iterator[dict[str, Any]]:
    places = {feature["id"]: feature["position_m"] for feature in record["features"]}
    for segment in record["segments"]:
        told = ("line", "length_m", "bore_mm", "bore", "seen_m", "status", "cause", "reason")
        yield _feature("LineString", [places[end] for end in segment["ends"]], {key: segment[key] for key in told})
    for feature in record["features"]:
        if feature["kind"] != "joint":
            properties = {
                "id": feature["id"],
                "node": feature["name"],
                "code": CODES[feature["kind"]],
                "remark": remark(feature),
                "verdict": feature["verdict"],
                "cause": feature["cause"],
                "reason": feature["reason"],
            }
            yield _feature("Point", feature["position_m"], properties)
    for point in record["entries"]["points"]:
        yield _feature("Point", places[point["feature"]], {"id": point["feature"], "code": "ENTRY"})


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}
