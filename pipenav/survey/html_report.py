"""The report of a survey as one HTML file, which loads nothing from anywhere."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

TEMPLATE = Path(__file__).with_name("report.html")

PLACE = "/*DATA*/"
"""Place of the data in the template."""

LARGE = ("features", "segments")
"""Parts of the record that the page gets in a shorter form."""


def html_report(record: dict[str, Any]) -> str:
    """The page of a survey's record."""
    data = {
        "record": {key: value for key, value in record.items() if key not in LARGE},
        "features": [
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
                "distance": feature["distance_m"],
                "entry": feature["entry"],
                "passages": feature["passages"],
            }
            for feature in record["features"]
        ],
        "segments": [
            {
                "line": segment["line"],
                "ends": segment["ends"],
                "length": segment["length_m"],
                "length_origin": segment["length"],
                "bore": segment["bore_mm"],
                "bore_origin": segment["bore"],
                "seen": segment["seen_m"],
                "status": segment["status"],
                "reason": segment["reason"],
            }
            for segment in record["segments"]
        ],
    }
    # Names of a stranger's file stand in the data: no < may end the script that they lie in.
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return TEMPLATE.read_text(encoding="utf-8").replace(PLACE, text)
