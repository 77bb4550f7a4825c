"""The folder of a survey: its record, tables, map and report, all of them or none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pipenav.storage.atomic_files import Content, atomic_write_all
from pipenav.survey.html_report import html_report
from pipenav.survey.map_figure import map_png
from pipenav.survey.tables import features_csv, map_geojson

FILES = ("survey.json", "features.csv", "map.geojson", "map.png", "report.html")
"""Files of a survey."""


def write_survey(folder: Path, record: dict[str, Any]) -> None:
    """Write the files of a survey into a folder that exists.

    Raises:
        FileProblem: they cannot be written; earlier ones are untouched.
    """
    contents: tuple[Content, ...] = (
        json.dumps(record, separators=(",", ":"), allow_nan=False) + "\n",
        features_csv(record),
        map_geojson(record),
        map_png(record),
        html_report(record),
    )
    atomic_write_all({folder / name: content for name, content in zip(FILES, contents, strict=True)})
