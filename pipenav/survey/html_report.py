"""The report of a survey as one HTML file, which loads nothing from anywhere."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipenav.pages.page import page_parts
from pipenav.storage.json_parts import json_parts

TEMPLATE = Path(__file__).with_name("report.html")

LARGE = ("features", "segments")
"""Parts of the record that the page gets in a shorter form."""


def html_report(record: dict[str, Any]) -> Iterator[str]:
    """The page of a survey's record, in parts."""
    data = {
        "record": {key: value for key, value in record.items() if key not in LARGE},
        "features": (
            {
                "id": feature["id"],
                "name": feature["name"],
                "kind": feature["kind"],
                "p": feature["position_m"],
                "height": feature["height"],
                "angle": feature["angle_deg"],
                "error": feature["angle_error_deg"],
                "radius": feature["radius_mm"],
                "origin": feature["radius"],
                "bores": feature["bores_mm"],
                "legs": feature["legs_m"],
                "incline": feature["incline_deg"],
                "taps": feature["taps"],
                "verdict": feature["verdict"],
                "cause": feature["cause"],
                "distance": feature["distance_m"],
                "entry": feature["entry"],
                "passages": feature["passages"],
            }
            for feature in record["features"]
        ),
        "segments": (
            {
                "line": segment["line"],
                "ends": segment["ends"],
                "length": segment["length_m"],
                "length_origin": segment["length"],
                "bore": segment["bore_mm"],
                "bore_origin": segment["bore"],
                "seen": segment["seen_m"],
                "status": segment["status"],
                "cause": segment["cause"],
                "reason": segment["reason"],
            }
            for segment in record["segments"]
        ),
    }
    return page_parts(TEMPLATE, json_parts(data))
